"""CIE L*u*v*."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rgb
from ..primitives.images.color_planes import rgb_planes
from ..primitives.numbers.power import power
from .linear import from_linear, to_linear
from .xyz import rgb_to_xyz, xyz_to_rgb


def rgb_to_luv(image: Tensor, eps: float = 1e-12) -> Tensor:
    """CIE 1976 L*u*v* of an sRGB image, for D65 white.

    CIE 15:2018. White is (0.950456, 1, 1.088754) as in OpenCV, so that greys have u = v = 0. OpenCV's uint8
    form is L * 255 / 100, (u + 134) * 255 / 354, (v + 140) * 255 / 262, rounded.

    Args:
        image: sRGB image (*, 3, H, W) in [0, 1], floating point.
        eps: added to what the chromaticity is divided by. Black has u = v = 0, with gradient 0.

    Returns:
        (*, 3, H, W): L in [0, 100], u within about [-134, 220], v within about [-140, 122].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_luv(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten().round(decimals=1)
        tensor([ 53.2000, 175.0000,  37.8000])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    x, y, z = rgb_planes(rgb_to_xyz(to_linear(image)), "image")
    root = power(y.clamp(min=0.008856451679035631), 1.0 / 3.0)
    lightness = torch.where(y > 0.008856451679035631, 116.0 * root - 16.0, y * 903.2962962962963)
    weight = x + 15.0 * y + 3.0 * z
    dark = weight == 0
    weight = torch.where(dark, torch.ones_like(weight), weight + eps)
    scale = 13.0 * torch.where(dark, torch.zeros_like(lightness), lightness)
    # The offsets are u' and v' of white.
    return torch.stack(
        [
            lightness,
            scale * (4.0 * x / weight - 0.19783940212891712),
            scale * (9.0 * y / weight - 0.46834220078579497),
        ],
        -3,
    )


def luv_to_rgb(image: Tensor, eps: float = 1e-12) -> Tensor:
    """sRGB from CIE 1976 L*u*v* for D65 white, the inverse of ``rgb_to_luv``; the result is not clipped.

    Args:
        image: Luv image (*, 3, H, W), floating point: L in [0, 100].
        eps: |v + 13 L v'(white)| up to this counts as black.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> luv_to_rgb(torch.tensor([53.2406, 175.0150, 37.7564]).reshape(1, 3, 1, 1)).flatten().round(
        ...     decimals=2
        ... ).abs()
        tensor([1., 0., 0.])
    """
    lightness, u, v = rgb_planes(image, "image")
    f = (lightness + 16.0) / 116.0
    y = torch.where(lightness > 8.0, f * f * f, lightness / 903.2962962962963)
    # 13 L u' and 13 L v': only their ratios count, so there is no division by L.
    up = u + 2.571912227675923 * lightness
    vp = v + 6.088448610215335 * lightness
    dark = vp.abs() <= eps
    ratio = torch.where(dark, torch.zeros_like(y), y / torch.where(dark, torch.ones_like(vp), vp))
    x = 2.25 * up * ratio
    z = (39.0 * lightness - 0.75 * up) * ratio - 5.0 * y
    return from_linear(xyz_to_rgb(torch.stack([x, y, z], -3)))
