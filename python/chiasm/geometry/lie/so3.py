"""SO(3), the rotations of space: matrices (*, 3, 3); tangents are rotation vectors (*, 3), axis times angle
in radians."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_matrix, check_tensor
from ...primitives.geometry.stumpff import stumpff
from ...primitives.linalg.matrices import small_matmul
from ..conversions.rotations import (
    axis_angle_to_rotation_matrix,
    rotation_matrix_to_axis_angle,
    vector_to_skew_symmetric_matrix,
)


def so3_exp(v: Tensor) -> Tensor:
    """The rotation of a rotation vector, by Rodrigues' formula.

    Args:
        v: (*, 3) in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> so3_exp(torch.tensor([0.0, 0.0, torch.pi])).diagonal()
        tensor([-1., -1.,  1.])
    """
    check_last(v, 3, "v")
    return axis_angle_to_rotation_matrix(v)


def so3_log(rotation: Tensor) -> Tensor:
    """The rotation vector of rotations: the inverse of `so3_exp`.

    Args:
        rotation: (*, 3, 3), orthonormal with determinant 1, floating point.

    Returns:
        (*, 3), of length in [0, pi]. Values and gradients are finite also at 0 and at 180 degrees, where one
        of the two possible axes is used.

    Raises:
        TypeError, ValueError: if rotation is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> so3_log(torch.diag(torch.tensor([-1.0, -1.0, 1.0])))
        tensor([0.0000, 0.0000, 3.1416])
    """
    check_matrix(rotation, 3, 3, "rotation")
    return rotation_matrix_to_axis_angle(rotation)


def so3_hat(v: Tensor) -> Tensor:
    """The tangent as a skew-symmetric matrix, whose exponential is `so3_exp` and whose product with a vector
    is the cross product.

    Args:
        v: (*, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> so3_hat(torch.tensor([1.0, 2.0, 3.0]))[0]
        tensor([ 0., -3.,  2.])
    """
    check_last(v, 3, "v")
    return vector_to_skew_symmetric_matrix(v)


def so3_vee(omega: Tensor) -> Tensor:
    """The inverse of `so3_hat`.

    Args:
        omega: (*, 3, 3), skew-symmetric, floating point.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if omega is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> so3_vee(so3_hat(torch.tensor([1.0, 2.0, 3.0])))
        tensor([1., 2., 3.])
    """
    check_matrix(omega, 3, 3, "omega")
    return torch.stack([omega[..., 2, 1], omega[..., 0, 2], omega[..., 1, 0]], -1)


def so3_adjoint(rotation: Tensor) -> Tensor:
    """How tangents change with the frame: R exp(v) R^T = exp(Ad v). Here Ad is the rotation itself.

    Args:
        rotation: (*, 3, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if rotation is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> so3_adjoint(torch.eye(3)).diagonal()
        tensor([1., 1., 1.])
    """
    check_matrix(rotation, 3, 3, "rotation")
    return rotation.clone()


def so3_left_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(J d) exp(v) to first order.

    J = I + (1 - cos a) / a^2 [v]x + (a - sin a) / a^3 [v]x^2 (J. Sola et al., A micro Lie theory for state
    estimation in robotics, 2018, 145).

    Args:
        v: (*, 3) in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> so3_left_jacobian(torch.zeros(3)).diagonal()
        tensor([1., 1., 1.])
    """
    check_last(v, 3, "v")
    squared = (v * v).sum(-1)[..., None, None]
    m = vector_to_skew_symmetric_matrix(v)
    eye = torch.eye(3, dtype=v.dtype, device=v.device)
    return eye + stumpff(squared, 2) * m + stumpff(squared, 3) * small_matmul(m, m)


def so3_right_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(v) exp(J d) to first order: the left Jacobian of -v.

    Args:
        v: (*, 3) in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> so3_right_jacobian(torch.zeros(3)).diagonal()
        tensor([1., 1., 1.])
    """
    check_tensor(v, "v")
    return so3_left_jacobian(-v)
