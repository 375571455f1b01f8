"""Correlation with kernels of any shape that are given at run time, and sums over windows, in two and three
dimensions."""

from typing import List, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .padding import join_columns, padded, padded_parts, stencil, stencil3d
from .stencil import along_columns, along_rows, separable_by_kernel, separable_shared


def centred(size: int) -> Tuple[int, int]:
    """The number of pixels before and after its pixel in a window of ``size``; an even window has one more
    after it.

    >>> centred(5), centred(4)
    ((2, 2), (1, 2))
    """
    return (size - 1) // 2, size // 2


@primitive
def correlate2d_valid(p: Tensor, kernel: Tensor) -> Tensor:
    """Correlate (B, C, H + kh - 1, W + kw - 1) with (B or 1, kh, kw) to (B, C, H, W)."""
    kh, kw = kernel.size(1), kernel.size(2)
    height, width = p.size(2) - kh + 1, p.size(3) - kw + 1
    out = p[:, :, :height, :width] * kernel[:, 0, 0, None, None, None]
    for i in range(kh):
        rows = p[:, :, i : i + height]
        for j in range(kw):
            if i + j > 0:
                out = out + rows[..., j : j + width] * kernel[:, i, j, None, None, None]
    return out


def _is_shared(_: Tensor, kernel: Tensor) -> bool:
    # Do not compare a symbolic batch size with 1: the trace would keep the answer as a constant.
    batch = kernel.size(0)
    return isinstance(batch, int) and batch == 1


@correlate2d_valid.lowering("onnx", when=_is_shared)
def _convolution2d(p: Tensor, kernel: Tensor) -> Tensor:
    flat = F.conv2d(p.reshape(-1, 1, p.size(2), p.size(3)), kernel[:, None])
    return flat.reshape(p.size(0), p.size(1), flat.size(2), flat.size(3))


@correlate2d_valid.lowering("vjp")
def _sum_of_rows2d(p: Tensor, kernel: Tensor) -> Tensor:
    kh, height = kernel.size(1), p.size(2) - kernel.size(1) + 1
    shifts, taps = _shifts(p, kernel)
    total = (shifts[:, :, :, :height] * taps[:, :, 0, None, None, None]).sum(0)
    for i in range(1, kh):
        total = total + (shifts[:, :, :, i : i + height] * taps[:, :, i, None, None, None]).sum(0)
    return total


@primitive
def correlate3d_valid(p: Tensor, kernel: Tensor) -> Tensor:
    """Correlate (B, C, D + kd - 1, H + kh - 1, W + kw - 1) with (B or 1, kd, kh, kw) to (B, C, D, H, W)."""
    kd, kh, kw = kernel.size(1), kernel.size(2), kernel.size(3)
    depth, height, width = p.size(2) - kd + 1, p.size(3) - kh + 1, p.size(4) - kw + 1
    # With few operators a tap, because a volume has many taps, and an export traces every one.
    taps = kernel.flatten(1)[:, :, None, None, None, None].unbind(1)
    out = p[:, :, :depth, :height, :width] * taps[0]
    for d in range(kd):
        for i in range(kh):
            rows = p[:, :, d : d + depth, i : i + height]
            for j in range(kw):
                if d + i + j > 0:
                    out = out + rows[..., j : j + width] * taps[(d * kh + i) * kw + j]
    return out


@correlate3d_valid.lowering("onnx", when=_is_shared)
def _convolution3d(p: Tensor, kernel: Tensor) -> Tensor:
    # Without a bias, the exporter would add a wrong one.
    flat = F.conv3d(
        p.flatten(0, 1)[:, None], kernel[:, None], torch.zeros([1], dtype=p.dtype, device=p.device)
    )
    return flat.reshape(p.size(0), p.size(1), flat.size(2), flat.size(3), flat.size(4))


@correlate3d_valid.lowering("vjp")
def _sum_of_rows3d(p: Tensor, kernel: Tensor) -> Tensor:
    kd, kh = kernel.size(1), kernel.size(2)
    depth, height = p.size(2) - kd + 1, p.size(3) - kh + 1
    shifts, taps = _shifts(p, kernel)
    total = (shifts[:, :, :, :depth, :height] * taps[:, :, 0, 0, None, None, None, None]).sum(0)
    for d in range(kd):
        slices = shifts[:, :, :, d : d + depth]
        for i in range(kh):
            if d + i > 0:
                total = total + (
                    slices[:, :, :, :, i : i + height] * taps[:, :, d, i, None, None, None, None]
                ).sum(0)
    return total


