"""Maxima and minima over windows, for floating-point numbers and integers of 8 and 16 bits."""

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows
from ..core.lowering import primitive
from ..core.pixels import difference, narrow, ordered, saturated
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
    tall = _along(ordered(x), (ry, ry), (0, 0), border_type, 2, rows, largest, value)
    return _along(tall, (0, 0), (rx, rx), border_type, 3, columns, largest, value).to(x.dtype)


@minmax_filter.lowering("onnx", when=narrow)
def _minmax_filter_in_int32(
    x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float = 0.0
) -> Tensor:
    """ONNX Runtime has no minima for these types."""
    return minmax_filter(x.to(torch.int32), rows, columns, border_type, largest, value).to(x.dtype)


@minmax_filter.lowering("native", when=kernels.has_pixel_kernel)
def _minmax_filter_kernel(
    x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float = 0.0
) -> Tensor:
    values, step = as_rows(x)
    return from_rows(kernels.minmax_filter(values, step, rows, columns, border_type, value, largest), x)


@stencil
def _along(p: Tensor, dim: int, count: int, largest: bool) -> Tensor:
    """The extreme of each ``count`` successive entries along ``dim``."""
    size = p.size(dim) - count + 1
    length = 1
    while length < count:
        # Two windows of this length make one of up to twice the length; they may overlap.
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
    max_val: float,
    largest: bool,
) -> Tensor:
    """The largest x + height or smallest x - height over a window that begins (row, column) before each pixel
    of (B, C, H, W).

    The heights are (kh, kw); the largest take them reversed, as in a dilation. A height of -``max_val``
    excludes its pixel. For integers, all other heights count as 0.
    """
    kh, kw = heights.size(0), heights.size(1)
    above, beside = (row, kh - row - 1), (column, kw - column - 1)
    if x.is_floating_point():
        return _structured(x, above, beside, border_type, heights, largest, value)
    # An excluded pixel is beyond the range of pixels; if all are excluded, the result is clamped to the
    # range.
    flat = -1048576 * (heights == -max_val).to(torch.int32)
    return saturated(_structured(x.to(torch.int32), above, beside, border_type, flat, largest, value), x)


@stencil
def _structured(p: Tensor, heights: Tensor, largest: bool) -> Tensor:
    return _highest(p, heights) if largest else _lowest(p, heights)


@morphology.lowering("native", when=kernels.has_pixel_kernel)
def _morphology_kernel(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    value: float,
    max_val: float,
    largest: bool,
) -> Tensor:
    window = (heights.flip([0, 1]) if largest else heights).to(torch.float64)
    values, step = as_rows(x)
    return from_rows(
        kernels.morphology(values, step, window, row, column, border_type, value, max_val, largest), x
    )


@primitive
def morphology_gradient(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    high_value: float,
    low_value: float,
    max_val: float,
) -> Tensor:
    """The largest minus the smallest ``morphology``. A constant border is ``high_value`` for the first and
    ``low_value`` for the second. Integers saturate."""
    high = morphology(x, heights, row, column, border_type, high_value, max_val, True)
    return difference(high, morphology(x, heights, row, column, border_type, low_value, max_val, False))


@morphology_gradient.lowering("native", when=kernels.has_pixel_kernel)
def _morphology_gradient_kernel(
    x: Tensor,
    heights: Tensor,
    row: int,
    column: int,
    border_type: str,
    high_value: float,
    low_value: float,
    max_val: float,
) -> Tensor:
    window = heights.to(torch.float64)
    values, step = as_rows(x)
    return from_rows(
        kernels.morphology_gradient(
            values,
            step,
            window.flip([0, 1]),
            window,
            row,
            column,
            border_type,
            high_value,
            low_value,
            max_val,
        ),
        x,
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
