"""Conversion between pixels and the plane z = 1 in front of a camera, by focal lengths and principal
point."""

import torch
from torch import Tensor

from ..core.checks import check_floating, check_tensor


def check_intrinsics(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (*, 3, 3) or (*, 4, 4) tensor."""
    check_tensor(value, name)
    if value.dim() < 2 or value.size(-1) not in (3, 4) or value.size(-2) != value.size(-1):
        raise ValueError(f"{name}: expected shape (*, 3, 3) or (*, 4, 4), got {list(value.shape)}")
    check_floating(value, name)


def focal_lengths(camera_matrix: Tensor) -> Tensor:
    """(fx, fy) of camera matrices (*, 3, 3) or larger, (*, 2)."""
    return torch.stack([camera_matrix[..., 0, 0], camera_matrix[..., 1, 1]], -1)


def principal_point(camera_matrix: Tensor) -> Tensor:
    """(cx, cy) of camera matrices (*, 3, 3) or larger, (*, 2)."""
    return camera_matrix[..., 0:2, 2]


def to_pixels(xy: Tensor, camera_matrix: Tensor) -> Tensor:
    """The pixels (*, 2) of points (*, 2) on the plane z = 1.

    >>> to_pixels(torch.ones(2), torch.tensor([[2.0, 0.0, 3.0], [0.0, 4.0, 5.0], [0.0, 0.0, 1.0]]))
    tensor([5., 9.])
    """
    return xy * focal_lengths(camera_matrix) + principal_point(camera_matrix)


def from_pixels(uv: Tensor, camera_matrix: Tensor) -> Tensor:
    """The points (*, 2) on the plane z = 1 that are seen at pixels (*, 2); the inverse of
    :func:`to_pixels`."""
    return (uv - principal_point(camera_matrix)) / focal_lengths(camera_matrix)


def with_one(xy: Tensor) -> Tensor:
    """(*, n) points in homogeneous coordinates (*, n + 1)."""
    return torch.cat([xy, torch.ones_like(xy[..., 0:1])], -1)


def over_depth(xyz: Tensor, eps: float) -> Tensor:
    """(x / z, y / z) of (*, 3), with ``eps`` in place of a smaller |z| (the sign is kept), so that no value
    is infinite."""
    z = xyz[..., 2:3]
    least = torch.where(z < 0, torch.full_like(z, -eps), torch.full_like(z, eps))
    return xyz[..., 0:2] / torch.where(z.abs() < eps, least, z)


def moved(transform: Tensor, xyz: Tensor) -> Tensor:
    """Points (*, 3) under affine transformations (*, 3, 4) or (*, 4, 4), whose last row is assumed to be (0,
    0, 0, 1)."""
    return (transform[..., 0:3, 0:3] * xyz[..., None, :]).sum(-1) + transform[..., 0:3, 3]


def homogeneous(points: Tensor, name: str) -> Tensor:
    """Points (*, N, 2) or (*, N, 3) in homogeneous coordinates (*, N, 3); raise unless they are such a
    floating-point tensor."""
    check_floating(points, name)
    if points.dim() < 2 or points.size(-1) not in (2, 3):
        raise ValueError(f"{name}: expected shape (*, N, 2) or (*, N, 3), got {list(points.shape)}")
    return with_one(points) if points.size(-1) == 2 else points
