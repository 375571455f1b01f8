"""The transfer function of sRGB."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rgb
from ..primitives.numbers.power import power


def rgb_to_linear_rgb(image: Tensor) -> Tensor:
    """Linear light from sRGB: ((c + 0.055) / 1.055) ^ 2.4 above 0.04045, c / 12.92 below (IEC 61966-2-1).

    Args:
        image: sRGB image (*, 3, H, W) in [0, 1], floating point.

    Returns:
        (*, 3, H, W): linear RGB in [0, 1].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_linear_rgb(torch.full((1, 3, 1, 1), 0.5)).flatten()
        tensor([0.2140, 0.2140, 0.2140])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    return to_linear(image)


def linear_rgb_to_rgb(image: Tensor) -> Tensor:
    """sRGB from linear light: 1.055 c ^ (1 / 2.4) - 0.055 above 0.0031308, 12.92 c below (IEC 61966-2-1).

    Args:
        image: linear RGB image (*, 3, H, W) in [0, 1], floating point.

    Returns:
        (*, 3, H, W): sRGB in [0, 1].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> linear_rgb_to_rgb(torch.full((1, 3, 1, 1), 0.2140)).flatten()
        tensor([0.5000, 0.5000, 0.5000])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    return from_linear(image)


def to_linear(x: Tensor) -> Tensor:
    """``rgb_to_linear_rgb`` of a tensor of any shape."""
    # The clamp keeps the power's derivative finite where the straight part is taken.
    curved = power((x.clamp(min=0.04045) + 0.055) / 1.055, 2.4)
    return torch.where(x > 0.04045, curved, x / 12.92)


def from_linear(x: Tensor) -> Tensor:
    """``linear_rgb_to_rgb`` of a tensor of any shape."""
    curved = 1.055 * power(x.clamp(min=0.0031308), 1.0 / 2.4) - 0.055
    return torch.where(x > 0.0031308, curved, 12.92 * x)
