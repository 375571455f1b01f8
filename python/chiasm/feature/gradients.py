"""Helpers of patch descriptors."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image


def check_patches(patches: Tensor) -> None:
    """Raise unless ``patches`` is a floating-point (N, 1, PS, PS) tensor."""
    check_image(patches, "patches")
    if patches.size(1) != 1 or patches.size(2) != patches.size(3):
        raise ValueError(f"patches: expected shape (N, 1, PS, PS), got {list(patches.shape)}")


def gaussian_window(size: int, sigma: float, like: Tensor) -> Tensor:
    """(size, size) weights exp(-r^2 / (2 sigma^2)), 1 in the middle of a patch."""
    offset = torch.arange(size, device=like.device).to(like.dtype) - 0.5 * (size - 1)
    weights = torch.exp(offset * offset * (-0.5 / (sigma * sigma)))
    return weights[:, None] * weights


def unit(vectors: Tensor, squares: bool) -> Tensor:
    """(N, D, ...) divided by its length along D: with ``squares`` the root of the sum of squares, otherwise
    the sum of absolute values. Zeros stay zeros."""
    size = (vectors * vectors).sum(1, keepdim=True) if squares else vectors.abs().sum(1, keepdim=True)
    empty = size == 0
    safe = torch.where(empty, torch.ones_like(size), size)
    return vectors / (torch.sqrt(safe) if squares else safe)
