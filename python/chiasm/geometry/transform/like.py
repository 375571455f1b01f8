"""Resampling to a size that is known only at run time.

Every runtime passes tensors, and not every one passes integers that change from call to call; so the size
wanted comes in as the shape of a tensor.
"""

from typing import Optional

import torch
from torch import Tensor

from .affine import warp_affine
from .crop import center_crop, crop_by_transform_mat
from .homography_warp import homography_warp
from .matrices import check_points, get_perspective_transform
from .polar import warp_polar
from .resize import resize
from .warp import warp_perspective


def resize_like(
    input: Tensor,
    like: Tensor,
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    antialias: bool = False,
) -> Tensor:
    """Resize images to the height and width of another tensor.

    Args:
        input: images (B, C, H, W).
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        interpolation, align_corners, antialias: as in :func:`resize`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> resize_like(torch.rand(1, 3, 32, 48), torch.empty(16, 20, dtype=torch.uint8)).shape
        torch.Size([1, 3, 16, 20])
    """
    size = (like.shape[-2], like.shape[-1])
    return resize(input, size, interpolation, align_corners, "short", antialias)


def warp_perspective_like(
    src: Tensor,
    M: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp images by homographies to the height and width of another tensor.

    Args:
        src: images (B, C, H, W).
        M: homographies (B, 3, 3) from source to destination pixels.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`warp_perspective`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> like = torch.empty(16, 20, dtype=torch.uint8)
        >>> warp_perspective_like(torch.rand(1, 3, 32, 48), torch.eye(3)[None], like).shape
        torch.Size([1, 3, 16, 20])
    """
    dsize = (like.shape[-2], like.shape[-1])
    return warp_perspective(src, M, dsize, mode, padding_mode, align_corners)


def warp_affine_like(
    src: Tensor,
    M: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
    fill_value: Optional[Tensor] = None,
) -> Tensor:
    """Warp images by affine transforms to the height and width of another tensor.

    Args:
        src: images (B, C, H, W).
        M: matrices (B, 2, 3) from source to destination pixels.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners, fill_value: as in :func:`warp_affine`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> warp_affine_like(torch.rand(1, 3, 32, 48), torch.eye(3)[None, :2], torch.empty(16, 20)).shape
        torch.Size([1, 3, 16, 20])
    """
    dsize = (like.shape[-2], like.shape[-1])
    return warp_affine(src, M, dsize, mode, padding_mode, align_corners, fill_value)


def homography_warp_like(
    patch_src: Tensor,
    src_homo_dst: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
    normalized_coordinates: bool = True,
    normalized_homography: bool = True,
) -> Tensor:
    """``homography_warp`` to the height and width of another tensor.

    Args:
        patch_src: images (B, C, H, W).
        src_homo_dst: homographies (B, 3, 3) from the output to patch_src.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners, normalized_coordinates, normalized_homography: as in
            :func:`homography_warp`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> homography_warp_like(torch.rand(1, 3, 32, 48), torch.eye(3)[None], torch.empty(16, 20)).shape
        torch.Size([1, 3, 16, 20])
    """
    dsize = (like.shape[-2], like.shape[-1])
    return homography_warp(
        patch_src,
        src_homo_dst,
        dsize,
        mode,
        padding_mode,
        align_corners,
        normalized_coordinates,
        normalized_homography,
    )


def crop_by_transform_mat_like(
    input_tensor: Tensor,
    transform: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``crop_by_transform_mat`` to the height and width of another tensor.

    Args:
        input_tensor: images (B, C, H, W).
        transform: homographies (B, 3, 3) from source to destination pixels.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`crop_by_transform_mat`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> crop_by_transform_mat_like(
        ...     torch.rand(1, 3, 32, 48), torch.eye(3)[None], torch.empty(16, 20)
        ... ).shape
        torch.Size([1, 3, 16, 20])
    """
    return crop_by_transform_mat(
        input_tensor, transform, (like.shape[-2], like.shape[-1]), mode, padding_mode, align_corners
    )


def crop_by_boxes_like(
    input_tensor: Tensor,
    src_box: Tensor,
    dst_box: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``crop_by_boxes`` with the height and width of another tensor instead of dst_box's.

    Args:
        input_tensor: images (B, C, H, W).
        src_box: corners (B, 4, 2) in the images, from the upper left clockwise.
        dst_box: where they are (B, 4, 2) in the output.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`crop_by_boxes`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [7.0, 0.0], [7.0, 7.0], [0.0, 7.0]]])
        >>> crop_by_boxes_like(torch.rand(1, 3, 32, 48), 2.0 * square, square, torch.empty(8, 8)).shape
        torch.Size([1, 3, 8, 8])
    """
    check_points(src_box, 4, 2, "src_box")
    check_points(dst_box, 4, 2, "dst_box")
    matrix = get_perspective_transform(src_box.to(torch.float64), dst_box.to(torch.float64))
    return crop_by_transform_mat(
        input_tensor, matrix, (like.shape[-2], like.shape[-1]), mode, padding_mode, align_corners
    )


def center_crop_like(
    input_tensor: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``center_crop`` to the height and width of another tensor.

    Args:
        input_tensor: images (B, C, H, W).
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`center_crop`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> center_crop_like(torch.rand(1, 3, 32, 48), torch.empty(16, 20)).shape
        torch.Size([1, 3, 16, 20])
    """
    return center_crop(input_tensor, (like.shape[-2], like.shape[-1]), mode, padding_mode, align_corners)


def warp_polar_like(
    src: Tensor,
    center: Tensor,
    max_radius: Tensor,
    like: Tensor,
    mapping: str = "linear",
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``warp_polar`` to the height and width of another tensor.

    Args:
        src: images (B, C, H, W).
        center: (B, 2), x and y in pixels.
        max_radius: (B,) in pixels.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mapping, mode, padding_mode, align_corners: as in :func:`warp_polar`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> middle, radius = torch.tensor([[24.0, 16.0]]), torch.tensor([16.0])
        >>> warp_polar_like(torch.rand(1, 3, 32, 48), middle, radius, torch.empty(36, 16)).shape
        torch.Size([1, 3, 36, 16])
    """
    return warp_polar(
        src, (like.shape[-2], like.shape[-1]), center, max_radius, mapping, mode, padding_mode, align_corners
    )
