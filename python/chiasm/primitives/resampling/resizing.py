"""Resizing, alone and with a blur before or after it, as for pyramids."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows, in_planes
from ..core.lowering import primitive
from ..core.materialise import materialised, stored_index
from ..core.pixels import has_words, pixel_range
from ..filters.fixed_point import rounded_sums
from ..filters.stencil import separable_shared
from ..kernels import operators as kernels
from ..numbers.reshaping import split_dim
from .taps import (
    antialias_table,
    area_table,
    cubic_weights,
    exact_positions,
    lanczos_weights,
    nearest_index,
    source_positions,
    weight_dtype,
)


@primitive
def resized(
    x: Tensor, height: int, width: int, interpolation: str, align_corners: bool, antialias: bool
) -> Tensor:
    """(B, C, H, W) as (B, C, height, width); ``interpolation`` is "nearest", "bilinear", "bicubic" or
    "lanczos4", with ``antialias`` "bilinear", "bicubic", "lanczos" or "area"."""
    if antialias:
        sides = [x.size(2), x.size(3)]
        (rows, down), (columns, across) = [
            _filter_table(i, o, align_corners, interpolation, x) for i, o in zip(sides, [height, width])
        ]
        return resampled(x, rows, down, columns, across)
    if interpolation == "nearest":
        return resized_nearest(x, height, width)
    if interpolation == "lanczos4":
        rows, down = _lanczos_table(x.size(2), height, align_corners, weight_dtype(x), x.device)
        columns, across = _lanczos_table(x.size(3), width, align_corners, weight_dtype(x), x.device)
        return resampled(x, rows, down.to(x.dtype), columns, across.to(x.dtype))
    if interpolation == "bilinear":
        return _bilinear(x, height, width, align_corners)
    return _bicubic_axis(_bicubic_axis(x, width, align_corners, 3), height, align_corners, 2)


def _has_resize(x: Tensor, height: int, width: int, interpolation: str, *_: object) -> bool:
    return kernels.has_kernel(x) and interpolation not in ("area", "lanczos", "lanczos4")


resized.lowering("native", when=_has_resize)(kernels.resize)


@primitive
def resampled(x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor) -> Tensor:
    """(B, C, H, W) resampled along the rows and then down the columns: pixel i of a row is the sum of its
    pixels ``columns[i]`` times the weights ``across[i]``; row j is the sum of these rows ``rows[j]`` times
    ``down[j]``."""
    return _sums(_sums(x, columns, across, 3), rows, down, 2)


resampled.lowering("native", when=kernels.has_kernel)(kernels.resampled)


def _filter_table(
    in_size: int, out_size: int, align_corners: bool, shape: str, x: Tensor
) -> Tuple[Tensor, Tensor]:
    """Indices and weights (out_size, taps), in a type for x, of a filter as wide as the reduction."""
    if shape == "area":
        index, parts = area_table(in_size, out_size, x.device)
        return index, (parts / in_size).to(x.dtype)
    index, weight = antialias_table(in_size, out_size, align_corners, shape, weight_dtype(x), x.device)
    return index, weight.to(x.dtype)


@primitive
def resized_bytes(x: Tensor, height: int, width: int, align_corners: bool) -> Tensor:
    """Bytes (B, C, H, W) as (B, C, height, width), bilinear: by weights in 1/256, rounded half up. All
    products are integers below 2^24, exact in float32."""
    rows, down = _fixed_table(x.size(2), height, align_corners, 256, x.device)
    columns, across = _fixed_table(x.size(3), width, align_corners, 256, x.device)
    image, down, across = x.to(torch.float32), down.to(torch.float32)[:, :, None], across.to(torch.float32)
    top, bottom = image.index_select(2, rows[:, 0]), image.index_select(2, rows[:, 1])
    image = top * down[:, 0] + bottom * down[:, 1]
    left, right = image.index_select(3, columns[:, 0]), image.index_select(3, columns[:, 1])
    sums = left * across[:, 0] + right * across[:, 1]
    return rounded_sums(sums)


@resized_bytes.lowering("native", when=kernels.available)
def _resized_bytes_kernel(x: Tensor, height: int, width: int, align_corners: bool) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.resize_bytes(rows, height, width, step, align_corners), x)


def resized_words(x: Tensor, height: int, width: int, interpolation: str, align_corners: bool) -> Tensor:
    """16 bits (B, C, H, W) as (B, C, height, width), rounded once, half up, and saturated. Weights are
    multiples of 1/2^18 for "bilinear" and "bicubic" (a = -0.75), and of 1/2^17 for "lanczos4", whose
    overshoot takes a bit. So the sums are integers below 2^53, exact in float64.

    >>> resized_words(torch.tensor([[[[-300, 20000]]]], dtype=torch.int16), 1, 3, "bilinear", False)
    tensor([[[[ -300,  9850, 20000]]]], dtype=torch.int16)
    """
    steps = 131072 if interpolation == "lanczos4" else 262144
    rows, down = _words_table(x.size(2), height, interpolation, align_corners, steps, x.device)
    columns, across = _words_table(x.size(3), width, interpolation, align_corners, steps, x.device)
    total = torch.full([1], steps, dtype=torch.float64, device=x.device) * steps
    return weighted_means(x, rows, down, columns, across, total)


def _words_table(
    in_size: int, out_size: int, interpolation: str, align_corners: bool, steps: int, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices and weights (out_size, taps), in units of 1 / ``steps``, which add up to ``steps``."""
    if interpolation == "bilinear":
        return _fixed_table(in_size, out_size, align_corners, steps, device)
    index, weight = _wide_table(in_size, out_size, interpolation, align_corners, device)
    whole = torch.round(steps * weight)
    # One of the two pixels beside the position gets what rounding takes from the sum.
    beside = weight.size(1) // 2
    rest = steps - whole[:, :beside].sum(1) - whole[:, beside + 1 :].sum(1)
    return index, torch.cat([whole[:, :beside], rest[:, None], whole[:, beside + 1 :]], 1)


