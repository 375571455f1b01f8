"""Angles and polar coordinates."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_all_broadcastable, check_floating, check_tensor
from ...primitives.geometry.angles import angle_of


def rad2deg(tensor: Tensor) -> Tensor:
    """Degrees from radians.

    Args:
        tensor: any shape, floating point or integer.

    Returns:
        The same shape; float32 for integer dtypes.

    Raises:
        TypeError: if tensor is not a numeric tensor.

    Example:
        >>> rad2deg(torch.tensor([0.0, torch.pi]))
        tensor([  0., 180.])
    """
    check_tensor(tensor, "tensor")
    return _as_floats(tensor) * (180.0 / math.pi)


def deg2rad(tensor: Tensor) -> Tensor:
    """Radians from degrees.

    Args:
        tensor: any shape, floating point or integer.

    Returns:
        The same shape; float32 for integer dtypes.

    Raises:
        TypeError: if tensor is not a numeric tensor.

    Example:
        >>> deg2rad(torch.tensor([0.0, 180.0]))
        tensor([0.0000, 3.1416])
    """
    check_tensor(tensor, "tensor")
    return _as_floats(tensor) * (math.pi / 180.0)


def _as_floats(tensor: Tensor) -> Tensor:
    if tensor.is_floating_point():
        return tensor
    if tensor.dtype == torch.bool or tensor.is_complex():
        raise TypeError(f"tensor: expected real numbers, got {tensor.dtype}")
    return tensor.to(torch.float32)


def angle_to_rotation_matrix(angle: Tensor) -> Tensor:
    """Rotation matrix [[cos a, sin a], [-sin a, cos a]] of an angle. In images, where y points down, it
    rotates counterclockwise; `geometry.lie.so2_exp` is its transpose.

    Args:
        angle: (*) in degrees, floating point.

    Returns:
        (*, 2, 2).

    Raises:
        TypeError: if angle is not floating point.

    Example:
        >>> angle_to_rotation_matrix(torch.tensor(90.0)).round(decimals=4)
        tensor([[-0.,  1.],
                [-1., -0.]])
    """
    check_floating(angle, "angle")
    radians = deg2rad(angle)
    cosine, sine = torch.cos(radians), torch.sin(radians)
    return torch.stack([torch.stack([cosine, sine], -1), torch.stack([-sine, cosine], -1)], -2)


def cart2pol(x: Tensor, y: Tensor, eps: float = 1e-8) -> Tuple[Tensor, Tensor]:
    """Polar coordinates of points in the plane.

    Args:
        x: (*), floating point.
        y: (*), of x's shape or broadcast with it.
        eps: at radii below this the gradients are 0, since they have no limit at the origin. The values are
            exact everywhere.

    Returns:
        rho, the distance from the origin, and phi, the angle from the x axis towards the y axis in radians,
        in (-pi, pi]; 0 at the origin.

    Raises:
        TypeError: if x or y is not floating point.
        ValueError: if the shapes do not broadcast.

    Example:
        >>> cart2pol(torch.tensor(0.0), torch.tensor(2.0))
        (tensor(2.), tensor(1.5708))
    """
    check_floating(x, "x")
    check_floating(y, "y")
    check_all_broadcastable([x, y], ["x", "y"])
    squared = x * x + y * y
    tiny = squared < eps * eps
    rho = torch.where(
        tiny, torch.sqrt(squared.detach()), torch.sqrt(torch.where(tiny, torch.ones_like(squared), squared))
    )
    return rho, angle_of(torch.where(tiny, y.detach(), y), torch.where(tiny, x.detach(), x))


def pol2cart(rho: Tensor, phi: Tensor) -> Tuple[Tensor, Tensor]:
    """Points in the plane from polar coordinates.

    Args:
        rho: (*), distance from the origin, floating point.
        phi: (*), angle from the x axis towards the y axis in radians; of rho's shape or broadcast with it.

    Returns:
        x and y.

    Raises:
        TypeError: if rho or phi is not floating point.
        ValueError: if the shapes do not broadcast.

    Example:
        >>> pol2cart(torch.tensor(2.0), torch.tensor(0.0))
        (tensor(2.), tensor(0.))
    """
    check_floating(rho, "rho")
    check_floating(phi, "phi")
    check_all_broadcastable([rho, phi], ["rho", "phi"])
    return rho * torch.cos(phi), rho * torch.sin(phi)
