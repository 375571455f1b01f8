"""Losses of predicted boxes, each with its own target."""

from typing import Tuple

from torch import Tensor

from ..primitives.core.checks import check_floating, check_last, check_same_shape
from ..primitives.geometry.boxes import intersections_and_unions, wide
from ..primitives.numbers.loss_reduction import reduced
from .boxes import aspect_penalty, centre_distance, hull_sides


def generalized_box_iou_loss(
    boxes1: Tensor, boxes2: Tensor, reduction: str = "none", eps: float = 1e-7
) -> Tensor:
    """Generalized IoU loss: 1 minus the generalized intersection over union of each box with its target.

    H. Rezatofighi et al., Generalized Intersection over Union, CVPR 2019.

    Args:
        boxes1: (..., 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., 4), the targets.
        reduction: "none", "mean" or "sum".
        eps: added to the denominators.

    Returns:
        (...), or a scalar tensor, float32 for half precision; the mean of no boxes is 0.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if a last dimension is not 4, the shapes differ, or reduction is none of these.

    Example:
        >>> boxes = torch.tensor([[0.0, 0.0, 2.0, 2.0]])
        >>> generalized_box_iou_loss(boxes, torch.tensor([[2.0, 0.0, 6.0, 2.0]]))
        tensor([1.])
    """
    first, second = _checked(boxes1, boxes2)
    intersection, union = intersections_and_unions(first, second)
    hull = hull_sides(first, second)
    area = hull[..., 0] * hull[..., 1]
    return _reduced(1.0 - intersection / (union + eps) + (area - union) / (area + eps), reduction)


def distance_box_iou_loss(
    boxes1: Tensor, boxes2: Tensor, reduction: str = "none", eps: float = 1e-7
) -> Tensor:
    """Distance IoU loss: 1 minus IoU, plus (distance of the centres / diagonal of the enclosing box)^2.

    Z. Zheng et al., Distance-IoU Loss, AAAI 2020.

    Args:
        boxes1: (..., 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., 4), the targets.
        reduction: "none", "mean" or "sum".
        eps: added to the denominators.

    Returns:
        (...), or a scalar tensor, float32 for half precision; the mean of no boxes is 0.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if a last dimension is not 4, the shapes differ, or reduction is none of these.

    Example:
        >>> boxes = torch.tensor([[0.0, 0.0, 2.0, 2.0]])
        >>> distance_box_iou_loss(boxes, boxes).abs()
        tensor([0.])
    """
    first, second = _checked(boxes1, boxes2)
    return _reduced(_distance_loss(first, second, eps)[0], reduction)


def complete_box_iou_loss(
    boxes1: Tensor, boxes2: Tensor, reduction: str = "none", eps: float = 1e-7
) -> Tensor:
    """Complete IoU loss: ``distance_box_iou_loss`` plus a penalty for different aspect ratios. The weight of
    the penalty has no gradient.

    Z. Zheng et al., Distance-IoU Loss, AAAI 2020, equations 10 to 12.

    Args:
        boxes1: (..., 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., 4), the targets.
        reduction: "none", "mean" or "sum".
        eps: added to the denominators.

    Returns:
        (...), or a scalar tensor, float32 for half precision; the mean of no boxes is 0.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if a last dimension is not 4, the shapes differ, or reduction is none of these.

    Example:
        >>> boxes = torch.tensor([[0.0, 0.0, 2.0, 2.0]])
        >>> complete_box_iou_loss(boxes, boxes).abs()
        tensor([0.])
    """
    first, second = _checked(boxes1, boxes2)
    loss, iou = _distance_loss(first, second, eps)
    return _reduced(loss + aspect_penalty(first, second, iou, eps), reduction)


def _reduced(loss: Tensor, reduction: str) -> Tensor:
    """``reduced``, but the mean of no boxes is 0, so that a batch without objects does not spoil a
    training."""
    if reduction == "mean" and isinstance(loss.numel(), int) and loss.numel() == 0:
        return loss.sum()
    return reduced(loss, reduction)


def _checked(boxes1: Tensor, boxes2: Tensor) -> Tuple[Tensor, Tensor]:
    """Boxes and targets, at least float32."""
    check_last(boxes1, 4, "boxes1")
    check_floating(boxes1, "boxes1")
    check_floating(boxes2, "boxes2")
    check_same_shape(boxes2, boxes1, "boxes2", "boxes1")
    return wide(boxes1), wide(boxes2)


def _distance_loss(boxes1: Tensor, boxes2: Tensor, eps: float) -> Tuple[Tensor, Tensor]:
    """The loss by the distance of centres, and the intersection over union."""
    intersection, union = intersections_and_unions(boxes1, boxes2)
    iou = intersection / (union + eps)
    return 1.0 - iou + centre_distance(boxes1, boxes2, hull_sides(boxes1, boxes2), eps), iou
