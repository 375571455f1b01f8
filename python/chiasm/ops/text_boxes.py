"""Boxes of text lines from probability maps, by differentiable binarization (DB)."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.features.connected_components import numbered_components
from ..primitives.geometry.rectangles import smallest_rectangle_direction
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.rounding import known_or, to_index
from ..primitives.resampling.warping import position_dtype


def decode_db(
    probability: Tensor,
    threshold: float = 0.3,
    box_threshold: float = 0.6,
    unclip_ratio: float = 1.5,
    max_candidates: int = 100,
    min_size: float = 3.0,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Decode the probability map of a DB network to boxes of text lines: enlarged minimum-area rectangles.

    M. Liao et al., Real-time Scene Text Detection with Differentiable Binarization, AAAI 2020. There is one
    rectangle for each 8-connected shape: exactly that of OpenCV's minAreaRect of the shape's pixel centres;
    of equal areas, the one with the least clockwise rotation from the axes. Its score is the mean probability
    of the pixels whose centres are in it. Each side is then moved outwards by area * unclip_ratio /
    perimeter, equation 10: this is the minimum-area rectangle around the polygon with round corners of
    Vatti's clipping. Unlike in the authors' code, the outlines of holes are not candidates.

    Args:
        probability: the network's output, (B, 1, H, W), floating point, in [0, 1]; NaN is 0.
        threshold: pixels above this belong to a shape.
        box_threshold: boxes with a lower score are dropped.
        unclip_ratio: how much boxes are enlarged, 0 or more.
        max_candidates: the number N of slots and of shapes that are used: those with the most pixels; of
            equal ones the first, row by row.
        min_size: boxes whose shorter side, before they are enlarged, is less are dropped.

    Returns:
        Corners (B, N, 4, 2), x and y in pixels, float32 of half precision, which may lie outside the image:
        first the upper one of the two leftmost corners, then clockwise; scores (B, N); and (B, N), bool, a
        mask of the slots that hold a box. Boxes are in descending order of score; empty slots are 0.

    Raises:
        TypeError: if probability is not floating point.
        ValueError: if probability is not (B, 1, H, W) with a pixel at least, unclip_ratio is negative, or
            max_candidates is not positive.

    Example:
        >>> probability = torch.zeros(1, 1, 12, 20)
        >>> probability[0, 0, 4:9, 5:14] = 0.8
        >>> corners, scores, found = decode_db(probability, max_candidates=2)
        >>> corners[0, 0], scores, found
        (tensor([[ 3.,  2.],
                [15.,  2.],
                [15., 10.],
                [ 3., 10.]]), tensor([[0.8000, 0.0000]]), tensor([[ True, False]]))
    """
    check_image(probability, "probability")
    height, width = probability.size(2), probability.size(3)
    if probability.size(1) != 1 or height < 1 or width < 1:
        raise ValueError(
            f"probability: expected shape (B, 1, H, W) with a pixel at least, got {list(probability.shape)}"
        )
    if not unclip_ratio >= 0.0:
        raise ValueError(f"unclip_ratio: expected 0 or more, got {unclip_ratio}")
    if max_candidates < 1:
        raise ValueError(f"max_candidates: expected a positive number, got {max_candidates}")
    slot, roots, used = _largest_shapes(probability > threshold, max_candidates)
    x, y = _row_ends(slot, roots, max_candidates)
    a, b = smallest_rectangle_direction(x, y)[..., None].unbind(2)
    along, across = a * x + b * y, a * y - b * x
    low = torch.stack([along.amin(2), across.amin(2)], 2)
    high = torch.stack([along.amax(2), across.amax(2)], 2)
    scores = _means_inside(known_or(probability[:, 0].to(torch.float64), 0.0), a, b, low, high)
    length = torch.sqrt(a * a + b * b)
    sides = (high - low) / length
    around = 2.0 * sides.sum(2, keepdim=True)
    # A single pixel has neither area nor perimeter.
    perimeter = torch.where(around > 0, around, torch.ones_like(around))
    offset = sides[..., :1] * sides[..., 1:] * unclip_ratio / perimeter
    corners = _corners(a / length, b / length, low / length - offset, high / length + offset)
    found = used & (sides.amin(2) >= min_size) & (scores >= box_threshold)
    ranked, order = stable_topk(
        torch.where(found, scores, torch.full_like(scores, -float("inf"))), max_candidates
    )
    found = found.gather(1, order)
    corners = corners.gather(1, order[..., None, None].expand(-1, -1, 4, 2))
    corners = torch.where(found[..., None, None], corners, torch.zeros_like(corners))
    ranked = torch.where(found, ranked, torch.zeros_like(ranked))
    return corners.to(position_dtype(probability.dtype)), ranked.to(probability.dtype), found


