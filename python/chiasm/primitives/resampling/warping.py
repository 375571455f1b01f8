"""Reading an image at given positions: the last step of every warp."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..core.checks import broadcastable, check_choice, check_floating, check_pixels, check_tensor
from ..core.layout import as_rows, from_rows, in_planes
from ..core.lowering import primitive
from ..core.pixels import has_words, pixel_range
from ..filters.stencil import join_channels, split_channels
from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .taps import bilinear_taps, cubic_taps, gather_taps, larger, nearest_taps, reflect_positions


def check_sampling(mode: str, padding_mode: str) -> None:
    """Raise ValueError unless ``resample_image`` knows both names."""
    check_choice(mode, ["bilinear", "nearest", "bicubic"], "mode")
    check_choice(padding_mode, ["zeros", "border", "reflection", "fill"], "padding_mode")


def check_source(src: Tensor, mode: str, padding_mode: str, name: str) -> None:
    """Raise unless ``src`` is an image (B, C, H, W), floating point, uint8, int16 or uint16, that these modes
    can read."""
    check_pixels(src, name, True)
    check_sampling(mode, padding_mode)


def check_fill(fill_value: Tensor, src: Tensor) -> None:
    """Raise unless ``fill_value`` is a tensor (C,) for ``src`` (B, C, H, W); either C may be 1."""
    check_tensor(fill_value, "fill_value")
    if fill_value.dim() != 1 or not broadcastable(fill_value, src, 0, 2):
        raise ValueError(
            f"fill_value: expected shape (C,) for an image {list(src.shape)}, got {list(fill_value.shape)}"
        )


def check_matrices(value: Tensor, rows: int, columns: int, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, rows, columns) tensor."""
    check_floating(value, name)
    if value.dim() != 3 or value.size(1) != rows or value.size(2) != columns:
        raise ValueError(f"{name}: expected shape (B, {rows}, {columns}), got {list(value.shape)}")


def position_dtype(dtype: torch.dtype) -> torch.dtype:
    """The dtype of positions in images of ``dtype``: half precision would be off by whole pixels.

    Positions in images of integers are float64: they are rounded to fractions of a pixel, and engines compute
    them with different errors.
    """
    if dtype in [torch.float64, torch.uint8, torch.int16, torch.uint16]:
        return torch.float64
    return torch.float32


def pixel_axes(height: int, width: int, dtype: torch.dtype, device: torch.device) -> Tuple[Tensor, Tensor]:
    """Columns (1, 1, width) and rows (1, height, 1) of an image's pixels."""
    column = torch.arange(width, device=device).to(dtype)[None, None, :]
    return column, torch.arange(height, device=device).to(dtype)[None, :, None]


def normalized_axis(size: int, align_corners: bool, dtype: torch.dtype, device: torch.device) -> Tensor:
    """Pixel centres (size,) in coordinates in which the image reaches from -1 to 1: its corner pixels'
    centres or its outer edges."""
    i = torch.arange(size, device=device).to(dtype)
    if align_corners:
        return i * 2.0 / larger(size - 1, 1) - 1.0
    return (i * 2.0 + 1.0) / size - 1.0


def from_normalized(x: Tensor, size: int, align_corners: bool) -> Tensor:
    """Pixel positions of positions in [-1, 1], in the same two conventions."""
    if align_corners:
        return (x + 1.0) * 0.5 * (size - 1)
    return ((x + 1.0) * size - 1.0) * 0.5


def stretched(x: Tensor, size: int) -> Tensor:
    """x * size / (size - 1) - 1/2: the position that results if ``size - 1`` normalises and outer edges are
    read."""
    return x * size / larger(size - 1, 1) - 0.5


def away_from_zero(depth: Tensor) -> Tensor:
    """A homogeneous coordinate, made safe as a divisor: points at infinity are far outside instead of NaN."""
    return torch.where(depth.abs() > 1e-8, depth, torch.full_like(depth, 1e-8))


def mapped(x: Tensor, y: Tensor, matrix: Tensor) -> Tuple[Tensor, Tensor]:
    """The points x and y, which broadcast to (B, h, w), mapped by homographies (B, 3, 3)."""
    m = matrix[:, :, :, None, None]
    depth = away_from_zero(m[:, 2, 0] * x + m[:, 2, 1] * y + m[:, 2, 2])
    return (m[:, 0, 0] * x + m[:, 0, 1] * y + m[:, 0, 2]) / depth, (
        m[:, 1, 0] * x + m[:, 1, 1] * y + m[:, 1, 2]
    ) / depth


