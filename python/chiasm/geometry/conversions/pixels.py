"""Pixel coordinates to and from the normalized range [-1, 1], and to and from the camera's plane.

With `align_corners`, -1 and 1 are the centres of the first and the last pixel: x = -1 + 2 i / (W - 1).
Without it, they are the outer edges of those pixels: x = -1 + (2 i + 1) / W. With `align_corners`, the
coordinate of an axis of one pixel is not changed: its pixel is at 0.
"""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import broadcastable, check_last, check_matrix


def normal_transform_pixel(
    height: int,
    width: int,
    eps: float = 1e-14,
    device: Optional[torch.device] = None,
    dtype: Optional[torch.dtype] = None,
    align_corners: bool = True,
) -> Tensor:
    """The matrix that maps homogeneous pixel coordinates (x, y, 1) to normalized coordinates.

    Args:
        height: height of the image, in pixels.
        width: width of the image, in pixels.
        eps: not used, for compatibility with Kornia: an axis of one pixel is not changed.
        device: the device of the result.
        dtype: the dtype of the result; PyTorch's default dtype by default.
        align_corners: True: -1 and 1 are the centres of the outermost pixels; False: -1 and 1 are their outer
            edges.

    Returns:
        (1, 3, 3).

    Raises:
        ValueError: if a size is not positive.

    Example:
        >>> normal_transform_pixel(3, 5)
        tensor([[[ 0.5000,  0.0000, -1.0000],
                 [ 0.0000,  1.0000, -1.0000],
                 [ 0.0000,  0.0000,  1.0000]]])
    """
    half, offset = normalisation([width, height], align_corners, dtype, device)
    return _scale_and_shift(1.0 / half, offset)


def normal_transform_pixel3d(
    depth: int,
    height: int,
    width: int,
    eps: float = 1e-14,
    device: Optional[torch.device] = None,
    dtype: Optional[torch.dtype] = None,
) -> Tensor:
    """The matrix that maps homogeneous voxel coordinates (x, y, z, 1) to normalized coordinates. -1 and 1 are
    the centres of the outermost voxels.

    Args:
        depth: depth of the volume, in voxels.
        height: height of the volume, in voxels.
        width: width of the volume, in voxels.
        eps: not used, for compatibility with Kornia: an axis of one voxel is not changed.
        device: the device of the result.
        dtype: the dtype of the result; PyTorch's default dtype by default.

    Returns:
        (1, 4, 4).

    Raises:
        ValueError: if a size is not positive.

    Example:
        >>> normal_transform_pixel3d(2, 3, 5)[0, :, 3]
        tensor([-1., -1., -1.,  1.])
    """
    half, offset = normalisation([width, height, depth], True, dtype, device)
    return _scale_and_shift(1.0 / half, offset)


def pixel_transform_normal(sizes: List[int], align_corners: bool, like: Tensor) -> Tensor:
    """The inverse (1, n + 1, n + 1) of the matrices above, for axes of the given sizes (width first), in the
    dtype of ``like``.

    >>> pixel_transform_normal([5, 3], True, torch.ones(1))[0, 0]
    tensor([2., 0., 2.])
    """
    half, offset = normalisation(sizes, align_corners, like.dtype, like.device)
    return _scale_and_shift(half, -offset * half)


def normalize_pixel_coordinates(
    pixel_coordinates: Tensor, height: int, width: int, eps: float = 1e-8
) -> Tensor:
    """Map pixel coordinates to [-1, 1]; -1 and 1 are the centres of the outermost pixels
    (`align_corners=True`).

    Args:
        pixel_coordinates: (*, 2) in the order x, y, floating point.
        height: height of the image, in pixels.
        width: width of the image, in pixels.
        eps: not used, for compatibility with Kornia: an axis of one pixel is not changed.

    Returns:
        (*, 2).

    Raises:
        TypeError, ValueError: if pixel_coordinates is not a floating-point (*, 2) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> normalize_pixel_coordinates(torch.tensor([[0.0, 0.0], [4.0, 1.0]]), 3, 5)
        tensor([[-1., -1.],
                [ 1.,  0.]])
    """
    check_last(pixel_coordinates, 2, "pixel_coordinates")
    half, offset = normalisation([width, height], True, pixel_coordinates.dtype, pixel_coordinates.device)
    return pixel_coordinates / half + offset


