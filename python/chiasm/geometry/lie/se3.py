"""SE(3), the rigid motions of space: matrices (*, 4, 4); tangents (*, 6) are a velocity, then a rotation
vector in radians.

T. D. Barfoot, State Estimation for Robotics, 2017, chapter 7 (whose tangents are in the same order).
"""

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_matrix, check_tensor
from ...primitives.geometry.stumpff import stumpff
from ...primitives.linalg.matrices import small_matmul
from .so3 import so3_exp, so3_hat, so3_left_jacobian, so3_log, so3_vee


def se3_exp(v: Tensor) -> Tensor:
    """The exponential: the motion of a tangent, along a helix.

    Args:
        v: (*, 6): the velocity, then the rotation vector in radians, floating point.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 6) tensor.

    Example:
        >>> se3_exp(torch.tensor([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]))[:, 3]
        tensor([1., 2., 3., 1.])
    """
    check_last(v, 6, "v")
    turn = v[..., 3:]
    translation = small_matmul(so3_left_jacobian(turn), v[..., :3, None])
    return _with_last_row(torch.cat([so3_exp(turn), translation], -1), 1.0)


def se3_log(motion: Tensor) -> Tensor:
    """The logarithm: the tangent of motions, the inverse of `se3_exp`.

    Args:
        motion: (*, 4, 4), floating point.

    Returns:
        (*, 6): the velocity, then the rotation vector, of length in [0, pi].

    Raises:
        TypeError, ValueError: if motion is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> se3_log(torch.eye(4))
        tensor([0., 0., 0., 0., 0., 0.])
    """
    check_matrix(motion, 4, 4, "motion")
    turn = so3_log(motion[..., :3, :3])
    # The left Jacobian's inverse: I - [w]x / 2 + (1 / a^2 - (1 + cos a) / (2 a sin a)) [w]x^2, where the last
    # factor is written without cancellation.
    squared = (turn * turn).sum(-1)[..., None, None]
    factor = (stumpff(squared, 3) - 2.0 * stumpff(squared, 4)) / (2.0 * stumpff(squared, 2))
    m, t = so3_hat(turn), motion[..., :3, 3:]
    once = small_matmul(m, t)
    velocity = t - 0.5 * once + factor * small_matmul(m, once)
    return torch.cat([velocity[..., 0], turn], -1)


def se3_hat(v: Tensor) -> Tensor:
    """The tangent as a matrix, whose exponential is `se3_exp`.

    Args:
        v: (*, 6), floating point.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 6) tensor.

    Example:
        >>> se3_hat(torch.tensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))[0]
        tensor([ 0., -6.,  5.,  1.])
    """
    check_last(v, 6, "v")
    return _with_last_row(torch.cat([so3_hat(v[..., 3:]), v[..., :3, None]], -1), 0.0)


def se3_vee(omega: Tensor) -> Tensor:
    """The inverse of `se3_hat`.

    Args:
        omega: (*, 4, 4), floating point.

    Returns:
        (*, 6).

    Raises:
        TypeError, ValueError: if omega is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> se3_vee(se3_hat(torch.tensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])))
        tensor([1., 2., 3., 4., 5., 6.])
    """
    check_matrix(omega, 4, 4, "omega")
    return torch.cat([omega[..., :3, 3], so3_vee(omega[..., :3, :3])], -1)


def se3_adjoint(motion: Tensor) -> Tensor:
    """How tangents change with the frame: T exp(v) T^-1 = exp(Ad v).

    Args:
        motion: (*, 4, 4), floating point.

    Returns:
        (*, 6, 6): [[R, [t]x R], [0, R]].

    Raises:
        TypeError, ValueError: if motion is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> se3_adjoint(torch.eye(4)).diagonal()
        tensor([1., 1., 1., 1., 1., 1.])
    """
    check_matrix(motion, 4, 4, "motion")
    rotation = motion[..., :3, :3]
    return _block_triangle(rotation, small_matmul(so3_hat(motion[..., :3, 3]), rotation))


def se3_left_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(J d) exp(v) to first order (Barfoot, 7.85 and 7.86).

    Args:
        v: (*, 6): the velocity, then the rotation vector in radians, floating point.

    Returns:
        (*, 6, 6).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 6) tensor.

    Example:
        >>> se3_left_jacobian(torch.tensor([0.0, 0.0, 2.0, 0.0, 0.0, 0.0]))[0]
        tensor([ 1.,  0.,  0.,  0., -1.,  0.])
    """
    check_last(v, 6, "v")
    turn = v[..., 3:]
    squared = (turn * turn).sum(-1)[..., None, None]
    p, m = so3_hat(v[..., :3]), so3_hat(turn)
    mp, pm, mm = small_matmul(m, p), small_matmul(p, m), small_matmul(m, m)
    mpm = small_matmul(mp, m)
    third, fourth, fifth = stumpff(squared, 3), stumpff(squared, 4), stumpff(squared, 5)
    q = 0.5 * p + third * (mp + pm + mpm)
    q = q + fourth * (small_matmul(mm, p) + small_matmul(p, mm) - 3.0 * mpm)
    q = q + (0.5 * fourth - 1.5 * fifth) * (small_matmul(mpm, m) + small_matmul(m, mpm))
    return _block_triangle(so3_left_jacobian(turn), q)


def se3_right_jacobian(v: Tensor) -> Tensor:
    """J with exp(v + d) = exp(v) exp(J d) to first order: the left Jacobian of -v.

    Args:
        v: (*, 6): the velocity, then the rotation vector in radians, floating point.

    Returns:
        (*, 6, 6).

    Raises:
        TypeError, ValueError: if v is not a floating-point (*, 6) tensor.

    Example:
        >>> se3_right_jacobian(torch.zeros(6)).diagonal()
        tensor([1., 1., 1., 1., 1., 1.])
    """
    check_tensor(v, "v")
    return se3_left_jacobian(-v)


def _block_triangle(diagonal: Tensor, corner: Tensor) -> Tensor:
    """[[diagonal, corner], [0, diagonal]]."""
    return torch.cat(
        [torch.cat([diagonal, corner], -1), torch.cat([torch.zeros_like(diagonal), diagonal], -1)], -2
    )


def _with_last_row(matrix: Tensor, corner: float) -> Tensor:
    """(*, 3, 4) with the row 0, 0, 0, corner below."""
    zero = torch.zeros_like(matrix[..., :1, :])
    return torch.cat([matrix, torch.cat([zero[..., :3], zero[..., 3:] + corner], -1)], -2)
