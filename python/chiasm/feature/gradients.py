"""Gradients of patches, and histograms of their directions."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ..filters.gradient import spatial_gradient
from ..primitives import kernels
from ..primitives.angles import angle_of
from ..primitives.checks import check_image
from ..primitives.linalg import small_matmul


def check_patches(patches: Tensor) -> None:
    """Raise unless ``patches`` is a floating-point (N, 1, PS, PS) tensor."""
    check_image(patches, "patches")
    if patches.size(1) != 1 or patches.size(2) != patches.size(3):
        raise ValueError(f"patches: expected shape (N, 1, PS, PS), got {list(patches.shape)}")


def polar_gradient(image: Tensor) -> Tuple[Tensor, Tensor]:
    """Length and direction of the central differences of (N, 1, H, W), the border replicated: (N, H, W) each.

    Directions are in radians from x towards y, that is down, from -pi to pi. Where there is no gradient, both are 0 and have derivative 0.
    """
    gradient = spatial_gradient(image, "diff")[:, 0]
    dx, dy = gradient[:, 0], gradient[:, 1]
    squared = dx * dx + dy * dy
    flat = squared == 0
    zero, one = torch.zeros_like(dx), torch.ones_like(dx)
    length = torch.sqrt(torch.where(flat, one, squared))
    direction = angle_of(torch.where(flat, zero, dy), torch.where(flat, one, dx))
    return torch.where(flat, zero, length), direction


def directed(length: Tensor, direction: Tensor, bins: int) -> Tensor:
    """(N, bins, H, W): each length shared by the two of ``bins`` directions around its own; the first is 0 radians."""
    place = direction * (bins / (2.0 * math.pi))
    place = torch.where(place < 0, place + bins, place)[:, None]
    bin = torch.arange(bins, device=length.device).to(length.dtype)[:, None, None]
    away = (place - bin).abs()
    return length[:, None] * (1.0 - torch.minimum(away, bins - away)).clamp(min=0)


def direction_histograms(patches: Tensor, window: Tensor, nearness: Tensor, bins: int) -> Tensor:
    """(N, bins, P, P): lengths of the gradients of patches (N, 1, PS, PS), weighed by window (PS, PS), by their ``directed`` and by the places that
    rows and columns are near to: nearness (P, PS)."""
    if not torch.jit.is_scripting() and kernels.has_kernel(patches):
        return kernels.direction_histograms(patches[:, 0], window, nearness, bins)
    length, direction = polar_gradient(patches)
    planes = directed(length * window, direction, bins)
    return small_matmul(small_matmul(nearness, planes), nearness.transpose(-1, -2))


def gaussian_window(size: int, sigma: float, like: Tensor) -> Tensor:
    """(size, size) weights exp(-r^2 / (2 sigma^2)), 1 in the middle of a patch."""
    offset = torch.arange(size, device=like.device).to(like.dtype) - 0.5 * (size - 1)
    falloff = torch.exp(offset * offset * (-0.5 / (sigma * sigma)))
    return falloff[:, None] * falloff


def unit(vectors: Tensor, squares: bool) -> Tensor:
    """(N, D, ...) divided by the length along D, the root of the sum of squares or the sum of absolute values; zeros stay."""
    size = (vectors * vectors).sum(1, keepdim=True) if squares else vectors.abs().sum(1, keepdim=True)
    empty = size == 0
    safe = torch.where(empty, torch.ones_like(size), size)
    return vectors / (torch.sqrt(safe) if squares else safe)
