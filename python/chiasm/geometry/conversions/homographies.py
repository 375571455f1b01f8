"""Conversion of homographies between pixel coordinates and normalized coordinates (defined in `pixels`)."""

from typing import Tuple

from torch import Tensor

from ...primitives.core.checks import check_matrix, check_pair, check_rank, check_size3d
from ...primitives.linalg.matrices import small_matmul
from .pixels import normal_transform_pixel, normal_transform_pixel3d, pixel_transform_normal


def normalize_homography(
    dst_pix_trans_src_pix: Tensor,
    dsize_src: Tuple[int, int],
    dsize_dst: Tuple[int, int],
    align_corners: bool = True,
) -> Tensor:
    """Convert a homography between pixel coordinates to one between normalized coordinates.

    Args:
        dst_pix_trans_src_pix: (B, 3, 3), from source to destination pixels, floating point.
        dsize_src: (height, width) of the source.
        dsize_dst: (height, width) of the destination.
        align_corners: True: -1 and 1 are the centres of the outermost pixels; False: -1 and 1 are their outer
            edges.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError, ValueError: if dst_pix_trans_src_pix is not a floating-point (B, 3, 3) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> normalize_homography(torch.eye(3)[None], (5, 5), (5, 9))[0, 0]
        tensor([ 0.5000,  0.0000, -0.5000])
    """
    m = _checked(dst_pix_trans_src_pix, 3, "dst_pix_trans_src_pix")
    check_pair(dsize_src, "dsize_src")
    check_pair(dsize_dst, "dsize_dst")
    normal_dst = normal_transform_pixel(dsize_dst[0], dsize_dst[1], 1e-14, m.device, m.dtype, align_corners)
    return small_matmul(
        small_matmul(normal_dst, m), pixel_transform_normal([dsize_src[1], dsize_src[0]], align_corners, m)
    )


def denormalize_homography(
    dst_pix_trans_src_pix: Tensor,
    dsize_src: Tuple[int, int],
    dsize_dst: Tuple[int, int],
    align_corners: bool = True,
) -> Tensor:
    """Convert a homography between normalized coordinates to pixel coordinates: the inverse of
    `normalize_homography`.

    Args:
        dst_pix_trans_src_pix: (B, 3, 3), from normalized source to normalized destination coordinates (the
            name is Kornia's), floating point.
        dsize_src: (height, width) of the source.
        dsize_dst: (height, width) of the destination.
        align_corners: True: -1 and 1 are the centres of the outermost pixels; False: -1 and 1 are their outer
            edges.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError, ValueError: if dst_pix_trans_src_pix is not a floating-point (B, 3, 3) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> denormalize_homography(torch.eye(3)[None], (5, 5), (5, 9))[0, 0]
        tensor([2., 0., 0.])
    """
    m = _checked(dst_pix_trans_src_pix, 3, "dst_pix_trans_src_pix")
    check_pair(dsize_src, "dsize_src")
    check_pair(dsize_dst, "dsize_dst")
    normal_src = normal_transform_pixel(dsize_src[0], dsize_src[1], 1e-14, m.device, m.dtype, align_corners)
    return small_matmul(
        small_matmul(pixel_transform_normal([dsize_dst[1], dsize_dst[0]], align_corners, m), m), normal_src
    )


def normalize_homography3d(
    dst_pix_trans_src_pix: Tensor, dsize_src: Tuple[int, int, int], dsize_dst: Tuple[int, int, int]
) -> Tensor:
    """Convert a homography between voxels to normalized coordinates; -1 and 1 are the outermost voxels'
    centres.

    Args:
        dst_pix_trans_src_pix: (B, 4, 4), from source to destination voxels (x, y, z), floating point.
        dsize_src: (depth, height, width) of the source.
        dsize_dst: (depth, height, width) of the destination.

    Returns:
        (B, 4, 4).

    Raises:
        TypeError, ValueError: if dst_pix_trans_src_pix is not a floating-point (B, 4, 4) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> normalize_homography3d(torch.eye(4)[None], (3, 5, 5), (3, 5, 9))[0, 0]
        tensor([ 0.5000,  0.0000,  0.0000, -0.5000])
    """
    m = _checked(dst_pix_trans_src_pix, 4, "dst_pix_trans_src_pix")
    check_size3d(dsize_src, "dsize_src")
    check_size3d(dsize_dst, "dsize_dst")
    normal_dst = normal_transform_pixel3d(dsize_dst[0], dsize_dst[1], dsize_dst[2], 1e-14, m.device, m.dtype)
    return small_matmul(
        small_matmul(normal_dst, m),
        pixel_transform_normal([dsize_src[2], dsize_src[1], dsize_src[0]], True, m),
    )


def denormalize_homography3d(
    dst_pix_trans_src_pix: Tensor, dsize_src: Tuple[int, int, int], dsize_dst: Tuple[int, int, int]
) -> Tensor:
    """Convert a homography between normalized coordinates to voxels: the inverse of `normalize_homography3d`.

    Args:
        dst_pix_trans_src_pix: (B, 4, 4), from normalized source to normalized destination coordinates (the
            name is Kornia's), floating point.
        dsize_src: (depth, height, width) of the source.
        dsize_dst: (depth, height, width) of the destination.

    Returns:
        (B, 4, 4).

    Raises:
        TypeError, ValueError: if dst_pix_trans_src_pix is not a floating-point (B, 4, 4) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> denormalize_homography3d(torch.eye(4)[None], (3, 5, 5), (3, 5, 9))[0, 0]
        tensor([2., 0., 0., 0.])
    """
    m = _checked(dst_pix_trans_src_pix, 4, "dst_pix_trans_src_pix")
    check_size3d(dsize_src, "dsize_src")
    check_size3d(dsize_dst, "dsize_dst")
    normal_src = normal_transform_pixel3d(dsize_src[0], dsize_src[1], dsize_src[2], 1e-14, m.device, m.dtype)
    return small_matmul(
        small_matmul(pixel_transform_normal([dsize_dst[2], dsize_dst[1], dsize_dst[0]], True, m), m),
        normal_src,
    )


def _checked(matrix: Tensor, size: int, name: str) -> Tensor:
    check_rank(matrix, 3, f"(B, {size}, {size})", name)
    check_matrix(matrix, size, size, name)
    return matrix
