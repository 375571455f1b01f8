"""Reductions of a loss per pixel, and the precision in which it is computed."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..core.checks import check_reduction


def reduced(loss: Tensor, reduction: Optional[str]) -> Tensor:
    """The mean of a loss, its sum, or the loss itself ("none" or None).

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
    """``reduced``, with 0 for the entries for which ``counts`` is False; the mean is over all entries.

    >>> reduced_where(torch.tensor([1.0, 3.0]), torch.tensor([False, True]), "mean")
    tensor(1.5000)
    """
    return reduced(torch.where(counts, loss, torch.zeros_like(loss)), reduction)


def widened(x: Tensor) -> Tensor:
    """Half precision as float32, other dtypes as they are: a square or a sum over an image exceeds float16,
    and bfloat16 has two digits.

    >>> widened(torch.tensor([256.0], dtype=torch.float16)).square()
    tensor([65536.])
    """
    return x.to(torch.float32) if x.dtype in [torch.float16, torch.bfloat16] else x


def narrowed(loss: Tensor, given: Tensor, other: Optional[Tensor] = None) -> Tensor:
    """What was computed of ``widened`` tensors, in the dtype that these have; of tensors of two dtypes it has
    the one to which PyTorch promotes them.

    >>> narrowed(torch.tensor(1.0), torch.zeros(2, dtype=torch.float16)).dtype
    torch.float16
    """
    if loss.dtype == given.dtype or (other is not None and other.dtype != given.dtype):
        return loss
    return loss.to(given.dtype)


def considered(target: Tensor, ignore_index: Optional[int]) -> Tensor:
    """bool, in target's shape: False where target is ``ignore_index``."""
    if ignore_index is None:
        return torch.ones_like(target, dtype=torch.bool)
    # The dtype may not have the number: in bytes, -100 would equal 156.
    return (
        target.to(torch.float64) != ignore_index
        if target.is_floating_point()
        else target.to(torch.int64) != ignore_index
    )


def where_considered(pred: Tensor, counts: Tensor) -> Tuple[Tensor, Tensor]:
    """``pred`` (B, C, *) with 0 where ``counts`` (B, *) is False, so that values there, even NaN, do not
    affect a gradient; and ``counts`` with a channel dimension, (B, 1, *)."""
    every = counts[:, None]
    return torch.where(every, pred, torch.zeros_like(pred)), every
