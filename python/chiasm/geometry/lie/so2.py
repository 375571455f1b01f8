"""SO(2), the rotations of the plane: matrices (*, 2, 2); tangents are angles (*) in radians.

The group is commutative, so the adjoint and the Jacobians are 1; they exist so that the four groups have the
same functions.
"""

import torch
from torch import Tensor

from ...primitives.core.checks import check_floating, check_matrix
from ...primitives.geometry.angles import angle_of


def so2_exp(theta: Tensor) -> Tensor:
    """The rotation [[cos a, -sin a], [sin a, cos a]], from the x axis towards the y axis.

    Args:
        theta: (*) in radians, floating point.

    Returns:
        (*, 2, 2).

    Raises:
        TypeError: if theta is not floating point.

    Example:
        >>> so2_exp(torch.tensor(0.0))
        tensor([[1., -0.],
                [0., 1.]])
    """
    check_floating(theta, "theta")
    c, s = torch.cos(theta), torch.sin(theta)
    return torch.stack([torch.stack([c, -s], -1), torch.stack([s, c], -1)], -2)


def so2_log(rotation: Tensor) -> Tensor:
    """The angle of rotations: the inverse of `so2_exp`.

    Args:
        rotation: (*, 2, 2), floating point.

    Returns:
        (*) in radians, in (-pi, pi].

    Raises:
        TypeError, ValueError: if rotation is not a floating-point (*, 2, 2) tensor.

    Example:
        >>> so2_log(torch.eye(2))
        tensor(0.)
    """
    check_matrix(rotation, 2, 2, "rotation")
    return angle_of(rotation[..., 1, 0], rotation[..., 0, 0])


def so2_hat(theta: Tensor) -> Tensor:
    """The tangent as a matrix, [[0, -a], [a, 0]], whose exponential is `so2_exp`.

    Args:
        theta: (*), floating point.

    Returns:
        (*, 2, 2).

    Raises:
        TypeError: if theta is not floating point.

    Example:
        >>> so2_hat(torch.tensor(3.0))
        tensor([[ 0., -3.],
                [ 3.,  0.]])
    """
    check_floating(theta, "theta")
    zero = torch.zeros_like(theta)
    return torch.stack([torch.stack([zero, -theta], -1), torch.stack([theta, zero], -1)], -2)


def so2_vee(omega: Tensor) -> Tensor:
    """The inverse of `so2_hat`.

    Args:
        omega: (*, 2, 2), skew-symmetric, floating point.

    Returns:
        (*).

    Raises:
        TypeError, ValueError: if omega is not a floating-point (*, 2, 2) tensor.

    Example:
        >>> so2_vee(torch.tensor([[0.0, -3.0], [3.0, 0.0]]))
        tensor(3.)
    """
    check_matrix(omega, 2, 2, "omega")
    return omega[..., 1, 0].clone()


def so2_adjoint(rotation: Tensor) -> Tensor:
    """How tangents change with the frame: not at all, since rotations of the plane commute.

    Args:
        rotation: (*, 2, 2), floating point.

    Returns:
        (*, 1, 1), ones.

    Raises:
        TypeError, ValueError: if rotation is not a floating-point (*, 2, 2) tensor.

    Example:
        >>> so2_adjoint(torch.eye(2))
        tensor([[1.]])
    """
    check_matrix(rotation, 2, 2, "rotation")
    return torch.ones_like(rotation[..., :1, :1])


def so2_left_jacobian(theta: Tensor) -> Tensor:
    """J with exp(theta + d) = exp(J d) exp(theta) to first order: 1.

    Args:
        theta: (*) in radians, floating point.

    Returns:
        (*, 1, 1), ones.

    Raises:
        TypeError: if theta is not floating point.

    Example:
        >>> so2_left_jacobian(torch.tensor(0.3))
        tensor([[1.]])
    """
    check_floating(theta, "theta")
    return torch.ones_like(theta)[..., None, None]


def so2_right_jacobian(theta: Tensor) -> Tensor:
    """J with exp(theta + d) = exp(theta) exp(J d) to first order: 1.

    Args:
        theta: (*) in radians, floating point.

    Returns:
        (*, 1, 1), ones.

    Raises:
        TypeError: if theta is not floating point.

    Example:
        >>> so2_right_jacobian(torch.tensor(0.3))
        tensor([[1.]])
    """
    return so2_left_jacobian(theta)
