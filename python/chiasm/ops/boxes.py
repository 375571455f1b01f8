"""Boxes x1, y1, x2, y2: areas, formats, and overlap measures."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_broadcastable, check_choice, check_last, check_pair, check_rank
from ..primitives.geometry.angles import angle_of
from ..primitives.geometry.boxes import box_areas, intersections_and_unions, wide


def box_area(boxes: Tensor) -> Tensor:
    """The areas of boxes.

    Args:
        boxes: (..., 4) as x1, y1, x2, y2, floating point.

    Returns:
        (...), float32 for half precision, which areas exceed; negative if exactly one side is negative.

    Raises:
        TypeError: if boxes is not floating point.
        ValueError: if the last dimension is not 4.

    Example:
        >>> box_area(torch.tensor([[1.0, 1.0, 3.0, 4.0]]))
        tensor([6.])
    """
    check_last(boxes, 4, "boxes")
    return box_areas(boxes)


def box_convert(boxes: Tensor, in_fmt: str, out_fmt: str) -> Tensor:
    """Convert boxes between formats.

    Args:
        boxes: (..., 4), floating point.
        in_fmt: "xyxy", two corners; "xywh", the top left corner, width and height; or "cxcywh", the centre,
            width and height.
        out_fmt: the same choices.

    Returns:
        (..., 4).

    Raises:
        TypeError: if boxes is not floating point.
        ValueError: if the last dimension is not 4, or a format is none of these.

    Example:
        >>> box_convert(torch.tensor([[1.0, 1.0, 3.0, 4.0]]), "xyxy", "cxcywh")
        tensor([[2.0000, 2.5000, 2.0000, 3.0000]])
    """
    check_last(boxes, 4, "boxes")
    for name, form in [("in_fmt", in_fmt), ("out_fmt", out_fmt)]:
        check_choice(form, ["xyxy", "xywh", "cxcywh"], name)
    if in_fmt == out_fmt:
        return boxes.clone()
    first, second = boxes[..., :2], boxes[..., 2:]
    if in_fmt == "xywh":
        second = first + second
    elif in_fmt == "cxcywh":
        half = second * 0.5
        first, second = first - half, first + half
    if out_fmt == "xywh":
        second = second - first
    elif out_fmt == "cxcywh":
        first, second = (first + second) * 0.5, second - first
    return torch.cat([first, second], -1)


def clip_boxes_to_image(boxes: Tensor, size: Tuple[int, int]) -> Tensor:
    """Clip the corners of boxes to an image.

    Args:
        boxes: (..., 4) as x1, y1, x2, y2, floating point.
        size: height and width of the image.

    Returns:
        (..., 4).

    Raises:
        TypeError: if boxes is not floating point.
        ValueError: if the last dimension is not 4, or size is not two numbers.

    Example:
        >>> clip_boxes_to_image(torch.tensor([[-1.0, 2.0, 9.0, 3.0]]), (4, 6))
        tensor([[0., 2., 6., 3.]])
    """
    check_last(boxes, 4, "boxes")
    check_pair(size, "size")
    height, width = size
    across, down = boxes[..., 0::2].clamp(0, width), boxes[..., 1::2].clamp(0, height)
    return torch.stack([across, down], -1).flatten(-2)


def remove_small_boxes(boxes: Tensor, min_size: float) -> Tensor:
    """The indices of the boxes whose sides are both at least ``min_size``. Their number depends on the data,
    so this function cannot be exported.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        min_size: the least side.

    Returns:
        (K,), int64.

    Raises:
        TypeError: if boxes is not floating point.
        ValueError: if boxes is not (N, 4).

    Example:
        >>> remove_small_boxes(torch.tensor([[0.0, 0.0, 1.0, 5.0], [0.0, 0.0, 2.0, 5.0]]), 2.0)
        tensor([1])
    """
    check_rank(boxes, 2, "(N, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    sides = boxes[:, 2:] - boxes[:, :2]
    return torch.where((sides >= min_size).all(1))[0]


def box_iou(boxes1: Tensor, boxes2: Tensor) -> Tensor:
    """Intersection over union (IoU) of each box of one set with each box of another set.

    Args:
        boxes1: (..., N, 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., M, 4); leading dimensions broadcast.

    Returns:
        (..., N, M), in [0, 1], float32 for half precision; NaN where both boxes are empty.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if boxes1 is not (..., N, 4) or boxes2 not (..., M, 4), or leading dimensions differ.

    Example:
        >>> box_iou(torch.tensor([[0.0, 0.0, 2.0, 2.0]]), torch.tensor([[1.0, 0.0, 3.0, 2.0]]))
        tensor([[0.3333]])
    """
    first, second = _pairs(boxes1, boxes2)
    intersection, union = intersections_and_unions(first, second)
    return intersection / union


def generalized_box_iou(boxes1: Tensor, boxes2: Tensor) -> Tensor:
    """Generalized IoU: ``box_iou`` minus the fraction of the smallest enclosing box that neither box covers.

    H. Rezatofighi et al., Generalized Intersection over Union, CVPR 2019.

    Args:
        boxes1: (..., N, 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., M, 4); leading dimensions broadcast.

    Returns:
        (..., N, M), in [-1, 1], float32 for half precision.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if boxes1 is not (..., N, 4) or boxes2 not (..., M, 4), or leading dimensions differ.

    Example:
        >>> generalized_box_iou(torch.tensor([[0.0, 0.0, 1.0, 1.0]]), torch.tensor([[1.0, 0.0, 3.0, 1.0]]))
        tensor([[0.]])
    """
    first, second = _pairs(boxes1, boxes2)
    intersection, union = intersections_and_unions(first, second)
    hull = _hulls(first, second)
    area = hull[..., 0] * hull[..., 1]
    return intersection / union - (area - union) / area


def distance_box_iou(boxes1: Tensor, boxes2: Tensor, eps: float = 1e-7) -> Tensor:
    """Distance IoU: ``box_iou`` minus (distance of the centres / diagonal of the enclosing box)^2.

    Z. Zheng et al., Distance-IoU Loss, AAAI 2020.

    Args:
        boxes1: (..., N, 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., M, 4); leading dimensions broadcast.
        eps: added to the denominator of the distance.

    Returns:
        (..., N, M), in [-1, 1], float32 for half precision.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if boxes1 is not (..., N, 4) or boxes2 not (..., M, 4), or leading dimensions differ.

    Example:
        >>> distance_box_iou(torch.tensor([[0.0, 0.0, 2.0, 2.0]]), torch.tensor([[0.0, 0.0, 2.0, 2.0]]))
        tensor([[1.]])
    """
    first, second = _pairs(boxes1, boxes2)
    intersection, union = intersections_and_unions(first, second)
    return intersection / union - centre_distance(first, second, _hulls(first, second), eps)


def complete_box_iou(boxes1: Tensor, boxes2: Tensor, eps: float = 1e-7) -> Tensor:
    """Complete IoU: ``distance_box_iou`` minus a penalty for different aspect ratios. The weight of the
    penalty has no gradient.

    Z. Zheng et al., Distance-IoU Loss, AAAI 2020, equations 10 to 12.

    Args:
        boxes1: (..., N, 4) as x1, y1, x2, y2, floating point.
        boxes2: (..., M, 4); leading dimensions broadcast.
        eps: added to the denominators.

    Returns:
        (..., N, M), float32 for half precision.

    Raises:
        TypeError: if boxes1 or boxes2 is not floating point.
        ValueError: if boxes1 is not (..., N, 4) or boxes2 not (..., M, 4), or leading dimensions differ.

    Example:
        >>> complete_box_iou(torch.tensor([[0.0, 0.0, 2.0, 2.0]]), torch.tensor([[0.0, 0.0, 2.0, 2.0]]))
        tensor([[1.]])
    """
    first, second = _pairs(boxes1, boxes2)
    intersection, union = intersections_and_unions(first, second)
    iou = intersection / union
    distance = centre_distance(first, second, _hulls(first, second), eps)
    return iou - distance - aspect_penalty(first, second, iou, eps)


def hull_sides(boxes1: Tensor, boxes2: Tensor) -> Tensor:
    """The sides (..., 2) of the smallest box around two boxes (..., 4), which broadcast."""
    low = torch.minimum(boxes1[..., :2], boxes2[..., :2])
    return torch.maximum(boxes1[..., 2:], boxes2[..., 2:]) - low


def centre_distance(boxes1: Tensor, boxes2: Tensor, sides: Tensor, eps: float) -> Tensor:
    """The squared distance of two boxes' centres, divided by the squared diagonal of the enclosing box with
    ``sides``."""
    apart = (boxes1[..., :2] + boxes1[..., 2:]) * 0.5 - (boxes2[..., :2] + boxes2[..., 2:]) * 0.5
    return (apart[..., 0] ** 2 + apart[..., 1] ** 2) / (sides[..., 0] ** 2 + sides[..., 1] ** 2 + eps)


def aspect_penalty(boxes1: Tensor, boxes2: Tensor, iou: Tensor, eps: float) -> Tensor:
    """The squared difference of the angles of two boxes' diagonals, times (2 / pi)^2, with a weight that
    grows with their overlap and has no gradient."""
    apart = (4.0 / (math.pi * math.pi)) * (_diagonal_angle(boxes1) - _diagonal_angle(boxes2)) ** 2
    return (apart / (1.0 - iou + apart + eps)).detach() * apart


def _diagonal_angle(boxes: Tensor) -> Tensor:
    """The arc tangent of width / height, with a derivative where the height is 0; 0, with derivative 0, where
    both are 0."""
    width, height = boxes[..., 2] - boxes[..., 0], boxes[..., 3] - boxes[..., 1]
    turned = height < 0
    x, y = torch.where(turned, -width, width), torch.where(turned, -height, height)
    empty = (x == 0) & (y == 0)
    angle = angle_of(x, torch.where(empty, torch.ones_like(y), y))
    return torch.where(empty, torch.zeros_like(angle), angle)


def _pairs(boxes1: Tensor, boxes2: Tensor) -> Tuple[Tensor, Tensor]:
    """The boxes (..., N, 1, 4) and (..., 1, M, 4), at least float32."""
    for name, boxes, layout in [("boxes1", boxes1, "(..., N, 4)"), ("boxes2", boxes2, "(..., M, 4)")]:
        check_last(boxes, 4, name)
        if boxes.dim() < 2:
            raise ValueError(f"{name}: expected shape {layout}, got {list(boxes.shape)}")
    check_broadcastable(boxes2, boxes1, "boxes2", "boxes1", 2, 2)
    return wide(boxes1)[..., :, None, :], wide(boxes2)[..., None, :, :]


def _hulls(boxes1: Tensor, boxes2: Tensor) -> Tensor:
    """Sides (..., 2) of the smallest box around each pair, at least 0."""
    return hull_sides(boxes1, boxes2).clamp(min=0.0)
