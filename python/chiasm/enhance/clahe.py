"""Contrast-limited adaptive histogram equalisation.

K. Zuiderveld, Contrast limited adaptive histogram equalization, Graphics Gems IV, 1994, in the form of
OpenCV's ``createCLAHE``.
"""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank, check_tensor, check_values
from ..primitives.core.layout import in_planes
from ..primitives.images.histograms import (
    clahe_histograms,
    clahe_interpolate,
    lut,
    mirrored,
    quantize_u8,
    running_sum,
    tile_start,
    whole_quotient,
)
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.numbers.rounding import to_index
from ..primitives.resampling.taps import smaller


def clahe(image: Tensor, clip_limit: float = 40.0, tile_grid_size: Tuple[int, int] = (8, 8)) -> Tensor:
    """CLAHE of each uint8 channel, identical to OpenCV's ``createCLAHE(clipLimit, tileGridSize).apply``.

    Args:
        image: (B, C, H, W), uint8, H and W greater than the number of tiles.
        clip_limit: the limit of a level's count in a tile, as a multiple of the mean count; 0 or less means
            no limit.
        tile_grid_size: number of tiles (across, down), in OpenCV's order.

    Returns:
        (B, C, H, W), uint8.

    Raises:
        TypeError: if image is not uint8.
        ValueError: if image is not 4-D or not larger than the grid, or the grid is not positive.

    Example:
        >>> clahe(torch.full((1, 1, 16, 16), 7, dtype=torch.uint8)).shape
        torch.Size([1, 1, 16, 16])
    """
    check_tensor(image, "image")
    if image.dtype != torch.uint8:
        raise TypeError(f"image: expected dtype torch.uint8, got {image.dtype}")
    check_rank(image, 4, "(B, C, H, W)", "image")
    tiles_x, tiles_y = tile_grid_size
    _check_grid(image, tiles_y, tiles_x, "image", "tile_grid_size")
    return (
        _equalized(in_planes(image).flatten(0, 1), clip_limit, tiles_y, tiles_x)
        .to(torch.uint8)
        .reshape(image.shape)
    )


def equalize_clahe(
    input: Tensor,
    clip_limit: Union[float, Tensor] = 40.0,
    grid_size: Tuple[int, int] = (8, 8),
    slow_and_differentiable: bool = False,
) -> Tensor:
    """Equalize the clipped histogram of each tile, and blend the curves of neighbouring tiles (CLAHE). For
    256 levels, and for uint8, the result equals OpenCV's ``createCLAHE``; Kornia's differs in borders and
    rounding. Other values are rounded to the nearest level, and there is no gradient.

    Args:
        input: (*, H, W), floating point in [0, 1], or uint8, H and W greater than the number of tiles; planes
            are independent.
        clip_limit: the limit of a level's count in a tile, as a multiple of the mean count; 0 or less means
            no limit. A number, or a tensor (B,) of positive numbers, one for each entry of the first
            dimension.
        grid_size: number of tiles (down, across).
        slow_and_differentiable: True splits each pixel between its two nearest levels and rounds nothing, so
            that there are gradients; not for uint8.

    Returns:
        Tensor of the input's shape and dtype: multiples of 1 / 255 (unless slow_and_differentiable), or
        uint8.

    Raises:
        TypeError: if input is neither floating point nor uint8, or is uint8 and slow_and_differentiable.
        ValueError: if input has fewer than two dimensions or is not larger than the grid, or the grid is not
            positive.

    Example:
        >>> equalize_clahe(torch.rand(1, 3, 20, 30)).shape
        torch.Size([1, 3, 20, 30])
    """
    if slow_and_differentiable:
        check_floating(input, "input")
    check_values(input, "input")
    if input.dim() < 2:
        raise ValueError(f"input: expected shape (*, H, W), got {list(input.shape)}")
    tiles_y, tiles_x = grid_size
    _check_grid(input, tiles_y, tiles_x, "input", "grid_size")
    if isinstance(clip_limit, Tensor):
        if clip_limit.dim() != 1 or input.dim() < 3 or clip_limit.size(0) != input.size(0):
            raise ValueError(
                f"clip_limit: expected a number, or shape ({input.size(0)},), got {list(clip_limit.shape)}"
            )
        channels = 1
        for i in range(1, input.dim() - 2):
            channels = channels * input.size(i)
        clip_limit = clip_limit[:, None].expand(input.size(0), channels).reshape(-1)  # one for each plane
    if input.dtype == torch.uint8:
        bytes = in_planes(input).reshape([-1, input.size(-2), input.size(-1)])
        return _equalized(bytes, clip_limit, tiles_y, tiles_x).to(torch.uint8).reshape(input.shape)
    planes = input.reshape([-1, input.size(-2), input.size(-1)])
    if slow_and_differentiable:
        made = _equalized_softly(widened(planes), clip_limit, tiles_y, tiles_x)  # counts exceed float16
        return narrowed(made, input).reshape(input.shape)
    return (_equalized(quantize_u8(planes), clip_limit, tiles_y, tiles_x).to(input.dtype) / 255.0).reshape(
        input.shape
    )


