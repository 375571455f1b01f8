"""Essential matrices from five or more correspondences.

D. Nister, An efficient solution to the five-point relative pose problem, IEEE TPAMI 26(6), 2004. His
elimination leads to a polynomial of degree ten. Its roots are starting points for Gauss-Newton steps on the
original conditions; the last step carries the gradient.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_floating, check_leading, check_tensor
from ...primitives.linalg.eigen import symmetric_eigen
from ...primitives.linalg.matrices import cofactors, cross, small_matmul, solve, spd_inverse
from ...primitives.linalg.polynomials import real_roots
from ...primitives.linalg.qr import pointed, qr
from ..solvers import determinant_to_polynomial, multiply_deg_one_poly, multiply_deg_two_one_poly
from .seven_point import epipolar_rows, subspace_basis


def find_essential(points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None) -> Tensor:
    """Essential matrices from five or more correspondences, by Nister's five-point algorithm.

    :func:`find_essential_5point` also returns a mask of the solutions that exist.

    Args:
        points1, points2: (B, N, 2), N >= 5, points of the planes z = 1 (pixels times the inverse camera
            matrix), floating point.
        weights: (B, N), not negative; ones by default.

    Returns:
        (B, 10, 3, 3), of unit length; zeros in place of solutions that do not exist. Differentiable in all.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> x = torch.tensor([[0, 0], [9, 1], [8, 9], [1, 8], [4, 5]]).float()[None] / 10
        >>> z = torch.tensor([4.0, 2.0, 3.0, 5.0, 2.5])[None, :, None]
        >>> find_essential(x, x + torch.tensor([1.0, 0.2]) / z).shape
        torch.Size([1, 10, 3, 3])
    """
    return find_essential_5point(points1, points2, weights)[0]


def find_essential_5point(
    points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor]:
    """Up to ten essential matrices of five correspondences, with a mask of the solutions that exist. With
    more correspondences, the matrices are in the four-dimensional space that fits them best.

    Args:
        points1, points2: (B, N, 2), N >= 5, points of the planes z = 1, floating point.
        weights: (B, N), not negative; ones by default.

    Returns:
        E (B, 10, 3, 3), of unit length, and a mask (B, 10) of the solutions that exist; the others are zeros.
        Differentiable in all.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> x = torch.tensor([[0, 0], [9, 1], [8, 9], [1, 8], [4, 5]]).float()[None] / 10
        >>> z = torch.tensor([4.0, 2.0, 3.0, 5.0, 2.5])[None, :, None]
        >>> E, exists = find_essential_5point(x, x + torch.tensor([1.0, 0.2]) / z)
        >>> bool(exists.any())
        True
    """
    _check(points1, points2, weights)
    rows = epipolar_rows(points1.to(torch.float64), points2.to(torch.float64))
    weighted = rows if weights is None else rows * weights.to(torch.float64)[..., None]
    basis = subspace_basis(_least_four(small_matmul(weighted.transpose(1, 2), rows)), 4)
    fixed = basis.detach()
    w, exists = _starts(fixed, 48)
    for _ in range(2):
        w = _improved(w, fixed)[0]
    w, residual = _improved(w, fixed)
    # Missing solutions and NaN are replaced before the differentiation.
    exists = exists & (residual < 1e-6)
    w, residual = _improved(torch.where(exists[..., None], w, torch.full_like(w, 0.5)), basis)
    exists = exists & (residual < 1e-9)
    E = small_matmul(w, basis.transpose(1, 2))
    E = E / torch.sqrt((E * E).sum(-1, keepdim=True))
    E = E * pointed(E.transpose(1, 2)).transpose(1, 2)
    E = torch.where(exists[..., None], E, torch.zeros_like(E))
    return E.unflatten(2, [3, 3]).to(points1.dtype), exists


def essentials_of_five(rows: Tensor) -> Tuple[Tensor, Tensor]:
    """The essential matrices (B, 10, 3, 3) of five rows (B, 5, 9) of `epipolar_rows`, of unit length, and
    which of them exist (B, 10).

    Accurate to about 1e-6, without gradient; used for the many samples of a robust estimator.
    """
    span = qr(rows.detach().transpose(1, 2))[0]
    projector = torch.eye(9, dtype=rows.dtype, device=rows.device) - small_matmul(span, span.transpose(1, 2))
    basis = subspace_basis(projector, 4)
    w, exists = _starts(basis, 24)
    return small_matmul(w, basis.transpose(1, 2)).unflatten(2, [3, 3]), exists


def _least_four(m: Tensor) -> Tensor:
    """Projector (B, 9, 9) onto the eigenvectors of the four least eigenvalues of a symmetric matrix."""
    values, vectors = symmetric_eigen(m.detach())
    least, others = vectors[..., :4], vectors[..., 4:]
    projector = small_matmul(least, least.transpose(1, 2))
    # For the derivative: the space changes by mixing with the other eigenvectors, not by mixing among the
    # four.
    change = small_matmul(others.transpose(1, 2), small_matmul(m - m.detach(), least))
    gap = values[:, None, :4] - values[:, 4:, None]
    tiny = gap > -1e-300
    change = torch.where(
        tiny, torch.zeros_like(change), change / torch.where(tiny, torch.ones_like(gap), gap)
    )
    moved = small_matmul(small_matmul(others, change), least.transpose(1, 2))
    return projector + moved + moved.transpose(1, 2)


def _starts(basis: Tensor, halvings: int) -> Tuple[Tensor, Tensor]:
    """Coefficients (B, 10, 4) of the essential matrices in a basis (B, 9, 4), and which of them exist."""
    reduced = _eliminated(basis.unflatten(1, [3, 3]))
    # Pairs of rows x^2 z and x^2, y^2 z and y^2, xyz and xy: the first minus z times the second contains
    # neither monomial.
    a, b = reduced[:, 4::2], reduced[:, 5::2]
    parts = [
        -b[..., 0:1],
        a[..., 0:2] - b[..., 1:3],
        a[..., 2:3],
        -b[..., 3:4],
        a[..., 3:5] - b[..., 4:6],
        a[..., 5:6],
    ]
    parts += [-b[..., 6:7], a[..., 6:9] - b[..., 7:10], a[..., 9:10]]
    matrix = torch.cat(parts, -1)
    s, exists = real_roots(determinant_to_polynomial(matrix), halvings)
    c = 1.0 - s.abs()
    # With z = s / c and powers of s and c, no entry is infinite.
    cubic = torch.stack([s * s * s, s * s * c, s * c * c, c * c * c], -1)
    quartic = torch.cat([cubic[..., 0:1] * s[..., None], cubic * c[..., None]], -1)
    x = (matrix[:, None, :, 0:4] * cubic[:, :, None]).sum(-1) * c[..., None]
    y = (matrix[:, None, :, 4:8] * cubic[:, :, None]).sum(-1) * c[..., None]
    one = (matrix[:, None, :, 8:13] * quartic[:, :, None]).sum(-1)
    m = torch.stack([x, y, one], -1)
    n = _longest(cross(m[:, :, 0], m[:, :, 1]), cross(m[:, :, 1], m[:, :, 2]), cross(m[:, :, 2], m[:, :, 0]))
    w = torch.stack([n[..., 0] * c, n[..., 1] * c, n[..., 2] * s, n[..., 2] * c], -1)
    return w / (torch.sqrt((w * w).sum(-1, keepdim=True)) + 1e-300), exists


def _eliminated(basis: Tensor) -> Tensor:
    """The ten conditions on x X + y Y + z Z + W, for a basis (B, 3, 3, 4), solved for the first ten of
    Nister's monomials: (B, 10, 10)."""
    square = multiply_deg_one_poly(basis[:, :, None], basis[:, None]).sum(3)
    trace = square[:, 0, 0] + square[:, 1, 1] + square[:, 2, 2]
    eye = torch.eye(3, dtype=basis.dtype, device=basis.device)
    square = square - 0.5 * trace[:, None, None] * eye[..., None]
    cubic = multiply_deg_two_one_poly(square[:, :, :, None], basis[:, None]).sum(2).flatten(1, 2)
    e = basis
    minors = [
        multiply_deg_one_poly(e[:, 1, j], e[:, 2, k]) - multiply_deg_one_poly(e[:, 1, k], e[:, 2, j])
        for j, k in [(1, 2), (2, 0), (0, 1)]
    ]
    determinant = multiply_deg_two_one_poly(torch.stack(minors, 1), e[:, 0]).sum(1)
    conditions = torch.cat([cubic, determinant[:, None]], 1)
    return solve(conditions[..., :10], conditions[..., 10:])


