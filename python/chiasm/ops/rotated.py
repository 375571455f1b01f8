"""Rotated boxes, like OpenCV's RotatedRect: intersection over union, and non-maximum suppression."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank
from ..primitives.core.loops import until_stable
from ..primitives.geometry.boxes import wide
from ..primitives.geometry.rotated_boxes import rotated_overlaps
from ..primitives.numbers.slots import empty_slots, filled_slots, highest, taken
from .suppression import check_candidates, check_slots


def rotated_iou(boxes1: Tensor, boxes2: Tensor) -> Tensor:
    """Intersection over union of each rotated box of one set with each rotated box of another set. One box is
    clipped by the sides of the other (I. Sutherland, G. Hodgman, Reentrant Polygon Clipping, CACM 17(1),
    1974). This takes memory for about 50 * N * M values.

    Args:
        boxes1: (N, 5) as cx, cy, width, height, angle in degrees, floating point; sides are not negative. A
            positive angle rotates from the x axis towards the y axis, as in OpenCV's RotatedRect: clockwise
            if y points down.
        boxes2: (M, 5).

    Returns:
        (N, M), in [0, 1], float32 for half precision; NaN where both boxes are empty.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if boxes1 is not (N, 5) or boxes2 not (M, 5).

    Example:
        >>> square = torch.tensor([[0.0, 0.0, 2.0, 2.0, 0.0]])
        >>> rotated_iou(square, torch.tensor([[0.0, 0.0, 2.0, 2.0, 45.0], [1.0, 0.0, 2.0, 2.0, 90.0]]))
        tensor([[0.7071, 0.3333]])
    """
    _check_rotated(boxes1, 2, "(N, 5)", "boxes1")
    _check_rotated(boxes2, 2, "(M, 5)", "boxes2")
    common, union = rotated_overlaps(wide(boxes1)[:, None], wide(boxes2)[None])
    return common / union


def rotated_nms_fixed(
    boxes: Tensor,
    scores: Tensor,
    idxs: Tensor,
    iou_threshold: float,
    max_output: int,
    score_threshold: float = 0.0,
) -> Tuple[Tensor, Tensor]:
    """`batched_nms_fixed` for rotated boxes. Each step keeps the box with the highest score and drops the
    boxes of its class that overlap it. There is one step for each filled slot, in float64; memory grows with
    N.

    Args:
        boxes: (B, N, 5) as cx, cy, width, height, angle in degrees, floating point; as in `rotated_iou`.
        scores: (B, N), floating point.
        idxs: (B, N), int64: the class of each box.
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box of its class is
            greater than this.
        max_output: the number K of slots, for the K kept boxes with the highest scores.
        score_threshold: boxes are dropped unless their score is above this.

    Returns:
        (B, K), int64, the indices of the boxes kept, in descending order of score, equal scores in their
        original order, 0 in empty slots; and (B, K), bool, a mask of the slots that hold a box.

    Raises:
        TypeError: if boxes or scores is not floating point, or idxs not int64.
        ValueError: if a shape is not as above, or max_output is not positive.

    Example:
        >>> boxes = torch.tensor([[[5.0, 5.0, 8.0, 4.0, 30.0], [5.0, 5.0, 8.0, 4.0, 25.0]]])
        >>> rotated_nms_fixed(boxes, torch.tensor([[0.6, 0.9]]), torch.zeros(1, 2, dtype=torch.int64), 0.5, 2)
        (tensor([[1, 0]]), tensor([[ True, False]]))
    """
    _check_rotated(boxes, 3, "(B, N, 5)", "boxes")
    check_candidates(boxes, scores, idxs)
    check_slots(max_output)
    state = empty_slots(scores, max_output, score_threshold)
    if scores.size(1) > 0:
        exact = boxes.detach().to(torch.float64)
        state = _kept(state, max_output, exact, idxs, iou_threshold, max_output)
    return filled_slots(state, scores.size(1), max_output)


def _check_rotated(boxes: Tensor, rank: int, layout: str, name: str) -> None:
    check_rank(boxes, rank, layout, name)
    if boxes.size(-1) != 5:
        raise ValueError(f"{name}: expected shape {layout}, got {list(boxes.shape)}")
    check_floating(boxes, name)


@until_stable
def _kept(
    state: Tensor, k: Tensor, boxes: Tensor, groups: Tensor, iou_threshold: float, slots: int
) -> Tensor:
    """The state of the slots after the k-th slot is filled."""
    values = state[:, : boxes.size(1)]
    best, score = highest(state, boxes.size(1))
    common, union = rotated_overlaps(boxes.gather(1, best[:, :, None].expand(-1, -1, 5)), boxes)
    drops = (common > iou_threshold * union) & (groups == groups.gather(1, best))
    left = torch.where(drops, torch.full_like(values, float("-inf")), values)
    return taken(state, left, best, score, k, slots)
