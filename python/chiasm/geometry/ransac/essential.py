"""An essential matrix from correspondences with outliers."""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_matrix, check_one_for_each, check_rank
from ...primitives.core.loops import repeated
from ...primitives.geometry.consensus import (
    best_models,
    best_of_each,
    chosen,
    costs_less,
    draw_samples,
    in_common_frame,
    inliers,
    least,
    model_costs,
    near_weights,
    sampson_denominators,
    score_planes,
)
from ...primitives.geometry.intrinsics import with_one
from ...primitives.linalg.matrices import inverse3x3, small_matmul, spd_inverse
from ...primitives.linalg.qr import pointed
from ..conversions.rotations import axis_angle_to_rotation_matrix, vector_to_skew_symmetric_matrix
from ..epipolar.essential import decompose_essential_matrix
from ..epipolar.five_point import essentials_of_five
from .arguments import check_arguments


def ransac_essential(
    points1: Tensor,
    points2: Tensor,
    K1: Tensor,
    K2: Tensor,
    uniforms: Tensor,
    inl_th: float = 1.0,
    refinements: int = 5,
) -> Tuple[Tensor, Tensor]:
    """Essential matrix from five or more correspondences with outliers.

    Each of S samples of five correspondences gives up to ten matrices by Nister's algorithm; the one that
    fits 32 of the points (evenly spread) best is kept. The four with the least MSAC costs (the sum over all
    points of Sampson's squared distance in pixels, limited to inl_th squared) are refined: three Gauss-Newton
    steps of rotation and direction of translation on the squared Sampson distances, with fixed denominators,
    of the points within a distance that decreases from nearly 3 inl_th to inl_th. The result is the model
    with the least cost of all; among samples with equal cost the first one wins. Correspondences with a
    coordinate that is not finite, or some 1e8 times as far away as others, have no influence.

    Args:
        points1, points2: (B, N, 2), N >= 6, pixels, floating point.
        K1, K2: (B, 3, 3), camera matrices.
        uniforms: (B, S, 5), random numbers in [0, 1), five for each sample: the k-th number u draws point
            floor(u (N - 4 + k)), k = 0 to 4, or, if that point has already been drawn, point N - 5 + k.
        inl_th: an inlier's Sampson distance, in pixels, is less than this, as for :func:`ransac_fundamental`.
        refinements: how many times to fit again to the nearby points.

    Returns:
        E (B, 3, 3), of unit length, for points of the planes z = 1, and the mask (B, N), bool, of its
        inliers. If no sample gives a matrix, E is zeros. E has no gradient: the gradient is defined at the
        least cost, which a fixed number of steps only approximates.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above, inl_th is not positive or refinements is negative.

    Example:
        >>> generator = torch.Generator().manual_seed(0)
        >>> x = 100.0 * torch.rand(1, 30, 2, generator=generator)
        >>> y = x + torch.tensor([40.0, 0.0]) / (
        ...     1.0 + torch.rand(1, 30, 1, generator=generator)
        ... )  # the camera moved along x
        >>> y[0, :5, 1] += 20.0
        >>> K = torch.tensor([[[90.0, 0.0, 50.0], [0.0, 90.0, 50.0], [0.0, 0.0, 1.0]]])
        >>> E, mask = ransac_essential(x, y, K, K, torch.rand(1, 100, 5, generator=generator))
        >>> mask[0].nonzero().flatten().equal(torch.arange(5, 30))
        True
    """
    check_arguments(points1, points2, uniforms, 6, 5, inl_th, refinements)
    check_rank(K1, 3, "(B, 3, 3)", "K1")
    check_matrix(K1, 3, 3, "K1")
    check_rank(K2, 3, "(B, 3, 3)", "K2")
    check_matrix(K2, 3, 3, "K2")
    check_one_for_each(K1, points1, "K1", "points1")
    check_one_for_each(K2, points1, "K2", "points1")
    p, q, t1, t2, present = in_common_frame(points1.detach(), points2.detach())
    planes = score_planes(p, q, present, t1, inl_th, points1.dtype)
    # From normalized pixels to rays with last coordinate 1: F = M2^T E M1.
    m1, m2 = _to_rays(K1, t1), _to_rays(K2, t2)
    rows = _rows(small_matmul(with_one(p), m1.transpose(1, 2)), small_matmul(with_one(q), m2.transpose(1, 2)))
    index, enough = draw_samples(uniforms, present)
    sizes = [index.size(0), index.size(1)]
    of_samples = rows.gather(1, index.flatten(1)[..., None].expand([sizes[0], sizes[1] * 5, 9]))
    solutions, exists = essentials_of_five(of_samples.reshape(-1, 5, 9))
    fundamentals = _fundamental(solutions.unflatten(0, sizes), m1[:, None, None], m2[:, None, None])
    models, exists = best_of_each(fundamentals, exists.unflatten(0, sizes), planes)
    # The best sample may lead to a nearby minimum that is not the global one.
    F = best_models(models, exists & enough, planes, True, 4).flatten(0, 1)
    rows, n1, n2, marks = _for_each(rows), _for_each(m1), _for_each(m2), _for_each(planes)
    E = small_matmul(small_matmul(inverse3x3(n2).transpose(1, 2), F), inverse3x3(n1))
    R, _, t = decompose_essential_matrix(E)
    pose = torch.cat([R, t], -1)
    # the best so far and the latest
    pose = _refined(torch.stack([pose, pose], 1), refinements, rows, n1, n2, marks, refinements)[:, 0]
    found = (F * F).sum(-1, keepdim=True).sum(-2, keepdim=True) > 0
    E = torch.where(found, _essential(pose), torch.zeros_like(F)).unflatten(0, [points1.size(0), 4])
    cost = model_costs(_fundamental(E, m1[:, None], m2[:, None]), planes, True)
    E = chosen(E, least(cost, 1))[:, 0]
    E = E * pointed(E.flatten(1)[..., None]) / 2.0**0.5
    return E.to(points1.dtype), inliers(_fundamental(E, m1, m2), planes, True)