@primitive
def weighted_means(
    x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor, total: Tensor
) -> Tensor:
    """Integers of 8 or 16 bits (B, C, H, W), ``resampled``: the sums are divided by ``total`` (1,), rounded
    half up and saturated. Weights and total are integers in float64; sums below 2^53 are exact.

    >>> x = torch.tensor([[[[10, 20]]]], dtype=torch.int16)
    >>> one, both = torch.zeros(1, 1, dtype=torch.int64), torch.tensor([[0, 1]])
    >>> weights = torch.tensor([[1.0, 2.0]], dtype=torch.float64)
    >>> weighted_means(x, one, torch.ones_like(weights[:, :1]), both, weights, weights.sum(1))
    tensor([[[[17]]]], dtype=torch.int16)
    """
    sums = resampled(in_planes(x).to(torch.float64), rows, down, columns, across)
    low, high = pixel_range(x)
    return torch.floor((2.0 * sums + total) / (2.0 * total)).clamp(low, high).to(x.dtype)


@weighted_means.lowering("native", when=has_words)
def _weighted_means_kernel(
    x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor, total: Tensor
) -> Tensor:
    pixels, step = as_rows(x)
    down, across, total = down.to(torch.int64), across.to(torch.int64), total.to(torch.int64)
    return from_rows(kernels.resample_words(pixels, rows, down, columns, across, total, step), x)


@primitive
def resampled_bytes(x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor) -> Tensor:
    """Bytes (B, C, H, W) resampled along the rows and then down the columns: pixel i of a row is the sum of
    its pixels ``columns[i]`` times the taps ``across[i]``; row j is the sum of these rows ``rows[j]`` times
    ``down[j]``.

    Taps are multiples of 1/2^22. Both sums are exact in float64, rounded half up and saturated.
    """
    return _summed(_summed(x, columns, across, 3), rows, down, 2)


def _summed(x: Tensor, index: Tensor, taps: Tensor, dim: int) -> Tensor:
    sums = _sums(x.to(torch.float64), index, taps, dim)
    return torch.floor(sums / 4194304.0 + 0.5).clamp(0.0, 255.0).to(torch.uint8)


def _sums(x: Tensor, index: Tensor, taps: Tensor, dim: int) -> Tensor:
    """The sums along an axis of the pixels ``index`` (n, taps) times their ``taps``."""
    picked = split_dim(x.index_select(dim, index.reshape(-1)), dim, index.size(0), index.size(1))
    return (picked * (taps[:, :, None] if dim == 2 else taps)).sum(dim + 1)


@resampled_bytes.lowering("native", when=kernels.available)
def _resampled_bytes_kernel(x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor) -> Tensor:
    pixels, step = as_rows(x)
    down, across = down.to(torch.int32), across.to(torch.int32)
    return from_rows(kernels.resample_bytes(pixels, rows, down, columns, across, step), x)


@primitive
def area_means(x: Tensor, height: int, width: int) -> Tensor:
    """(B, C, height, width): the mean over the area of (B, C, H, W), integers of 8 or 16 bits, that each
    pixel covers, rounded half up. The sums are integers, exact in float64.

    >>> area_means(torch.tensor([[1, 2, 5], [2, 2, 5]], dtype=torch.uint8)[None, None], 1, 2)
    tensor([[[[2, 4]]]], dtype=torch.uint8)
    """
    rows, down = area_table(x.size(2), height, x.device)
    columns, across = area_table(x.size(3), width, x.device)
    area = torch.ones([1], dtype=torch.float64, device=x.device) * x.size(2) * x.size(3)
    return weighted_means(x, rows, down, columns, across, area)


