"""Non-maximum suppression of boxes."""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_floating, check_last, check_rank
from ...primitives.core.loops import until_stable
from ...primitives.numbers.ranking import stable_topk


def nms(boxes: Tensor, scores: Tensor, iou_threshold: float) -> Tensor:
    """Non-maximum suppression: from the highest score on, drop every box that overlaps one that was kept.

    How many are left depends on the data, so it cannot be exported: `nms_fixed` can.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,).
        iou_threshold: boxes are dropped whose intersection with a kept one is more than this part of the
            union.

    Returns:
        (K,), int64: indices of the boxes kept, by falling score; of equal scores the first comes first.

    Raises:
        TypeError, ValueError: if boxes is not a floating-point (N, 4) tensor or scores is not (N,).

    Example:
        >>> nms(
        ...     torch.tensor([[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [5.0, 0.0, 6.0, 1.0]]),
        ...     torch.tensor([0.5, 0.9, 0.7]),
        ...     0.5,
        ... )
        tensor([1, 2])
    """
    order, kept = nms_fixed(boxes, scores, iou_threshold)
    return order[kept]


def nms_fixed(boxes: Tensor, scores: Tensor, iou_threshold: float) -> Tuple[Tensor, Tensor]:
    """`nms` with results of a fixed size: all boxes by falling score, and which of them are kept.

    All pairs are compared at once, N * N bytes of memory, and the decisions repeated until none changes,
    which takes as many steps as the longest chain of boxes that decide about each other.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,).
        iou_threshold: boxes are dropped whose intersection with a kept one is more than this part of the
            union.

    Returns:
        Indices (N,), int64, of all boxes by falling score, of equal scores the first first; and (N,), bool,
        in the same order: which are kept.

    Raises:
        TypeError, ValueError: if boxes is not a floating-point (N, 4) tensor or scores is not (N,).

    Example:
        >>> nms_fixed(
        ...     torch.tensor([[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [5.0, 0.0, 6.0, 1.0]]),
        ...     torch.tensor([0.5, 0.9, 0.7]),
        ...     0.5,
        ... )
        (tensor([1, 2, 0]), tensor([ True,  True, False]))
    """
    check_rank(boxes, 2, "(N, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    if scores.dim() != 1 or scores.size(0) != boxes.size(0):
        raise ValueError(
            f"scores: expected shape (N,) for boxes {list(boxes.shape)}, got {list(scores.shape)}"
        )
    check_floating(scores, "scores")
    order = stable_topk(scores, scores.size(0))[1]
    ranked = boxes.index_select(0, order)
    position = torch.arange(order.size(0), device=boxes.device)
    drops = _overlap(ranked, iou_threshold) & (position[:, None] < position)
    return order, _undropped(torch.ones_like(order, dtype=torch.bool), order.size(0), drops)


@until_stable
def _undropped(kept: Tensor, k: Tensor, drops: Tensor) -> Tensor:
    """Which boxes are dropped by none of those kept; drops[i, j] says that i drops j."""
    return ~(drops & kept[:, None]).any(0)


def _overlap(boxes: Tensor, threshold: float) -> Tensor:
    """(N, N), bool: whether the intersection of two boxes is more than this part of their union."""
    low = torch.maximum(boxes[:, None, :2], boxes[:, :2])
    high = torch.minimum(boxes[:, None, 2:], boxes[:, 2:])
    common = (high - low).clamp(min=0.0)
    intersection = common[..., 0] * common[..., 1]
    area = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    return intersection > threshold * (area[:, None] + area - intersection)
