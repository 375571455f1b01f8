"""Mosaics of a batch's images."""

from typing import Dict, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_choice, check_pair, check_pixels
from ..primitives.random.draws import ranks, uniform
from .cut import cut
from .decisions import check_bounds, check_chance, drawn


def random_mosaic(
    input: Tensor,
    seed: Tensor,
    output_size: Optional[Tuple[int, int]] = None,
    mosaic_grid: Tuple[int, int] = (2, 2),
    start_ratio_range: Tuple[float, float] = (0.3, 0.7),
    p: float = 0.7,
    padding_mode: str = "constant",
) -> Tensor:
    """Put each image at the upper left of a grid of other images, and crop a box out of this mosaic.

    A. Bochkovskiy et al., YOLOv4: optimal speed and accuracy of object detection, 2020. Each other tile of
    the grid comes from a permutation of the batch, in which an image may be its own partner. The box begins
    at a fraction of the image's height and of its width; both fractions are uniform in ``start_ratio_range``,
    and the position is rounded down to a pixel.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample, all different.
        output_size: (height, width) of the box; the image's by default.
        mosaic_grid: number of images (down, across).
        start_ratio_range: (least, greatest), within [0, 1].
        p: probability that a sample is changed. For other samples the box begins at the image's upper left
            corner, and pixels outside a smaller image are black.
        padding_mode: the values of the box outside the grid: "constant" (black), "reflect" (about the centres
            of the border pixels), "replicate" or "circular".

    Returns:
        (B, C, height, width), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.arange(4.0).reshape(1, 1, 2, 2)
        >>> random_mosaic(x, torch.tensor([7]), start_ratio_range=(0.5, 0.5), p=1.0)[0, 0]
        tensor([[3., 2.],
                [1., 0.]])
    """
    check_pixels(input, "input")
    check_mosaic(mosaic_grid, start_ratio_range, padding_mode)
    check_chance(p)
    is_changed = drawn(seed, 1, input)[:, 0] < p
    height, width = input.size(2), input.size(3)
    params = mosaic_parameters(seed, height, width, mosaic_grid, start_ratio_range)
    changed = cut_out_of_mosaic(input, params, output_size, mosaic_grid, padding_mode)
    if p >= 1.0:
        return changed
    return torch.where(each(is_changed, input), changed, cut_at_corner(input, output_size))


def check_mosaic(grid: Tuple[int, int], start: Tuple[float, float], padding_mode: str) -> None:
    """Raise ValueError unless these are a mosaic's settings."""
    check_pair(grid, "mosaic_grid")
    if grid[0] < 1 or grid[1] < 1:
        raise ValueError(f"mosaic_grid: expected positive numbers, got ({grid[0]}, {grid[1]})")
    check_bounds(start, 0.0, 1.0, "start_ratio_range")
    check_choice(padding_mode, ["constant", "reflect", "replicate", "circular"], "padding_mode")


def mosaic_parameters(
    seed: Tensor, height: int, width: int, grid: Tuple[int, int], start: Tuple[float, float]
) -> Dict[str, Tensor]:
    """The image index of each tile, "permutation" (B, tiles), and the upper left corner of the box, "corner"
    (B, 2), (x, y), both int64."""
    count = grid[0] * grid[1]
    u = uniform(seed, 2 + count)  # column 0 selects the samples that are changed
    own = torch.arange(seed.size(0), device=seed.device)
    others = [ranks(u[:, 3 + i]) for i in range(count - 1)]
    at = u[:, 1:3] * (start[1] - start[0]) + start[0]
    corner = torch.stack([torch.floor(at[:, 0] * width), torch.floor(at[:, 1] * height)], -1)
    return {"permutation": torch.stack([own] + others, 1), "corner": corner.to(torch.int64)}


def cut_out_of_mosaic(
    input: Tensor,
    params: Dict[str, Tensor],
    output_size: Optional[Tuple[int, int]],
    grid: Tuple[int, int],
    padding_mode: str,
) -> Tensor:
    """The box (B, C, height, width) of each sample's mosaic."""
    height, width = input.size(2), input.size(3)
    size = (height, width) if output_size is None else output_size
    tiles = input.index_select(0, params["permutation"].flatten())
    tiles = tiles.reshape(-1, grid[0], grid[1], input.size(1), height, width).permute(0, 3, 1, 4, 2, 5)
    mosaic = tiles.reshape(-1, input.size(1), grid[0] * height, grid[1] * width)
    return cut(mosaic, params["corner"], size, padding_mode, 0.0)


def cut_at_corner(input: Tensor, output_size: Optional[Tuple[int, int]]) -> Tensor:
    """The images, cropped or padded to the size of the box from their upper left corners."""
    if output_size is None:
        return input
    corner = torch.zeros([input.size(0), 2], dtype=torch.int64, device=input.device)
    return cut(input, corner, output_size, "constant", 0.0)


def boxes_of_mosaic(
    boxes: Tensor,
    params: Dict[str, Tensor],
    height: int,
    width: int,
    output_size: Optional[Tuple[int, int]],
    grid: Tuple[int, int],
    least: float,
) -> Tensor:
    """The visible parts of boxes (B, N, 4), (x1, y1, x2, y2), of images of this size: (B, tiles * N, 4), tile
    by tile. For unchanged samples, the first N are their own boxes. Boxes are 0 if they are not visible, or
    if their visible area is less than ``least`` pixels.
    """
    size = (height, width) if output_size is None else output_size
    count = grid[0] * grid[1]
    place = torch.arange(count, device=boxes.device)
    tile = torch.stack(
        [place % grid[1] * width, torch.div(place, grid[1], rounding_mode="floor") * height], -1
    )
    shift = (tile - params["corner"][:, None]).to(boxes.dtype).repeat(1, 1, 2)  # (B, tiles, 4)
    moved = boxes.index_select(0, params["permutation"].flatten())
    moved = moved.reshape(-1, count, boxes.size(1), 4) + shift[:, :, None]
    stays = torch.cat([boxes[:, None], torch.zeros_like(moved[:, 1:])], 1)
    moved = torch.where(params["batch_prob"][:, None, None, None], moved, stays).flatten(1, 2)
    x, y = moved[..., 0::2].clamp(0, size[1]), moved[..., 1::2].clamp(0, size[0])
    area = (x[..., 1] - x[..., 0]) * (y[..., 1] - y[..., 0])
    seen = (area >= least) & (area > 0)
    clipped = torch.stack([x[..., 0], y[..., 0], x[..., 1], y[..., 1]], -1)
    return torch.where(seen[..., None], clipped, torch.zeros_like(clipped))