def rounded_pixels(sums: Tensor, like: Tensor) -> Tensor:
    """Sums of floating point as integers of the type of ``like``, of 8 or 16 bits: rounded half up and
    saturated.

    >>> rounded_pixels(torch.tensor([-0.6, 1.5, 255.5]), torch.zeros(1, dtype=torch.uint8))
    tensor([  0,   2, 255], dtype=torch.uint8)
    """
    low, high = pixel_range(like)
    return torch.floor(sums + 0.5).clamp(low, high).to(like.dtype)


def _outside(src: Tensor, padding_mode: str, fill_value: Optional[Tensor], mode: str) -> Tuple[str, Tensor]:
    """For a kernel: how it pads, and what pixels outside are."""
    padding = "zeros" if padding_mode == "fill" else padding_mode
    if padding_mode != "fill" or fill_value is None:
        return padding, torch.zeros([1], dtype=src.dtype, device=src.device)
    check_fill(fill_value, src)
    level = fill_value if src.is_floating_point() else _filled_level(fill_value, src, mode)
    return padding, level.to(src.dtype).contiguous()


@primitive
def resample_floating(
    src: Tensor,
    x: Tensor,
    y: Tensor,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    """``resample_image`` for floating-point images."""
    height, width = src.size(2), src.size(3)
    if mode == "bicubic":
        index, weight = cubic_taps(x, y, height, width, padding_mode, align_corners)
    else:
        if padding_mode == "border":
            x = x.clamp(0, width - 1)
            y = y.clamp(0, height - 1)
        elif padding_mode == "reflection":
            x = reflect_positions(x, width, align_corners)
            y = reflect_positions(y, height, align_corners)
        if mode == "bilinear":
            index, weight = bilinear_taps(x, y, height, width)
        else:
            index, weight = nearest_taps(x, y, height, width)
    return weigh_image(src, index, weight, fill_value if padding_mode == "fill" else None)


@resample_floating.lowering("native", when=kernels.has_kernel)
def _resample_floating_kernel(
    src: Tensor,
    x: Tensor,
    y: Tensor,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    x, y = torch.broadcast_tensors(x.to(src.dtype), y.to(src.dtype))
    x, y = x.expand(src.size(0), -1, -1).contiguous(), y.expand(src.size(0), -1, -1).contiguous()
    padding, fill = _outside(src, padding_mode, fill_value, mode)
    return kernels.remap(src, x, y, mode, padding, align_corners, fill)


def _filled_level(fill_value: Tensor, src: Tensor, mode: str) -> Tensor:
    """``fill_value`` (C,) as levels of an image of integers, in the type in which its sums are exact."""
    low, high = pixel_range(src)
    return known_or(torch.round(fill_value.to(_exact_type(src, mode))), 0.0).clamp(low, high)


def _exact_type(src: Tensor, mode: str) -> torch.dtype:
    return torch.float32 if src.dtype == torch.uint8 and mode != "bicubic" else torch.float64


@primitive
def resample_bytes(
    src: Tensor,
    x: Tensor,
    y: Tensor,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    """``resample_image`` for integers of 8 or 16 bits. Positions are rounded, half to even: to 1/32 pixel,
    for "bilinear" and 16 bits to 1/65536 pixel, and for "nearest" to pixels. Sums are rounded half up and
    saturated. ``fill_value`` is rounded to integers, half to even, and saturated.

    1/32 pixel is the step of OpenCV's remap of 8 bits, version 4.6 (INTER_BITS = 5). Bilinear weights are
    then multiples of 1/2^10, whose sums of bytes are exact in float32, and bicubic weights multiples of
    1/2^34, whose sums are exact in float64. So are sums of 16 bits by bilinear weights of 1/2^32; a step of
    1/32 pixel would cost them the lower half of their bits.
    """
    steps = 1.0 if mode == "nearest" else 32.0
    if mode == "bilinear" and src.dtype != torch.uint8:
        steps = 65536.0
    # Further away nothing changes; NaN stays NaN.
    at_x = torch.round(x.to(torch.float64).clamp(-16777216.0, 16777216.0) * steps) / steps
    at_y = torch.round(y.to(torch.float64).clamp(-16777216.0, 16777216.0) * steps) / steps
    exact = in_planes(src).to(_exact_type(src, mode))
    if padding_mode == "fill" and fill_value is not None:
        check_fill(fill_value, src)
        # The fill is subtracted before sampling, so that the zeros outside the image stand for it.
        level = _filled_level(fill_value, src, mode)[:, None, None]
        sums = resample_floating(exact - level, at_x, at_y, mode, "zeros", align_corners, None) + level
    else:
        beyond = "zeros" if padding_mode == "fill" else padding_mode
        sums = resample_floating(exact, at_x, at_y, mode, beyond, align_corners, None)
    return rounded_pixels(sums, src)


def _has_integer_kernel(src: Tensor, mode: str) -> bool:
    return (kernels.available(src) and src.dtype == torch.uint8) or (has_words(src) and mode != "bicubic")


@resample_bytes.lowering("native", when=lambda src, x, y, mode, *_: _has_integer_kernel(src, mode))
def _resample_bytes_kernel(
    src: Tensor,
    x: Tensor,
    y: Tensor,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    rows, step = as_rows(src)
    is_words = src.dtype != torch.uint8
    if is_words or x.dtype != torch.float32 or y.dtype != torch.float32:
        x, y = x.to(torch.float64), y.to(torch.float64)
    x, y = torch.broadcast_tensors(x, y)
    remap = kernels.remap_words if is_words else kernels.remap_bytes
    padding, fill = _outside(src, padding_mode, fill_value, mode)
    made = remap(rows, x.contiguous(), y.contiguous(), step, mode, padding, align_corners, fill)
    return from_rows(made, src)


def resample_image(
    src: Tensor,
    x: Tensor,
    y: Tensor,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    """src (B, C, H, W) at pixel positions x and y (B, h, w), or (1, h, w) for all of them: (B, C, h, w).

    Args:
        mode, padding_mode: as ``check_sampling`` allows; ``fill_value`` (C,) is the colour for "fill", black
            by default.
        align_corners: whether "reflection" mirrors at the corner pixels' centres, else at the outer edges.
    """
    if not src.is_floating_point():
        return resample_bytes(src, x, y, mode, padding_mode, align_corners, fill_value)
    return resample_floating(src, x, y, mode, padding_mode, align_corners, fill_value)


@primitive
def resample_projective(
    src: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    """``resample_image`` at the positions to which ``matrix`` (B, 3, 3) maps the pixels of the output (B, C,
    height, width)."""
    precision = position_dtype(src.dtype)
    column, row = pixel_axes(height, width, precision, src.device)
    x, y = mapped(column, row, matrix.to(precision))
    return resample_image(src, x, y, mode, padding_mode, align_corners, fill_value)


@resample_projective.lowering("native", when=kernels.has_kernel)
def _resample_projective_kernel(
    src: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    matrix = matrix.to(position_dtype(src.dtype)).to(src.dtype).expand(src.size(0), 3, 3).contiguous()
    padding, fill = _outside(src, padding_mode, fill_value, mode)
    return kernels.warp_perspective(src, matrix, height, width, mode, padding, align_corners, fill)


def _of_integers(src: Tensor, matrix: Tensor, height: int, width: int, mode: str, *_: object) -> bool:
    return _has_integer_kernel(src, mode)


@resample_projective.lowering("native", when=_of_integers)
def _warp_integers_kernel(
    src: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    rows, step = as_rows(src)
    warp = kernels.warp_bytes if src.dtype == torch.uint8 else kernels.warp_words
    matrix = matrix.to(torch.float64).contiguous()
    padding, fill = _outside(src, padding_mode, fill_value, mode)
    return from_rows(warp(rows, matrix, height, width, step, mode, padding, align_corners, fill), src)


@primitive
def resample_affine(
    src: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    """``resample_projective`` with a ``matrix`` (B, 2, 3)."""
    precision = position_dtype(src.dtype)
    m = matrix.to(precision)[:, :, :, None, None]
    column, row = pixel_axes(height, width, precision, src.device)
    x = m[:, 0, 0] * column + m[:, 0, 1] * row + m[:, 0, 2]
    y = m[:, 1, 0] * column + m[:, 1, 1] * row + m[:, 1, 2]
    return resample_image(src, x, y, mode, padding_mode, align_corners, fill_value)


@resample_affine.lowering(
    "native", when=lambda src, *rest: kernels.has_kernel(src) or _of_integers(src, *rest)
)
def _resample_affine_kernel(
    src: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    mode: str,
    padding_mode: str,
    align_corners: bool,
    fill_value: Optional[Tensor],
) -> Tensor:
    precision = position_dtype(src.dtype)
    last = torch.tensor([0.0, 0.0, 1.0], dtype=precision, device=src.device).expand(matrix.size(0), 1, 3)
    whole = torch.cat([matrix.to(precision), last], 1)
    return resample_projective(src, whole, height, width, mode, padding_mode, align_corners, fill_value)


def weigh_image(
    src: Tensor, index: List[Tensor], weight: List[Tensor], fill_value: Optional[Tensor]
) -> Tensor:
    """The weighted sum of the taps; if the weights add up to less than 1, ``fill_value`` has the rest."""
    weight = [w.to(src.dtype) for w in weight]
    out = join_channels([gather_taps(plane, index, weight) for plane in split_channels(src)])
    if fill_value is not None:
        check_fill(fill_value, src)
        covered = weight[0]
        for w in weight[1:]:
            covered = covered + w
        out = out + (1.0 - covered)[:, None] * fill_value.to(src.dtype)[:, None, None]
    return out
