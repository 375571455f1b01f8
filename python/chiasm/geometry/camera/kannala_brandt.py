"""The fisheye camera of J. Kannala and S. Brandt, A Generic Camera Model and Calibration Method ..., PAMI
28(8), 2006.

A ray at angle t to the optical axis is seen at radius d(t) = t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8), as in
OpenCV's fisheye.
"""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_last


def distort_points_kannala_brandt(projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor:
    """Pixels at which a fisheye camera sees points of the plane z = 1.

    Args:
        projected_points_in_camera_z1_plane: (*, 2), floating point.
        params: (*, 8): fx, fy, cx, cy, k1, k2, k3, k4.

    Returns:
        (*, 2). Differentiable in both, also at the principal point.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimension is not as above.

    Example:
        >>> distort_points_kannala_brandt(
        ...     torch.tensor([1.0, 0.0]), torch.tensor([400.0, 400.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0])
        ... )
        tensor([634.1593, 240.0000])
    """
    xy = projected_points_in_camera_z1_plane
    check_last(xy, 2, "projected_points_in_camera_z1_plane")
    check_last(params, 8, "params")
    check_broadcastable(params, xy, "params", "projected_points_in_camera_z1_plane", 1, 1)
    ratio, _ = _ratio_and_slope((xy * xy).sum(-1), params)
    return xy * ratio[..., None] * params[..., 0:2] + params[..., 2:4]


def undistort_points_kannala_brandt(
    distorted_points_in_camera: Tensor, params: Tensor, num_iters: int = 10
) -> Tensor:
    """Points of the plane z = 1 that a fisheye camera sees at given pixels. The inverse of
    :func:`distort_points_kannala_brandt`. The angle is computed by Newton's method; its last step carries the
    gradient.

    Args:
        distorted_points_in_camera: (*, 2) pixels less than 90 degrees from the optical axis, floating point.
        params: (*, 8): fx, fy, cx, cy, k1, k2, k3, k4, with d(t) increasing up to the angles that occur.
        num_iters: Newton steps, at least 1.

    Returns:
        (*, 2). Differentiable in both.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a last dimension is not as above, or num_iters is below 1.

    Example:
        >>> undistort_points_kannala_brandt(
        ...     torch.tensor([634.1593, 240.0]),
        ...     torch.tensor([400.0, 400.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0]),
        ... )
        tensor([1.0000, 0.0000])
    """
    check_last(distorted_points_in_camera, 2, "distorted_points_in_camera")
    check_last(params, 8, "params")
    check_broadcastable(params, distorted_points_in_camera, "params", "distorted_points_in_camera", 1, 1)
    if num_iters < 1:
        raise ValueError(f"num_iters: expected at least 1, got {num_iters}")
    xy = (distorted_points_in_camera - params[..., 2:4]) / params[..., 0:2]
    squared = (xy * xy).sum(-1)
    small = squared < 1e-4  # here and below, a series is used instead
    radius = torch.sqrt(torch.where(small, torch.ones_like(squared), squared))
    fixed_radius, fixed_params = radius.detach(), params.detach()
    # If d is nearly linear, the radius is close to the angle; if d bends upwards, 90 degrees is an upper
    # bound.
    angle = fixed_radius.clamp(max=1.5707963267948966)
    for _ in range(num_iters - 1):
        distorted, slope = _distorted_angle(angle, fixed_params)
        angle = angle - (distorted - fixed_radius) / slope
    distorted, slope = _distorted_angle(angle, params)
    angle = angle - (distorted - radius) / slope.detach()
    # tan(t) / d for d near 0, where t is the inverse series of d.
    k1, k2 = params[..., 4], params[..., 5]
    inverse = (1.0 / 3.0 - k1) * squared + (2.0 / 15.0 - k1 + 3.0 * k1 * k1 - k2) * squared * squared
    series = 1.0 + torch.where(small, inverse, torch.zeros_like(inverse))
    return xy * torch.where(small, series, torch.tan(angle) / radius)[..., None]


def dx_distort_points_kannala_brandt(projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor:
    """Derivative of :func:`distort_points_kannala_brandt` with respect to the point.

    Args:
        projected_points_in_camera_z1_plane: (*, 2), floating point.
        params: (*, 8): fx, fy, cx, cy, k1, k2, k3, k4.

    Returns:
        (*, 2, 2): a row for each pixel coordinate.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimension is not as above.

    Example:
        >>> dx_distort_points_kannala_brandt(
        ...     torch.zeros(2), torch.tensor([400.0, 300.0, 320.0, 240.0, 0.1, 0.0, 0.0, 0.0])
        ... ).diagonal()
        tensor([400., 300.])
    """
    xy = projected_points_in_camera_z1_plane
    check_last(xy, 2, "projected_points_in_camera_z1_plane")
    check_last(params, 8, "params")
    check_broadcastable(params, xy, "params", "projected_points_in_camera_z1_plane", 1, 1)
    x, y = xy[..., 0], xy[..., 1]
    ratio, slope = _ratio_and_slope((xy * xy).sum(-1), params)
    fx, fy = params[..., 0], params[..., 1]
    twist = 2.0 * x * y * slope
    rows = [
        torch.stack([fx * (ratio + 2.0 * x * x * slope), fx * twist], -1),
        torch.stack([fy * twist, fy * (ratio + 2.0 * y * y * slope)], -1),
    ]
    return torch.stack(rows, -2)


def _distorted_angle(angle: Tensor, params: Tensor) -> Tuple[Tensor, Tensor]:
    """d(t) and its derivative."""
    q = angle * angle
    k1, k2, k3, k4 = params[..., 4], params[..., 5], params[..., 6], params[..., 7]
    distorted = angle * (1.0 + q * (k1 + q * (k2 + q * (k3 + q * k4))))
    return distorted, 1.0 + q * (3.0 * k1 + q * (5.0 * k2 + q * (7.0 * k3 + q * (9.0 * k4))))


def _ratio_and_slope(squared: Tensor, params: Tensor) -> Tuple[Tensor, Tensor]:
    """d(atan r) / r as a function of r^2, and its derivative with respect to r^2."""
    small = squared < 1e-4
    q = torch.where(small, squared, torch.zeros_like(squared))
    k1, k2, k3 = params[..., 4], params[..., 5], params[..., 6]
    a1 = k1 - 1.0 / 3.0
    a2 = 1.0 / 5.0 - k1 + k2
    a3 = -1.0 / 7.0 + 14.0 / 15.0 * k1 - 5.0 / 3.0 * k2 + k3
    safe = torch.where(small, torch.ones_like(squared), squared)
    radius = torch.sqrt(safe)
    distorted, derivative = _distorted_angle(torch.atan(radius), params)
    ratio = distorted / radius
    slope = 0.5 * (derivative / (1.0 + safe) - ratio) / safe
    return torch.where(small, 1.0 + q * (a1 + q * (a2 + q * a3)), ratio), torch.where(
        small, a1 + q * (2.0 * a2 + q * 3.0 * a3), slope
    )