def _shifts(p: Tensor, kernel: Tensor) -> Tuple[Tensor, Tensor]:
    """All shifts along the last axis, stacked in front, and the kernel with its last axis in front.

    A sum over a stack needs far fewer operators than separate products, and its gradient fewer still.
    """
    last = kernel.dim() - 1
    width = p.size(-1) - kernel.size(-1) + 1
    return torch.stack([p[..., j : j + width] for j in range(kernel.size(-1))]), torch.movedim(
        kernel, last, 0
    )


_bordered2d = stencil(correlate2d_valid)
_bordered3d = stencil3d(correlate3d_valid)


@primitive
def correlated2d(x: Tensor, kernel: Tensor, border_type: str) -> Tensor:
    """Correlate (B, C, H, W) with (B or 1, kh, kw), centred at each pixel. A constant border is 0."""
    return _bordered2d(x, centred(kernel.size(1)), centred(kernel.size(2)), border_type, kernel)


correlated2d.lowering("native", when=kernels.has_kernel)(kernels.correlate2d)


@primitive
def correlated3d(x: Tensor, kernel: Tensor, border_type: str) -> Tensor:
    """``correlated2d`` of a volume (B, C, D, H, W) with (B or 1, kd, kh, kw)."""
    depth, height, width = centred(kernel.size(1)), centred(kernel.size(2)), centred(kernel.size(3))
    return _bordered3d(x, depth, height, width, border_type, kernel)


correlated3d.lowering("native", when=kernels.has_kernel)(kernels.correlate3d)


def separable_any(
    x: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    rows: Tuple[int, int],
    columns: Tuple[int, int],
    border_type: str,
) -> Tensor:
    """Correlate with kernel_y (B or 1, ky), then kernel_x (B or 1, kx), of any sizes, after padding by
    (before, after)."""
    return along_rows(
        along_columns(x, rows, (0, 0), border_type, kernel_y), (0, 0), columns, border_type, kernel_x
    )


@primitive
def box_sums(
    x: Tensor, ky: int, kx: int, border_type: str, scale: float = 1.0, centre: float = 0.0
) -> Tensor:
    """``scale`` times the sums over windows of ky x kx pixels, plus ``centre`` times the pixel: (B, C, H, W)
    to the same.

    A constant border is 0. Sums of integers are exact while they fit the dtype, which float16 may not for
    numbers whose mean it holds.
    """
    # Native code does this for small windows too: a new sum for every pixel is cheaper than storing the
    # columns' sums.
    return _window_sums(x, centred(ky), centred(kx), border_type, ky, kx, scale, centre)


@stencil
def _window_sums(p: Tensor, ky: int, kx: int, scale: float, centre: float) -> Tensor:
    # The pixel is weighted here and not in the joined result, because native code stores that first.
    return _weighted(
        sum_shifts(sum_shifts(p, 2, ky), 3, kx), p[:, :, centred(ky)[0] :, centred(kx)[0] :], scale, centre
    )


@box_sums.lowering("onnx")
def _convolution_with_ones(
    x: Tensor, ky: int, kx: int, border_type: str, scale: float, centre: float
) -> Tensor:
    flat = padded(x.reshape(-1, 1, x.size(2), x.size(3)), centred(ky), centred(kx), border_type)
    ones = torch.ones([1, 1, ky, kx], dtype=x.dtype, device=x.device)
    sums = F.conv2d(F.conv2d(flat, ones[:, :, :, :1]), ones[:, :, :1]).reshape(x.shape)
    return _weighted(sums, x, scale, centre)


def _is_middling(x: Tensor, ky: int, kx: int, *_: object) -> bool:
    return kernels.has_kernel(x) and 9 < ky * kx <= 15 * 15 and ky % 2 == 1 and kx % 2 == 1


@box_sums.lowering("native", when=_is_middling)
def _kernel_of_ones(x: Tensor, ky: int, kx: int, border_type: str, scale: float, centre: float) -> Tensor:
    return separable_by_kernel(x, [1.0] * ky, [1.0] * kx, border_type, scale, centre)


@box_sums.lowering("native", when=lambda x, ky, kx, *_: ky * kx > 9)
def _sums_of_sums(x: Tensor, ky: int, kx: int, border_type: str, scale: float, centre: float) -> Tensor:
    rows, columns = centred(ky), centred(kx)
    tall = join_columns([sum_shifts(p, 2, ky) for p in padded_parts(x, rows, (0, 0), border_type, 0.0)])
    pairs = zip(
        padded_parts(tall, (0, 0), columns, border_type, 0.0),
        padded_parts(x, (0, 0), columns, border_type, 0.0),
    )
    return join_columns(
        [_weighted(sum_shifts(p, 3, kx), q[..., columns[0] :], scale, centre) for p, q in pairs]
    )


