"""A fundamental matrix from correspondences with outliers."""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.loops import repeated
from ...primitives.geometry.consensus import (
    best_model,
    best_of_each,
    costs_less,
    draw_samples,
    drawn,
    in_common_frame,
    inliers,
    near_weights,
    score_planes,
)
from ..epipolar.fundamental import denormalised, find_fundamental
from ..epipolar.seven_point import epipolar_rows, matrices_of_rank_two
from .arguments import check_arguments


def ransac_fundamental(
    points1: Tensor, points2: Tensor, uniforms: Tensor, inl_th: float = 1.0, refinements: int = 3
) -> Tuple[Tensor, Tensor]:
    """Fundamental matrix from eight or more correspondences with outliers.

    Each of S samples of seven correspondences gives up to three matrices; the one that fits 32 of the points
    (evenly spread) best is kept. The one with the least MSAC cost (the sum over all points of Sampson's
    squared distance, limited to inl_th squared) is refined: :func:`chiasm.geometry.epipolar.find_fundamental`
    of the points within a distance that decreases from nearly 3 inl_th to inl_th. The result is the model
    with the least cost of all; among samples with equal cost the first one wins. Correspondences with a
    coordinate that is not finite, or some 1e8 times as far away as others, have no influence.

    Args:
        points1, points2: (B, N, 2), N >= 8, pixels, floating point.
        uniforms: (B, S, 7), random numbers in [0, 1), seven for each sample: the k-th number u draws point
            floor(u (N - 6 + k)), k = 0 to 6, or, if that point has already been drawn, point N - 7 + k.
        inl_th: an inlier's Sampson distance (:func:`chiasm.geometry.epipolar.sampson_epipolar_distance`, not
            squared) is less than this, in pixels. It measures both points together: each point is about 1.4
            times this distance away from its epipolar line.
        refinements: how many times to fit again to the nearby points.

    Returns:
        F (B, 3, 3) of rank 2, scaled so that the last entry is 1, and the mask (B, N), bool, of its inliers.
        If no sample gives a matrix, the refinements begin with all points (without refinements F is zeros).
        Differentiable in the points: the derivative is that of the chosen fit with its points held fixed; it
        is 0 if the chosen fit is a sample's matrix.

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
        >>> F, mask = ransac_fundamental(x, y, torch.rand(1, 200, 7, generator=generator))
        >>> mask[0].nonzero().flatten().equal(torch.arange(5, 30))
        True
    """
    check_arguments(points1, points2, uniforms, 8, 7, inl_th, refinements)
    p, q, t1, t2, present = in_common_frame(points1, points2)
    planes = score_planes(p, q, present, t1, inl_th, points1.dtype)
    index, enough = draw_samples(uniforms, present)
    rows = epipolar_rows(drawn(p.detach(), index).flatten(0, 1), drawn(q.detach(), index).flatten(0, 1))
    solutions, exists = matrices_of_rank_two(rows)
    sizes = [index.size(0), index.size(1)]
    models, exists = best_of_each(solutions.unflatten(0, sizes), exists.unflatten(0, sizes), planes)
    model = best_model(models, exists & enough, planes, True)
    # the best so far and the latest
    F = _refined(torch.stack([model, model], 1), refinements, p, q, planes, refinements)[:, 0]
    return denormalised(F, t1, t2).to(points1.dtype), inliers(F, planes, True)


@repeated
def _refined(state: Tensor, k: Tensor, p: Tensor, q: Tensor, planes: Tensor, steps: int) -> Tensor:
    best, latest = state[:, 0], state[:, 1]
    fitted = find_fundamental(p, q, near_weights(latest, planes, True, 8, k, steps))
    best = torch.where(costs_less(best, fitted, planes, True)[:, None, None], best, fitted)
    return torch.stack([best, fitted], 1)
