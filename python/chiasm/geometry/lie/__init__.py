"""Lie groups of rotations and rigid motions as plain functions on batches of matrices.

For each of SO(2), SO(3), SE(2) and SE(3) there are: the exponential of a tangent vector and its inverse, the
logarithm; the conversion of a tangent vector to a matrix (hat) and back (vee); the adjoint of a group
element; the left and right Jacobians of the exponential. All are smooth at rotation 0.
"""

from .se2 import se2_adjoint, se2_exp, se2_hat, se2_left_jacobian, se2_log, se2_right_jacobian, se2_vee
from .se3 import se3_adjoint, se3_exp, se3_hat, se3_left_jacobian, se3_log, se3_right_jacobian, se3_vee
from .so2 import so2_adjoint, so2_exp, so2_hat, so2_left_jacobian, so2_log, so2_right_jacobian, so2_vee
from .so3 import so3_adjoint, so3_exp, so3_hat, so3_left_jacobian, so3_log, so3_right_jacobian, so3_vee

__all__ = [
    "se2_adjoint",
    "se2_exp",
    "se2_hat",
    "se2_left_jacobian",
    "se2_log",
    "se2_right_jacobian",
    "se2_vee",
    "se3_adjoint",
    "se3_exp",
    "se3_hat",
    "se3_left_jacobian",
    "se3_log",
    "se3_right_jacobian",
    "se3_vee",
    "so2_adjoint",
    "so2_exp",
    "so2_hat",
    "so2_left_jacobian",
    "so2_log",
    "so2_right_jacobian",
    "so2_vee",
    "so3_adjoint",
    "so3_exp",
    "so3_hat",
    "so3_left_jacobian",
    "so3_log",
    "so3_right_jacobian",
    "so3_vee",
]


def __dir__() -> list[str]:
    return __all__
