"""Hue, lightness, saturation."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.images.color_planes import rgb_planes
from .hue import from_hue, radians, sixths_of


def rgb_to_hls(image: Tensor, eps: float = 1e-8) -> Tensor:
    """Hue in radians [0, 2 pi), lightness (max + min) / 2 and saturation in [0, 1].

    G. H. Joblove, D. Greenberg, Color spaces for computer graphics, SIGGRAPH 1978. Grey pixels have hue and
    saturation 0. OpenCV's float32 hue is in degrees; its uint8 form is hue in degrees / 2 (here H * 90 / pi),
    L * 255, S * 255, rounded.

    Args:
        image: RGB image (*, 3, H, W) in [0, 1], floating point.
        eps: added to what the saturation is divided by.

    Returns:
        (*, 3, H, W): hue, lightness, saturation.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hls(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.0000, 0.5000, 1.0000])
    """
    hue, lightness, saturation = _hue_lightness_saturation(image, eps)
    return torch.stack([hue, lightness, saturation], -3)


def rgb_to_hsl(image: Tensor, eps: float = 1e-8) -> Tensor:
    """``rgb_to_hls`` with its channels in the order hue, saturation, lightness.

    Args:
        image: RGB image (*, 3, H, W) in [0, 1], floating point.
        eps: added to what the saturation is divided by.

    Returns:
        (*, 3, H, W): hue in radians [0, 2 pi), saturation, lightness.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hsl(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.0000, 1.0000, 0.5000])
    """
    hue, lightness, saturation = _hue_lightness_saturation(image, eps)
    return torch.stack([hue, saturation, lightness], -3)


def hls_to_rgb(image: Tensor) -> Tensor:
    """RGB in [0, 1] from hue in radians, lightness and saturation.

    G. H. Joblove, D. Greenberg, Color spaces for computer graphics, SIGGRAPH 1978.

    Args:
        image: HLS image (*, 3, H, W), floating point: hue in radians (any number of turns), lightness and
            saturation in [0, 1].

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> hls_to_rgb(torch.tensor([0.0, 0.5, 1.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([1., 0., 0.])
    """
    hue, lightness, saturation = rgb_planes(image, "image")
    return _rgb(hue, lightness, saturation)


def hsl_to_rgb(image: Tensor) -> Tensor:
    """``hls_to_rgb`` of channels in the order hue, saturation, lightness.

    Args:
        image: HSL image (*, 3, H, W), floating point: hue in radians (any number of turns), saturation and
            lightness in [0, 1].

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> hsl_to_rgb(torch.tensor([0.0, 1.0, 0.5]).reshape(1, 3, 1, 1)).flatten()
        tensor([1., 0., 0.])
    """
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