@area_means.lowering("native", when=lambda x, *_: kernels.available(x) and x.dtype == torch.uint8)
def _area_kernel(x: Tensor, height: int, width: int) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.area_bytes(rows, height, width, step), x)


def wide_bytes(x: Tensor, height: int, width: int, interpolation: str, align_corners: bool) -> Tensor:
    """Bytes (B, C, H, W) as (B, C, height, width), "bicubic" or "lanczos4", by weights in 1/2^11."""
    rows, down = _wide_table(x.size(2), height, interpolation, align_corners, x.device)
    columns, across = _wide_table(x.size(3), width, interpolation, align_corners, x.device)
    return summed_bytes(x, rows, torch.round(2048.0 * down), columns, torch.round(2048.0 * across))


@primitive
def summed_bytes(x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor) -> Tensor:
    """``resampled`` of bytes by weights that are multiples of 1/2^11. Rounded once, half up, and saturated.
    The sums are integers, exact in float64.

    >>> x, first = torch.tensor([[[[10, 20]]]], dtype=torch.uint8), torch.zeros(1, 4, dtype=torch.int64)
    >>> once, half = torch.tensor([[2048.0, 0, 0, 0]]), torch.tensor([[1024.0, 1024, 0, 0]])
    >>> summed_bytes(x, first, once, torch.tensor([[0, 1, 0, 0]]), half)
    tensor([[[[15]]]], dtype=torch.uint8)
    """
    sums = resampled(in_planes(x).to(torch.float64), rows, down, columns, across)
    return torch.floor(sums * (1.0 / 4194304.0) + 0.5).clamp(0.0, 255.0).to(torch.uint8)


@summed_bytes.lowering("native", when=lambda x, rows, *_: kernels.available(x) and rows.size(1) == 4)
def _summed_bytes_kernel(x: Tensor, rows: Tensor, down: Tensor, columns: Tensor, across: Tensor) -> Tensor:
    pixels, step = as_rows(x)
    down, across = down.to(torch.int64), across.to(torch.int64)
    return from_rows(kernels.resize_cubic_bytes(pixels, rows, down, columns, across, step), x)


