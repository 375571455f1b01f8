"""Fundamental matrices: x2^T F x1 = 0 for the pixels of two views."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_choice,
    check_floating,
    check_leading,
    check_matrix,
    check_optional,
    check_tensor,
)
from ...primitives.linalg.direct_linear import hartley, normal_matrix
from ...primitives.linalg.matrices import inverse3x3, small_matmul, smallest_eigenvector
from ...primitives.linalg.qr import null_vector, pointed
from ...primitives.numbers.loss_reduction import narrowed, widened
from .seven_point import epipolar_rows, matrices_of_rank_two


def find_fundamental(
    points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None, method: str = "8POINT"
) -> Tensor:
    """Fundamental matrix from correspondences, by the normalized eight-point or the seven-point algorithm.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., algorithm 11.1 and 11.1.2. Computed in float64.
    :func:`find_fundamental_7point` also returns a mask of the solutions of the seven-point algorithm that
    exist.

    Args:
        points1, points2: (B, N, 2), floating point; N >= 8, or N = 7 with "7POINT".
        weights: (B, N), not negative; ones by default. "7POINT" ignores them.
        method: "8POINT" or "7POINT".

    Returns:
        (B, 3, 3) of rank 2; with "7POINT" (B, 3, 3, 3): up to three solutions, zeros in place of solutions
        that do not exist. Scaled so that the last entry is 1. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or the method is not as above.

    Example:
        >>> x = torch.tensor(
        ...     [[0, 0], [9, 1], [8, 9], [1, 8], [4, 5], [6, 2], [3, 7], [2, 3], [7, 5]]
        ... ).float()[None]
        >>> z = torch.tensor([4.0, 2.0, 3.0, 5.0, 2.5, 4.5, 3.5, 6.0, 3.2])[None, :, None]
        >>> F = find_fundamental(x, x + torch.tensor([10.0, 2.0]) / z)[0]
        >>> (F / F[1, 2]).round(decimals=2) + 0.0
        tensor([[ 0.0000,  0.0000, -0.2000],
                [ 0.0000,  0.0000,  1.0000],
                [ 0.2000, -1.0000,  0.0000]])
    """
    check_choice(method, ["8POINT", "7POINT"], "method")
    if method == "7POINT":
        return find_fundamental_7point(points1, points2)[0]
    _check_pair(points1, points2, 8)
    w = torch.ones_like(points1[..., 0]) if weights is None else weights
    check_tensor(w, "weights")
    if w.dim() != 2:
        raise ValueError(f"weights: expected shape (B, N), got {list(w.shape)}")
    check_leading([points1, points2, w], ["points1", "points2", "weights"], [1, 1, 0])
    w = w.to(torch.float64)
    p1, t1 = hartley(points1.to(torch.float64), w, 1e-8)
    p2, t2 = hartley(points2.to(torch.float64), w, 1e-8)
    rows = epipolar_rows(p1, p2)
    f = smallest_eigenvector(normal_matrix(rows, w)).reshape(-1, 3, 3)
    # The nearest matrix of rank 2 lacks the part in the direction of the least singular vector.
    v = null_vector(f)
    f = f - small_matmul(f, v[..., None]) * v[:, None]
    return denormalised(f, t1, t2).to(points1.dtype)


def find_fundamental_7point(points1: Tensor, points2: Tensor) -> Tuple[Tensor, Tensor]:
    """The one to three fundamental matrices of seven correspondences.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 11.1.2: the matrices of determinant 0 in the
    two-dimensional space of matrices that satisfy the correspondences.

    Args:
        points1, points2: (B, 7, 2), floating point.

    Returns:
        F (B, 3, 3, 3), scaled so that the last entry is 1, and a mask (B, 3) of the solutions that exist; the
        others are zeros. Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or not (B, 7, 2).

    Example:
        >>> x = torch.tensor([[0, 0], [9, 1], [8, 9], [1, 8], [4, 5], [6, 2], [3, 7]]).float()[None]
        >>> z = torch.tensor([4.0, 2.0, 3.0, 5.0, 2.5, 4.5, 3.5])[None, :, None]
        >>> F, exists = find_fundamental_7point(x, x + torch.tensor([10.0, 2.0]) / z)
        >>> F.shape, bool(exists.any())
        (torch.Size([1, 3, 3, 3]), True)
    """
    _check_pair(points1, points2, 7)
    if points1.size(1) != 7:
        raise ValueError(f"points1: expected 7 points, got {points1.size(1)}")
    p1, t1 = hartley(points1.to(torch.float64), None, 1e-8)
    p2, t2 = hartley(points2.to(torch.float64), None, 1e-8)
    f, exists = matrices_of_rank_two(epipolar_rows(p1, p2))
    f = denormalised(f, t1[:, None], t2[:, None])
    f = torch.where(exists[..., None, None], f, torch.zeros_like(f))
    return f.to(points1.dtype), exists


def normalize_points(
    points: Tensor, eps: float = 1e-8, weights: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor]:
    """Normalize points to centroid 0 and mean distance sqrt(2), and return this similarity.

    R. Hartley, In defense of the eight-point algorithm, PAMI 19(6), 1997.

    Args:
        points: (B, N, 2), floating point.
        eps: added to the mean distance before dividing by it.
        weights: (B, N), not negative; both means are weighted.

    Returns:
        Points (B, N, 2), and the similarity (B, 3, 3). Differentiable.

    Raises:
        TypeError, ValueError: if points is not floating point, or a shape is not as above.

    Example:
        >>> points, similarity = normalize_points(torch.tensor([[[0.0, 0.0], [4.0, 0.0]]]))
        >>> points
        tensor([[[-1.4142,  0.0000],
                 [ 1.4142,  0.0000]]])
    """
    _check_points(points, "points")
    check_optional(weights, "weights")
    if weights is not None and weights.dim() != 2:
        raise ValueError(f"weights: expected shape (B, N), got {list(weights.shape)}")
    moved, similarity = hartley(widened(points), None if weights is None else widened(weights), eps)
    return narrowed(moved, points, weights), narrowed(similarity, points, weights)


def normalize_transformation(M: Tensor, eps: float = 1e-8) -> Tensor:
    """Divide matrices by their last entry; a matrix stays unchanged if the entry's absolute value is at most
    eps.

    Args:
        M: (*, r, c), floating point.
        eps: the least divisor.

    Returns:
        (*, r, c). Differentiable.

    Raises:
        TypeError, ValueError: if M is not floating point or has fewer than two dimensions.

    Example:
        >>> normalize_transformation(torch.diag(torch.tensor([1.0, 2.0, 4.0]))).diagonal()
        tensor([0.2500, 0.5000, 1.0000])
    """
    check_floating(M, "M")
    if M.dim() < 2:
        raise ValueError(f"M: expected shape (*, r, c), got {list(M.shape)}")
    last = M[..., -1:, -1:]
    return M / torch.where(last.abs() > eps, last, torch.ones_like(last))


def fundamental_from_essential(E_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor:
    """Fundamental matrices K2^-T E K1^-1. R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 9.6.

    Args:
        E_mat: (*, 3, 3), essential matrices, floating point.
        K1, K2: (*, 3, 3), camera matrices.

    Returns:
        (*, 3, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> fundamental_from_essential(torch.ones(3, 3), torch.eye(3), 2.0 * torch.eye(3))[0]
        tensor([0.5000, 0.5000, 0.5000])
    """
    check_matrix(E_mat, 3, 3, "E_mat")
    check_matrix(K1, 3, 3, "K1")
    check_matrix(K2, 3, 3, "K2")
    check_leading([E_mat, K1, K2], ["E_mat", "K1", "K2"], [2, 2, 2])
    left = small_matmul(inverse3x3(widened(K2)).transpose(-2, -1), widened(E_mat))
    made = small_matmul(left, inverse3x3(widened(K1)))
    return made.to(torch.promote_types(torch.promote_types(E_mat.dtype, K1.dtype), K2.dtype))


def fundamental_from_projections(P1: Tensor, P2: Tensor) -> Tensor:
    """Fundamental matrices of pairs of projection matrices.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 17.1: its entries are determinants of two rows
    of P1 and two of P2.

    Args:
        P1, P2: (*, 3, 4), floating point.

    Returns:
        (*, 3, 3), not scaled. Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not a floating-point (*, 3, 4) tensor.

    Example:
        >>> P1 = torch.eye(4)[:3]
        >>> P2 = P1 + torch.tensor([[0.0, 0.0, 0.0, 1.0], [0.0] * 4, [0.0] * 4])
        >>> fundamental_from_projections(P1, P2) + 0.0
        tensor([[ 0.,  0.,  0.],
                [ 0.,  0.,  1.],
                [ 0., -1.,  0.]])
    """
    check_matrix(P1, 3, 4, "P1")
    check_matrix(P2, 3, 4, "P2")
    check_leading([P1, P2], ["P1", "P2"], [2, 2])
    # By Laplace's expansion: products of 2x2 minors of the two pairs of rows, at complementary columns.
    return (_row_minors(P2)[..., :, None, :] * _complements(_row_minors(P1))[..., None, :, :]).sum(-1)


def _row_minors(P: Tensor) -> Tensor:
    """2x2 minors (*, 3, 6) of the rows (1, 2), (2, 0), (0, 1), at the columns 01, 02, 03, 12, 13, 23."""
    upper = torch.stack([P[..., 1, :], P[..., 2, :], P[..., 0, :]], -2)
    lower = torch.stack([P[..., 2, :], P[..., 0, :], P[..., 1, :]], -2)
    a, b, c, d = upper[..., 0], upper[..., 1], upper[..., 2], upper[..., 3]
    e, f, g, h = lower[..., 0], lower[..., 1], lower[..., 2], lower[..., 3]
    return torch.stack(
        [a * f - b * e, a * g - c * e, a * h - d * e, b * g - c * f, b * h - d * f, c * h - d * g], -1
    )


def _complements(minors: Tensor) -> Tensor:
    """For each pair of columns the minor of the other two columns, with the sign of Laplace's expansion of a
    4x4 determinant."""
    a, b, c, d, e, f = (
        minors[..., 0],
        minors[..., 1],
        minors[..., 2],
        minors[..., 3],
        minors[..., 4],
        minors[..., 5],
    )
    return torch.stack([f, -e, d, c, -b, a], -1)


def denormalised(f: Tensor, t1: Tensor, t2: Tensor) -> Tensor:
    """T2^T F T1, scaled so that its last entry is 1 or, if this entry is near 0, so that its length is 1."""
    f = small_matmul(small_matmul(t2.transpose(-2, -1), f), t1)
    squared = (f * f).sum(-1, keepdim=True).sum(-2, keepdim=True)
    f = f / torch.sqrt(torch.where(squared == 0, torch.ones_like(squared), squared))
    f = f * pointed(f.flatten(-2)[..., None])
    return normalize_transformation(f)


def _check_points(points: Tensor, name: str) -> None:
    check_floating(points, name)
    if points.dim() != 3 or points.size(2) != 2:
        raise ValueError(f"{name}: expected shape (B, N, 2), got {list(points.shape)}")


def _check_pair(points1: Tensor, points2: Tensor, least: int) -> None:
    _check_points(points1, "points1")
    _check_points(points2, "points2")
    if points1.size(1) < least:
        raise ValueError(f"points1: expected at least {least} points, got {points1.size(1)}")
    if points1.size(1) != points2.size(1):
        raise ValueError(
            f"points2: expected as many points as points1, {points1.size(1)}, got {points2.size(1)}"
        )
    check_leading([points1, points2], ["points1", "points2"], [1, 1])
