"""Homographies from correspondences."""

from typing import List, Optional

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_choice,
    check_floating,
    check_leading,
    check_matrix,
    check_rank,
    check_tensor,
)
from ..primitives.core.loops import repeated
from ..primitives.geometry.intrinsics import with_one
from ..primitives.linalg.direct_linear import hartley, projective_equations
from ..primitives.linalg.matrices import cross, inverse3x3, small_matmul, smallest_eigenvector
from .transfer_error import (
    check_segments,
    line_segment_transfer_error_one_way,
    line_through,
    oneway_transfer_error,
    sampson_homography_distance,
    symmetric_transfer_error,
)

__all__ = [
    "find_homography_dlt",
    "find_homography_dlt_iterated",
    "find_homography_lines_dlt",
    "find_homography_lines_dlt_iterated",
    "line_segment_transfer_error_one_way",
    "oneway_transfer_error",
    "sample_is_valid_for_homography",
    "sampson_homography_distance",
    "symmetric_transfer_error",
]


def __dir__() -> list[str]:
    return __all__


def find_homography_dlt(
    points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None, solver: str = "lu"
) -> Tensor:
    """Homography from four or more correspondences by the normalized direct linear transform.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., algorithm 4.2. The algebraic error is minimized
    in float64 for every input dtype, so that the minimal set of four points is exact too.

    Args:
        points1: (B, N, 2), N >= 4, no three of the four determining points on a line.
        points2: (B, N, 2).
        weights: (B, N), not negative; ones by default.
        solver: "lu" or "svd", as in Kornia. Both choices use the same computation here: inverse iteration on
            the 9x9 normal matrix, since ONNX has neither decomposition.

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
        raise ValueError(
            f"points2: expected as many points as points1, {points1.size(1)}, got {points2.size(1)}"
        )
    _check_batch([points1, points2], ["points1", "points2"], 1, weights)
    p1, p2 = torch.broadcast_tensors(points1.to(torch.float64), points2.to(torch.float64))
    return homography_by_weights(p1, p2, weights, None).to(points1.dtype)


def homography_by_weights(
    points1: Tensor, points2: Tensor, weights: Optional[Tensor], present: Optional[Tensor]
) -> Tensor:
    """``find_homography_dlt`` in float64, with normalized points and the weights ``present`` (B, N)."""
    p1, t1 = hartley(points1, present, 1e-8)
    p2, t2 = hartley(points2, present, 1e-8)
    return _denormalised(projective_equations(with_one(p1), p2, _weights(weights, p1)), t1, t2)


def find_homography_dlt_iterated(
    points1: Tensor, points2: Tensor, weights: Tensor, soft_inl_th: float = 3.0, n_iter: int = 5
) -> Tensor:
    """Homography by repeated :func:`find_homography_dlt`, each time with weights exp(-e / (2 soft_inl_th^2)).

    e is the unsquared :func:`symmetric_transfer_error` of the previous homography: distant points lose their
    influence.

    Args:
        points1, points2: (B, N, 2), N >= 4, floating point.
        weights: (B, N), not negative: the weights of the first estimate.
        soft_inl_th: in pixels; a larger value reduces the weights of distant points less.
        n_iter: number of estimates, at least 1.

    Returns:
        (B, 3, 3) with the last entry 1, mapping points1 to points2. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or n_iter is not as above.

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
        >>> find_homography_dlt_iterated(square, 2.0 * square, torch.ones(1, 4))[0].round(
        ...     decimals=3
        ... ).diagonal()
        tensor([2., 2., 1.])
    """
    if n_iter < 1:
        raise ValueError(f"n_iter: expected at least 1, got {n_iter}")
    check_tensor(weights, "weights")
    H = find_homography_dlt(points1, points2, weights)
    return _weighted_again(H, n_iter - 1, points1, points2, soft_inl_th)


@repeated
def _weighted_again(H: Tensor, k: Tensor, points1: Tensor, points2: Tensor, soft_inl_th: float) -> Tensor:
    errors = symmetric_transfer_error(points1, points2, H, False)
    return find_homography_dlt(points1, points2, torch.exp(-errors / (2.0 * soft_inl_th**2)))


def find_homography_lines_dlt(ls1: Tensor, ls2: Tensor, weights: Optional[Tensor] = None) -> Tensor:
    """Homography from four or more corresponding line segments, whose end points need not correspond. The
    transformed end points of the first image's segments must lie on the lines through the second image's
    segments. Each segment gives two linear equations; points and lines are normalized as for points. E.
    Dubrofsky, R. Woodham, Combining line and point correspondences for homography estimation, ISVC 2008. The
    error is minimized in float64.

    Args:
        ls1, ls2: (B, N, 2, 2), or (N, 2, 2) for a batch of one, N >= 4, the segments' two end points,
            floating point.
        weights: (B, N), not negative; ones by default.

    Returns:
        (B, 3, 3) with the last entry 1, from the first image to the second. Differentiable in all tensors.

    Raises:
        TypeError: if ls1 or ls2 is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> corner = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        >>> segments = torch.stack([corner, corner.roll(1, 0)], 1)[None]
        >>> find_homography_lines_dlt(segments, 2.0 * segments)[0].round(decimals=3).diagonal()
        tensor([2., 2., 1.])
    """
    check_tensor(ls1, "ls1")
    check_tensor(ls2, "ls2")
    if ls1.dim() == 3:
        ls1 = ls1.unsqueeze(0)
    if ls2.dim() == 3:
        ls2 = ls2.unsqueeze(0)
    check_segments(ls1, "ls1")
    check_segments(ls2, "ls2")
    if ls1.size(1) < 4:
        raise ValueError(f"ls1: expected at least 4 segments, got {ls1.size(1)}")
    if ls1.size(1) != ls2.size(1):
        raise ValueError(f"ls2: expected as many segments as ls1, {ls1.size(1)}, got {ls2.size(1)}")
    _check_batch([ls1, ls2], ["ls1", "ls2"], 2, weights)
    p1, t1 = hartley(ls1.to(torch.float64).flatten(1, 2), None, 1e-8)
    p2, t2 = hartley(ls2.to(torch.float64).flatten(1, 2), None, 1e-8)
    p = with_one(p1).unflatten(1, [-1, 2])
    q = with_one(p2).unflatten(1, [-1, 2])
    line = line_through(q[:, :, 0], q[:, :, 1])
    # The equation of a line l and a point p is (l x p) . H; so the normal matrix is the product of l l^T and
    # p p^T.
    pp = (p[..., :, None] * p[..., None, :]).sum(2)
    ll = line[..., :, None] * line[..., None, :] * _weights(weights, line)[..., None, None]
    normal = (ll[..., :, None, :, None] * pp[..., None, :, None, :]).sum(1).reshape(-1, 9, 9)
    return _denormalised(normal, t1, t2).to(ls1.dtype)


def find_homography_lines_dlt_iterated(
    ls1: Tensor, ls2: Tensor, weights: Tensor, soft_inl_th: float = 4.0, n_iter: int = 5
) -> Tensor:
    """Homography by repeated :func:`find_homography_lines_dlt`, each time with weights exp(-e / (2
    soft_inl_th^2)).

    e is :func:`line_segment_transfer_error_one_way` of the homography before.

    Args:
        ls1, ls2: (B, N, 2, 2), N >= 4, the segments' two end points, floating point.
        weights: (B, N), not negative: the weights of the first estimate.
        soft_inl_th: in pixels; a larger value reduces the weights of distant points less.
        n_iter: number of estimates, at least 1.

    Returns:
        (B, 3, 3) with the last entry 1, from the first image to the second. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or n_iter is not as above.

    Example:
        >>> corner = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        >>> segments = torch.stack([corner, corner.roll(1, 0)], 1)[None]
        >>> find_homography_lines_dlt_iterated(segments, 2.0 * segments, torch.ones(1, 4))[0].round(
        ...     decimals=3
        ... ).diagonal()
        tensor([2., 2., 1.])
    """
    if n_iter < 1:
        raise ValueError(f"n_iter: expected at least 1, got {n_iter}")
    check_tensor(weights, "weights")
    H = find_homography_lines_dlt(ls1, ls2, weights)
    return _lines_weighted_again(H, n_iter - 1, ls1, ls2, soft_inl_th)


@repeated
def _lines_weighted_again(H: Tensor, k: Tensor, ls1: Tensor, ls2: Tensor, soft_inl_th: float) -> Tensor:
    errors = line_segment_transfer_error_one_way(ls1, ls2, H)
    return find_homography_lines_dlt(ls1, ls2, torch.exp(-errors / (2.0 * soft_inl_th**2)))


def sample_is_valid_for_homography(points1: Tensor, points2: Tensor) -> Tensor:
    """Whether four correspondences can lie on one plane seen from one side. Each triple of points must have
    the same orientation in both images.

    P. Márquez-Neila et al., Speeding-up homography estimation in mobile devices, J. Real-Time Image
    Processing 11, 2016. Three points on a line in either image determine no homography and are not valid;
    Kornia accepts them if they are on a line in both images.

    Args:
        points1, points2: (B, 4, 2), floating point.

    Returns:
        (B,), bool.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or not (B, 4, 2).

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
        >>> sample_is_valid_for_homography(square, torch.stack([square[0], square[0, [1, 0, 2, 3]]]))
        tensor([ True, False])
    """
    turns1 = _turns(points1, "points1")
    turns2 = _turns(points2, "points2")
    check_leading([points1, points2], ["points1", "points2"], [2, 2])
    # Signs are taken before the product, since the product may underflow.
    return (torch.sign(turns1) * torch.sign(turns2) > 0).all(-1)


def _turns(points: Tensor, name: str) -> Tensor:
    """Twice the signed areas (B, 4) of the triangles of the four point triples."""
    check_rank(points, 3, "(B, 4, 2)", name)
    check_matrix(points, 4, 2, name)
    p = with_one(points)
    a, b, c, d = p[:, 0], p[:, 1], p[:, 2], p[:, 3]
    return torch.stack(
        [
            (cross(a, b) * c).sum(-1),
            (cross(a, b) * d).sum(-1),
            (cross(a, c) * d).sum(-1),
            (cross(b, c) * d).sum(-1),
        ],
        -1,
    )


def _denormalised(normal: Tensor, t1: Tensor, t2: Tensor) -> Tensor:
    """The homography that solves normal equations (B, 9, 9) of normalized points, for points before
    normalisation."""
    h = smallest_eigenvector(normal).reshape(-1, 3, 3)
    h = small_matmul(small_matmul(inverse3x3(t2), h), t1)
    return h / h[:, 2:3, 2:3]


def _weights(weights: Optional[Tensor], like: Tensor) -> Tensor:
    if weights is None:
        return torch.ones_like(like[..., 0])
    return weights.to(torch.float64)


def _check_batch(values: List[Tensor], names: List[str], own: int, weights: Optional[Tensor]) -> None:
    """Raise unless the leading dimensions (B, N) of both ``values``, those before the last ``own``, broadcast
    with each other and with ``weights``."""
    check_leading(values, names, [own, own])
    if weights is not None:
        check_tensor(weights, "weights")
        if weights.dim() != 2:
            raise ValueError(f"weights: expected shape (B, N), got {list(weights.shape)}")
        check_leading(values + [weights], names + ["weights"], [own, own, 0])


def _check_points(points: Tensor, name: str) -> None:
    check_floating(points, name)
    if points.dim() != 3 or points.size(2) != 2:
        raise ValueError(f"{name}: expected shape (B, N, 2), got {list(points.shape)}")
