"""What the hexagonal colour spaces (HSV, HLS) share: hue from RGB, and RGB from hue."""

import torch
from torch import Tensor


def hue_of(red: Tensor, green: Tensor, blue: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    """Hue in radians [0, 2 pi), 0 where there is no chroma; ``value`` is the largest channel, ``chroma`` the spread."""
    safe = torch.where(chroma == 0, torch.ones_like(chroma), chroma)
    # One division for the three cases, which compilers would compute and choose from.
    step = torch.where(value == red, green - blue, torch.where(value == green, blue - red, red - green)) / safe
    hue = torch.where(value == red, step, torch.where(value == green, 2.0 + step, 4.0 + step))
    return torch.where(hue < 0, hue + 6.0, hue) * 1.0471975511965976  # pi / 3, one sixth of a turn


def from_hue(hue: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    """(*, 3, H, W) of the given hue (radians, any number of turns), largest channel and spread."""
    sixths = hue * 0.954929658551372  # 3 / pi
    return torch.stack([_channel(sixths + 5.0, value, chroma), _channel(sixths + 3.0, value, chroma), _channel(sixths + 1.0, value, chroma)], -3)


def _channel(sixths: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    # Without cases, so that no rounding near a multiple of 60 degrees can tell two backends apart.
    k = sixths - 6.0 * torch.floor(sixths.detach() * 0.16666666666666666)
    return value - chroma * torch.minimum(k, 4.0 - k).clamp(0.0, 1.0)
