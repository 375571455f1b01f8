"""Helpers of the metrics: lengths with finite derivatives, and means over valid values."""

import math
from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating
from ..primitives.numbers.loss_reduction import widened


def vector_length(v: Tensor) -> Tensor:
    """Euclidean length along the last axis, from squares in float64; its derivative is 0 for a zero vector.

    >>> vector_length(torch.tensor([[3.0, 4.0], [0.0, 0.0]]))
    tensor([5., 0.])
    """
    exact = v.to(torch.float64)
    return safe_sqrt((exact * exact).sum(-1)).to(v.dtype)


def safe_sqrt(x: Tensor) -> Tensor:
    """The square root, with a derivative of 0 at 0."""
    zero = x == 0
    return torch.where(zero, torch.zeros_like(x), torch.sqrt(torch.where(zero, torch.ones_like(x), x)))


def check_pair(input: Tensor, target: Tensor) -> None:
    """Raise unless both are floating point and of one shape."""
    check_floating(input, "input")
    check_floating(target, "target")
    if target.shape != input.shape:
        raise ValueError(f"target: expected input's shape {list(input.shape)}, got {list(target.shape)}")


def reduced_valid(values: Tensor, valid: Optional[Tensor], reduction: str) -> Tensor:
    """Mean or sum of the valid values, summed in float64, or the values themselves, which must be 0 where
    invalid. Without valid values the mean is NaN, with derivatives of 0. A sum of half precision is float32.

    >>> reduced_valid(torch.tensor([1.0, 0.0, 3.0]), torch.tensor([True, False, True]), "mean")
    tensor(2.)
    """
    if reduction == "none":
        return values
    total = values.to(torch.float64).sum()
    if reduction == "mean":
        counted = torch.ones_like(values, dtype=torch.float64) if valid is None else valid.to(torch.float64)
        count = counted.sum()
        none = count == 0
        total = torch.where(
            none, torch.full_like(total, math.nan), total / torch.where(none, torch.ones_like(count), count)
        )
        return total.to(values.dtype)
    return total.to(widened(values).dtype)