def denormalize_pixel_coordinates(
    pixel_coordinates: Tensor, height: int, width: int, eps: float = 1e-8
) -> Tensor:
    """The inverse of `normalize_pixel_coordinates`.

    Args:
        pixel_coordinates: (*, 2) in the order x, y, floating point, -1 and 1 at the outermost pixels' centres
            (`align_corners=True`).
        height: height of the image, in pixels.
        width: width of the image, in pixels.
        eps: not used, for compatibility with Kornia: an axis of one pixel is not changed.

    Returns:
        (*, 2) in pixels.

    Raises:
        TypeError, ValueError: if pixel_coordinates is not a floating-point (*, 2) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> denormalize_pixel_coordinates(torch.tensor([[-1.0, -1.0], [1.0, 0.0]]), 3, 5)
        tensor([[0., 0.],
                [4., 1.]])
    """
    check_last(pixel_coordinates, 2, "pixel_coordinates")
    half, offset = normalisation([width, height], True, pixel_coordinates.dtype, pixel_coordinates.device)
    return (pixel_coordinates - offset) * half


def normalize_pixel_coordinates3d(
    pixel_coordinates: Tensor, depth: int, height: int, width: int, eps: float = 1e-8
) -> Tensor:
    """Map voxel coordinates to [-1, 1]; -1 and 1 are the centres of the outermost voxels
    (`align_corners=True`).

    Args:
        pixel_coordinates: (*, 3) in the order z, x, y, as `create_meshgrid3d` makes them, floating point.
        depth: depth of the volume, in voxels.
        height: height of the volume, in voxels.
        width: width of the volume, in voxels.
        eps: not used, for compatibility with Kornia: an axis of one voxel is not changed.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if pixel_coordinates is not a floating-point (*, 3) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> normalize_pixel_coordinates3d(torch.tensor([1.0, 1.0, 1.0]), 3, 5, 9)
        tensor([ 0.0000, -0.7500, -0.5000])
    """
    check_last(pixel_coordinates, 3, "pixel_coordinates")
    half, offset = normalisation(
        [depth, width, height], True, pixel_coordinates.dtype, pixel_coordinates.device
    )
    return pixel_coordinates / half + offset


def denormalize_pixel_coordinates3d(
    pixel_coordinates: Tensor, depth: int, height: int, width: int, eps: float = 1e-8
) -> Tensor:
    """The inverse of `normalize_pixel_coordinates3d`.

    Args:
        pixel_coordinates: (*, 3) in the order z, x, y, floating point, -1 and 1 at the outermost voxels'
            centres (`align_corners=True`).
        depth: depth of the volume, in voxels.
        height: height of the volume, in voxels.
        width: width of the volume, in voxels.
        eps: not used, for compatibility with Kornia: an axis of one voxel is not changed.

    Returns:
        (*, 3) in voxels.

    Raises:
        TypeError, ValueError: if pixel_coordinates is not a floating-point (*, 3) tensor.
        ValueError: if a size is not positive.

    Example:
        >>> denormalize_pixel_coordinates3d(torch.tensor([1.0, 1.0, 1.0]), 3, 5, 9)
        tensor([2., 8., 4.])
    """
    check_last(pixel_coordinates, 3, "pixel_coordinates")
    half, offset = normalisation(
        [depth, width, height], True, pixel_coordinates.dtype, pixel_coordinates.device
    )
    return (pixel_coordinates - offset) * half


