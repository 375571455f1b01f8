"""The 256 levels of 8-bit images: quantisation of values, counts of levels, and tables with an entry per
level."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.layout import in_planes
from ..core.lowering import primitive
from ..core.materialise import materialised
from ..kernels import operators as kernels
from ..linalg.matrices import small_matmul
from ..numbers.reductions import greatest, least
from ..numbers.rounding import known_or, to_index


@primitive
def quantize_u8(x: Tensor) -> Tensor:
    """The nearest of the 256 levels of a floating-point image, half up, as int32 (uint8 in native code).
    Values outside [0, 1] count as 0 or 1, NaN as 0.

    >>> quantize_u8(torch.tensor([-1.0, 0.5, 2.0]))
    tensor([  0, 128, 255], dtype=torch.int32)
    """
    # The clamp is between the product and the sum, because a compiler would fuse these, with other rounding.
    # Adding 0.5 would round one float32 number up to 255 wrongly, the one before 0.5; adding the number
    # before 0.5 rounds all of them correctly.
    scaled = known_or(x.to(torch.float32) * 255.0, 0.0).clamp(0.0, 255.0)
    return torch.floor(scaled + 0.49999997).to(torch.int32).clamp(0, 255)


quantize_u8.lowering("native", when=kernels.has_kernel)(kernels.quantize_u8)


def level_rows(image: Tensor) -> Tensor:
    """The levels of each channel of (B, C, *), in [0, 1] or bytes, as the rows of (B * C, N).

    >>> level_rows(torch.tensor([[[0.0, 1.0]]]))
    tensor([[  0, 255]], dtype=torch.int32)
    """
    levels = in_planes(image) if image.dtype == torch.uint8 else quantize_u8(image)
    return levels.flatten(2).flatten(0, 1)


@primitive
def bincount(index: Tensor, bins: int) -> Tensor:
    """The counts (P, bins), int32, of the numbers 0 to ``bins`` - 1 in each row of (P, N).

    >>> bincount(torch.tensor([[0, 2, 2]]), 3)
    tensor([[1, 0, 2]], dtype=torch.int32)
    """
    where = index.to(torch.int64)
    zeros = torch.zeros([index.size(0), bins], dtype=torch.int32, device=index.device)
    return zeros.scatter_add(1, where, torch.ones_like(where, dtype=torch.int32))


@bincount.lowering("native", when=kernels.available)
def _bincount_kernel(index: Tensor, bins: int) -> Tensor:
    short = isinstance(bins, int) and bins <= 256  # not for symbolic sizes, which this would limit
    return kernels.bincount(index.to(torch.uint8 if short else torch.int32), bins)


def mirrored(size: int, padded: int, device: torch.device) -> Tensor:
    """The source index of each position of a padded axis; beyond the end it is mirrored without repeating the
    last pixel."""
    last = size - 1
    return last - (last - torch.arange(padded, device=device)).abs()


def tile_start(padded: int, tile: int, device: torch.device) -> Tensor:
    return torch.div(torch.arange(padded, device=device), tile, rounding_mode="floor")


@primitive
def clahe_histograms(levels: Tensor, tile_y: int, tile_x: int, tiles_y: int, tiles_x: int) -> Tensor:
    """The counts (P, tiles, 256), int32, of each level in each of tiles_y x tiles_x tiles of tile_y x tile_x
    pixels. The planes (P, H, W) are mirrored at their bottom and right ends."""
    device = levels.device
    high, wide = tile_y * tiles_y, tile_x * tiles_x
    padded = levels.index_select(1, mirrored(levels.size(1), high, device)).index_select(
        2, mirrored(levels.size(2), wide, device)
    )
    tile = tile_start(high, tile_y, device)[:, None] * tiles_x + tile_start(wide, tile_x, device)
    counts = bincount((tile * 256 + padded).flatten(1), tiles_y * tiles_x * 256)
    return counts.unflatten(1, [tiles_y * tiles_x, 256])


@clahe_histograms.lowering("native", when=kernels.available)
def _clahe_histograms_kernel(levels: Tensor, tile_y: int, tile_x: int, tiles_y: int, tiles_x: int) -> Tensor:
    return kernels.clahe_histograms(levels.to(torch.uint8), tile_y, tile_x, tiles_y, tiles_x)


@primitive
def clahe_interpolate(
    table: Tensor,
    tiles_x: int,
    levels: Tensor,
    y0: Tensor,
    y1: Tensor,
    wy: Tensor,
    x0: Tensor,
    x1: Tensor,
    wx: Tensor,
) -> Tensor:
    """The levels (P, H, W), each mapped by the curves of four tiles, blended bilinearly and rounded to a
    level again.

    ``table`` (P, tiles * 256) float32 has the tiles' curves. Row y blends those of the tile rows y0[y] and,
    with weight wy[y], y1[y].
    """
    corners: List[Tensor] = []
    for y in [y0, y1]:
        for x in [x0, x1]:
            index = (y[:, None] * tiles_x + x) * 256 + levels
            corners.append(lut(table, index.flatten(1)).reshape(levels.shape))
    upper = corners[0] * (1.0 - wx) + corners[1] * wx
    lower = corners[2] * (1.0 - wx) + corners[3] * wx
    below = wy[:, None]
    return torch.round(upper * (1.0 - below) + lower * below)


@clahe_interpolate.lowering("native", when=lambda table, tiles_x, levels, *_: kernels.available(levels))
def _clahe_interpolate_kernel(
    table: Tensor,
    tiles_x: int,
    levels: Tensor,
    y0: Tensor,
    y1: Tensor,
    wy: Tensor,
    x0: Tensor,
    x1: Tensor,
    wx: Tensor,
) -> Tensor:
    return kernels.clahe_interpolate(
        table.unflatten(1, [-1, 256]), tiles_x, levels.to(torch.uint8), y0, y1, wy, x0, x1, wx
    )


@primitive
def aminmax(x: Tensor) -> Tuple[Tensor, Tensor]:
    """The smallest and the greatest value of each row of (P, N), both (P, 1).

    >>> aminmax(torch.tensor([[2.0, 1.0, 3.0]]))
    (tensor([[1.]]), tensor([[3.]]))
    """
    return least(x, [1]), greatest(x, [1])


@aminmax.lowering("native", when=kernels.has_kernel)
def _aminmax_kernel(x: Tensor) -> Tuple[Tensor, Tensor]:
    both = kernels.aminmax(x)
    return both[0], both[1]


@primitive
def row_histograms(x: Tensor, low: Tensor, span: Tensor, bins: int) -> Tensor:
    """The counts, int32, of the values of each row of (P, N) in each of ``bins`` bins, which divide ``span``
    (P, 1) from ``low`` (P, 1) on.

    >>> row_histograms(torch.tensor([[0.0, 0.4, 1.0]]), torch.zeros(1, 1), torch.ones(1, 1), 2)
    tensor([[2, 1]], dtype=torch.int32)
    """
    return bincount(to_index((x - low) / span * float(bins), bins), bins)


row_histograms.lowering("native", when=kernels.has_kernel)(kernels.row_histograms)


def whole_quotient(a: Tensor, b: Tensor) -> Tensor:
    """floor(a / b) of integers below 2^53, as int64: in float64, because vector units do not divide integers.

    >>> whole_quotient(torch.tensor([100000001]), torch.tensor([10]))
    tensor([10000000])
    """
    return torch.floor(a.to(torch.float64) / b.to(torch.float64)).to(torch.int64)


@primitive
def lut(table: Tensor, index: Tensor) -> Tensor:
    """Entries of the rows of ``table`` (P, K) at ``index`` (P, N), integers that must lie in range."""
    return materialised(table, 0).gather(1, index.to(torch.int64))


def _has_256(table: Tensor, _: Tensor) -> bool:
    return kernels.has_kernel(table) and isinstance(table.size(1), int) and table.size(1) == 256


@lut.lowering("native", when=_has_256)
def _lut_kernel(table: Tensor, index: Tensor) -> Tensor:
    return kernels.lut(table, index.to(torch.uint8))


@primitive
def partial_sums(x: Tensor) -> Tensor:
    """Sums of the first 1, 2, ..., n - 1 entries along the last axis (..., n), floating point.

    >>> partial_sums(torch.tensor([1.0, 2.0, 3.0]))
    tensor([1., 3.])
    """
    return x.cumsum(-1)[..., : x.size(-1) - 1]


# A gradient's ``cumsum`` has no form in ONNX.
@partial_sums.lowering("vjp")
def _product_with_a_triangle(x: Tensor) -> Tensor:
    n = x.size(-1)
    number = torch.arange(n, device=x.device)
    return small_matmul(x, (number[:, None] <= number[None, : n - 1]).to(x.dtype))


@primitive
def running_sum(x: Tensor) -> Tensor:
    """Inclusive sums along the last axis, of a size that is a multiple of 16 (256 levels), in x's dtype.

    A gradient's ``cumsum`` has no form in ONNX: there rows of 16 are multiplied by a triangular matrix, and
    then the rows' totals.

    >>> running_sum(torch.ones(1, 32))[0, -1]
    tensor(32.)
    """
    return x.cumsum(-1, dtype=x.dtype)


@running_sum.lowering("vjp")
def _sums_under_a_triangle(x: Tensor) -> Tensor:
    rows = x.unflatten(-1, [-1, 16])
    i = torch.arange(16, device=x.device)
    inner = (rows[..., None, :] * (i[None, :] <= i[:, None]).to(x.dtype)).sum(-1, dtype=x.dtype)
    totals = inner[..., 15]
    j = torch.arange(totals.size(-1), device=x.device)
    before = (totals[..., None, :] * (j[None, :] < j[:, None]).to(x.dtype)).sum(-1, dtype=x.dtype)
    return (inner + before[..., None]).flatten(-2)
