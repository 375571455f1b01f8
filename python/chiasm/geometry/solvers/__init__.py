"""Solvers of small equations: polynomials, null vectors, affine maps."""

from .affine import find_affine
from .equations import solve_cubic, solve_quadratic, solve_quartic
from .minimal import (
    determinant_to_polynomial,
    multiply_deg_one_poly,
    multiply_deg_two_one_poly,
    null_vector_3x4,
)

__all__ = [
    "determinant_to_polynomial",
    "find_affine",
    "multiply_deg_one_poly",
    "multiply_deg_two_one_poly",
    "null_vector_3x4",
    "solve_cubic",
    "solve_quadratic",
    "solve_quartic",
]


def __dir__() -> list[str]:
    return __all__
