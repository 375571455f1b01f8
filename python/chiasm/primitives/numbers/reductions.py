"""The smallest and the greatest value, which are NaN on every engine if any value is NaN. ONNX Runtime's own
reductions ignore NaN."""

from typing import List

import torch
from torch import Tensor

from ..core.lowering import primitive


def least(x: Tensor, dims: List[int]) -> Tensor:
    """``x.amin(dims, keepdim=True)``.

    >>> least(torch.tensor([[2.0, 1.0], [3.0, torch.nan]]), [1])
    tensor([[1.],
            [nan]])
    """
    return _with_nan(x.amin(dims, keepdim=True), x, dims)


def greatest(x: Tensor, dims: List[int]) -> Tensor:
    """``x.amax(dims, keepdim=True)``.

    >>> greatest(torch.tensor([[2.0, 1.0], [3.0, torch.nan]]), [1])
    tensor([[2.],
            [nan]])
    """
    return _with_nan(x.amax(dims, keepdim=True), x, dims)


@primitive
def _with_nan(extreme: Tensor, x: Tensor, dims: List[int]) -> Tensor:
    """PyTorch's extreme, which is NaN already."""
    return extreme


@_with_nan.lowering("onnx")
def _nan_where_not_known(extreme: Tensor, x: Tensor, dims: List[int]) -> Tensor:
    known = (x == x).to(torch.float32).amin(dims, keepdim=True) > 0
    return torch.where(known, extreme, torch.full_like(extreme, float("nan")))