def _wide_table(
    in_size: int, out_size: int, interpolation: str, align_corners: bool, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices of the neighbours of each position, and their float64 weights: "bicubic" (a = -0.75) or
    "lanczos4"."""
    if interpolation == "bicubic":
        return _cubic_table(in_size, out_size, align_corners, device)
    return _lanczos_table(in_size, out_size, align_corners, torch.float64, device)


def _cubic_table(
    in_size: int, out_size: int, align_corners: bool, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices (out_size, 4) of the neighbours of each position, and their weights, float64."""
    whole, rest, denominator = exact_positions(in_size, out_size, align_corners, device)
    weights = torch.stack(cubic_weights(rest.to(torch.float64) / denominator, -0.75), 1)
    neighbours = whole[:, None] + torch.arange(-1, 3, device=device)
    return neighbours.clamp(0, in_size - 1), weights


def _lanczos_table(
    in_size: int, out_size: int, align_corners: bool, dtype: torch.dtype, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices (out_size, 8) of the neighbours of each position, and their weights."""
    whole, fraction = source_positions(in_size, out_size, align_corners, dtype, device)
    neighbours = whole[:, None] + torch.arange(-3, 5, device=device)
    return neighbours.clamp(0, in_size - 1), lanczos_weights(fraction)


def resized_bytes_antialias(
    x: Tensor, height: int, width: int, interpolation: str, align_corners: bool
) -> Tensor:
    """Bytes (B, C, H, W) as (B, C, height, width), "bilinear", "bicubic" or "lanczos", by a filter that is as
    wide as the reduction."""
    rows, down = antialias_table(x.size(2), height, align_corners, interpolation, torch.float64, x.device)
    columns, across = antialias_table(x.size(3), width, align_corners, interpolation, torch.float64, x.device)
    return resampled_bytes(x, rows, torch.round(down * 4194304.0), columns, torch.round(across * 4194304.0))


def _fixed_table(
    in_size: int, out_size: int, align_corners: bool, steps: int, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices (out_size, 2) of the two neighbours of each position, and their weights in units of 1 /
    ``steps``: integers in float64, which add up to ``steps``."""
    whole, rest, denominator = exact_positions(in_size, out_size, align_corners, device)
    # Exact: quotients of integers that are exact in float64.
    weight = torch.floor((2 * steps * rest + denominator).to(torch.float64) / (2 * denominator))
    weight = torch.where(whole < 0, torch.zeros_like(weight), weight)
    neighbours = torch.stack([whole, whole + 1], 1).clamp(0, in_size - 1)
    return neighbours, torch.stack([steps - weight, weight], 1)


@primitive
def resized_nearest(x: Tensor, height: int, width: int) -> Tensor:
    """(B, C, H, W) of any type as (B, C, height, width): pixel floor(i * in / out) along each axis."""
    rows = x.index_select(2, stored_index(nearest_index(x.size(2), height, x.device)))
    return rows.index_select(3, stored_index(nearest_index(x.size(3), width, x.device)))


@resized_nearest.lowering("native", when=kernels.has_pixel_kernel)
def _resized_nearest_kernel(x: Tensor, height: int, width: int) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.resize_nearest(rows, height, width, step), x)


def _bilinear(x: Tensor, height: int, width: int, align_corners: bool) -> Tensor:
    top, bottom, down = _linear_table(x, height, align_corners, 2)
    left, right, across = _linear_table(x, width, align_corners, 3)
    upper, lower = x.index_select(2, top), x.index_select(2, bottom)
    down = down[:, None]
    # Name each tap only once: then AOTInductor fuses the four gathers into one loop, without an intermediate
    # image.
    first = upper.index_select(3, left) * (1.0 - across) + upper.index_select(3, right) * across
    second = lower.index_select(3, left) * (1.0 - across) + lower.index_select(3, right) * across
    return first * (1.0 - down) + second * down


def _linear_table(x: Tensor, out_size: int, align_corners: bool, dim: int) -> Tuple[Tensor, Tensor, Tensor]:
    """Indices of the two neighbours, and the weight of the second, for each of ``out_size`` positions."""
    in_size = x.size(dim)
    whole, fraction = source_positions(in_size, out_size, align_corners, weight_dtype(x), x.device)
    first = stored_index(whole.clamp(0, in_size - 1))
    second = stored_index((whole + 1).clamp(0, in_size - 1))
    return first, second, materialised(fraction.to(x.dtype), 0)


def _bicubic_axis(x: Tensor, out_size: int, align_corners: bool, dim: int) -> Tensor:
    in_size = x.size(dim)
    whole, fraction = source_positions(in_size, out_size, align_corners, weight_dtype(x), x.device)
    whole = materialised(whole, 0)
    weights = [materialised(w.to(x.dtype), 0) for w in cubic_weights(fraction, -0.75)]
    if dim == 2:
        weights = [w[:, None] for w in weights]
    out = x.index_select(dim, (whole - 1).clamp(0, in_size - 1)) * weights[0]
    for k in range(1, 4):
        out = out + x.index_select(dim, (whole + (k - 1)).clamp(0, in_size - 1)) * weights[k]
    return out


def _in_one_pass(
    x: Tensor, height: int, width: int, align_corners: bool, taps: List[float], border_type: str
) -> bool:
    # the kernel does not support "circular", whose pixels are too far apart
    return kernels.has_kernel(x) and border_type != "circular"


def _resized_in_one_pass(
    x: Tensor,
    height: int,
    width: int,
    align_corners: bool,
    taps: List[float],
    border_type: str,
    blurred_before: bool,
) -> Tensor:
    return kernels.resize_blurred(
        x, torch.tensor(taps, dtype=x.dtype), height, width, align_corners, border_type, blurred_before
    )


@primitive
def blurred_and_resized(
    x: Tensor, height: int, width: int, align_corners: bool, taps: List[float], border_type: str
) -> Tensor:
    """``resized``, bilinear, after ``separable_shared`` with the same symmetric taps along both axes."""
    return resized(
        separable_shared(x, taps, taps, border_type), height, width, "bilinear", align_corners, False
    )


@blurred_and_resized.lowering("native", when=_in_one_pass)
def _blurred_and_resized_kernel(
    x: Tensor, height: int, width: int, align_corners: bool, taps: List[float], border_type: str
) -> Tensor:
    return _resized_in_one_pass(x, height, width, align_corners, taps, border_type, True)


@primitive
def resized_and_blurred(
    x: Tensor, height: int, width: int, align_corners: bool, taps: List[float], border_type: str
) -> Tensor:
    """``resized``, bilinear, before ``separable_shared`` with the same symmetric taps along both axes."""
    return separable_shared(
        resized(x, height, width, "bilinear", align_corners, False), taps, taps, border_type
    )


@resized_and_blurred.lowering("native", when=_in_one_pass)
def _resized_and_blurred_kernel(
    x: Tensor, height: int, width: int, align_corners: bool, taps: List[float], border_type: str
) -> Tensor:
    return _resized_in_one_pass(x, height, width, align_corners, taps, border_type, False)
