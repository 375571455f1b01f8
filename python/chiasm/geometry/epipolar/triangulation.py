"""3D points from two views."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_choice, check_last, check_matrix
from ...primitives.linalg.qr import null_vector


def triangulate_points(
    P1: Tensor, P2: Tensor, points1: Tensor, points2: Tensor, solver: str = "eigh"
) -> Tensor:
    """Triangulate 3D points from their pixels in two cameras, by the direct linear transform.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 12.2. Computed in float64.

    Args:
        P1, P2: (*, 3, 4), projection matrices, floating point.
        points1, points2: (*, N, 2), pixels.
        solver: "eigh", "svd" or "cofactor". All choices use the same computation here: the null vector by a
            QR factorization.

    Returns:
        (*, N, 3). Points at infinity become very distant points. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a last dimension or the solver is not as above.

    Example:
        >>> P1 = torch.eye(4)[:3]
        >>> P2 = P1 + torch.tensor([[0.0, 0.0, 0.0, -1.0], [0.0] * 4, [0.0] * 4])
        >>> triangulate_points(P1, P2, torch.tensor([[0.5, 0.25]]), torch.tensor([[0.25, 0.25]])).round(
        ...     decimals=4
        ... )
        tensor([[2., 1., 4.]])
    """
    check_matrix(P1, 3, 4, "P1")
    check_matrix(P2, 3, 4, "P2")
    check_last(points1, 2, "points1")
    check_last(points2, 2, "points2")
    check_choice(solver, ["eigh", "svd", "cofactor"], "solver")
    check_broadcastable(points1, P1, "points1", "P1", 2, 2)
    check_broadcastable(points2, P2, "points2", "P2", 2, 2)
    first = _equations(P1.to(torch.float64), points1.to(torch.float64))
    second = _equations(P2.to(torch.float64), points2.to(torch.float64))
    if first.shape != second.shape:
        raise ValueError(
            f"points2: expected with P2 the dimensions of points1 with P1, {list(first.shape[:-2])}, got"
            f" {list(second.shape[:-2])}"
        )
    a = torch.cat([first, second], -2)
    x = null_vector(a)
    depth = x[..., 3:4]
    least = torch.where(depth < 0, torch.full_like(depth, -1e-12), torch.full_like(depth, 1e-12))
    return (x[..., 0:3] / torch.where(depth.abs() < 1e-12, least, depth)).to(points1.dtype)


def _equations(P: Tensor, points: Tensor) -> Tensor:
    """(*, N, 2, 4): x P3 - P1 and y P3 - P2; their products with the 3D point are 0."""
    rows = P[..., None, :, :]
    return points[..., :, None] * rows[..., 2:3, :] - rows[..., 0:2, :]
