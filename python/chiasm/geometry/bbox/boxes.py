"""Boxes as corners, in pixels: (B, 4, 2), clockwise from the top left; in volumes (B, 8, 3), first the front
face in this order, then the back face. The last pixel belongs to the box: a box from x = 1 to x = 3 has width
3.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_all_broadcastable,
    check_choice,
    check_floating,
    check_last,
    check_matrix,
    check_one_for_each,
    check_rank,
    check_tensor,
)
from ...primitives.linalg.matrices import small_matmul
from ...primitives.numbers.reductions import greatest, least
from ..conversions.homogeneous import convert_points_from_homogeneous, convert_points_to_homogeneous


def bbox_generator(x_start: Tensor, y_start: Tensor, width: Tensor, height: Tensor) -> Tensor:
    """Boxes from their top left corners and sizes.

    Args:
        x_start: (B,), or (1,) or a scalar for all, any dtype.
        y_start: like x_start.
        width: like x_start, in pixels.
        height: like x_start, in pixels.

    Returns:
        (B, 4, 2), clockwise from the top left; the right side is at x_start + width - 1.

    Raises:
        ValueError: if an argument has more than one dimension.

    Example:
        >>> bbox_generator(torch.tensor([1]), torch.tensor([2]), torch.tensor([5]), torch.tensor([7]))[0]
        tensor([[1, 2],
                [5, 2],
                [5, 8],
                [1, 8]])
    """
    left, top = _column(x_start, "x_start"), _column(y_start, "y_start")
    across, down = _column(width, "width"), _column(height, "height")
    check_all_broadcastable([left, top, across, down], ["x_start", "y_start", "width", "height"])
    left, top, across, down = torch.broadcast_tensors(left, top, across, down)
    right, bottom = left + across - 1, top + down - 1
    return torch.stack(
        [torch.stack([left, right, right, left], -1), torch.stack([top, top, bottom, bottom], -1)], -1
    )


def bbox_generator3d(
    x_start: Tensor, y_start: Tensor, z_start: Tensor, width: Tensor, height: Tensor, depth: Tensor
) -> Tensor:
    """3D boxes from their front top left corners and sizes.

    Args:
        x_start: (B,), or (1,) or a scalar for all, any dtype.
        y_start: like x_start.
        z_start: like x_start.
        width: like x_start, in voxels.
        height: like x_start, in voxels.
        depth: like x_start, in voxels.

    Returns:
        (B, 8, 3) in the order x, y, z: the front clockwise from the top left, then the back; the right side
        is at x_start + width - 1.

    Raises:
        ValueError: if an argument has more than one dimension.

    Example:
        >>> one = torch.tensor([1])
        >>> bbox_generator3d(one, one, one, 2 * one, 3 * one, 4 * one)[0, [0, 6]]
        tensor([[1, 1, 1],
                [2, 3, 4]])
    """
    x, y, z = _column(x_start, "x_start"), _column(y_start, "y_start"), _column(z_start, "z_start")
    across, down, deep = _column(width, "width"), _column(height, "height"), _column(depth, "depth")
    names = ["x_start", "y_start", "z_start", "width", "height", "depth"]
    check_all_broadcastable([x, y, z, across, down, deep], names)
    x, y, z, across, down, deep = torch.broadcast_tensors(x, y, z, across, down, deep)
    face = bbox_generator(x, y, across, down)
    front = z[:, None, None].expand_as(face[..., :1])
    back = front + deep[:, None, None] - 1
    return torch.cat([torch.cat([face, front], -1), torch.cat([face, back], -1)], 1)


def bbox_to_mask(boxes: Tensor, width: int, height: int) -> Tensor:
    """Masks with 1 for the pixels that a box covers, including its border, and 0 elsewhere.

    Args:
        boxes: (B, 4, 2) in pixels, with sides along the axes, floating point. Boxes may extend outside the
            image.
        width: width of the masks.
        height: height of the masks.

    Returns:
        (B, height, width) in boxes' dtype.

    Raises:
        TypeError, ValueError: if boxes is not a floating-point (B, 4, 2) tensor.

    Example:
        >>> bbox_to_mask(torch.tensor([[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]]), 4, 3)[0]
        tensor([[0., 1., 1., 0.],
                [0., 1., 1., 0.],
                [0., 0., 0., 0.]])
    """
    _check_boxes(boxes, 4, 2)
    low, high = least(boxes, [1])[:, 0], greatest(boxes, [1])[:, 0]
    x, y = torch.arange(width, device=boxes.device), torch.arange(height, device=boxes.device)
    columns = (x >= low[:, :1]) & (x <= high[:, :1])
    rows = (y >= low[:, 1:]) & (y <= high[:, 1:])
    return (rows[:, :, None] & columns[:, None, :]).to(boxes.dtype)


def bbox_to_mask3d(boxes: Tensor, size: Tuple[int, int, int]) -> Tensor:
    """Masks with 1 for the voxels that a box covers, including its border, and 0 elsewhere.

    Args:
        boxes: (B, 8, 3) in voxels, with sides along the axes, floating point. Boxes may extend outside the
            volume.
        size: depth, height and width of the masks.

    Returns:
        (B, 1, depth, height, width) in boxes' dtype.

    Raises:
        TypeError, ValueError: if boxes is not a floating-point (B, 8, 3) tensor.

    Example:
        >>> one = torch.tensor([1.0])
        >>> bbox_to_mask3d(bbox_generator3d(one, one, one, 2 * one, 3 * one, one), (4, 5, 6)).sum()
        tensor(6.)
    """
    _check_boxes(boxes, 8, 3)
    depth, height, width = size
    face = bbox_to_mask(boxes[:, :4, :2], width, height)
    z = torch.arange(depth, device=boxes.device)
    inside = (z >= boxes[..., 2].amin(1)[:, None]) & (z <= boxes[..., 2].amax(1)[:, None])
    return (face[:, None] * inside.to(boxes.dtype)[:, :, None, None])[:, None]


def infer_bbox_shape(boxes: Tensor) -> Tuple[Tensor, Tensor]:
    """Heights and widths of boxes.

    Args:
        boxes: (B, 4, 2) in pixels, with sides along the axes, any dtype.

    Returns:
        Heights (B,) and widths (B,); they include the last pixel.

    Raises:
        ValueError: if boxes is not (B, 4, 2).

    Example:
        >>> infer_bbox_shape(torch.tensor([[[1, 1], [3, 1], [3, 2], [1, 2]]]))
        (tensor([2]), tensor([3]))
    """
    _check_corners(boxes, 4, 2)
    return boxes[:, 2, 1] - boxes[:, 1, 1] + 1, boxes[:, 1, 0] - boxes[:, 0, 0] + 1


def infer_bbox_shape3d(boxes: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """Depths, heights and widths of 3D boxes.

    Args:
        boxes: (B, 8, 3) in voxels, with sides along the axes, any dtype.

    Returns:
        Depths (B,), heights (B,) and widths (B,); they include the last voxel.

    Raises:
        ValueError: if boxes is not (B, 8, 3).

    Example:
        >>> one = torch.tensor([1])
        >>> infer_bbox_shape3d(bbox_generator3d(one, one, one, 2 * one, 3 * one, 4 * one))
        (tensor([4]), tensor([3]), tensor([2]))
    """
    _check_corners(boxes, 8, 3)
    height, width = infer_bbox_shape(boxes[:, :4, :2])
    return boxes[:, 4, 2] - boxes[:, 0, 2] + 1, height, width


def transform_bbox(
    trans_mat: Tensor, boxes: Tensor, mode: str = "xyxy", restore_coordinates: Optional[bool] = None
) -> Tensor:
    """Transform two opposite corners of boxes by homographies. (After a rotation, the result is not the
    bounding box of the rotated content.)

    Args:
        trans_mat: (B, 3, 3), floating point.
        boxes: (B, 4) or (B, N, 4) in pixels.
        mode: "xyxy", two opposite corners, or "xywh", the top left corner, width and height; width is x2 - x1
            here.
        restore_coordinates: True reorders the corners if the transform has mirrored the box, so that x1 <= x2
            and y1 <= y2; True by default.

    Returns:
        Boxes of the same shape, dtype and mode; computed in the wider dtype of both.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above, or mode is not
            "xyxy" or "xywh".

    Example:
        >>> transform_bbox(
        ...     torch.tensor([[[-1.0, 0.0, 10.0], [0.0, 1.0, 2.0], [0.0, 0.0, 1.0]]]),
        ...     torch.tensor([[1.0, 2.0, 3.0, 5.0]]),
        ... )
        tensor([[7., 4., 9., 7.]])
    """
    check_choice(mode, ["xyxy", "xywh"], "mode")
    check_rank(trans_mat, 3, "(B, 3, 3)", "trans_mat")
    check_matrix(trans_mat, 3, 3, "trans_mat")
    check_last(boxes, 4, "boxes")
    if boxes.dim() != 2 and boxes.dim() != 3:
        raise ValueError(f"boxes: expected shape (B, 4) or (B, N, 4), got {list(boxes.shape)}")
    check_one_for_each(trans_mat, boxes, "trans_mat", "boxes")
    many = boxes[:, None] if boxes.dim() == 2 else boxes
    first, second = many[..., :2], many[..., 2:]
    if mode == "xywh":
        second = first + second
    wider = torch.promote_types(trans_mat.dtype, boxes.dtype)
    matrix = trans_mat.to(wider)
    first, second = _moved(matrix, first.to(wider)), _moved(matrix, second.to(wider))
    if restore_coordinates is None or restore_coordinates:
        first, second = torch.minimum(first, second), torch.maximum(first, second)
    if mode == "xywh":
        second = second - first
    return torch.cat([first, second], -1).reshape(boxes.shape).to(boxes.dtype)


def is_bbox(boxes: Tensor) -> Tensor:
    """Whether the opposite sides of each box are equal: `validate_bbox` for each box, as a tensor, which can
    be exported.

    Args:
        boxes: (B, 4, 2), clockwise from the top left, any dtype.

    Returns:
        (B,), bool: whether both diagonals have the same midpoint, within 1e-4 + 1e-5 |coordinate|.

    Raises:
        ValueError: if boxes is not (B, 4, 2).

    Example:
        >>> is_bbox(torch.tensor([[[1, 1], [3, 1], [3, 2], [1, 2]], [[1, 1], [4, 1], [3, 2], [1, 2]]]))
        tensor([ True, False])
    """
    _check_corners(boxes, 4, 2)
    return _agree(boxes[:, 0] + boxes[:, 2], boxes[:, 1] + boxes[:, 3])


def is_bbox3d(boxes: Tensor) -> Tensor:
    """Whether the opposite edges of each 3D box are equal: `validate_bbox3d` for each box, as a tensor, which
    can be exported.

    Args:
        boxes: (B, 8, 3), the front clockwise from the top left, then the back, any dtype.

    Returns:
        (B,), bool: whether the front passes `is_bbox` and all four edges to the back are equal, within 1e-4 +
        1e-5 |coordinate|.

    Raises:
        ValueError: if boxes is not (B, 8, 3).

    Example:
        >>> one = torch.tensor([1])
        >>> is_bbox3d(bbox_generator3d(one, one, one, 2 * one, 3 * one, 4 * one))
        tensor([True])
    """
    _check_corners(boxes, 8, 3)
    front, back = boxes[:, :4], boxes[:, 4:]
    edges = back - front
    return _agree(front[:, 0] + front[:, 2], front[:, 1] + front[:, 3]) & _agree(
        edges[:, 1:], edges[:, :1].expand_as(edges[:, 1:])
    ).all(-1)


def validate_bbox(boxes: Tensor) -> bool:
    """Whether the opposite sides of all boxes are equal.

    Args:
        boxes: (B, 4, 2) or (B, N, 4, 2), clockwise from the top left, any dtype.

    Returns:
        True or False; False also for another shape.

    Example:
        >>> validate_bbox(torch.tensor([[[1, 1], [3, 1], [3, 2], [1, 2]]]))
        True
    """
    if (boxes.dim() != 3 and boxes.dim() != 4) or boxes.size(-2) != 4 or boxes.size(-1) != 2:
        return False
    return bool(is_bbox(boxes.reshape(-1, 4, 2)).all())


def validate_bbox3d(boxes: Tensor) -> bool:
    """Whether the opposite edges of all 3D boxes are equal.

    Args:
        boxes: (B, 8, 3) or (B, N, 8, 3), the front clockwise from the top left, then the back, any dtype.

    Returns:
        True or False; False also for another shape.

    Example:
        >>> one = torch.tensor([1])
        >>> validate_bbox3d(bbox_generator3d(one, one, one, 2 * one, 3 * one, 4 * one))
        True
    """
    if (boxes.dim() != 3 and boxes.dim() != 4) or boxes.size(-2) != 8 or boxes.size(-1) != 3:
        return False
    return bool(is_bbox3d(boxes.reshape(-1, 8, 3)).all())


def _moved(matrix: Tensor, points: Tensor) -> Tensor:
    return convert_points_from_homogeneous(
        small_matmul(convert_points_to_homogeneous(points), matrix.transpose(1, 2))
    )


def _agree(a: Tensor, b: Tensor) -> Tensor:
    """Whether all coordinates of points (..., D) are equal within rounding: (...)."""
    return ((a - b).abs() <= 1e-4 + 1e-5 * b.abs()).all(-1)


def _column(value: Tensor, name: str) -> Tensor:
    check_tensor(value, name)
    if value.dim() > 1:
        raise ValueError(f"{name}: expected shape (B,) or a scalar, got {list(value.shape)}")
    return value.reshape(-1)


def _check_corners(boxes: Tensor, corners: int, axes: int) -> None:
    check_tensor(boxes, "boxes")
    if boxes.dim() != 3 or boxes.size(1) != corners or boxes.size(2) != axes:
        raise ValueError(f"boxes: expected shape (B, {corners}, {axes}), got {list(boxes.shape)}")


def _check_boxes(boxes: Tensor, corners: int, axes: int) -> None:
    _check_corners(boxes, corners, axes)
    check_floating(boxes, "boxes")