def _largest_shapes(mask: Tensor, most: int) -> Tuple[Tensor, Tensor, Tensor]:
    """The ``most`` shapes of (B, 1, H, W) with the most pixels: for each pixel the number of its shape, from
    1, or 0, (B, H, W); the first pixel of each shape (B, most); and a mask of the shapes that exist (B,
    most)."""
    labels = numbered_components(mask.to(torch.float32), 2147483647).flatten(1)
    inside = labels > 0
    root = (labels - 1).clamp(min=0)
    # A small image may have fewer pixels than there are slots.
    # 32 bits hold the number of an image's pixels.
    none = torch.zeros(
        [mask.size(0), mask.size(2) * mask.size(3) + most], dtype=torch.int32, device=mask.device
    )
    pixels = none.scatter_add(1, root, inside.to(torch.int32))
    count, roots = stable_topk(pixels.to(torch.float64), most)
    number = torch.arange(1, most + 1, dtype=torch.int32, device=mask.device).expand_as(roots)
    slot = none.scatter(1, roots, number).gather(1, root).to(torch.int64)
    slot = torch.where(inside, slot, torch.zeros_like(slot))
    used = count > 0
    return slot.reshape(mask[:, 0].shape), torch.where(used, roots, torch.zeros_like(roots)), used


def _row_ends(slot: Tensor, roots: Tensor, most: int) -> Tuple[Tensor, Tensor]:
    """The first and the last pixel of each shape in each row of (B, H, W), x and y (B, most, 2 H), float64;
    for a row without pixels of the shape, the shape's first pixel."""
    height, width = slot.size(1), slot.size(2)
    # Sort keys within a row: by descending shape, then from left to right, all different; so a shape ends
    # where another one begins.
    across = torch.arange(width, device=slot.device)
    column = stable_topk((slot * width + (width - 1 - across)).to(torch.float64), width)[1]
    shape = slot.gather(2, column)
    edge = torch.full_like(shape[..., :1], -1)
    begins = shape != torch.cat([edge, shape[..., :-1]], 2)
    ends = shape != torch.cat([shape[..., 1:], edge], 2)
    row = torch.arange(height, device=slot.device)
    place = (shape - 1) * height + row[:, None]
    spare = torch.full_like(place, most * height)
    nowhere = torch.full([slot.size(0), most * height + 1], -1, dtype=torch.int64, device=slot.device)
    first_y = (roots // width)[..., None]
    first_x = roots[..., None] - first_y * width
    columns = column.flatten(1)
    sides = [
        nowhere.scatter(1, torch.where((shape > 0) & is_end, place, spare).flatten(1), columns)
        for is_end in [begins, ends]
    ]
    x = torch.cat([side[:, : most * height].reshape([-1, most, height]) for side in sides], 2)
    y = torch.cat([row, row]).expand_as(x)
    is_there = x >= 0
    return (
        torch.where(is_there, x, first_x).to(torch.float64),
        torch.where(is_there, y, first_y).to(torch.float64),
    )


def _means_inside(values: Tensor, a: Tensor, b: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """The means (B, N) of the pixels of (B, H, W) in rectangles: low <= (a x + b y, a y - b x) <= high.

    a > 0 and b >= 0 are (B, N, 1), low and high (B, N, 2), all whole numbers.
    """
    height, width = values.size(1), values.size(2)
    y = torch.arange(height, device=values.device).to(values.dtype)
    # In a row, each pair of sides limits x to an interval; integer quotients are exact.
    left = torch.ceil((low[..., :1] - b * y) / a)
    right = torch.floor((high[..., :1] - b * y) / a)
    slanted = b > 0
    divisor = torch.where(slanted, b, torch.ones_like(b))
    across = a * y
    left = torch.where(slanted, torch.maximum(left, torch.ceil((across - high[..., 1:]) / divisor)), left)
    right = torch.where(slanted, torch.minimum(right, torch.floor((across - low[..., 1:]) / divisor)), right)
    has = slanted | ((across >= low[..., 1:]) & (across <= high[..., 1:]))
    begin, end = to_index(left, width + 1), to_index(right + 1.0, width + 1)
    has = has & (right >= left)
    sums = torch.cat([torch.zeros_like(values[..., :1]), values.cumsum(2)], 2)
    part = sums.gather(2, end.transpose(1, 2)) - sums.gather(2, begin.transpose(1, 2))
    total = torch.where(has.transpose(1, 2), part, torch.zeros_like(part)).sum(1)
    count = torch.where(has, end - begin, torch.zeros_like(end)).sum(2)
    return total / count.clamp(min=1).to(total.dtype)


def _corners(a: Tensor, b: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """Corners (B, N, 4, 2) of rectangles that begin and end at low and high (B, N, 2) along the directions
    (a, b) and (-b, a), of length 1."""
    along = torch.stack([low[..., 0], high[..., 0], high[..., 0], low[..., 0]], 2)
    across = torch.stack([low[..., 1], low[..., 1], high[..., 1], high[..., 1]], 2)
    corners = torch.stack([a * along - b * across, b * along + a * across], 3)
    # The last corner is the leftmost. If the first corner is equally far left, it is the upper one of the
    # two.
    ahead = corners[:, :, :1, :1] <= corners[:, :, 2:3, :1] + 1e-9
    before = torch.cat([corners[:, :, 3:], corners[:, :, :3]], 2)
    return torch.where(ahead, corners, before)