def _improved(w: Tensor, basis: Tensor) -> Tuple[Tensor, Tensor]:
    """One Gauss-Newton step on det E = 0 and 2 E E^T E = |E|^2 E, with |w| kept, and the length of the
    residual before it."""
    E = small_matmul(w, basis.transpose(1, 2)).unflatten(2, [3, 3])
    D = basis.transpose(1, 2).unflatten(2, [3, 3])[:, None]
    residual = _conditions(E)
    Et, Dt = E.transpose(-2, -1)[:, :, None], D.transpose(-2, -1)
    wide = E[:, :, None]
    outer, inner = small_matmul(wide, Et), small_matmul(Et, wide)
    slope = 2.0 * (
        small_matmul(D, inner) + small_matmul(small_matmul(wide, Dt), wide) + small_matmul(outer, D)
    )
    squared, mixed = (wide * wide).sum(-1).sum(-1), (wide * D).sum(-1).sum(-1)
    slope = slope - 2.0 * mixed[..., None, None] * wide - squared[..., None, None] * D
    last = (cofactors(E)[:, :, None] * D).sum(-1).sum(-1)
    slope = torch.cat([slope.flatten(-2), last[..., None]], -1).detach()
    eye = torch.eye(4, dtype=w.dtype, device=w.device)
    normal = small_matmul(slope, slope.transpose(-2, -1)) + w[..., :, None] * w[..., None, :] + 1e-14 * eye
    step = (spd_inverse(normal) * (slope * residual[:, :, None]).sum(-1)[..., None, :]).sum(-1)
    moved = w - step
    size = torch.sqrt((residual.detach() * residual.detach()).sum(-1))
    return moved / torch.sqrt((moved * moved).sum(-1, keepdim=True)), size


