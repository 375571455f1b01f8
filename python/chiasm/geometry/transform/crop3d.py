"""Crops of volumes."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_one_for_each, check_size3d
from ...primitives.resampling.volumes import check_volume, check_volume_sampling
from .crop import check_above_one
from .matrices import check_points, from_rows
from .matrices3d import get_perspective_transform3d
from .volume import crop_by_transform_mat3d, warp_affine3d


def center_crop3d(
    tensor: Tensor, size: Tuple[int, int, int], interpolation: str = "bilinear", align_corners: bool = True
) -> Tensor:
    """Crop the centre of volumes. If the sizes differ by an odd number, the crop begins between two voxels.

    Args:
        tensor: (B, C, D, H, W), floating point.
        size: (depth, height, width) of the crop, zeros where it is larger than the volume; may come from
            another tensor's shape.
        interpolation, align_corners: as ``flags`` and ``align_corners`` in :func:`warp_affine3d`.

    Returns:
        (B, C, depth, height, width).

    Raises:
        TypeError: if tensor is not floating point.
        ValueError: if tensor is not 5-D or interpolation is not as above.

    Example:
        >>> center_crop3d(torch.arange(5.0).expand(1, 1, 3, 3, 5), (1, 1, 3)).flatten()
        tensor([1., 2., 3.])
    """
    check_volume(tensor, "tensor")
    check_volume_sampling(interpolation, "zeros", "interpolation")
    check_size3d(size, "size")
    one = torch.ones([tensor.size(0)], dtype=torch.float64, device=tensor.device)
    zero = torch.zeros_like(one)
    x, y, z = (
        one * (size[2] - tensor.size(4)) * 0.5,
        one * (size[1] - tensor.size(3)) * 0.5,
        one * (size[0] - tensor.size(2)) * 0.5,
    )
    matrix = from_rows([[one, zero, zero, x], [zero, one, zero, y], [zero, zero, one, z]])
    return warp_affine3d(tensor, matrix, size, interpolation, "zeros", align_corners)


def crop_and_resize3d(
    tensor: Tensor,
    boxes: Tensor,
    size: Tuple[int, int, int],
    interpolation: str = "bilinear",
    align_corners: bool = False,
) -> Tensor:
    """Crop one box of each volume and resize it; its corners become the centres of the corner voxels.

    Args:
        tensor: (B, C, D, H, W), floating point.
        boxes: (B, 8, 3), corners (x, y, z): the front's from the upper left clockwise, then the back's.
        size: (depth, height, width) of the crops, more than 1 each; may come from another tensor's shape.
        interpolation, align_corners: as ``flags`` and ``align_corners`` in :func:`warp_affine3d`.

    Returns:
        (B, C, depth, height, width). Differentiable in tensor and boxes.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape or interpolation is not as above.

    Example:
        >>> front = torch.tensor([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
        >>> box = torch.cat([front, front + torch.tensor([0.0, 0.0, 1.0])])[None]
        >>> crop_and_resize3d(torch.arange(5.0).expand(1, 1, 2, 2, 5), box, (2, 2, 3), align_corners=True)[
        ...     0, 0, 0, 0
        ... ].round()
        tensor([1., 2., 3.])
    """
    check_volume(tensor, "tensor")
    check_points(boxes, 8, 3, "boxes")
    check_one_for_each(boxes, tensor, "boxes", "tensor")
    check_volume_sampling(interpolation, "zeros", "interpolation")
    check_size3d(size, "size")
    check_above_one([size[0], size[1], size[2]])
    one = torch.ones_like(boxes[:, 0, 0].to(torch.float64))
    low, x, y, z = torch.zeros_like(one), one * (size[2] - 1), one * (size[1] - 1), one * (size[0] - 1)
    target = from_rows(
        [
            [low, low, low],
            [x, low, low],
            [x, y, low],
            [low, y, low],
            [low, low, z],
            [x, low, z],
            [x, y, z],
            [low, y, z],
        ]
    )
    matrix = get_perspective_transform3d(boxes.to(torch.float64), target)
    return crop_by_transform_mat3d(tensor, matrix, size, interpolation, "zeros", align_corners)


def crop_by_boxes3d(
    tensor: Tensor,
    src_box: Tensor,
    dst_box: Tensor,
    interpolation: str = "bilinear",
    align_corners: bool = False,
    size: Optional[Tuple[int, int, int]] = None,
) -> Tensor:
    """Warp volumes so that src_box maps to dst_box, and crop to dst_box. The output has the size of the first
    dst_box, or ``size`` if given: exported programs cannot have sizes that depend on data.

    Args:
        tensor: (B, C, D, H, W), floating point.
        src_box: (B, 8, 3), corners (x, y, z) in tensor: the front's from the upper left clockwise, then the
            back's.
        dst_box: (B, 8, 3), the corners in the output: boxes of one size along the axes, at whole voxels.
        interpolation, align_corners: as ``flags`` and ``align_corners`` in :func:`warp_affine3d`.
        size: (depth, height, width) of the output.

    Returns:
        (B, C, depth, height, width): ``size``, or that of dst_box from (x, y, z) to (x + width - 1,
        y + height - 1, z + depth - 1).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape or interpolation is not as above.

    Example:
        >>> front = torch.tensor([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
        >>> box = torch.cat([front, front + torch.tensor([0.0, 0.0, 1.0])])[None]
        >>> crop_by_boxes3d(torch.ones(1, 1, 4, 5, 6), box + 1.0, box, align_corners=True).shape
        torch.Size([1, 1, 2, 2, 3])
    """
    check_volume(tensor, "tensor")
    check_points(src_box, 8, 3, "src_box")
    check_points(dst_box, 8, 3, "dst_box")
    check_one_for_each(src_box, tensor, "src_box", "tensor")
    check_one_for_each(dst_box, tensor, "dst_box", "tensor")
    check_volume_sampling(interpolation, "zeros", "interpolation")
    if size is None:
        extent = (dst_box[0, 6] - dst_box[0, 0]).round()
        size = (int(extent[2].item()) + 1, int(extent[1].item()) + 1, int(extent[0].item()) + 1)
    check_size3d(size, "size")
    matrix = get_perspective_transform3d(src_box.to(torch.float64), dst_box.to(torch.float64))
    return crop_by_transform_mat3d(tensor, matrix, size, interpolation, "zeros", align_corners)
