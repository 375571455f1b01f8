"""Non-maximum suppression of boxes, for one class or several classes."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_last, check_rank, check_tensor
from ..primitives.geometry.boxes import boxes_at, kept_boxes, upright, wide
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.slots import above_or_nothing, chosen_first


def nms(boxes: Tensor, scores: Tensor, iou_threshold: float) -> Tensor:
    """Non-maximum suppression: in descending order of score, drop every box that overlaps a kept box. The
    number of kept boxes depends on the data, so this function cannot be exported; `batched_nms_fixed` and
    `geometry.bbox.nms_fixed` can.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,).
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box is greater than
            this.

    Returns:
        (K,), int64: indices of the boxes kept, in descending order of score; equal scores keep their order.

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
    return batched_nms(boxes, scores, one_class(scores), iou_threshold)


def batched_nms(boxes: Tensor, scores: Tensor, idxs: Tensor, iou_threshold: float) -> Tensor:
    """Non-maximum suppression for each class separately. The number of kept boxes depends on the data, so
    this function cannot be exported; `batched_nms_fixed` can.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,), floating point.
        idxs: (N,), int64: the class of each box. Boxes of other classes do not suppress each other.
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box is greater than
            this.

    Returns:
        (K,), int64: indices of the boxes kept, in descending order of score; equal scores keep their order.

    Raises:
        TypeError: if boxes or scores is not floating point, or idxs not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> boxes = torch.tensor([[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [0.0, 0.0, 2.0, 2.1]])
        >>> batched_nms(boxes, torch.tensor([0.5, 0.9, 0.7]), torch.tensor([0, 0, 1]), 0.5)
        tensor([1, 2])
    """
    order, kept = ranked(boxes, scores, idxs, iou_threshold)
    return order[kept]


def batched_nms_fixed(
    boxes: Tensor,
    scores: Tensor,
    idxs: Tensor,
    iou_threshold: float,
    max_output: int,
    score_threshold: float = 0.0,
) -> Tuple[Tensor, Tensor]:
    """`batched_nms` for a batch of images, with a fixed number of slots for the kept boxes. Native code
    compares each box with the kept boxes of its class; its memory grows with N. Other engines compare all
    pairs at once, which takes N * N bytes.

    Args:
        boxes: (B, N, 4) as x1, y1, x2, y2, floating point. A box whose second corner is before its first is
            empty, and suppresses no other.
        scores: (B, N), floating point.
        idxs: (B, N), int64: the class of each box.
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box of its class is
            greater than this.
        max_output: the number K of slots, for the K kept boxes with the highest scores.
        score_threshold: boxes are dropped unless their score is above this, which NaN is not; they suppress
            no other box.

    Returns:
        (B, K), int64, the indices of the boxes kept, in descending order of score, equal scores in their
        original order, 0 in empty slots; and (B, K), bool, a mask of the slots that hold a box.

    Raises:
        TypeError: if boxes or scores is not floating point, or idxs not int64.
        ValueError: if a shape is not as above, or max_output is not positive.

    Example:
        >>> boxes = torch.tensor([[[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [5.0, 0.0, 6.0, 1.0]]])
        >>> scores, idxs = torch.tensor([[0.5, 0.9, 0.7]]), torch.zeros(1, 3, dtype=torch.int64)
        >>> batched_nms_fixed(boxes, scores, idxs, 0.5, 4)
        (tensor([[1, 2, 0, 0]]), tensor([[ True,  True, False, False]]))
    """
    check_rank(boxes, 3, "(B, N, 4)", "boxes")
    check_slots(max_output)
    check_floating(scores, "scores")
    # Before the suppression: NaN would come first, and drop boxes that have a score.
    scores = above_or_nothing(scores, score_threshold)
    values, order, kept = _ranked(boxes, scores, idxs, iou_threshold, max_output)
    kept = kept & (values > score_threshold)
    filled = torch.arange(max_output, device=boxes.device) < kept.to(torch.int64).sum(1, keepdim=True)
    return chosen_first(order, kept, max_output, 0), filled


def one_class(scores: Tensor) -> Tensor:
    """The same class for every box."""
    check_tensor(scores, "scores")
    return torch.zeros(scores.shape, dtype=torch.int64, device=scores.device)


def ranked(boxes: Tensor, scores: Tensor, idxs: Tensor, threshold: float) -> Tuple[Tensor, Tensor]:
    """For one image: the indices (N,) in descending order of score, and a mask of the kept boxes."""
    check_rank(boxes, 2, "(N, 4)", "boxes")
    for name, each in [("scores", scores), ("idxs", idxs)]:
        if each.dim() != 1 or each.size(0) != boxes.size(0):
            raise ValueError(
                f"{name}: expected shape (N,) for boxes {list(boxes.shape)}, got {list(each.shape)}"
            )
    _, order, kept = _ranked(boxes[None], scores[None], idxs[None], threshold, boxes.size(0))
    return order[0], kept[0]


def _ranked(
    boxes: Tensor, scores: Tensor, idxs: Tensor, threshold: float, most: int
) -> Tuple[Tensor, Tensor, Tensor]:
    """The scores (B, N) in descending order, the order of the boxes, and a mask of the kept ones."""
    check_last(boxes, 4, "boxes")
    check_candidates(boxes, scores, idxs)
    values, order = stable_topk(scores, scores.size(1))
    inputs = upright(wide(boxes_at(boxes, order)))
    return values, order, kept_boxes(inputs, idxs.gather(1, order), threshold, most)


def check_slots(max_output: int) -> None:
    """Raise ValueError unless there is a slot."""
    if max_output < 1:
        raise ValueError(f"max_output: expected a positive number, got {max_output}")


def check_candidates(boxes: Tensor, scores: Tensor, idxs: Tensor) -> None:
    """Raise unless each box of (B, N, ...) has a score and a class."""
    check_floating(scores, "scores")
    check_tensor(idxs, "idxs")
    if idxs.dtype != torch.int64:
        raise TypeError(f"idxs: expected dtype int64, got {idxs.dtype}")
    for name, each in [("scores", scores), ("idxs", idxs)]:
        if each.shape != boxes.shape[:2]:
            raise ValueError(f"{name}: expected shape {list(boxes.shape[:2])}, got {list(each.shape)}")
