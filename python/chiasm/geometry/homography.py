"""Homographies from correspondences."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.checks import check_choice, check_floating
from ..primitives.linalg import inverse3x3, small_matmul, smallest_eigenvector


def find_homography_dlt(points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None, solver: str = "lu") -> Tensor:
    """Homography from four or more correspondences by the normalised direct linear transform.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., algorithm 4.2. The algebraic error is minimised in float64
    whatever the input's dtype, so that the minimal set of four points is exact too.

    Args:
        points1: (B, N, 2), N >= 4, no three of the four determining points on a line.
        points2: (B, N, 2).
        weights: (B, N), not negative; ones by default.
        solver: "lu" or "svd", as in Kornia. Both name the same computation here: inverse iteration on the 9x9 normal
            matrix, since neither decomposition exists in ONNX.

    Returns:
        (B, 3, 3) with the last entry 1, mapping points1 to points2. Differentiable in all inputs.

    Raises:
        TypeError: if points1 or points2 is not floating point.
        ValueError: if a shape or the solver is not as above.

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
        >>> find_homography_dlt(square, 2.0 * square)[0].round(decimals=3).diagonal()
        tensor([2., 2., 1.])
    """
    _check_points(points1, "points1")
    _check_points(points2, "points2")
    check_choice(solver, ["lu", "svd"], "solver")
    if points1.size(1) < 4:
        raise ValueError(f"points1: expected at least 4 points, got {points1.size(1)}")
    if points1.size(1) != points2.size(1):
        raise ValueError(f"points2: expected as many points as points1, {points1.size(1)}, got {points2.size(1)}")
    p1, t1 = _hartley(points1.to(torch.float64))
    p2, t2 = _hartley(points2.to(torch.float64))
    w = torch.ones_like(p1[..., 0])
    if weights is not None:
        if weights.dim() != 2:
            raise ValueError(f"weights: expected shape (B, N), got {list(weights.shape)}")
        w = weights.to(torch.float64)
    h = smallest_eigenvector(_normal_matrix(p1, p2, w)).reshape(-1, 3, 3)
    h = small_matmul(small_matmul(inverse3x3(t2), h), t1)
    return (h / h[:, 2:3, 2:3]).to(points1.dtype)


def _check_points(points: Tensor, name: str) -> None:
    check_floating(points, name)
    if points.dim() != 3 or points.size(2) != 2:
        raise ValueError(f"{name}: expected shape (B, N, 2), got {list(points.shape)}")


def _hartley(points: Tensor) -> Tuple[Tensor, Tensor]:
    """Points moved to centroid 0 and mean distance sqrt(2), and the similarity (B, 3, 3) that does it."""
    centre = points.mean(1, keepdim=True)
    offset = points - centre
    # 1e-300 keeps the square root's derivative finite for a point at the centroid and changes no value.
    distance = torch.sqrt((offset * offset).sum(-1) + 1e-300).mean(1)
    scale = 1.4142135623730951 / (distance + 1e-8)
    zero = torch.zeros_like(scale)
    shift = -scale[:, None] * centre[:, 0]
    rows = [
        torch.stack([scale, zero, shift[:, 0]], -1),
        torch.stack([zero, scale, shift[:, 1]], -1),
        torch.stack([zero, zero, torch.ones_like(scale)], -1),
    ]
    return offset * scale[:, None, None], torch.stack(rows, -2)


def _normal_matrix(p1: Tensor, p2: Tensor, weights: Tensor) -> Tensor:
    """A^T W A (B, 9, 9) of the DLT equations h1.p - u h3.p = 0, h2.p - v h3.p = 0 for p = (x, y, 1)."""
    p = torch.cat([p1, torch.ones_like(p1[..., :1])], -1)
    pp = p[..., :, None] * p[..., None, :]
    u, v = p2[..., 0], p2[..., 1]
    s = (pp * weights[..., None, None]).sum(1)
    su = (pp * (weights * u)[..., None, None]).sum(1)
    sv = (pp * (weights * v)[..., None, None]).sum(1)
    sq = (pp * (weights * (u * u + v * v))[..., None, None]).sum(1)
    zero = torch.zeros_like(s)
    rows = [torch.cat([s, zero, -su], -1), torch.cat([zero, s, -sv], -1), torch.cat([-su, -sv, sq], -1)]
    return torch.cat(rows, -2)
