"""RGB to hue, saturation, value."""

import torch
from torch import Tensor

from ..primitives.checks import check_floating, check_rgb


def rgb_to_hsv(image: Tensor, eps: float = 1e-8) -> Tensor:
    """Hue in radians [0, 2 pi), saturation and value in [0, 1].

    A. R. Smith, Color gamut transform pairs, SIGGRAPH 1978. Grey pixels have hue 0.

    Args:
        image: RGB image (*, 3, H, W) in [0, 1], floating point.
        eps: added to the value where the saturation divides by it.

    Returns:
        (*, 3, H, W): hue, saturation, value.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_hsv(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0., 1., 1.])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    red, green, blue = image.select(-3, 0), image.select(-3, 1), image.select(-3, 2)
    value = torch.maximum(torch.maximum(red, green), blue)
    chroma = value - torch.minimum(torch.minimum(red, green), blue)
    saturation = chroma / (value + eps)
    safe = torch.where(chroma == 0, torch.ones_like(chroma), chroma)
    blue_or_green = torch.where(value == green, 2.0 + (blue - red) / safe, 4.0 + (red - green) / safe)
    hue = torch.where(value == red, (green - blue) / safe, blue_or_green)
    hue = torch.where(hue < 0, hue + 6.0, hue) * 1.0471975511965976  # pi / 3, one sixth of a turn
    return torch.stack([hue, saturation, value], -3)