def _conditions(E: Tensor) -> Tensor:
    """2 E E^T E - |E|^2 E and det E, (..., 10)."""
    squared = (E * E).sum(-1, keepdim=True).sum(-2, keepdim=True)
    cubic = 2.0 * small_matmul(E, small_matmul(E.transpose(-2, -1), E)) - squared * E
    return torch.cat([cubic.flatten(-2), (cofactors(E)[..., 0, :] * E[..., 0, :]).sum(-1, keepdim=True)], -1)


def _longest(a: Tensor, b: Tensor, c: Tensor) -> Tensor:
    la, lb, lc = (a * a).sum(-1, keepdim=True), (b * b).sum(-1, keepdim=True), (c * c).sum(-1, keepdim=True)
    first = torch.where(la >= lb, a, b)
    return torch.where(torch.maximum(la, lb) >= lc, first, c)


def _check(points1: Tensor, points2: Tensor, weights: Optional[Tensor]) -> None:
    check_floating(points1, "points1")
    check_floating(points2, "points2")
    if points1.dim() != 3 or points1.size(2) != 2 or points1.size(1) < 5:
        raise ValueError(f"points1: expected shape (B, N, 2) with N of at least 5, got {list(points1.shape)}")
    if points2.dim() != 3 or points2.size(2) != 2 or points2.size(1) != points1.size(1):
        raise ValueError(
            f"points2: expected shape (B, {points1.size(1)}, 2) like points1, got {list(points2.shape)}"
        )
    check_leading([points1, points2], ["points1", "points2"], [1, 1])
    if weights is not None:
        check_tensor(weights, "weights")
        if weights.dim() != 2:
            raise ValueError(f"weights: expected shape (B, N), got {list(weights.shape)}")
        check_leading([points1, points2, weights], ["points1", "points2", "weights"], [1, 1, 0])
