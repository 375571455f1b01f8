"""Metrics of detected boxes."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_floating, check_last, check_rank, check_tensor
from ..primitives.geometry.boxes import intersections, wide
from ..primitives.numbers.ranking import stable_topk
from .classification import check_integer_tensor


def mean_iou_bbox(boxes_1: Tensor, boxes_2: Tensor, box_format: str = "xyxy") -> Tensor:
    """Intersection over union (IoU) of each box of one set with each box of another set. (The name is
    Kornia's; there is no mean.)

    Args:
        boxes_1: (N, 4), floating point.
        boxes_2: (M, 4), floating point.
        box_format: "xyxy" for the corners x1, y1, x2, y2, or "xywh" for a corner and the size x, y, width,
            height.

    Returns:
        (N, M), in [0, 1], float32 for half precision; 0 if the union is empty. A box whose second corner is
        before its first is empty.

    Raises:
        TypeError: if boxes_1 or boxes_2 is not floating point.
        ValueError: if boxes_1 is not (N, 4), boxes_2 not (M, 4), or box_format unknown.

    Example:
        >>> mean_iou_bbox(
        ...     torch.tensor([[0.0, 0.0, 2.0, 2.0]]),
        ...     torch.tensor([[1.0, 0.0, 3.0, 2.0], [5.0, 5.0, 6.0, 6.0]]),
        ... )
        tensor([[0.3333, 0.0000]])
    """
    check_choice(box_format, ["xyxy", "xywh", "cxcywh"], "box_format")
    _check_boxes(boxes_1, 2, "(N, 4)", "boxes_1")
    _check_boxes(boxes_2, 2, "(M, 4)", "boxes_2")
    if box_format == "xywh":
        return _pairwise_iou(_corners(boxes_1), _corners(boxes_2))
    if box_format == "cxcywh":
        return _pairwise_iou(_around(boxes_1), _around(boxes_2))
    return _pairwise_iou(boxes_1, boxes_2)


def mean_average_precision(
    pred_boxes: Tensor,
    pred_labels: Tensor,
    pred_scores: Tensor,
    gt_boxes: Tensor,
    gt_labels: Tensor,
    n_classes: int,
    threshold: float = 0.5,
    pred_mask: Optional[Tensor] = None,
    gt_mask: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor]:
    """Mean average precision of detected boxes over the classes, by Pascal VOC's rules.

    M. Everingham et al., The Pascal visual object classes (VOC) challenge, IJCV 88, 2010, section 4.2. A
    detection is matched with the true box of its class and image with the highest intersection over union, if
    this is above the threshold. Of the detections matched with the same box, the one with the highest score
    (of equal scores the first) is correct, all others are wrong. The average precision of a class is the
    mean, over the recalls 0, 0.1, ... 1, of the highest precision at this or a greater recall.

    Kornia takes a list of tensors, one for each image. Here, tensors have a fixed capacity: images with fewer
    boxes are padded with boxes that a mask or their label marks as void. This takes memory for about B * N *
    (M + n_classes) numbers.

    Args:
        pred_boxes: (B, N, 4) as x1, y1, x2, y2, the boxes detected in B images, floating point.
        pred_labels: (B, N), integers: classes 1 to n_classes - 1; any other label, for example 0 for the
            background, marks a box as void.
        pred_scores: (B, N), floating point.
        gt_boxes: (B, M, 4), the true boxes, floating point.
        gt_labels: (B, M), as pred_labels.
        n_classes: number of classes, including the background, at least 2.
        threshold: in [0, 1).
        pred_mask: (B, N), bool: a mask of the detections that exist; all by default.
        gt_mask: (B, M), bool: a mask of the true boxes that exist; all by default.

    Returns:
        The mean, a scalar, and the average precisions (n_classes - 1,) of the classes 1, 2, ..., in
        pred_boxes' dtype; 0 for a class without true boxes, which also counts in the mean. Kornia's second
        result is a dict from class to number.

    Raises:
        TypeError: if boxes or scores are not floating point, labels not integer, or a mask not bool.
        ValueError: if a tensor is not of its shape, n_classes is less than 2 or threshold not in [0, 1).

    Example:
        >>> box = torch.tensor([[[0.0, 0.0, 2.0, 2.0]]])
        >>> one = torch.ones(1, 1, dtype=torch.int64)
        >>> mean_average_precision(box, one, torch.tensor([[0.9]]), box, one, 3)
        (tensor(0.5000), tensor([1., 0.]))
    """
    if n_classes < 2:
        raise ValueError(f"n_classes: expected at least 2, got {n_classes}")
    if not (threshold >= 0.0 and threshold < 1.0):
        raise ValueError(f"threshold: expected a number in [0, 1), got {threshold}")
    _check_boxes(pred_boxes, 3, "(B, N, 4)", "pred_boxes")
    _check_boxes(gt_boxes, 3, "(B, M, 4)", "gt_boxes")
    if gt_boxes.size(0) != pred_boxes.size(0):
        raise ValueError(
            f"gt_boxes: expected as many images as pred_boxes {list(pred_boxes.shape)}, got"
            f" {list(gt_boxes.shape)}"
        )
    check_floating(pred_scores, "pred_scores")
    _check_like(pred_scores, pred_boxes, "pred_scores")
    pred_class = _classes(pred_labels, pred_mask, pred_boxes, n_classes, "pred")
    gt_class = _classes(gt_labels, gt_mask, gt_boxes, n_classes, "gt")
    if pred_boxes.size(0) == 0 or pred_boxes.size(1) == 0 or gt_boxes.size(1) == 0:
        nothing = torch.zeros([n_classes - 1], dtype=pred_boxes.dtype, device=pred_boxes.device)
        return nothing.mean(), nothing
    scores = pred_scores.reshape(-1)
    count = pred_scores.size(0) * pred_scores.size(1)
    order = stable_topk(scores, count)[1]
    rank = (
        torch.zeros_like(order)
        .scatter(0, order, torch.arange(count, device=order.device))
        .reshape(pred_class.shape)
    )
    hit = (
        _right(pred_boxes, pred_class, rank, gt_boxes, gt_class, threshold).reshape(-1).index_select(0, order)
    )
    found = pred_class.reshape(-1).index_select(0, order)
    classes = torch.arange(1, n_classes, device=order.device)[:, None]
    total = (gt_class.reshape(1, -1) == classes).to(torch.int64).sum(1, keepdim=True)
    each = _average_precision(found == classes, hit, total)
    return each.mean().to(pred_boxes.dtype), each.to(pred_boxes.dtype)


def _right(
    pred_boxes: Tensor, pred_class: Tensor, rank: Tensor, gt_boxes: Tensor, gt_class: Tensor, threshold: float
) -> Tensor:
    """A mask (B, N) of the correct detections; ``rank`` is their place in the order of scores."""
    overlap = _pairwise_iou(pred_boxes, gt_boxes)
    candidate = (
        (pred_class[:, :, None] == gt_class[:, None]) & (pred_class > 0)[:, :, None] & (overlap > threshold)
    )
    overlap = torch.where(candidate, overlap, torch.full_like(overlap, -1.0))
    best = overlap.argmax(-1)
    claims = candidate & (best[:, :, None] == torch.arange(gt_boxes.size(1), device=best.device))
    last = torch.full_like(rank, 1 << 62)
    first = torch.where(claims, rank[:, :, None], last[:, :, None]).amin(1)
    return candidate.any(-1) & (first.gather(1, best) == rank)


def _average_precision(detected: Tensor, hit: Tensor, total: Tensor) -> Tensor:
    """(K,), float64: from detections in descending order of score: (K, D) whether each has the class, (D,)
    whether it is correct, and the numbers (K, 1) of true boxes."""
    right = (detected & hit).to(torch.int64).cumsum(1)
    tried = detected.to(torch.int64).cumsum(1)
    precision = right.to(torch.float64) / tried.clamp(min=1).to(torch.float64)
    reached: List[Tensor] = []
    for tenth in range(11):
        # recall >= tenth / 10, in integers
        reached.append(
            torch.where(10 * right >= tenth * total, precision, torch.zeros_like(precision)).amax(1)
        )
    return torch.stack(reached).mean(0)


def _pairwise_iou(a: Tensor, b: Tensor) -> Tensor:
    """(*, N, M), at least float32, of corners (*, N, 4) and (*, M, 4)."""
    a, b = wide(a), wide(b)
    intersection = intersections(a[..., :, None, :], b[..., None, :, :])
    union = _area(a)[..., :, None] + _area(b)[..., None, :] - intersection
    empty = union <= 0
    return torch.where(
        empty, torch.zeros_like(union), intersection / torch.where(empty, torch.ones_like(union), union)
    )


def _area(boxes: Tensor) -> Tensor:
    size = (boxes[..., 2:] - boxes[..., :2]).clamp(min=0.0)
    return size[..., 0] * size[..., 1]


def _corners(boxes: Tensor) -> Tensor:
    return torch.cat([boxes[..., :2], boxes[..., :2] + boxes[..., 2:]], -1)


def _around(boxes: Tensor) -> Tensor:
    half = 0.5 * boxes[..., 2:]
    return torch.cat([boxes[..., :2] - half, boxes[..., :2] + half], -1)


def _check_boxes(value: Tensor, rank: int, layout: str, name: str) -> None:
    check_rank(value, rank, layout, name)
    check_last(value, 4, name)


def _check_like(value: Tensor, boxes: Tensor, name: str) -> None:
    check_tensor(value, name)
    if value.dim() != 2 or value.size(0) != boxes.size(0) or value.size(1) != boxes.size(1):
        raise ValueError(f"{name}: expected shape {list(boxes.shape[:2])}, got {list(value.shape)}")


def _classes(labels: Tensor, mask: Optional[Tensor], boxes: Tensor, n_classes: int, kind: str) -> Tensor:
    """The boxes' classes, 0 for those that are void."""
    check_integer_tensor(labels, f"{kind}_labels")
    _check_like(labels, boxes, f"{kind}_labels")
    known = labels.to(torch.int64)
    there = (known > 0) & (known < n_classes)
    if mask is not None:
        _check_like(mask, boxes, f"{kind}_mask")
        if mask.dtype != torch.bool:
            raise TypeError(f"{kind}_mask: expected a bool tensor, got dtype {mask.dtype}")
        there = there & mask
    return torch.where(there, known, torch.zeros_like(known))
