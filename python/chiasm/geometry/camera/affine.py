"""The camera without distortion: from the plane z = 1 to pixels by focal lengths and principal point."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_last


def distort_points_affine(projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor:
    """Pixels of points of the plane z = 1: (fx x + cx, fy y + cy).

    Args:
        projected_points_in_camera_z1_plane: (*, 2), floating point.
        params: (*, 4): fx, fy, cx, cy.

    Returns:
        (*, 2). Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimension is not as above.

    Example:
        >>> distort_points_affine(torch.tensor([1.0, 2.0]), torch.tensor([600.0, 500.0, 319.5, 239.5]))
        tensor([ 919.5000, 1239.5000])
    """
    check_last(projected_points_in_camera_z1_plane, 2, "projected_points_in_camera_z1_plane")
    check_last(params, 4, "params")
    check_broadcastable(
        params, projected_points_in_camera_z1_plane, "params", "projected_points_in_camera_z1_plane", 1, 1
    )
    return projected_points_in_camera_z1_plane * params[..., 0:2] + params[..., 2:4]


def undistort_points_affine(distorted_points_in_camera: Tensor, params: Tensor) -> Tensor:
    """Points of the plane z = 1 from pixels; the inverse of :func:`distort_points_affine`.

    Args:
        distorted_points_in_camera: (*, 2) pixels, floating point.
        params: (*, 4): fx, fy, cx, cy.

    Returns:
        (*, 2). Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimension is not as above.

    Example:
        >>> undistort_points_affine(torch.tensor([919.5, 1239.5]), torch.tensor([600.0, 500.0, 319.5, 239.5]))
        tensor([1., 2.])
    """
    check_last(distorted_points_in_camera, 2, "distorted_points_in_camera")
    check_last(params, 4, "params")
    check_broadcastable(params, distorted_points_in_camera, "params", "distorted_points_in_camera", 1, 1)
    return (distorted_points_in_camera - params[..., 2:4]) / params[..., 0:2]


def dx_distort_points_affine(projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor:
    """Derivative of :func:`distort_points_affine` with respect to the point: diag(fx, fy).

    Args:
        projected_points_in_camera_z1_plane: (*, 2), floating point.
        params: (*, 4): fx, fy, cx, cy.

    Returns:
        (*, 2, 2).

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimension is not as above.

    Example:
        >>> dx_distort_points_affine(torch.tensor([1.0, 2.0]), torch.tensor([600.0, 500.0, 319.5, 239.5]))
        tensor([[600.,   0.],
                [  0., 500.]])
    """
    check_last(projected_points_in_camera_z1_plane, 2, "projected_points_in_camera_z1_plane")
    check_last(params, 4, "params")
    check_broadcastable(
        params, projected_points_in_camera_z1_plane, "params", "projected_points_in_camera_z1_plane", 1, 1
    )
    one = torch.ones_like(projected_points_in_camera_z1_plane[..., 0])
    fx, fy = one * params[..., 0], one * params[..., 1]
    zero = torch.zeros_like(fx)
    return torch.stack([torch.stack([fx, zero], -1), torch.stack([zero, fy], -1)], -2)
