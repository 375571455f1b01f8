"""CIE L*u*v*."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import rgb_planes
from ..primitives.images.luv import bytes_of_luv, linear_of_luv, luv_of_bytes
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.numbers.power import power
from .linear import from_linear, to_linear
from .xyz import rgb_to_xyz, weights_of_xyz


def rgb_to_luv(image: Tensor, eps: float = 1e-12) -> Tensor:
    """CIE 1976 L*u*v* of an sRGB image, for D65 white.

    CIE 15:2018. White is (0.950456, 1, 1.088754) as in OpenCV, so that greys have u = v = 0. For uint8, the
    result has OpenCV's 8-bit format, L * 255 / 100, (u + 134) * 255 / 354, (v + 140) * 255 / 262, computed
    from tables of linear light and of lightness. Each value is within one level of the exact number and of
    OpenCV's, and 99 % of all values are the nearest integers.

    Args:
        image: sRGB image (*, 3, H, W), floating point in [0, 1], or uint8.
        eps: added to the denominator of the chromaticity; not used for uint8. Black has u = v = 0, with
            gradient 0.

    Returns:
        (*, 3, H, W): L in [0, 100], u within about [-134, 220], v within about [-140, 122], or all as bytes.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_luv(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten().round(decimals=1)
        tensor([ 53.2000, 175.0000,  37.8000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return _luv_of_bytes(image)
    x, y, z = rgb_planes(rgb_to_xyz(to_linear(widened(image))), "image")
    lightness = _lightness(y)
    weight = x + 15.0 * y + 3.0 * z
    dark = weight == 0
    weight = torch.where(dark, torch.ones_like(weight), weight + eps)
    scale = 13.0 * torch.where(dark, torch.zeros_like(lightness), lightness)
    # The offsets are u' and v' of white.
    luv = [
        lightness,
        scale * (4.0 * x / weight - 0.19783940212891712),
        scale * (9.0 * y / weight - 0.46834220078579497),
    ]
    return narrowed(torch.stack(luv, -3), image)


def luv_to_rgb(image: Tensor, eps: float = 1e-12) -> Tensor:
    """sRGB from CIE 1976 L*u*v* for D65 white, the inverse of ``rgb_to_luv``; the result is not clipped.

    For uint8, a table of the sRGB curve is used and the result is clipped. Each value is within one level of
    the exact number, and 99 % of all values are the nearest integers.

    Args:
        image: Luv image (*, 3, H, W), floating point: L in [0, 100]; or uint8.
        eps: a pixel whose |v + 13 L v'(white)| is at most eps counts as black.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> luv_to_rgb(torch.tensor([53.2406, 175.0150, 37.7564]).reshape(1, 3, 1, 1)).flatten().round(
        ...     decimals=2
        ... ).abs()
        tensor([1., 0., 0.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return _bytes_of_luv(image, eps)
    lightness, u, v = rgb_planes(widened(image), "image")
    rgb = from_linear(linear_of_luv(lightness, _luminance(lightness), u, v, weights_of_xyz(), eps))
    return narrowed(rgb, image)


def _lightness(y: Tensor) -> Tensor:
    """CIE's L* of relative luminance."""
    root = power(y.clamp(min=0.008856451679035631), 1.0 / 3.0)
    return torch.where(y > 0.008856451679035631, 116.0 * root - 16.0, y * 903.2962962962963)


def _luminance(lightness: Tensor) -> Tensor:
    """The inverse of ``_lightness``."""
    f = (lightness + 16.0) / 116.0
    return torch.where(lightness > 8.0, f * f * f, lightness / 903.2962962962963)


def _luv_of_bytes(image: Tensor) -> Tensor:
    # Linear light in 1/2^16 and the matrix in 1/2^20.
    level = torch.arange(256, device=image.device).to(torch.float64)
    light = torch.round(65536.0 * to_linear(level / 255.0))
    x, y, z = [432488.0, 374950.0, 189187.0], [223002.0, 749900.0, 75674.0], [20273.0, 124983.0, 996385.0]
    place = torch.arange(16385, device=image.device).to(torch.float64)
    # Round to a multiple of 1/2^20 again, since engines differ in the last digits of a root.
    curve = torch.round(1048576.0 * _lightness(place / 16384.0)) / 1048576.0
    return luv_of_bytes(image, light, x + y + z, curve)


def _bytes_of_luv(image: Tensor, eps: float) -> Tensor:
    lightness = torch.arange(256, device=image.device).to(torch.float64) * (100.0 / 255.0)
    place = torch.arange(16385, device=image.device).to(torch.float64)
    curve = torch.round(255.0 * from_linear(place / 16384.0)).clamp(0.0, 255.0).to(torch.uint8)
    return bytes_of_luv(image, lightness, _luminance(lightness), weights_of_xyz(), curve, eps)
