"""Boxes x1, y1, x2, y2: overlaps of pairs, and non-maximum suppression."""

from typing import Tuple

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..resampling.warping import position_dtype


def wide(boxes: Tensor) -> Tensor:
    """Boxes of half precision as float32: as float16, a square of 256 pixels already has an infinite area.

    >>> wide(torch.tensor([0.0, 0.0, 256.0, 256.0], dtype=torch.float16)).dtype
    torch.float32
    """
    return boxes.to(position_dtype(boxes.dtype))


def upright(boxes: Tensor) -> Tensor:
    """Boxes whose second corner is not before the first: where it is, they become empty, and overlap nothing.

    >>> upright(torch.tensor([5.0, 1.0, 3.0, 4.0]))
    tensor([5., 1., 5., 4.])
    """
    low = boxes[..., :2]
    return torch.cat([low, torch.maximum(low, boxes[..., 2:])], -1)


def box_areas(boxes: Tensor) -> Tensor:
    """The areas (...) of boxes (..., 4), at least float32; negative if exactly one side is.

    >>> box_areas(torch.tensor([1.0, 1.0, 3.0, 4.0]))
    tensor(6.)
    """
    boxes = wide(boxes)
    return (boxes[..., 2] - boxes[..., 0]) * (boxes[..., 3] - boxes[..., 1])


def intersections(a: Tensor, b: Tensor) -> Tensor:
    """The areas (...) of the intersections of boxes (..., 4), at least float32; they broadcast.

    >>> intersections(torch.tensor([0.0, 0.0, 2.0, 2.0]), torch.tensor([1.0, 0.0, 3.0, 2.0]))
    tensor(2.)
    """
    a, b = wide(a), wide(b)
    sides = (torch.minimum(a[..., 2:], b[..., 2:]) - torch.maximum(a[..., :2], b[..., :2])).clamp(min=0.0)
    return sides[..., 0] * sides[..., 1]


def intersections_and_unions(a: Tensor, b: Tensor) -> Tuple[Tensor, Tensor]:
    """The areas (...) of the intersections and of the unions of boxes (..., 4), at least float32."""
    common = intersections(a, b)
    return common, box_areas(a) + box_areas(b) - common


def boxes_at(boxes: Tensor, index: Tensor) -> Tensor:
    """The boxes (B, M, 4) with the numbers (B, M), out of boxes (B, N, 4)."""
    return boxes.gather(1, index[:, :, None].expand(-1, -1, 4))


@primitive
def kept_boxes(boxes: Tensor, groups: Tensor, threshold: float, most: int) -> Tensor:
    """(B, N), bool: the boxes that non-maximum suppression keeps of (B, N, 4), x1, y1, x2, y2, at most
    ``most``. They are ``upright``.

    A box is dropped if an earlier box of its group is kept and their intersection is more than ``threshold``
    of their union. All pairs are compared at once, and the decisions are repeated until none changes.

    >>> boxes = torch.tensor([[[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [5.0, 0.0, 6.0, 1.0]]])
    >>> kept_boxes(boxes, torch.zeros(1, 3, dtype=torch.int64), 0.5, 3)
    tensor([[ True, False,  True]])
    """
    common, union = intersections_and_unions(boxes[:, :, None], boxes[:, None])
    overlap = common > threshold * union
    position = torch.arange(boxes.size(1), device=boxes.device)
    drops = overlap & (groups[:, :, None] == groups[:, None]) & (position[:, None] < position)
    kept = _undropped(torch.ones_like(groups, dtype=torch.bool), boxes.size(1), drops)
    return kept & (kept.to(torch.int64).cumsum(1) <= most)


@until_stable
def _undropped(kept: Tensor, k: Tensor, drops: Tensor) -> Tensor:
    """The boxes that no kept box drops; drops[b, i, j] says that i drops j."""
    return ~(drops & kept[:, :, None]).any(1)


kept_boxes.lowering("native", when=kernels.has_kernel)(kernels.nms)
