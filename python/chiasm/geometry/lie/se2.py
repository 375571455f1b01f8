"""SE(2), the rigid motions of the plane: matrices (*, 3, 3); tangents (*, 3) are a velocity (x, y), then an
angle in radians.

J. Sola, J. Deray, D. Atchuthan, A micro Lie theory for state estimation in robotics, 2018, appendix C.
"""

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_matrix, check_tensor
from ...primitives.geometry.stumpff import stumpff
from ...primitives.linalg.matrices import small_matmul
from .so2 import so2_exp, so2_hat, so2_log


def se2_exp(v: Tensor) -> Tensor:
    """The exponential: the motion of a tangent, along an arc of a circle.

    Args:
        v: (*, 3): x, y and the angle in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> se2_exp(torch.tensor([1.0, 2.0, 0.0]))[:, 2]
        tensor([1., 2., 1.])
    """
    check_last(v, 3, "v")
    angle = v[..., 2]
    translation = small_matmul(_arc(angle), v[..., :2, None])
    return _with_last_row(torch.cat([so2_exp(angle), translation], -1), 1.0)


def se2_log(motion: Tensor) -> Tensor:
    """The logarithm: the tangent of motions, the inverse of `se2_exp`.

    Args:
        motion: (*, 3, 3), floating point.

    Returns:
        (*, 3): x, y and the angle, in (-pi, pi].

    Raises:
        TypeError, ValueError: if motion is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> se2_log(torch.eye(3))
        tensor([0., 0., 0.])
    """
    check_matrix(motion, 3, 3, "motion")
    angle = so2_log(motion[..., :2, :2])
    # The arc is sinc I + (1 - cos) / a J, whose inverse is its transpose over sinc^2 + ((1 - cos) / a)^2 = 2
    # (1 - cos) / a^2.
    back = _arc(-angle) / (2.0 * stumpff(angle * angle, 2))[..., None, None]
    return torch.cat([small_matmul(back, motion[..., :2, 2:])[..., 0], angle[..., None]], -1)


def se2_hat(v: Tensor) -> Tensor:
    """The tangent as a matrix, whose exponential is `se2_exp`.

    Args:
        v: (*, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> se2_hat(torch.tensor([1.0, 2.0, 3.0]))
        tensor([[ 0., -3.,  1.],
                [ 3.,  0.,  2.],
                [ 0.,  0.,  0.]])
    """
    check_last(v, 3, "v")
    return _with_last_row(torch.cat([so2_hat(v[..., 2]), v[..., :2, None]], -1), 0.0)


def se2_vee(omega: Tensor) -> Tensor:
    """The inverse of `se2_hat`.

    Args:
        omega: (*, 3, 3), floating point.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if omega is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> se2_vee(se2_hat(torch.tensor([1.0, 2.0, 3.0])))
        tensor([1., 2., 3.])
    """
    check_matrix(omega, 3, 3, "omega")
    return torch.stack([omega[..., 0, 2], omega[..., 1, 2], omega[..., 1, 0]], -1)


def se2_adjoint(motion: Tensor) -> Tensor:
    """How tangents change with the frame: T exp(v) T^-1 = exp(Ad v).

    Args:
        motion: (*, 3, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if motion is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> se2_adjoint(torch.tensor([[1.0, 0.0, 5.0], [0.0, 1.0, 6.0], [0.0, 0.0, 1.0]]))
        tensor([[ 1.,  0.,  6.],
                [ 0.,  1., -5.],
                [ 0.,  0.,  1.]])
    """
    check_matrix(motion, 3, 3, "motion")
    column = torch.stack([motion[..., 1, 2], -motion[..., 0, 2]], -1)[..., None]
    return _with_last_row(torch.cat([motion[..., :2, :2], column], -1), 1.0)


def se2_left_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(J d) exp(v) to first order.

    Args:
        v: (*, 3): x, y and the angle in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> se2_left_jacobian(torch.tensor([2.0, 4.0, 0.0]))[:, 2]
        tensor([ 2., -1.,  1.])
    """
    check_last(v, 3, "v")
    x, y, angle = v[..., 0], v[..., 1], v[..., 2]
    squared = angle * angle
    second, third = stumpff(squared, 2), angle * stumpff(squared, 3)
    column = torch.stack([second * y + third * x, third * y - second * x], -1)[..., None]
    return _with_last_row(torch.cat([_arc(angle), column], -1), 1.0)


def se2_right_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(v) exp(J d) to first order: the left Jacobian of -v.

    Args:
        v: (*, 3): x, y and the angle in radians, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 3) tensor.

    Example:
        >>> se2_right_jacobian(torch.zeros(3)).diagonal()
        tensor([1., 1., 1.])
    """
    check_tensor(v, "v")
    return se2_left_jacobian(-v)


def _arc(angle: Tensor) -> Tensor:
    """The matrix (*, 2, 2) that maps a velocity to the chord of its arc: the mean of the rotations by 0 to
    angle."""
    squared = angle * angle
    c, s = stumpff(squared, 1), angle * stumpff(squared, 2)
    return torch.stack([torch.stack([c, -s], -1), torch.stack([s, c], -1)], -2)


def _with_last_row(matrix: Tensor, corner: float) -> Tensor:
    """(*, 2, 3) with the row 0, 0, corner below."""
    zero = torch.zeros_like(matrix[..., :1, :])
    return torch.cat([matrix, torch.cat([zero[..., :2], zero[..., 2:] + corner], -1)], -2)