def normalize_points_with_intrinsics(point_2d: Tensor, camera_matrix: Tensor) -> Tensor:
    """Map pixel coordinates to the plane z = 1 of the camera: ((x - cx) / fx, (y - cy) / fy). Skew is
    ignored.

    Args:
        point_2d: (*, 2) in pixels, floating point.
        camera_matrix: (*, 3, 3); (B, 3, 3) for points (B, N, 2).

    Returns:
        (*, 2).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> K = torch.tensor([[100.0, 0.0, 50.0], [0.0, 200.0, 60.0], [0.0, 0.0, 1.0]])
        >>> normalize_points_with_intrinsics(torch.tensor([70.0, 80.0]), K)
        tensor([0.2000, 0.1000])
    """
    focal, centre = _intrinsics(point_2d, camera_matrix, "point_2d")
    return (point_2d - centre) / focal


def denormalize_points_with_intrinsics(point_2d_norm: Tensor, camera_matrix: Tensor) -> Tensor:
    """The inverse of `normalize_points_with_intrinsics`: (fx x + cx, fy y + cy).

    Args:
        point_2d_norm: (*, 2) in the plane z = 1 of the camera, floating point.
        camera_matrix: (*, 3, 3); (B, 3, 3) for points (B, N, 2).

    Returns:
        (*, 2) in pixels.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> K = torch.tensor([[100.0, 0.0, 50.0], [0.0, 200.0, 60.0], [0.0, 0.0, 1.0]])
        >>> denormalize_points_with_intrinsics(torch.tensor([0.2, 0.1]), K)
        tensor([70., 80.])
    """
    focal, centre = _intrinsics(point_2d_norm, camera_matrix, "point_2d_norm")
    return point_2d_norm * focal + centre


def normalisation(
    sizes: List[int],
    align_corners: bool,
    dtype: Optional[torch.dtype] = None,
    device: Optional[torch.device] = None,
) -> Tuple[Tensor, Tensor]:
    """For each axis half the extent and the offset, so that normalized = pixel / half + offset. The sizes may
    be symbolic: only the check branches on them in Python.

    >>> normalisation([5, 1], True)
    (tensor([2., 1.]), tensor([-1.,  0.]))
    """
    halves: List[Tensor] = []
    offsets: List[Tensor] = []
    zero = torch.zeros([], dtype=dtype, device=device)
    for size in sizes:
        if size < 1:
            raise ValueError(f"sizes: expected positive numbers, got {sizes}")
        if align_corners:
            last = zero + (size - 1)
            single = last < 0.5
            halves.append(torch.where(single, zero + 1.0, 0.5 * last))
            offsets.append(torch.where(single, zero, zero - 1.0))
        else:
            halves.append((zero + size) * 0.5)
            offsets.append(1.0 / (zero + size) - 1.0)
    return torch.stack(halves), torch.stack(offsets)


def _scale_and_shift(scale: Tensor, shift: Tensor) -> Tensor:
    """(1, n + 1, n + 1) that multiplies by scale (n,) and adds shift (n,)."""
    one = torch.ones_like(scale[:1])
    return torch.cat([torch.diag(torch.cat([scale, one]))[:, :-1], torch.cat([shift, one])[:, None]], 1)[None]


def _intrinsics(points: Tensor, camera_matrix: Tensor, name: str) -> Tuple[Tensor, Tensor]:
    check_last(points, 2, name)
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    focal = torch.stack([camera_matrix[..., 0, 0], camera_matrix[..., 1, 1]], -1)
    centre = camera_matrix[..., :2, 2]
    if focal.dim() > 1 and focal.dim() < points.dim():
        focal, centre = focal.unsqueeze(-2), centre.unsqueeze(-2)
    if not broadcastable(focal, points):
        raise ValueError(
            f"camera_matrix: expected leading dimensions that broadcast with {name}'s {list(points.shape)},"
            f" got {list(camera_matrix.shape)}"
        )
    return focal, centre