@primitive
def separable_plus(
    x: Tensor, taps_y: List[float], taps_x: List[float], border_type: str, scale: float, centre: float
) -> Tensor:
    """``scale`` times ``separable_shared`` plus ``centre`` times x. Native code does not store the first
    term."""
    return _weighted(separable_shared(x, taps_y, taps_x, border_type), x, scale, centre)


separable_plus.lowering("native", when=kernels.has_kernel)(separable_by_kernel)


def _weighted(sums: Tensor, x: Tensor, scale: float, centre: float) -> Tensor:
    out = sums if scale == 1.0 else sums * scale
    return out if centre == 0.0 else out + x[:, :, : sums.size(2), : sums.size(3)] * centre


def sum_shifts(p: Tensor, dim: int, count: int) -> Tensor:
    """Sums over windows of ``count`` along ``dim``, without padding, in about log2(count) additions.

    >>> sum_shifts(torch.arange(6.0), 0, 3)
    tensor([ 3.,  6.,  9., 12.])
    """
    # Sums over 1, 2, 4, ... entries are made of pairs; those of count's binary digits are put end to end.
    size = p.size(dim) - count + 1
    window = p
    width = 1
    offset = 0
    out = p.narrow(dim, 0, size)
    while width <= count:
        if (count // width) % 2 == 1:
            part = window.narrow(dim, offset, size)
            out = part if offset == 0 else out + part
            offset += width
        if 2 * width <= count:
            pairs = window.size(dim) - width
            window = window.narrow(dim, 0, pairs) + window.narrow(dim, width, pairs)
        width = 2 * width
    return out


def max_shifts(p: Tensor, dim: int, count: int) -> Tensor:
    """Maxima over windows of ``count`` along ``dim``, without padding.

    >>> max_shifts(torch.tensor([1.0, 3.0, 2.0, 0.0]), 0, 2)
    tensor([3., 3., 2.])
    """
    size = p.size(dim) - count + 1
    out = p.narrow(dim, 0, size)
    for i in range(1, count):
        out = torch.maximum(out, p.narrow(dim, i, size))
    return out


@primitive
def weigh_and_thin(p: Tensor, taps_y: List[float], taps_x: List[float], stride: int) -> Tensor:
    """Valid separable correlation of (B, C, H, W); keeps every stride-th row and column of the result."""
    return _thin(_weigh(_thin(_weigh(p, 2, taps_y), 2, stride), 3, taps_x), 3, stride)


@weigh_and_thin.lowering("onnx")
def _strided_convolution(p: Tensor, taps_y: List[float], taps_x: List[float], stride: int) -> Tensor:
    flat = p.reshape(-1, 1, p.size(2), p.size(3))
    column = torch.tensor(taps_y, dtype=p.dtype, device=p.device).reshape(1, 1, -1, 1)
    row = torch.tensor(taps_x, dtype=p.dtype, device=p.device).reshape(1, 1, 1, -1)
    # Drop the axis of size 1: with it, a reshape to divided sizes fails.
    flat = F.conv2d(flat, column * row, stride=[stride, stride])[:, 0]
    return flat.reshape(p.size(0), p.size(1), flat.size(1), flat.size(2))


@weigh_and_thin.lowering("native", when=lambda p, *_: kernels.has_kernel(p))
def _thinned_kernel(p: Tensor, taps_y: List[float], taps_x: List[float], stride: int) -> Tensor:
    rows, down = _windows(p, 2, taps_y, stride)
    columns, across = _windows(p, 3, taps_x, stride)
    return kernels.resampled(p, rows, down, columns, across)


def _windows(p: Tensor, dim: int, taps: List[float], stride: int) -> Tuple[Tensor, Tensor]:
    """For each result along an axis, the indices that are summed, and their taps."""
    first = torch.arange((p.size(dim) - len(taps)) // stride + 1) * stride
    index = first[:, None] + torch.arange(len(taps))
    return index, torch.tensor(taps, dtype=p.dtype).expand(index.shape).contiguous()


def _weigh(p: Tensor, dim: int, taps: List[float]) -> Tensor:
    size = p.size(dim) - len(taps) + 1
    out = p.narrow(dim, 0, size) * taps[0]
    for i in range(1, len(taps)):
        out = out + p.narrow(dim, i, size) * taps[i]
    return out


def _thin(x: Tensor, dim: int, stride: int) -> Tensor:
    if stride == 1:
        return x
    # By index: for a slice with a step, the trace would have to prove for every size that its end is inside.
    return x.index_select(dim, torch.arange((x.size(dim) - 1) // stride + 1, device=x.device) * stride)
