"""Projection of points in a camera's frame: onto the plane z = 1, and orthographic."""

from typing import Optional

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_floating, check_last, check_same_leading


def project_points_z1(points_in_camera: Tensor) -> Tensor:
    """Project points onto the plane z = 1: (x / z, y / z).

    Args:
        points_in_camera: (*, 3) with z not zero, floating point.

    Returns:
        (*, 2).

    Raises:
        TypeError, ValueError: if points_in_camera is not a floating-point (*, 3) tensor.

    Example:
        >>> project_points_z1(torch.tensor([2.0, 4.0, 2.0]))
        tensor([1., 2.])
    """
    check_last(points_in_camera, 3, "points_in_camera")
    return points_in_camera[..., 0:2] / points_in_camera[..., 2:3]


def unproject_points_z1(points_in_cam_canonical: Tensor, extension: Optional[Tensor] = None) -> Tensor:
    """Points at given depths on the rays through points of the plane z = 1: (x z, y z, z).

    Args:
        points_in_cam_canonical: (*, 2), floating point.
        extension: depths z, (*) or (*, 1); ones by default.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if points_in_cam_canonical is not a floating-point (*, 2) tensor, or
            extension's rank does not fit.

    Example:
        >>> unproject_points_z1(torch.tensor([1.0, 2.0]), torch.tensor([3.0]))
        tensor([3., 6., 3.])
    """
    check_last(points_in_cam_canonical, 2, "points_in_cam_canonical")
    if extension is None:
        return torch.cat([points_in_cam_canonical, torch.ones_like(points_in_cam_canonical[..., 0:1])], -1)
    depth = _as_column(extension, points_in_cam_canonical)
    check_broadcastable(depth, points_in_cam_canonical, "extension", "points_in_cam_canonical", 1, 1)
    xy = points_in_cam_canonical * depth
    return torch.cat([xy, depth.expand_as(xy[..., 0:1])], -1)


def dx_project_points_z1(points_in_camera: Tensor) -> Tensor:
    """Derivative of :func:`project_points_z1` with respect to the point.

    Args:
        points_in_camera: (*, 3) with z not zero, floating point.

    Returns:
        (*, 2, 3): a row for each of (x / z, y / z).

    Raises:
        TypeError, ValueError: if points_in_camera is not a floating-point (*, 3) tensor.

    Example:
        >>> dx_project_points_z1(torch.tensor([2.0, 4.0, 2.0]))
        tensor([[ 0.5000,  0.0000, -0.5000],
                [ 0.0000,  0.5000, -1.0000]])
    """
    check_last(points_in_camera, 3, "points_in_camera")
    inverse = 1.0 / points_in_camera[..., 2]
    x = -points_in_camera[..., 0] * inverse * inverse
    y = -points_in_camera[..., 1] * inverse * inverse
    zero = torch.zeros_like(inverse)
    return torch.stack([torch.stack([inverse, zero, x], -1), torch.stack([zero, inverse, y], -1)], -2)


def project_points_orthographic(points_in_camera: Tensor) -> Tensor:
    """Project points along the z axis: (x, y).

    Args:
        points_in_camera: (*, 3), floating point.

    Returns:
        (*, 2).

    Raises:
        TypeError, ValueError: if points_in_camera is not a floating-point (*, 3) tensor.

    Example:
        >>> project_points_orthographic(torch.tensor([2.0, 4.0, 2.0]))
        tensor([2., 4.])
    """
    check_last(points_in_camera, 3, "points_in_camera")
    return points_in_camera[..., 0:2]


def unproject_points_orthographic(points_in_camera: Tensor, extension: Tensor) -> Tensor:
    """Points at given depths behind points of an orthographic image: (x, y, z).

    Args:
        points_in_camera: (*, 2), floating point.
        extension: depths z, (*) or (*, 1).

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if points_in_camera is not a floating-point (*, 2) tensor, or extension's rank
            does not fit.

    Example:
        >>> unproject_points_orthographic(torch.tensor([1.0, 2.0]), torch.tensor([3.0]))
        tensor([1., 2., 3.])
    """
    check_last(points_in_camera, 2, "points_in_camera")
    depth = _as_column(extension, points_in_camera)
    check_same_leading([points_in_camera, depth], ["points_in_camera", "extension"], [1, 1])
    return torch.cat([points_in_camera, depth], -1)


def dx_project_points_orthographic(points_in_camera: Tensor) -> Tensor:
    """Derivative of the projected x with respect to x, and of the projected y with respect to y: ones.

    Args:
        points_in_camera: (*, 3), floating point.

    Returns:
        (*, 1).

    Raises:
        TypeError, ValueError: if points_in_camera is not a floating-point (*, 3) tensor.

    Example:
        >>> dx_project_points_orthographic(torch.tensor([2.0, 4.0, 2.0]))
        tensor([1.])
    """
    check_last(points_in_camera, 3, "points_in_camera")
    return torch.ones_like(points_in_camera[..., 0:1])


def _as_column(extension: Tensor, points: Tensor) -> Tensor:
    """Depths (*) or (*, 1) as (*, 1)."""
    check_floating(extension, "extension")
    if extension.dim() == points.dim() - 1:
        return extension[..., None]
    if extension.dim() != points.dim() or extension.size(-1) != 1:
        raise ValueError(
            f"extension: expected shape (*) or (*, 1) for points of shape {list(points.shape)}, got"
            f" {list(extension.shape)}"
        )
    return extension
