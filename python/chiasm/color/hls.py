"""Hue, lightness, saturation."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import arranged, bytes_of_hue, hue_of_bytes, rgb_planes
from .hue import from_hue, radians, sixths_of


def rgb_to_hls(image: Tensor, eps: float = 1e-8) -> Tensor:
    """Hue in radians [0, 2 pi), lightness (max + min) / 2 and saturation in [0, 1].

    G. H. Joblove, D. Greenberg, Color spaces for computer graphics, SIGGRAPH 1978. Grey pixels have hue and
    saturation 0. OpenCV's float32 hue is in degrees. For uint8, the hue is in degrees / 2, 0 to 179, and the
    other channels are 0 to 255. Values are rounded to the nearest integer, halves to even, for the lightness
    halves up. This is OpenCV's 8-bit format; OpenCV's values differ by at most one level.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.
        eps: added to the denominator of the saturation; not used for uint8.

    Returns:
        (*, 3, H, W): hue, lightness, saturation.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hls(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.0000, 0.5000, 1.0000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return hue_of_bytes(image, True)
    hue, lightness, saturation = _hue_lightness_saturation(image, eps)
    return torch.stack([hue, lightness, saturation], -3)


def rgb_to_hsl(image: Tensor, eps: float = 1e-8) -> Tensor:
    """``rgb_to_hls`` with its channels in the order hue, saturation, lightness, also for uint8.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.
        eps: added to the denominator of the saturation; not used for uint8.

    Returns:
        (*, 3, H, W): hue in radians [0, 2 pi), saturation, lightness; for uint8 as in ``rgb_to_hls``.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hsl(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.0000, 1.0000, 0.5000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return arranged(hue_of_bytes(image, True), [0, 2, 1], 0.0)
    hue, lightness, saturation = _hue_lightness_saturation(image, eps)
    return torch.stack([hue, saturation, lightness], -3)


def hls_to_rgb(image: Tensor) -> Tensor:
    """RGB in [0, 1] from hue in radians, lightness and saturation.

    G. H. Joblove, D. Greenberg, Color spaces for computer graphics, SIGGRAPH 1978. For uint8, the hue is in
    degrees / 2 and the other channels are 0 to 255, as in OpenCV; the exact result is rounded (halves up).

    Args:
        image: HLS image (*, 3, H, W), floating point: hue in radians (any number of turns), lightness and
            saturation in [0, 1]; or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> hls_to_rgb(torch.tensor([0.0, 0.5, 1.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([1., 0., 0.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return bytes_of_hue(image, True)
    hue, lightness, saturation = rgb_planes(image, "image")
    return _rgb(hue, lightness, saturation)


def hsl_to_rgb(image: Tensor) -> Tensor:
    """``hls_to_rgb`` with channels in the order hue, saturation, lightness, also for uint8.

    Args:
        image: HSL image (*, 3, H, W), floating point: hue in radians (any number of turns), saturation and
            lightness in [0, 1]; or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> hsl_to_rgb(torch.tensor([0.0, 1.0, 0.5]).reshape(1, 3, 1, 1)).flatten()
        tensor([1., 0., 0.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return bytes_of_hue(arranged(image, [0, 2, 1], 0.0), True)
    hue, saturation, lightness = rgb_planes(image, "image")
    return _rgb(hue, lightness, saturation)


def _hue_lightness_saturation(image: Tensor, eps: float) -> Tuple[Tensor, Tensor, Tensor]:
    red, green, blue = rgb_planes(image, "image")
    value = torch.maximum(torch.maximum(red, green), blue)
    least = torch.minimum(torch.minimum(red, green), blue)
    total, chroma = value + least, value - least
    # The largest chroma that this lightness allows: zero for black and for white.
    room = torch.minimum(total, 2.0 - total)
    saturation = chroma / torch.where(room == 0, torch.ones_like(room), room + eps)
    return radians(sixths_of(red, green, blue, value, chroma)), total * 0.5, saturation


def _rgb(hue: Tensor, lightness: Tensor, saturation: Tensor) -> Tensor:
    half = saturation * torch.minimum(lightness, 1.0 - lightness)
    return from_hue(hue, lightness + half, half + half)
