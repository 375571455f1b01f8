"""The smallest and the greatest value, which are NaN on every engine if any value is NaN (ONNX Runtime's own
reductions ignore NaN), and where they are; sums of bytes."""

from typing import List

import torch
from torch import Tensor

from ..core.layout import as_rows
from ..core.lowering import primitive
from ..core.pixels import ordered
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
def extreme_indices(x: Tensor) -> Tensor:
    """The pixels (B, C, 2), int64, of the first least and of the first greatest value of each channel of x
    (B, C, H, W), counted row by row. NaN is ignored; 0 for a channel of NaN.

    >>> extreme_indices(torch.tensor([[5, 7], [2, 2]]).reshape(1, 1, 2, 2))
    tensor([[[2, 1]]])
    """
    values = ordered(x).flatten(2)
    low, high = values, values
    if x.is_floating_point():
        unknown = torch.isnan(values)
        low = torch.where(unknown, torch.full_like(values, float("inf")), values)
        high = torch.where(unknown, torch.full_like(values, -float("inf")), values)
    first = _first_true(values == low.amin(2, keepdim=True))
    last = _first_true(values == high.amax(2, keepdim=True))
    return torch.stack([first, last], 2)


def _first_true(x: Tensor) -> Tensor:
    """The index (B, C), int64, of the first true value of (B, C, N), or 0."""
    # No argmax: compiled loops process it one value at a time
    count = x.size(2)
    index = torch.arange(count, dtype=torch.int32, device=x.device)
    first = torch.where(x, index, torch.full_like(index, count)).amin(2)
    return torch.where(first < count, first, torch.zeros_like(first)).to(torch.int64)


@extreme_indices.lowering("native", when=lambda x: kernels.has_pixel_kernel(x))
def _extreme_indices_kernel(x: Tensor) -> Tensor:
    rows, step = as_rows(x)
    return kernels.extreme_indices(rows.flatten(1), step).reshape(x.size(0), x.size(1), 2)


@primitive
def moments_bytes(x: Tensor) -> Tensor:
    """The sum and the sum of squares (B, C, 2), int64, of each channel of uint8 (B, C, H, W).

    >>> moments_bytes(torch.tensor([[1, 255]], dtype=torch.uint8).reshape(1, 1, 1, 2))
    tensor([[[  256, 65026]]])
    """
    values = x.flatten(2).to(torch.int64)
    return torch.stack([values.sum(2), (values * values).sum(2)], 2)


@moments_bytes.lowering("native", when=kernels.available)
def _moments_bytes_kernel(x: Tensor) -> Tensor:
    rows, step = as_rows(x)
    return kernels.moments_bytes(rows.flatten(1), step).reshape(x.size(0), x.size(1), 2)
