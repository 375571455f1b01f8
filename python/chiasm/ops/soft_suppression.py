"""Soft non-maximum suppression: the scores of overlapping boxes decrease, instead of dropping the boxes."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_floating, check_last, check_rank
from ..primitives.core.loops import until_stable
from ..primitives.geometry.boxes import boxes_at, intersections_and_unions
from ..primitives.numbers.slots import above_or_nothing, empty_slots, filled_slots, highest, taken
from .suppression import check_slots


def soft_nms(
    boxes: Tensor,
    scores: Tensor,
    max_output: int,
    method: str = "gaussian",
    sigma: float = 0.5,
    iou_threshold: float = 0.3,
    score_threshold: float = 0.001,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Soft non-maximum suppression of a batch of images, with a fixed number of slots for the kept boxes. N.
    Bodla et al., Soft-NMS, ICCV 2017. Each step takes the box with the highest score (of equal scores the
    first one) and multiplies the scores of the remaining boxes by a factor of their IoU o with this box:
    "gaussian" exp(-o^2 / sigma), "linear" 1 - o if o is at least ``iou_threshold``. Computed in float64, with
    one step for each filled slot; memory grows with N + K.

    Args:
        boxes: (B, N, 4) as x1, y1, x2, y2, floating point.
        scores: (B, N), floating point.
        max_output: the number K of slots.
        method: "gaussian" or "linear".
        sigma: the width of "gaussian", positive; a larger value decreases scores less.
        iou_threshold: the least IoU for which "linear" decreases scores.
        score_threshold: boxes are dropped as soon as their score is not above this.

    Returns:
        (B, K), int64, the indices of the boxes kept, in descending order of score, 0 in empty slots; (B, K),
        their decreased scores, 0 in empty slots; and (B, K), bool, a mask of the slots that hold a box.

    Raises:
        TypeError: if boxes or scores is not floating point.
        ValueError: if a shape is not as above, max_output or sigma is not positive, or method none of these.

    Example:
        >>> boxes = torch.tensor([[[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.0], [5.0, 0.0, 6.0, 1.0]]])
        >>> index, scores, kept = soft_nms(boxes, torch.tensor([[0.9, 0.8, 0.7]]), 4, "linear")
        >>> index, scores
        (tensor([[0, 2, 1, 0]]), tensor([[0.9000, 0.7000, 0.4000, 0.0000]]))
    """
    check_rank(boxes, 3, "(B, N, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    check_floating(scores, "scores")
    if scores.shape != boxes.shape[:2]:
        raise ValueError(f"scores: expected shape {list(boxes.shape[:2])}, got {list(scores.shape)}")
    check_choice(method, ["gaussian", "linear"], "method")
    check_slots(max_output)
    if not sigma > 0.0:
        raise ValueError(f"sigma: expected a positive number, got {sigma}")
    count = scores.size(1)
    state = empty_slots(scores, max_output, score_threshold)
    if count > 0:
        inputs = boxes.detach().to(torch.float64)
        state = _taken(
            state,
            max_output,
            inputs,
            method == "gaussian",
            sigma,
            iou_threshold,
            score_threshold,
            max_output,
        )
    index, kept = filled_slots(state, count, max_output)
    left = torch.where(kept, state[:, count + max_output :], torch.zeros_like(state[:, :max_output]))
    return index, left.to(scores.dtype), kept


@until_stable
def _taken(
    state: Tensor,
    k: Tensor,
    boxes: Tensor,
    gaussian: bool,
    sigma: float,
    iou_threshold: float,
    score_threshold: float,
    slots: int,
) -> Tensor:
    """The state of slots after the k-th is filled."""
    count = boxes.size(1)
    best, score = highest(state, count)
    common, union = intersections_and_unions(boxes_at(boxes, best), boxes)
    overlap = torch.where(union > 0.0, common / union, torch.zeros_like(union))
    if gaussian:
        factor = torch.exp(-overlap * overlap / sigma)
    else:
        factor = torch.where(overlap >= iou_threshold, 1.0 - overlap, torch.ones_like(overlap))
    # A dropped box stays dropped: minus infinity times 0 would be NaN, which is not above any number.
    values = above_or_nothing(state[:, :count] * factor, score_threshold)
    return taken(state, values, best, score, k, slots)
