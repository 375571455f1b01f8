"""From a loss for every pixel to what the caller wants of it."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..core.checks import check_reduction


def reduced(loss: Tensor, reduction: Optional[str]) -> Tensor:
    """The mean of a loss, its sum, or the loss itself, which None stands for too.

    >>> reduced(torch.tensor([1.0, 3.0]), "mean")
    tensor(2.)
    """
    if reduction is None:
        return loss
    check_reduction(reduction)
    if reduction == "mean":
        return loss.mean()
    if reduction == "sum":
        return loss.sum()
    return loss


def reduced_where(loss: Tensor, counts: Tensor, reduction: str) -> Tensor:
    """``reduced`` of the entries that count; the others are 0, and the mean of none is 0.

    >>> reduced_where(torch.tensor([1.0, 3.0]), torch.tensor([False, True]), "mean")
    tensor(3.)
    """
    check_reduction(reduction)
    kept = torch.where(counts, loss, torch.zeros_like(loss))
    if reduction == "mean":
        return kept.sum() / counts.sum().clamp(min=1).to(loss.dtype)
    return reduced(kept, reduction)


def considered(target: Tensor, ignore_index: Optional[int]) -> Tensor:
    """bool, of target's shape: False where it is ``ignore_index``."""
    if ignore_index is None:
        return torch.ones_like(target, dtype=torch.bool)
    # The number might not be one of the dtype's: bytes would take -100 for 156.
    return (
        target.to(torch.float64) != ignore_index
        if target.is_floating_point()
        else target.to(torch.int64) != ignore_index
    )


def where_considered(pred: Tensor, counts: Tensor) -> Tuple[Tensor, Tensor]:
    """``pred`` (B, C, *) with 0 where ``counts`` (B, *) is False, so that nothing there, not even NaN,
    reaches a gradient; and ``counts`` for every channel, (B, 1, *)."""
    every = counts[:, None]
    return torch.where(every, pred, torch.zeros_like(pred)), every
