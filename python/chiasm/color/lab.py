"""CIE L*a*b*."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import curved, rgb_planes
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.numbers.power import power
from .linear import from_linear, to_linear
from .xyz import rgb_to_xyz, xyz_to_rgb


def rgb_to_lab(image: Tensor) -> Tensor:
    """CIE 1976 L*a*b* of an sRGB image, for D65 white.

    CIE 15:2018. White is (0.950456, 1, 1.088754) as in OpenCV, so that greys have a = b = 0. For uint8, the
    result has OpenCV's 8-bit format, L * 255 / 100, a + 128, b + 128, computed from tables of linear light
    and of cube roots. Each value is within one level of the exact number, and 98 % of all values are the
    nearest integers. OpenCV's coarser tables are wrong by up to 3 levels.

    Args:
        image: sRGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 3, H, W): L in [0, 100], a and b within about [-128, 127], or all as bytes.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_lab(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten().round(decimals=2)
        tensor([53.2400, 80.0900, 67.2000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return _lab_of_bytes(image)
    x, y, z = rgb_planes(rgb_to_xyz(to_linear(widened(image))), "image")
    fx, fy, fz = _compressed(x / 0.950456), _compressed(y), _compressed(z / 1.088754)
    return narrowed(torch.stack([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)], -3), image)


def lab_to_rgb(image: Tensor, clip: bool = True) -> Tensor:
    """sRGB from CIE 1976 L*a*b* for D65 white, the inverse of ``rgb_to_lab``.

    For uint8, tables of cubes and of the sRGB curve are used. Each value is within 2 levels of the exact
    number, and 98 % of all values are the nearest integers.

    Args:
        image: Lab image (*, 3, H, W), floating point: L in [0, 100], a and b within about [-128, 127]; or
            uint8.
        clip: limit the result to [0, 1]; many Lab values are outside the sRGB gamut. uint8 is always clipped.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W), or clip is False for bytes.

    Example:
        >>> lab_to_rgb(torch.tensor([53.2406, 80.0942, 67.2015]).reshape(1, 3, 1, 1)).flatten().round(
        ...     decimals=3
        ... ).abs()
        tensor([1., 0., 0.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        if not clip:
            raise ValueError("clip: expected True for an image of bytes, got False")
        return _bytes_of_lab(image)
    lightness, a, b = rgb_planes(widened(image), "image")
    fy = (lightness + 16.0) / 116.0
    fx, fz = fy + a / 500.0, fy - b / 200.0
    xyz = torch.stack([0.950456 * _expanded(fx), _expanded(fy), 1.088754 * _expanded(fz)], -3)
    rgb = narrowed(from_linear(xyz_to_rgb(xyz)), image)
    return rgb.clamp(0.0, 1.0) if clip else rgb


def _lab_of_bytes(image: Tensor) -> Tensor:
    # Linear light in 1/4080 and the matrix over white in 1/2^12, whose rows add up to 1; roots at 1/16320, in
    # 1/2^15; the factors of L, a, b in 1/2^6.
    level = torch.arange(256, device=image.device).to(torch.float64)
    light = torch.round(4080.0 * to_linear(level / 255.0)).to(torch.int32)
    place = torch.arange(16321, device=image.device).to(torch.float64)
    roots = torch.round(32768.0 * _compressed(place / 16320.0)).to(torch.int32)
    xyz = [1777, 1541, 778, 512, 871, 2929, 296, 512, 73, 448, 3575, 512]
    # 2.55 * 116 and -2.55 * 16, 500, 200; 128; and a half
    lightness, a, b = [0, 18931, 0, -84515226], [32000, -32000, 0, 269484032], [0, 12800, -12800, 269484032]
    return curved(image, light.expand(3, 256), xyz, 10, roots, lightness + a + b, 21, level.to(torch.int32))


def _bytes_of_lab(image: Tensor) -> Tensor:
    # f plus 1/2 in 1/2^14, its cubes in 1/2^15, the matrix times white in 1/2^11, linear light in 1/2^13.
    level = torch.arange(256, device=image.device).to(torch.float64)
    parts = [(level * (100.0 / 255.0) + 16.0) / 116.0, (level - 128.0) / 500.0, (128.0 - level) / 200.0]
    f = torch.round(16384.0 * torch.stack(parts)).to(torch.int32)
    place = torch.arange(35200, device=image.device).to(torch.float64)
    cubes = torch.round(32768.0 * _expanded(place / 16384.0 - 0.5)).to(torch.int32)
    light = torch.arange(8193, device=image.device).to(torch.float64)
    curve = torch.round(255.0 * from_linear(light / 8192.0)).clamp(0.0, 255.0).to(torch.int32)
    fx, fy, fz = [1, 1, 0, 8192], [1, 0, 0, 8192], [1, 0, 1, 8192]
    rgb = [6308, -3148, -1112, 4096, -1887, 3842, 93, 4096, 108, -418, 2358, 4096]
    return curved(image, f, fx + fy + fz, 0, cubes, rgb, 13, curve)


def _compressed(t: Tensor) -> Tensor:
    """CIE's f: the cube root, continued by its tangent through 16/116 below (6/29)^3."""
    root = power(t.clamp(min=0.008856451679035631), 1.0 / 3.0)
    return torch.where(t > 0.008856451679035631, root, t * 7.787037037037035 + 0.13793103448275862)


def _expanded(f: Tensor) -> Tensor:
    """Inverse of ``_compressed``."""
    return torch.where(f > 0.20689655172413793, f * f * f, (f - 0.13793103448275862) * 0.12841854934601665)
