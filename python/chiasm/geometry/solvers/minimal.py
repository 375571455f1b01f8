"""The parts of minimal solvers of relative pose: null vectors, and polynomials as vectors of coefficients.

D. Nister, An efficient solution to the five-point relative pose problem, IEEE TPAMI 26(6), 2004.
"""

from typing import List

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_floating, check_last
from ...primitives.linalg.matrices import cross4
from ...primitives.linalg.polynomials import product_of_coefficients


def null_vector_3x4(A: Tensor) -> Tensor:
    """The vector that a 3x4 matrix takes to 0: its signed 3x3 minors, not normalized.

    Args:
        A: (*, 3, 4), floating point.

    Returns:
        (*, 4); entry i is (-1)^i times the determinant of A without column i. Zeros where A has a lower rank.

    Raises:
        TypeError: if A is not floating point.
        ValueError: if its shape is not as above.

    Example:
        >>> null_vector_3x4(torch.eye(4)[None, 1:])
        tensor([[1., 0., 0., 0.]])
    """
    check_floating(A, "A")
    if A.dim() < 2 or A.size(-2) != 3 or A.size(-1) != 4:
        raise ValueError(f"A: expected shape (*, 3, 4), got {list(A.shape)}")
    return cross4(A[..., 0, :], A[..., 1, :], A[..., 2, :])


def multiply_deg_one_poly(a: Tensor, b: Tensor) -> Tensor:
    """Product of two polynomials of degree one in x, y and z.

    Args:
        a: (*, 4), floating point, coefficients of x, y, z, 1.
        b: (*, 4); the other dimensions are broadcast.

    Returns:
        (*, 10), coefficients of x^2, xy, xz, x, y^2, yz, y, z^2, z, 1.

    Raises:
        TypeError, ValueError: if a or b is not a floating-point (*, 4) tensor.

    Example:
        >>> multiply_deg_one_poly(torch.tensor([[1.0, 0.0, 0.0, 2.0]]), torch.tensor([[1.0, 1.0, 0.0, 0.0]]))
        tensor([[1., 1., 0., 2., 0., 0., 2., 0., 0., 0.]])
    """
    check_last(a, 4, "a")
    check_last(b, 4, "b")
    check_broadcastable(b, a, "b", "a", 1, 1)
    return product_of_coefficients(a, b, [0, 1, 2, 3, 1, 4, 5, 6, 2, 5, 7, 8, 3, 6, 8, 9], 10)


def multiply_deg_two_one_poly(a: Tensor, b: Tensor) -> Tensor:
    """Product of a polynomial of degree two and one of degree one in x, y and z.

    Args:
        a: (*, 10), floating point, coefficients of x^2, xy, xz, x, y^2, yz, y, z^2, z, 1.
        b: (*, 4), coefficients of x, y, z, 1; the other dimensions are broadcast.

    Returns:
        (*, 20), coefficients in Nister's order: x^3, y^3, x^2 y, x y^2, x^2 z, x^2, y^2 z, y^2, xyz, xy, x
        z^2, xz, x, y z^2, yz, y, z^3, z^2, z, 1.

    Raises:
        TypeError, ValueError: if a or b is not a floating-point tensor of the shape above.

    Example:
        >>> square = multiply_deg_one_poly(
        ...     torch.tensor([1.0, 0.0, 0.0, 0.0]), torch.tensor([1.0, 0.0, 0.0, 0.0])
        ... )
        >>> multiply_deg_two_one_poly(
        ...     square, torch.tensor([1.0, 0.0, 0.0, 7.0])
        ... ).nonzero().flatten()  # x^3 + 7 x^2
        tensor([0, 5])
    """
    check_last(a, 10, "a")
    check_last(b, 4, "b")
    check_broadcastable(b, a, "b", "a", 1, 1)
    place = [
        0,
        2,
        4,
        5,
        2,
        3,
        8,
        9,
        4,
        8,
        10,
        11,
        5,
        9,
        11,
        12,
        3,
        1,
        6,
        7,
        8,
        6,
        13,
        14,
        9,
        7,
        14,
        15,
        10,
        13,
        16,
        17,
        11,
        14,
        17,
        18,
        12,
        15,
        18,
        19,
    ]
    return product_of_coefficients(a, b, place, 20)


def determinant_to_polynomial(A: Tensor) -> Tensor:
    """Determinant of a 3x3 matrix of polynomials in z: the polynomial of degree ten of the five-point
    algorithm.

    Args:
        A: (*, 3, 13), floating point; a row has the coefficients of three polynomials, of degrees 3, 3 and 4,
            each from its highest power.

    Returns:
        (*, 11), coefficients of 1, z, ..., z^10.

    Raises:
        TypeError: if A is not floating point.
        ValueError: if its shape is not as above.

    Example:
        >>> A = torch.zeros(1, 3, 13)
        >>> A[0, 0, 3], A[0, 1, 7], A[0, 2, 11], A[0, 2, 12] = 1.0, 1.0, 2.0, 5.0  # diag(1, 1, 2 z + 5)
        >>> determinant_to_polynomial(A)
        tensor([[5., 2., 0., 0., 0., 0., 0., 0., 0., 0., 0.]])
    """
    check_floating(A, "A")
    if A.dim() < 2 or A.size(-2) != 3 or A.size(-1) != 13:
        raise ValueError(f"A: expected shape (*, 3, 13), got {list(A.shape)}")
    x, y, one = A[..., 0:4], A[..., 4:8], A[..., 8:13]
    following = torch.tensor([1, 2, 0], device=A.device)
    last = torch.tensor([2, 0, 1], device=A.device)
    minors = _convolved(x.index_select(-2, following), y.index_select(-2, last))
    minors = minors - _convolved(x.index_select(-2, last), y.index_select(-2, following))
    return _convolved(minors, one).sum(-2).flip(-1)


def _convolved(a: Tensor, b: Tensor) -> Tensor:
    """Product of polynomials in one variable."""
    place: List[int] = []
    for i in range(a.size(-1)):
        for j in range(b.size(-1)):
            place.append(i + j)
    return product_of_coefficients(a, b, place, a.size(-1) + b.size(-1) - 1)
