"""The epipolar equations of correspondences, and the solution of seven of them."""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.geometry.intrinsics import with_one
from ...primitives.linalg.matrices import cofactors, small_matmul
from ...primitives.linalg.qr import qr
from ..solvers import solve_cubic


def epipolar_rows(p1: Tensor, p2: Tensor) -> Tensor:
    """Rows (B, N, 9) from points (B, N, 2); the product of a row with the entries of F is x2^T F x1."""
    x1, x2 = with_one(p1), with_one(p2)
    return (x2[..., :, None] * x1[..., None, :]).flatten(-2)


def subspace_basis(projector: Tensor, size: int) -> Tensor:
    """Orthonormal basis (..., 9, size) of the image of a projector (..., 9, 9).

    The basis is built from the images of fixed vectors, so that it is the same on every engine; the basis of
    a decomposition would not be.
    """
    place = torch.arange(9 * size, device=projector.device).to(projector.dtype)
    fixed = torch.sin(1.0 + 7.25 * place * place).reshape(9, size)
    return qr(small_matmul(projector, fixed.expand(list(projector.shape[:-2]) + [9, size])))[0]


def matrices_of_rank_two(rows: Tensor) -> Tuple[Tensor, Tensor]:
    """The singular 3x3 matrices (B, 3, 3, 3) orthogonal to seven rows (B, 7, 9), and which of them exist (B,
    3)."""
    span = qr(rows.transpose(1, 2))[0]
    projector = torch.eye(9, dtype=rows.dtype, device=rows.device) - small_matmul(span, span.transpose(1, 2))
    basis = subspace_basis(projector, 2).transpose(1, 2).unflatten(2, [3, 3])
    a, b = basis[:, 0], basis[:, 1]
    minors_a, minors_b = cofactors(a), cofactors(b)
    # The coefficients of det(x a + b) by powers of x; each sum along a row is a determinant.
    coefficients = torch.stack(
        [
            (minors_a[:, 0] * a[:, 0]).sum(-1),
            _inner(minors_a, b),
            _inner(minors_b, a),
            (minors_b[:, 0] * b[:, 0]).sum(-1),
        ],
        -1,
    )
    x = solve_cubic(coefficients)
    c = coefficients.detach()[:, None, :]
    at = x.detach()[..., None]
    terms = torch.cat(
        [
            c[..., 0:1] * at * at * at,
            c[..., 1:2] * at * at,
            c[..., 2:3] * at,
            c[..., 3:4] + torch.zeros_like(at),
        ],
        -1,
    )
    exists = terms.sum(-1).abs() <= 1e-9 * terms.abs().sum(-1)
    return x[..., None, None] * a[:, None] + b[:, None], exists


def _inner(a: Tensor, b: Tensor) -> Tensor:
    return (a * b).sum(-1).sum(-1)
