"""CIE L*a*b*."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rgb
from ..primitives.images.color_planes import rgb_planes
from ..primitives.numbers.power import power
from .linear import from_linear, to_linear
from .xyz import rgb_to_xyz, xyz_to_rgb


def rgb_to_lab(image: Tensor) -> Tensor:
    """CIE 1976 L*a*b* of an sRGB image, for D65 white.

    CIE 15:2018. White is (0.950456, 1, 1.088754) as in OpenCV, so that greys have a = b = 0. OpenCV's uint8
    form is L * 255 / 100, a + 128, b + 128, rounded.

    Args:
        image: sRGB image (*, 3, H, W) in [0, 1], floating point.

    Returns:
        (*, 3, H, W): L in [0, 100], a and b within about [-128, 127].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_lab(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten().round(decimals=2)
        tensor([53.2400, 80.0900, 67.2000])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    x, y, z = rgb_planes(rgb_to_xyz(to_linear(image)), "image")
    fx, fy, fz = _compressed(x / 0.950456), _compressed(y), _compressed(z / 1.088754)
    return torch.stack([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)], -3)


def lab_to_rgb(image: Tensor, clip: bool = True) -> Tensor:
    """sRGB from CIE 1976 L*a*b* for D65 white, the inverse of ``rgb_to_lab``.

    Args:
        image: Lab image (*, 3, H, W), floating point: L in [0, 100], a and b within about [-128, 127].
        clip: bring the result to [0, 1]; many Lab values are no sRGB colour.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> lab_to_rgb(torch.tensor([53.2406, 80.0942, 67.2015]).reshape(1, 3, 1, 1)).flatten().round(
        ...     decimals=3
        ... ).abs()
        tensor([1., 0., 0.])
    """
    lightness, a, b = rgb_planes(image, "image")
    fy = (lightness + 16.0) / 116.0
    fx, fz = fy + a / 500.0, fy - b / 200.0
    xyz = torch.stack([0.950456 * _expanded(fx), _expanded(fy), 1.088754 * _expanded(fz)], -3)
    rgb = from_linear(xyz_to_rgb(xyz))
    return rgb.clamp(0.0, 1.0) if clip else rgb


def _compressed(t: Tensor) -> Tensor:
    """CIE's f: the cube root, continued by its tangent through 16/116 below (6/29)^3."""
    root = power(t.clamp(min=0.008856451679035631), 1.0 / 3.0)
    return torch.where(t > 0.008856451679035631, root, t * 7.787037037037035 + 0.13793103448275862)


def _expanded(f: Tensor) -> Tensor:
    """Inverse of ``_compressed``."""
    return torch.where(f > 0.20689655172413793, f * f * f, (f - 0.13793103448275862) * 0.12841854934601665)
