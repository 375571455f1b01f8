"""The smallest and the greatest value, which are NaN on every engine if any value is NaN (ONNX Runtime's own
reductions ignore NaN), and where they are; sums of bytes."""

from typing import List

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels


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


@primitive
def extreme_index(x: Tensor, greatest: bool) -> Tensor:
    """The index (N,), int64, of the first least, or greatest, value of each row of x (N, L). NaN is ignored;
    0 for a row of NaN.

    >>> extreme_index(torch.tensor([[5, 7, 2, 2]]), False)
    tensor([2])
    """
    values = x
    if x.is_floating_point():
        ignored = torch.full_like(x, -float("inf") if greatest else float("inf"))
        values = torch.where(torch.isnan(x), ignored, x)
    wanted = values.amax(1, keepdim=True) if greatest else values.amin(1, keepdim=True)
    # No argmax: compiled loops process it one value at a time
    count = x.size(1)
    index = torch.arange(count, dtype=torch.int32, device=x.device)
    first = torch.where(x == wanted, index, torch.full_like(index, count)).amin(1)
    return torch.where(first < count, first, torch.zeros_like(first)).to(torch.int64)


@extreme_index.lowering("native", when=lambda x, *_: kernels.has_pixel_kernel(x))
def _extreme_index_kernel(x: Tensor, greatest: bool) -> Tensor:
    return kernels.extreme_index(x, greatest)


@primitive
def moments_bytes(x: Tensor) -> Tensor:
    """The sum and the sum of squares (N, 2), int64, of each row of uint8 (N, L).

    >>> moments_bytes(torch.tensor([[1, 2, 255]], dtype=torch.uint8))
    tensor([[  258, 65030]])
    """
    values = x.to(torch.int64)
    return torch.stack([values.sum(1), (values * values).sum(1)], 1)


moments_bytes.lowering("native", when=kernels.available)(kernels.moments_bytes)