def _check_grid(image: Tensor, tiles_y: int, tiles_x: int, image_name: str, grid_name: str) -> None:
    if tiles_y < 1 or tiles_x < 1:
        raise ValueError(f"{grid_name}: expected positive numbers, got {tiles_y} down and {tiles_x} across")
    if image.size(-2) <= tiles_y or image.size(-1) <= tiles_x:
        raise ValueError(
            f"{image_name}: expected more than {tiles_y} rows and {tiles_x} columns, got {list(image.shape)}"
        )


def _padded_size(size: int, other: int, tiles: int, other_tiles: int) -> int:
    """OpenCV pads both axes if one is not a multiple of its tiles; an axis that is a multiple gets a whole
    pixel for each tile."""
    return size + (tiles - size % tiles) * smaller(size % tiles + other % other_tiles, 1)


def _limit(clip_limit: Union[float, Tensor], pixels: int, device: torch.device) -> Tensor:
    """The largest count of a level in a tile, a whole number, (1,) or (P, 1, 1)."""
    if isinstance(clip_limit, Tensor):
        limit = clip_limit.to(torch.float64)[:, None, None]
    else:
        limit = torch.full([1], clip_limit, dtype=torch.float64, device=device)
    return torch.floor(limit * pixels / 256.0).clamp(min=1.0)


def _limits(clip_limit: Union[float, Tensor]) -> bool:
    return True if isinstance(clip_limit, Tensor) else clip_limit > 0.0


def _blend(size: int, tile: int, tiles: int, device: torch.device) -> Tuple[Tensor, Tensor, Tensor]:
    """For each position along an axis: the two tiles whose curves are blended, and the weight of the second
    one, in float32 as in OpenCV."""
    # 2 / (2 tile), because ONNX Runtime turns a product with 1 / tile into a quotient, which rounds
    # differently
    two = torch.full([1], 2.0, device=device)
    position = torch.arange(size, device=device).to(torch.float32) * torch.div(two, two * tile) - 0.5
    first = torch.floor(position)
    lower = first.to(torch.int64).clamp(min=0)
    upper = (first.to(torch.int64) + 1).clamp(max=tiles - 1)
    return lower, upper, position - first


