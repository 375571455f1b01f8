"""Shared by the hexagonal colour spaces (HSV, HLS): hue from RGB, and RGB from hue."""

from typing import Tuple

import torch
from torch import Tensor


def sixths_of(red: Tensor, green: Tensor, blue: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    """Hue in sixths of a turn, [-1, 5], 0 for grey; ``value`` is the largest channel, ``chroma`` the spread
    (the largest minus the smallest channel)."""
    safe = torch.where(chroma == 0, torch.ones_like(chroma), chroma)
    # The three cases share one division.
    step = (
        torch.where(value == red, green - blue, torch.where(value == green, blue - red, red - green)) / safe
    )
    return torch.where(value == red, step, torch.where(value == green, 2.0 + step, 4.0 + step))


def radians(sixths: Tensor) -> Tensor:
    """The result of ``sixths_of`` in radians [0, 2 pi)."""
    return torch.where(sixths < 0, sixths + 6.0, sixths) * 1.0471975511965976  # pi / 3


def from_hue(hue: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    """``from_sixths`` of a hue in radians."""
    return from_sixths(hue * 0.954929658551372, value, chroma)  # 3 / pi


def from_sixths(sixths: Tensor, value: Tensor, chroma: Tensor) -> Tensor:
    """RGB (*, 3, H, W) from hue (sixths of a turn, any number of turns), largest channel and spread."""
    red, green, blue = planes_of_sixths(sixths, value, chroma)
    return torch.stack([red, green, blue], -3)


def planes_of_sixths(sixths: Tensor, value: Tensor, chroma: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The channels of ``from_sixths``, each (*, H, W)."""
    # Without case distinctions, so that rounding near a multiple of 60 degrees cannot make two backends
    # differ.
    h = sixths - 6.0 * torch.floor(sixths.detach() * 0.16666666666666666)
    red = value - chroma * (2.0 - (h - 3.0).abs()).clamp(0.0, 1.0)
    green = value - chroma * ((h - 2.0).abs() - 1.0).clamp(0.0, 1.0)
    blue = value - chroma * ((h - 4.0).abs() - 1.0).clamp(0.0, 1.0)
    return red, green, blue
