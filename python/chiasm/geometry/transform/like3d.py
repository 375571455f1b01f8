"""Warps of volumes to a size that is known only at run time: see ``like``."""

import torch
from torch import Tensor

from .crop3d import crop_by_transform_mat3d
from .matrices import check_points
from .matrices3d import get_perspective_transform3d
from .volume import homography_warp3d, warp_affine3d, warp_perspective3d


def warp_affine3d_like(
    src: Tensor,
    M: Tensor,
    like: Tensor,
    flags: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``warp_affine3d`` to the depth, height and width of another tensor.

    Args:
        src: volumes (B, C, D, H, W).
        M: matrices (B, 3, 4) from source to destination voxels.
        like: a tensor (..., OD, OH, OW) of any dtype, whose values are not read.
        flags, padding_mode, align_corners: as in :func:`warp_affine3d`.

    Returns:
        Volumes (B, C, OD, OH, OW).

    Example:
        >>> warp_affine3d_like(torch.rand(1, 2, 4, 5, 6), torch.eye(4)[None, :3], torch.empty(3, 4, 5)).shape
        torch.Size([1, 2, 3, 4, 5])
    """
    return warp_affine3d(
        src, M, (like.shape[-3], like.shape[-2], like.shape[-1]), flags, padding_mode, align_corners
    )


def warp_perspective3d_like(
    src: Tensor,
    M: Tensor,
    like: Tensor,
    flags: str = "bilinear",
    border_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """``warp_perspective3d`` to the depth, height and width of another tensor.

    Args:
        src: volumes (B, C, D, H, W).
        M: homographies (B, 4, 4) from source to destination voxels.
        like: a tensor (..., OD, OH, OW) of any dtype, whose values are not read.
        flags, border_mode, align_corners: as in :func:`warp_perspective3d`.

    Returns:
        Volumes (B, C, OD, OH, OW).

    Example:
        >>> warp_perspective3d_like(torch.rand(1, 2, 4, 5, 6), torch.eye(4)[None], torch.empty(3, 4, 5)).shape
        torch.Size([1, 2, 3, 4, 5])
    """
    return warp_perspective3d(
        src, M, (like.shape[-3], like.shape[-2], like.shape[-1]), flags, border_mode, align_corners
    )


def homography_warp3d_like(
    patch_src: Tensor,
    src_homo_dst: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """``homography_warp3d`` to the depth, height and width of another tensor.

    Args:
        patch_src: volumes (B, C, D, H, W).
        src_homo_dst: homographies (B, 4, 4) from the output to patch_src, in [-1, 1].
        like: a tensor (..., OD, OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`homography_warp3d`.

    Returns:
        Volumes (B, C, OD, OH, OW).

    Example:
        >>> homography_warp3d_like(torch.rand(1, 2, 4, 5, 6), torch.eye(4)[None], torch.empty(3, 4, 5)).shape
        torch.Size([1, 2, 3, 4, 5])
    """
    size = (like.shape[-3], like.shape[-2], like.shape[-1])
    return homography_warp3d(patch_src, src_homo_dst, size, mode, padding_mode, align_corners)


def crop_by_transform_mat3d_like(
    tensor: Tensor,
    transform: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``crop_by_transform_mat3d`` to the depth, height and width of another tensor.

    Args:
        tensor: volumes (B, C, D, H, W).
        transform: homographies (B, 4, 4) from source to destination voxels.
        like: a tensor (..., OD, OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`crop_by_transform_mat3d`.

    Returns:
        Volumes (B, C, OD, OH, OW).

    Example:
        >>> crop_by_transform_mat3d_like(
        ...     torch.rand(1, 2, 4, 5, 6), torch.eye(4)[None], torch.empty(3, 4, 5)
        ... ).shape
        torch.Size([1, 2, 3, 4, 5])
    """
    size = (like.shape[-3], like.shape[-2], like.shape[-1])
    return crop_by_transform_mat3d(tensor, transform, size, mode, padding_mode, align_corners)


def crop_by_boxes3d_like(
    tensor: Tensor,
    src_box: Tensor,
    dst_box: Tensor,
    like: Tensor,
    interpolation: str = "bilinear",
    align_corners: bool = False,
) -> Tensor:
    """``crop_by_boxes3d`` with the depth, height and width of another tensor instead of dst_box's.

    Args:
        tensor: volumes (B, C, D, H, W).
        src_box: corners (B, 8, 3) in the volumes: the front's from the upper left clockwise, then the back's.
        dst_box: where they are (B, 8, 3) in the output.
        like: a tensor (..., OD, OH, OW) of any dtype, whose values are not read.
        interpolation, align_corners: as in :func:`crop_by_boxes3d`.

    Returns:
        Volumes (B, C, OD, OH, OW).

    Example:
        >>> front = torch.tensor([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
        >>> box = torch.cat([front, front + torch.tensor([0.0, 0.0, 1.0])])[None]
        >>> crop_by_boxes3d_like(torch.ones(1, 1, 4, 5, 6), box + 1.0, box, torch.empty(2, 2, 3)).shape
        torch.Size([1, 1, 2, 2, 3])
    """
    check_points(src_box, 8, 3, "src_box")
    check_points(dst_box, 8, 3, "dst_box")
    matrix = get_perspective_transform3d(src_box.to(torch.float64), dst_box.to(torch.float64))
    size = (like.shape[-3], like.shape[-2], like.shape[-1])
    return crop_by_transform_mat3d(tensor, matrix, size, interpolation, "zeros", align_corners)