def _equalized(levels: Tensor, clip_limit: Union[float, Tensor], tiles_y: int, tiles_x: int) -> Tensor:
    """(P, H, W) levels to (P, H, W) levels."""
    height, width = levels.size(1), levels.size(2)
    high = _padded_size(height, width, tiles_y, tiles_x)
    wide = _padded_size(width, height, tiles_x, tiles_y)
    tile_y, tile_x = high // tiles_y, wide // tiles_x
    pixels = tile_y * tile_x
    device = levels.device
    counts = clahe_histograms(levels, tile_y, tile_x, tiles_y, tiles_x)
    if _limits(clip_limit):
        counts = _clipped(counts, _limit(clip_limit, pixels, device).to(torch.int32))
    # float32 products, rounded to even, as in OpenCV, for every dtype of the image
    scale = torch.div(torch.full([1], 255.0, device=device), torch.ones([1], device=device) * pixels)
    table = torch.round(running_sum(counts).to(torch.float32) * scale).clamp(0.0, 255.0).flatten(1)
    y0, y1, wy = _blend(height, tile_y, tiles_y, device)
    x0, x1, wx = _blend(width, tile_x, tiles_x, device)
    return clahe_interpolate(table, tiles_x, levels, y0, y1, wy, x0, x1, wx)


def _clipped(counts: Tensor, limit: Tensor) -> Tensor:
    """Clip counts (P, T, 256) at the limit and distribute the excess to all levels; the remainder goes to
    evenly spaced levels."""
    excess = (counts - limit).clamp(min=0).sum(-1, keepdim=True, dtype=torch.int32)
    levels = torch.full_like(excess, 256)
    share = whole_quotient(excess, levels).to(torch.int32)
    rest = excess - share * 256
    step = whole_quotient(levels, rest.clamp(min=1))
    level = torch.arange(256, device=counts.device)
    turn = whole_quotient(level, step)
    extra = (turn * step == level) & (turn < rest)
    return torch.minimum(counts, limit) + share + extra.to(torch.int32)


def _equalized_softly(x: Tensor, clip_limit: Union[float, Tensor], tiles_y: int, tiles_x: int) -> Tensor:
    """(P, H, W) values to (P, H, W) values: ``_equalized`` with every step made continuous."""
    height, width = x.size(1), x.size(2)
    high = _padded_size(height, width, tiles_y, tiles_x)
    wide = _padded_size(width, height, tiles_x, tiles_y)
    tile_y, tile_x = high // tiles_y, wide // tiles_x
    pixels = tile_y * tile_x
    device = x.device
    scaled = x.clamp(0.0, 1.0) * 255.0
    level = to_index(scaled.detach(), 255)
    share = scaled - level
    rows, columns = mirrored(height, high, device), mirrored(width, wide, device)
    level_padded = level.index_select(1, rows).index_select(2, columns)
    share_padded = share.index_select(1, rows).index_select(2, columns).flatten(1)
    tile = tile_start(high, tile_y, device)[:, None] * tiles_x + tile_start(wide, tile_x, device)
    index = (tile * 256 + level_padded).flatten(1)
    counts = torch.zeros([x.size(0), tiles_y * tiles_x * 256], dtype=x.dtype, device=device)
    counts = counts.scatter_add(1, index, 1.0 - share_padded).scatter_add(1, index + 1, share_padded)
    counts = counts.unflatten(1, [tiles_y * tiles_x, 256])
    if _limits(clip_limit):
        limit = _limit(clip_limit, pixels, device).to(x.dtype)
        excess = (counts - limit).clamp(min=0.0).sum(-1, keepdim=True)
        counts = torch.minimum(counts, limit) + excess / 256.0
    table = (running_sum(counts) / pixels).flatten(1)
    y0, y1, wy = _blend(height, tile_y, tiles_y, device)
    x0, x1, wx = _blend(width, tile_x, tiles_x, device)
    wy, wx = wy.to(x.dtype)[:, None], wx.to(x.dtype)
    corners: List[Tensor] = []
    for y in [y0, y1]:
        for column in [x0, x1]:
            where = ((y[:, None] * tiles_x + column) * 256 + level).flatten(1)
            below = lut(table, where).reshape(x.shape)
            above = lut(table, where + 1).reshape(x.shape)
            corners.append(below + (above - below) * share)
    upper = corners[0] * (1.0 - wx) + corners[1] * wx
    lower = corners[2] * (1.0 - wx) + corners[3] * wx
    return upper * (1.0 - wy) + lower * wy
