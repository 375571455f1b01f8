"""A homography from correspondences with outliers."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_tensor
from ...primitives.core.loops import repeated
from ...primitives.geometry.consensus import (
    best_model,
    costs_less,
    draw_samples,
    drawn,
    in_common_frame,
    inliers,
    moved_back,
    near_weights,
    score_planes,
)
from ...primitives.geometry.intrinsics import with_one
from ...primitives.linalg.matrices import cross
from ..homography import homography_by_weights
from .arguments import check_arguments


def ransac_homography(
    points1: Tensor,
    points2: Tensor,
    uniforms: Tensor,
    inl_th: float = 3.0,
    refinements: int = 3,
    mask: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor]:
    """Homography from four or more correspondences with outliers.

    Each of S samples of four correspondences gives a homography in closed form. Homographies that flip the
    orientation of a triangle are rejected, since a plane seen from one side cannot do this. The one with the
    least MSAC cost (the sum over all points of the squared distance in the second image, limited to inl_th
    squared) is refined: :func:`chiasm.geometry.homography.find_homography_dlt` of the points within a
    distance that decreases from nearly 3 inl_th to inl_th. The result is the model with the least cost of
    all; among samples with equal cost the first one wins. Correspondences with a coordinate that is not
    finite, or some 1e8 times as far away as others, have no influence.

    Args:
        points1, points2: (B, N, 2), N >= 4, pixels, floating point.
        uniforms: (B, S, 4), random numbers in [0, 1), four for each sample: the k-th number u draws point
            floor(u (N - 3 + k)), k = 0 to 3, or, if that point has already been drawn, point N - 4 + k.
        inl_th: a correspondence is an inlier if the distance in the second image between its point and its
            transformed partner is less than this, in pixels.
        refinements: how many times to fit again to the nearby points.
        mask: (B, N), bool, the correspondences to use; None means all. Samples are drawn only from these, as
            if the others did not exist.

    Returns:
        H (B, 3, 3) with the last entry 1, from the first image to the second, and the mask (B, N), bool, of
        its inliers. If no sample gives a homography, the refinements begin with all points (without
        refinements H is not finite). Differentiable in the points: the derivative is that of the chosen fit
        with its points held fixed; it is 0 if the chosen fit is a sample's homography.

    Raises:
        TypeError: if a tensor is not floating point, or mask not bool.
        ValueError: if a shape is not as above, inl_th is not positive or refinements is negative.

    Example:
        >>> x = torch.tensor([[0, 0], [9, 1], [8, 9], [1, 8], [4, 5], [3, 7]]).float()[None]
        >>> y = 2.0 * x
        >>> y[0, 5] = 90.0
        >>> H, mask = ransac_homography(
        ...     x, y, torch.rand(1, 100, 4, generator=torch.Generator().manual_seed(0))
        ... )
        >>> H[0].round(decimals=3).diagonal(), mask
        (tensor([2., 2., 1.]), tensor([[ True,  True,  True,  True,  True, False]]))
    """
    check_arguments(points1, points2, uniforms, 4, 4, inl_th, refinements)
    if mask is not None:
        check_tensor(mask, "mask")
        if mask.dtype != torch.bool:
            raise TypeError(f"mask: expected dtype torch.bool, got {mask.dtype}")
        if mask.dim() != 2 or mask.size(0) != points1.size(0) or mask.size(1) != points1.size(1):
            raise ValueError(
                f"mask: expected shape (B, N) of points1 {list(points1.shape)}, got {list(mask.shape)}"
            )
    p, q, t1, t2, present = in_common_frame(points1, points2, mask)
    planes = score_planes(p, q, present, t1, inl_th, points1.dtype)
    index, enough = draw_samples(uniforms, present)
    models, exists = _homographies_of_four(drawn(p.detach(), index), drawn(q.detach(), index))
    model = best_model(models, exists & enough, planes, False)
    # the best so far and the latest
    H = _refined(torch.stack([model, model], 1), refinements, p, q, planes, refinements)[:, 0]
    within = inliers(H, planes, False)
    H = moved_back(H, t1, t2)
    return (H / H[:, 2:3, 2:3]).to(points1.dtype), within


@repeated
def _refined(state: Tensor, k: Tensor, p: Tensor, q: Tensor, planes: Tensor, steps: int) -> Tensor:
    best, latest = state[:, 0], state[:, 1]
    near = near_weights(latest, planes, False, 4, k, steps)
    fitted = homography_by_weights(p, q, near, near)
    best = torch.where(costs_less(best, fitted, planes, False)[:, None, None], best, fitted)
    return torch.stack([best, fitted], 1)


def _homographies_of_four(p: Tensor, q: Tensor) -> Tuple[Tensor, Tensor]:
    """Homographies (..., 3, 3) of four correspondences (..., 4, 2), and which of them keep the orientation of
    all triangles. Three points, with the weights of their sum that gives the fourth point, are a projective
    basis; the homography maps the basis of one image to that of the other: R. Hartley, A. Zisserman, Multiple
    View Geometry, 2nd ed., 2.3.
    """
    p0, p1, p2, p3 = with_one(p).unbind(-2)
    q0, q1, q2, q3 = with_one(q).unbind(-2)
    row0, row1, row2 = cross(p1, p2), cross(p2, p0), cross(p0, p1)
    # Determinants: p3 = (a0 p0 + a1 p1 + a2 p2) / a3
    a0, a1, a2, a3 = _dot(row0, p3), _dot(row1, p3), _dot(row2, p3), _dot(row2, p2)
    other = cross(q0, q1)
    b0, b1, b2, b3 = _dot(cross(q1, q2), q3), _dot(cross(q2, q0), q3), _dot(other, q3), _dot(other, q2)
    H = q0[..., :, None] * (row0 * (b0 * a1 * a2)[..., None])[..., None, :]
    H = H + q1[..., :, None] * (row1 * (b1 * a2 * a0)[..., None])[..., None, :]
    H = H + q2[..., :, None] * (row2 * (b2 * a0 * a1)[..., None])[..., None, :]
    a, b = torch.stack([a0, a1, a2, a3], -1), torch.stack([b0, b1, b2, b3], -1)
    return H, (torch.sign(a) * torch.sign(b) > 0).all(-1)


def _dot(a: Tensor, b: Tensor) -> Tensor:
    return (a * b).sum(-1)
