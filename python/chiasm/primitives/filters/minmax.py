"""Maxima and minima over windows."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .padding import stencil


@primitive
def minmax_filter(
    x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float = 0.0
) -> Tensor:
    """The largest or smallest value in the centred rectangle of odd size around each pixel of (B, C, H, W).

    By doubling the window's length, along columns and then along rows.

    >>> minmax_filter(torch.tensor([[[[0, 3, 1, 2]]]]), 1, 3, "constant", True)
    tensor([[[[3, 3, 3, 2]]]])
    """
    ry, rx = rows // 2, columns // 2
    tall = _along(x, (ry, ry), (0, 0), border_type, 2, rows, largest, value)
    return _along(tall, (0, 0), (rx, rx), border_type, 3, columns, largest, value)


@minmax_filter.lowering("native", when=kernels.has_kernel)
def _minmax_filter_kernel(
    x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float = 0.0
) -> Tensor:
    return kernels.minmax_filter(x, rows, columns, border_type, value, largest)


@stencil
def _along(p: Tensor, dim: int, count: int, largest: bool) -> Tensor:
    """The extreme of each ``count`` successive entries along ``dim``."""
    size = p.size(dim) - count + 1
    length = 1
    while length < count:
        # Two windows of this length make one of up to twice the length; what they share does no harm.
        step = min(length, count - length)
        left, right = p.narrow(dim, 0, p.size(dim) - step), p.narrow(dim, step, p.size(dim) - step)
        p = torch.maximum(left, right) if largest else torch.minimum(left, right)
        length = length + step
    return p.narrow(dim, 0, size)


@primitive
def morphology(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    value: float,
    absent: float,
    largest: bool,
) -> Tensor:
    """The largest x + height or smallest x - height over a window that begins (row, column) before each pixel
    of (B, C, H, W).

    As in a dilation the largest take the heights (kh, kw) from the other end. A height of -``absent`` is
    none.
    """
    kh, kw = heights.size(0), heights.size(1)
    return _structured(
        x, (row, kh - row - 1), (column, kw - column - 1), border_type, heights, largest, value
    )


@stencil
def _structured(p: Tensor, heights: Tensor, largest: bool) -> Tensor:
    return _highest(p, heights) if largest else _lowest(p, heights)


@morphology.lowering("native", when=kernels.has_kernel)
def _morphology_kernel(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    value: float,
    absent: float,
    largest: bool,
) -> Tensor:
    window = heights.flip([0, 1]) if largest else heights
    return kernels.morphology(x, window, row, column, border_type, value, absent, largest)


@primitive
def morphology_gradient(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    high_value: float,
    low_value: float,
    absent: float,
) -> Tensor:
    """The largest minus the smallest ``morphology``; beyond a constant border is ``high_value`` for the one,
    ``low_value`` for the other."""
    high = morphology(x, heights, row, column, border_type, high_value, absent, True)
    return high - morphology(x, heights, row, column, border_type, low_value, absent, False)


@morphology_gradient.lowering("native", when=kernels.has_kernel)
def _morphology_gradient_kernel(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    high_value: float,
    low_value: float,
    absent: float,
) -> Tensor:
    return kernels.morphology_gradient(
        x, heights.flip([0, 1]), heights, row, column, border_type, high_value, low_value, absent
    )


def _highest(p: Tensor, heights: Tensor) -> Tensor:
    kh, kw = heights.size(0), heights.size(1)
    height = p.size(2) - kh + 1
    width = p.size(3) - kw + 1
    out = p[:, :, 0:height, 0:width] + heights[kh - 1, kw - 1]
    for i in range(kh):
        for j in range(kw):
            if i + j > 0:
                shifted = p[:, :, i : i + height, j : j + width] + heights[kh - 1 - i, kw - 1 - j]
                out = torch.maximum(out, shifted)
    return out


def _lowest(p: Tensor, heights: Tensor) -> Tensor:
    kh, kw = heights.size(0), heights.size(1)
    height = p.size(2) - kh + 1
    width = p.size(3) - kw + 1
    out = p[:, :, 0:height, 0:width] - heights[0, 0]
    for i in range(kh):
        for j in range(kw):
            if i + j > 0:
                out = torch.minimum(out, p[:, :, i : i + height, j : j + width] - heights[i, j])
    return out