def _for_each(x: Tensor) -> Tensor:
    """(B, ...) repeated four times, once for each model that is refined: (B * 4, ...)."""
    return torch.stack([x, x, x, x], 1).flatten(0, 1)


def _to_rays(K: Tensor, similarity: Tensor) -> Tensor:
    return inverse3x3(small_matmul(similarity, K.detach().to(torch.float64)))


def _rows(x1: Tensor, x2: Tensor) -> Tensor:
    """Rows (B, N, 9); the product of a row with the entries of E is x2^T E x1."""
    return (x2[..., :, None] * x1[..., None, :]).flatten(-2)


def _fundamental(E: Tensor, m1: Tensor, m2: Tensor) -> Tensor:
    return small_matmul(small_matmul(m2.transpose(-2, -1), E), m1)


def _essential(pose: Tensor) -> Tensor:
    return small_matmul(vector_to_skew_symmetric_matrix(pose[..., 3]), pose[..., 0:3])


@repeated
def _refined(
    state: Tensor, k: Tensor, rows: Tensor, m1: Tensor, m2: Tensor, planes: Tensor, steps: int
) -> Tensor:
    """Poses [R | t], |t| = 1, (B, 2, 3, 4)."""
    best, fitted = state[:, 0], state[:, 1]
    F = _fundamental(_essential(fitted), m1, m2)
    weights = near_weights(F, planes, True, 5, k, steps) / sampson_denominators(F, planes)
    moments = small_matmul((rows * weights[..., None]).transpose(1, 2), rows)
    for _ in range(3):
        fitted = _step(fitted, moments)
    kept = costs_less(
        _fundamental(_essential(best), m1, m2), _fundamental(_essential(fitted), m1, m2), planes, True
    )
    return torch.stack([torch.where(kept[:, None, None], best, fitted), fitted], 1)


def _step(pose: Tensor, moments: Tensor) -> Tensor:
    """One Gauss-Newton step that minimizes e^T M e, where e are the nine entries of [t]x R and M (B, 9, 9)
    are the moments."""
    R, t = pose[..., 0:3], pose[..., 3]
    eye = torch.eye(3, dtype=pose.dtype, device=pose.device)
    # Derivatives with respect to a rotation about each axis and a shift along each axis, without its part
    # along t, which changes nothing.
    turns = small_matmul(
        vector_to_skew_symmetric_matrix(t)[:, None],
        small_matmul(vector_to_skew_symmetric_matrix(eye), R[:, None]),
    )
    shifts = small_matmul(vector_to_skew_symmetric_matrix(eye - t[:, :, None] * t[:, None, :]), R[:, None])
    slope = torch.cat([turns, shifts], 1).flatten(2)
    weighted = small_matmul(slope, moments)
    normal = small_matmul(weighted, slope.transpose(1, 2))
    size = normal.diagonal(0, 1, 2).sum(-1)[:, None, None]
    along = torch.cat([torch.zeros_like(t), t], -1)
    normal = (
        normal / size
        + along[:, :, None] * along[:, None, :]
        + 1e-14 * torch.eye(6, dtype=pose.dtype, device=pose.device)
    )
    e = _essential(pose).flatten(1)
    gradient = (weighted * e[:, None, :]).sum(-1, keepdim=True) / size
    step = small_matmul(spd_inverse(normal), gradient)[..., 0]
    moved = t - step[:, 3:6]
    R = small_matmul(axis_angle_to_rotation_matrix(-step[:, 0:3]), R)
    return torch.cat([R, (moved / torch.sqrt((moved * moved).sum(-1, keepdim=True)))[..., None]], -1)
