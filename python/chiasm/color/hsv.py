"""Hue, saturation, value."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import bytes_of_hue, hue_of_bytes, rgb_planes
from .hue import from_hue, radians, sixths_of


def rgb_to_hsv(image: Tensor, eps: float = 1e-8) -> Tensor:
    """Hue in radians [0, 2 pi), saturation and value in [0, 1].

    A. R. Smith, Color gamut transform pairs, SIGGRAPH 1978. Grey pixels have hue 0. OpenCV's float32 hue is
    in degrees. For uint8, the hue is in degrees / 2, 0 to 179, and the saturation and the value are 0 to 255,
    all rounded to the nearest integer, halves to even. This is OpenCV's 8-bit format; OpenCV's values differ
    by at most one level.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.
        eps: added to the value, the denominator of the saturation; not used for uint8.

    Returns:
        (*, 3, H, W): hue, saturation, value.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hsv(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0., 1., 1.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return hue_of_bytes(image, False)
    sixths, value, chroma = sixths_value_chroma(image)
    return torch.stack([radians(sixths), saturation_of(value, chroma, eps), value], -3)


def sixths_value_chroma(image: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """Planes (*, H, W): hue in sixths of a turn, largest channel, and spread."""
    red, green, blue = rgb_planes(image, "image")
    return sixths_value_chroma_of(red, green, blue)


def sixths_value_chroma_of(red: Tensor, green: Tensor, blue: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """``sixths_value_chroma`` of an image's channels."""
    value = torch.maximum(torch.maximum(red, green), blue)
    chroma = value - torch.minimum(torch.minimum(red, green), blue)
    return sixths_of(red, green, blue, value, chroma), value, chroma


def saturation_of(value: Tensor, chroma: Tensor, eps: float) -> Tensor:
    # Half precision has no eps as small as the default, so black must not rely on it.
    return chroma / torch.where(value == 0, torch.ones_like(value), value + eps)


def hsv_to_rgb(image: Tensor) -> Tensor:
    """RGB in [0, 1] from hue in radians, saturation and value.

    A. R. Smith, Color gamut transform pairs, SIGGRAPH 1978, written without cases: every channel is
    V - V S clamp(d, 0, 1) with d = 2 - |h - 3|, |h - 2| - 1, |h - 4| - 1 for R, G, B and h = 3 H / pi mod
    6. For uint8, the hue is in degrees / 2 and the other channels are 0 to 255, as in OpenCV; the exact
    result is rounded (halves up), within one level of OpenCV's.

    Args:
        image: HSV image (*, 3, H, W), floating point: hue in radians (any number of turns), saturation and
            value in [0, 1]; or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> hsv_to_rgb(torch.tensor([0.0, 1.0, 0.5]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.5000, 0.0000, 0.0000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return bytes_of_hue(image, False)
    hue, saturation, value = rgb_planes(image, "image")
    return from_hue(hue, value, value * saturation)
