"""Positions and weights of resampling: tables per axis for resizing, taps per pixel for warping."""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ..numbers.rounding import known_or


def larger(a: int, b: int) -> int:
    """max of two sizes without fixing their order when the sizes are symbolic."""
    if torch.jit.is_scripting():
        return max(a, b)
    else:
        return torch.sym_max(a, b)  # pyright: ignore[reportReturnType]


def smaller(a: int, b: int) -> int:
    """min of two sizes without fixing their order when the sizes are symbolic."""
    if torch.jit.is_scripting():
        return min(a, b)
    else:
        return torch.sym_min(a, b)  # pyright: ignore[reportReturnType]


def weight_dtype(x: Tensor) -> torch.dtype:
    """The dtype of positions and weights for x: in half precision, positions would be off by whole pixels."""
    if x.dtype == torch.float64:
        return torch.float64
    return torch.float32


def index_dtype(sizes: List[int]) -> torch.dtype:
    """A type for the numbers of the pixels of an image or volume of these sizes: int32, unless their count is
    known to exceed it. The specs of exports limit symbolic sizes."""
    count = 1
    for size in sizes:
        if not isinstance(size, int):
            return torch.int32
        count = count * size
    return torch.int64 if count > 2147483647 else torch.int32


def source_positions(
    in_size: int, out_size: int, align_corners: bool, dtype: torch.dtype, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Source position of each of ``out_size`` pixels as (whole part, fraction in [0, 1)).

    With ``align_corners`` the centres of the corner pixels coincide, else the outer edges do (half-pixel
    centres). Both are ratios of integers and are computed as such, without rounding, so every backend has the
    same taps.
    """
    whole, rest, denominator = exact_positions(in_size, out_size, align_corners, device)
    return whole, rest.to(dtype) / denominator


def exact_positions(
    in_size: int, out_size: int, align_corners: bool, device: torch.device
) -> Tuple[Tensor, Tensor, int]:
    """``source_positions`` as whole parts, and numerators and the denominator of the fractions."""
    i = torch.arange(out_size, device=device)
    if align_corners:
        numerator = i * (in_size - 1)
        denominator = larger(out_size - 1, 1)
        shift = 0
    else:
        numerator = (2 * i + 1) * in_size - out_size
        denominator = 2 * out_size
        shift = 1  # the first position can be as low as -1/2; adding 1 keeps the division positive
    whole = (
        torch.floor((numerator + shift * denominator).to(torch.float64) / denominator).to(torch.int64) - shift
    )
    return whole, numerator - whole * denominator, denominator


def nearest_index(in_size: int, out_size: int, device: torch.device) -> Tensor:
    """Index of the source pixel of each output pixel, floor(i * in / out), exactly: in float64, because
    vector units do not divide integers."""
    return torch.floor((torch.arange(out_size, device=device) * in_size).to(torch.float64) / out_size).to(
        torch.int64
    )


def cubic_weights(t: Tensor, a: float) -> List[Tensor]:
    """Weights of the four neighbours at distances 1 + t, t, 1 - t, 2 - t under the cubic convolution kernel.

    R. Keys, Cubic Convolution Interpolation for Digital Image Processing, IEEE TASSP 29(6), 1981.
    """
    return [cubic_kernel(t + 1.0, a), cubic_kernel(t, a), cubic_kernel(1.0 - t, a), cubic_kernel(2.0 - t, a)]


def cubic_kernel(distance: Tensor, a: float) -> Tensor:
    """Keys' kernel of a nonnegative distance: piecewise cubic, zero from 2 on."""
    d = distance
    near = ((a + 2.0) * d - (a + 3.0)) * d * d + 1.0
    far = ((a * d - 5.0 * a) * d + 8.0 * a) * d - 4.0 * a
    return torch.where(d < 1.0, near, torch.where(d < 2.0, far, torch.zeros_like(d)))


def lanczos_kernel(distance: Tensor, lobes: float) -> Tensor:
    """sinc(x) sinc(x / lobes) of a nonnegative distance, zero from ``lobes`` on.

    K. Turkowski, Filters for Common Resampling Tasks, Graphics Gems I, 1990.
    """
    weight = _sinc(distance) * _sinc(distance / lobes)
    return torch.where(distance < lobes, weight, torch.zeros_like(weight))


def lanczos_weights(t: Tensor) -> Tensor:
    """Weights (n, 8) of the neighbours at distances 3 + t, ..., t, 1 - t, ..., 4 - t under the kernel of four
    lobes, which add up to 1."""
    weight = lanczos_kernel((t[:, None] - torch.arange(-3, 5, device=t.device)).abs(), 4.0)
    return weight / weight.sum(1, keepdim=True)


def _sinc(x: Tensor) -> Tensor:
    """``torch.sinc``, which torch 2.13 exports to ONNX with a float32 pi, even for float64."""
    zero = x == 0.0
    turned = torch.where(zero, torch.ones_like(x), x * math.pi)
    return torch.where(zero, torch.ones_like(x), torch.sin(turned) / turned)


def area_table(in_size: int, out_size: int, device: torch.device) -> Tuple[Tensor, Tensor]:
    """The pixels (out_size, taps) that each output pixel covers, and how much of each, in units of 1 /
    out_size: integers in float64, which add up to ``in_size``."""
    place = torch.arange(out_size, device=device).to(torch.float64)
    length = torch.ones([1], dtype=torch.float64, device=device) * out_size
    return covered_pixels(place, length, in_size, (in_size + out_size - 1) // out_size + 1)


def covered_pixels(place: Tensor, length: Tensor, in_size: int, taps: int) -> Tuple[Tensor, Tensor]:
    """``area_table`` for the pixels with the numbers ``place`` (n,) of an output of ``length`` (1,) pixels,
    both whole numbers in float64: (n, taps) each."""
    begin = place[:, None] * in_size
    first = torch.floor(begin / length)
    pixel = first + torch.arange(taps, device=place.device)
    end = torch.minimum((pixel + 1.0) * length, begin + in_size)
    covered = (end - torch.maximum(pixel * length, begin)).clamp(min=0.0)
    return pixel.clamp(0, in_size - 1).to(torch.int64), covered


def antialias_table(
    in_size: int, out_size: int, align_corners: bool, shape: str, dtype: torch.dtype, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Indices and weights (out_size, taps) of a filter stretched by the reduction factor.

    "bilinear" is the triangle, "bicubic" Keys' cubic with a = -0.5, "lanczos" has three lobes; weights are
    cut off at the image's border and normalised, as in Pillow's ``Image.resize``. A single output pixel has
    the whole image under its filter, with ``align_corners`` too, where PyTorch reads the first pixel.
    """
    one = torch.ones([1], dtype=dtype, device=device)
    from_size, to_size = in_size, out_size
    if align_corners:
        from_size, to_size = in_size - 1, larger(out_size - 1, 1)
    factor = one * from_size / to_size
    # Twice the support, rounded up, plus the partial pixel at either end. It is computed in integers, so that
    # it may be a symbolic size.
    taps = 2 * filter_radius(shape) * ((from_size + to_size - 1) // to_size) + 2
    place = torch.arange(out_size, device=device).to(dtype)
    return filter_weights(place, factor, factor.clamp(min=1.0), in_size, taps, shape)


def filter_radius(shape: str) -> int:
    """How far the filter of ``antialias_table`` reaches, before it is stretched."""
    return 1 if shape == "bilinear" else (2 if shape == "bicubic" else 3)


def filter_weights(
    place: Tensor, factor: Tensor, stretch: Tensor, in_size: int, taps: int, shape: str
) -> Tuple[Tensor, Tensor]:
    """``antialias_table`` for the output's pixels with the numbers ``place`` (n,): (n, taps) each. ``factor``
    (1,) is the reduction, ``stretch`` (1,) what the filter is stretched by. A pixel that reaches no pixel has
    weights NaN."""
    radius = filter_radius(shape)
    centre = (place + 0.5) * factor
    first = torch.floor(centre - radius * stretch + 0.5).clamp(min=0.0)
    pixel = first[:, None] + torch.arange(taps, device=place.device).to(place.dtype)
    distance = (pixel + 0.5 - centre[:, None]).abs() / stretch
    if radius == 1:
        weight = (1.0 - distance).clamp(min=0.0)
    elif radius == 2:
        weight = cubic_kernel(distance, -0.5)
    else:
        weight = lanczos_kernel(distance, 3.0)
    weight = torch.where(pixel < in_size, weight, torch.zeros_like(weight))
    index = pixel.clamp(max=in_size - 1).to(torch.int64)
    return index, weight / weight.sum(1, keepdim=True)


def reflect_positions(x: Tensor, size: int, align_corners: bool) -> Tensor:
    """Fold positions into the image by mirroring at the corner pixels' centres, or at the outer edges."""
    if align_corners:
        low = 0.0
        span = torch.ones([1], dtype=x.dtype, device=x.device) * larger(size - 1, 1)
    else:
        low = -0.5
        span = torch.ones([1], dtype=x.dtype, device=x.device) * size
    t = (x - low).abs()
    turns = torch.floor(t / span)
    rest = t - turns * span
    odd = turns - 2.0 * torch.floor(turns * 0.5)
    return (torch.where(odd > 0.5, span - rest, rest) + low).clamp(0, size - 1)


def bilinear_taps(x: Tensor, y: Tensor, height: int, width: int) -> Tuple[List[Tensor], List[Tensor]]:
    """Flat indices (``index_dtype``) and weights of the four pixels around each position; weights are zero
    outside the image."""
    # Clamp first, to keep the conversion to integers defined; anything beyond one pixel outside reads
    # nothing.
    x = x.clamp(-2, width + 1)
    y = y.clamp(-2, height + 1)
    # NaN counts as outside.
    left = known_or(torch.floor(x.detach()), -2.0)
    upper = known_or(torch.floor(y.detach()), -2.0)
    fx = x - left
    fy = y - upper
    zero = torch.zeros_like(fx)
    x0 = torch.where((left >= 0) & (left <= width - 1), 1.0 - fx, zero)
    x1 = torch.where((left >= -1) & (left <= width - 2), fx, zero)
    y0 = torch.where((upper >= 0) & (upper <= height - 1), 1.0 - fy, zero)
    y1 = torch.where((upper >= -1) & (upper <= height - 2), fy, zero)
    kind = index_dtype([height, width])
    column = left.to(kind)
    row = upper.to(kind)
    c0 = column.clamp(0, width - 1)
    c1 = (column + 1).clamp(0, width - 1)
    r0 = row.clamp(0, height - 1) * width
    r1 = (row + 1).clamp(0, height - 1) * width
    return [r0 + c0, r0 + c1, r1 + c0, r1 + c1], [y0 * x0, y0 * x1, y1 * x0, y1 * x1]


def nearest_taps(x: Tensor, y: Tensor, height: int, width: int) -> Tuple[List[Tensor], List[Tensor]]:
    """Flat index (``index_dtype``) and weight (1, or 0 outside the image) of the nearest pixel, half to
    even."""
    kind = index_dtype([height, width])
    column = known_or(torch.round(x.detach().clamp(-2, width + 1)), -2.0).to(kind)
    row = known_or(torch.round(y.detach().clamp(-2, height + 1)), -2.0).to(kind)
    inside = (column >= 0) & (column <= width - 1) & (row >= 0) & (row <= height - 1)
    return [row.clamp(0, height - 1) * width + column.clamp(0, width - 1)], [inside.to(x.dtype)]


def cubic_taps(
    x: Tensor, y: Tensor, height: int, width: int, padding_mode: str, align_corners: bool
) -> Tuple[List[Tensor], List[Tensor]]:
    """Flat indices (``index_dtype``) and weights of the 4 x 4 pixels around each position, by Keys' kernel
    with a = -0.75.

    As in ``grid_sample`` and OpenCV, "border" and "reflection" move the pixels that are read, not the
    position. A position that is NaN, or infinite with "reflection", reads nothing: all weights are 0.
    """
    kind = index_dtype([height, width])
    column, across = _cubic_axis(x, width, padding_mode, align_corners, kind)
    row, down = _cubic_axis(y, height, padding_mode, align_corners, kind)
    index: List[Tensor] = []
    weight: List[Tensor] = []
    for i in range(4):
        for j in range(4):
            index.append(row[i] * width + column[j])
            weight.append(down[i] * across[j])
    return index, weight


def _cubic_axis(
    x: Tensor, size: int, padding_mode: str, align_corners: bool, kind: torch.dtype
) -> Tuple[List[Tensor], List[Tensor]]:
    if padding_mode != "reflection":
        # Further outside than three pixels, nothing changes. The clamp keeps the conversion to integers
        # defined.
        x = x.clamp(-4, size + 3)
    first = torch.floor(x.detach())
    fraction = x - first
    known = fraction == fraction  # False for infinities too
    # Keep it finite, so that the arithmetic below cannot produce NaN; positions further away have no
    # fraction.
    first = torch.where(known, first, torch.full_like(first, -4.0)).clamp(
        -4503599627370496.0, 4503599627370496.0
    )
    weights = cubic_weights(fraction, -0.75)
    index: List[Tensor] = []
    weight: List[Tensor] = []
    for k in range(4):
        pixel = first + (k - 1.0)
        if padding_mode == "reflection":
            pixel = reflect_positions(pixel, size, align_corners)
        read = known
        if padding_mode != "border" and padding_mode != "reflection":
            read = (pixel >= 0) & (pixel <= size - 1)
        weight.append(torch.where(read, weights[k], torch.zeros_like(x)))
        index.append(pixel.clamp(0, size - 1).to(kind))
    return index, weight


def bounded_taps(
    low: Tensor,
    extent: Tensor,
    out_size: int,
    mode: str,
    align_corners: bool,
    dtype: torch.dtype,
    steps: int = 0,
) -> Tuple[List[Tensor], List[Tensor]]:
    """Indices and weights (B, out_size) that resize, along one axis, the ``extent`` (B,) pixels from ``low``
    (B,) on.

    mode: "nearest", "bilinear" or "bicubic" as for resizing, or "pad": pixels keep their size and zeros
    follow. steps: if not 0, positions are rounded to this part of a pixel, half to even.
    """
    i = torch.arange(out_size, device=low.device)[None]
    size, first = extent[:, None], low[:, None]
    if mode == "pad":
        return [first + torch.minimum(i, size - 1)], [(i < size).to(dtype)]
    if mode == "nearest":
        pixel = torch.floor((i * size).to(torch.float64) / out_size).to(torch.int64)
        return [first + pixel], [torch.ones_like(pixel).to(dtype)]
    if align_corners:
        numerator = i * (size - 1)
        denominator = larger(out_size - 1, 1)
    else:
        numerator = (2 * i + 1) * size - out_size
        denominator = 2 * out_size
    whole = torch.floor(numerator.to(torch.float64) / denominator).to(torch.int64)
    fraction = (numerator - whole * denominator).to(dtype) / denominator
    if steps > 0:
        fraction = torch.round(fraction * steps) / steps
    if mode == "bilinear":
        weight, start = [1.0 - fraction, fraction], 0
    else:
        weight, start = cubic_weights(fraction, -0.75), -1
    zero = torch.zeros_like(whole)
    return [
        first + torch.minimum(torch.maximum(whole + (start + k), zero), size - 1) for k in range(len(weight))
    ], weight


def gather_taps(plane: Tensor, index: List[Tensor], weight: List[Tensor]) -> Tensor:
    """Weighted sum over taps: plane (B, C, H, W), index and weight (B or 1, h, w) each -> (B, C, h, w)."""
    batch, channels = plane.size(0), plane.size(1)
    height, width = weight[0].size(1), weight[0].size(2)
    flat = plane.reshape(batch, channels, plane.size(2) * plane.size(3))
    out = torch.zeros([1], dtype=plane.dtype, device=plane.device)
    for i in range(len(index)):
        where = (
            index[i]
            .to(torch.int64)
            .reshape(index[i].size(0), 1, height * width)
            .expand(batch, channels, height * width)
        )
        out = out + flat.gather(2, where).reshape(batch, channels, height, width) * weight[i][:, None]
    return out
