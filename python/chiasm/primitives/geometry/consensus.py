"""Helpers of robust estimators: samples drawn from uniform numbers, and the costs of models for all
correspondences.

A model is a 3x3 matrix, of one of two kinds: a homography, whose error is the squared distance in the second
image, or a fundamental matrix (``epipolar``), whose error is Sampson's squared distance (R. Hartley, A.
Zisserman, Multiple View Geometry, 2nd ed., 11.4.3). A model's cost is the sum of its errors, each limited to
a bound: MSAC, P. Torr, A. Zisserman, MLESAC, CVIU 78(1), 2000.
"""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..core.loops import repeated
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..linalg.matrices import inverse3x3, small_matmul
from ..numbers.ranking import stable_topk
from ..numbers.rounding import known_or


def draw_samples(uniforms: Tensor, present: Tensor) -> Tuple[Tensor, Tensor]:
    """Indices (B, S, m), int64: m different numbers among those below N for which ``present`` (B, N) is True,
    drawn by uniform numbers (B, S, m) in [0, 1); if these are fewer than m, the same one several times. And
    whether there are m, (B, 1).

    R. Floyd's algorithm (J. Bentley, B. Floyd, Programming pearls: a sample of brilliance, CACM 30(9), 1987):
    the k-th number u (from 0) draws floor(u (l + 1)) with l = count - m + k, or l itself if that was drawn
    before. All sets are equally likely. Computed in float64, in which the product of a float32 number and a
    count is exact.

    >>> u = torch.tensor([[[0.0, 0.99, 0.5], [0.3, 0.3, 0.3]]])
    >>> draw_samples(u, torch.ones(1, 5, dtype=torch.bool))[0]
    tensor([[[0, 3, 2],
             [0, 1, 4]]])
    >>> draw_samples(torch.tensor([[[0.0, 0.9]]]), torch.tensor([[False, True, True, False, True]]))
    (tensor([[[1, 4]]]), tensor([[True]]))
    """
    order, count = _present_first(present)
    picks = _draw(uniforms, count)
    index = order.gather(1, picks.flatten(1)).unflatten(1, [picks.size(1), picks.size(2)])
    return index, count >= picks.size(2)


def _present_first(present: Tensor) -> Tuple[Tensor, Tensor]:
    """The indices (B, N) of the present ones, ascending, then those of the absent ones; and how many are
    present, (B, 1)."""
    place = torch.cumsum(present.to(torch.int64), 1)
    count = place[:, -1:]
    behind = count + torch.cumsum((~present).to(torch.int64), 1)
    index = torch.arange(present.size(1), device=present.device).expand_as(place)
    order = torch.zeros_like(place).scatter(1, torch.where(present, place, behind) - 1, index)
    return order, count


def _draw(uniforms: Tensor, count: Tensor) -> Tensor:
    u = uniforms.detach().to(torch.float64)
    size = u.size(-1)
    picks: List[Tensor] = []
    for k in range(size):
        last = torch.clamp(count - size + k, min=0)
        pick = torch.minimum(
            known_or(torch.floor(u[..., k] * (last + 1.0)), 0.0).clamp(min=0.0), last.to(u.dtype)
        ).to(torch.int64)
        taken = torch.zeros_like(pick, dtype=torch.bool)
        for j in range(k):
            taken = taken | (picks[j] == pick)
        picks.append(torch.where(taken, last, pick))
    return torch.stack(picks, -1)


def drawn(points: Tensor, index: Tensor) -> Tensor:
    """The points (B, S, m, 2) of (B, N, 2) at indices (B, S, m)."""
    flat = index.flatten(1)[..., None].expand([index.size(0), index.size(1) * index.size(2), 2])
    return points.gather(1, flat).unflatten(1, [index.size(1), index.size(2)])


def in_common_frame(
    points1: Tensor, points2: Tensor, mask: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """The points of both images moved by similarities, in float64, (B, N, 2); the similarities (B, 3, 3); and
    which correspondences are present, (B, N).

    Absent are those that a mask (B, N) leaves out, those with a coordinate that is not finite, and those that
    are so far from the others that squares of products of their coordinates would overflow in float32. Their
    moved points are zeros. Both similarities scale by the same factor, so that distances in the two images
    stay comparable. They carry no gradient, because results are moved back.
    """
    x = torch.cat([points1, points2], -1).to(torch.float64)
    present = (x.abs() < float("inf")).all(-1)
    if mask is not None:
        present = present & mask
    centre, scale = _medians(_or_zeros(x.detach(), present), present)
    moved = x * scale[:, None] - (centre * scale)[:, None]
    present = present & (moved.abs() <= 1e8).all(-1)
    return (
        _or_zeros(moved[..., 0:2], present),
        _or_zeros(moved[..., 2:4], present),
        _similarity(scale, centre[:, 0:2]),
        _similarity(scale, centre[:, 2:4]),
        present,
    )


def _or_zeros(x: Tensor, present: Tensor) -> Tensor:
    return torch.where(present[..., None], x, torch.zeros_like(x))


def _medians(x: Tensor, present: Tensor) -> Tuple[Tensor, Tensor]:
    """The medians (B, 4) of the coordinates of the correspondences (B, N, 4) that are present; and the factor
    (B, 1) by which the median distance from there becomes sqrt(2).

    They are medians of 65 correspondences, spread by the golden ratio. Means would be at the mercy of one
    wrong coordinate of 1e10. Distances of zero do not count: half of the points may be the same.
    """
    order, count = _present_first(present)
    index = torch.floor(_spread(65, x) * count).to(torch.int64)
    place = order.gather(1, index)[..., None].expand([x.size(0), 65, 4])
    some = x.gather(1, place)
    centre = stable_topk(some.transpose(1, 2), 33)[0][..., 32]
    a = some - centre[:, None]
    a = a * a
    distance = 0.5 * (torch.sqrt(a[..., 0] + a[..., 1]) + torch.sqrt(a[..., 2] + a[..., 3]))
    sizes = (distance > 0).to(torch.int64).sum(1, keepdim=True)
    distance = stable_topk(distance, 65)[0].gather(1, sizes // 2)
    return centre, 2.0**0.5 / (distance + 1e-8)


def _spread(count: int, like: Tensor) -> Tensor:
    """``count`` numbers in [0, 1), spread by the golden ratio, so that a regular order of the points does not
    bias them."""
    place = torch.arange(1, count + 1, device=like.device).to(torch.float64) * 0.6180339887498949
    return place - torch.floor(place)


def _similarity(scale: Tensor, centre: Tensor) -> Tensor:
    eye = torch.eye(3, dtype=scale.dtype, device=scale.device)
    shift = torch.cat([-centre, torch.zeros_like(centre[:, :1])], -1)
    keep = eye[2][:, None] * eye[2]
    return scale[:, None] * (eye - keep + shift[:, :, None] * eye[2]) + keep


def score_planes(
    p: Tensor, q: Tensor, present: Tensor, similarity: Tensor, inl_th: float, dtype: torch.dtype
) -> Tensor:
    """The planes (B, 7, N) from which errors are computed: x, y, 1 of both images' moved points, and the
    bound, inl_th squared in moved pixels. The bound of absent points is 0: they cost nothing and are never
    inliers.
    """
    p, q = p.detach(), q.detach()
    one = torch.ones_like(p[..., 0])
    bound = inl_th * similarity[:, 0, 0:1] * present.to(one.dtype)
    rows = [p[..., 0], p[..., 1], one, q[..., 0], q[..., 1], one, bound * bound]
    return torch.stack(rows, 1).to(torch.float64 if dtype == torch.float64 else torch.float32)


@primitive
def _forms(rows: Tensor, points: Tensor) -> Tensor:
    """Products (B, S, N) of rows (B, S, 3) with the points (B, 3, N), whose last coordinate is 1."""
    return torch.matmul(rows, points)


@_forms.lowering("native", "vjp")
def _sums_of_products(rows: Tensor, points: Tensor) -> Tensor:
    return rows[..., 0:1] * points[:, None, 0] + rows[..., 1:2] * points[:, None, 1] + rows[..., 2:3]


def model_errors(models: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """Errors (B, S, N) of models (B, S, 3, 3) at the points of `score_planes`."""
    if epipolar:
        product, denominator = _products_and_denominators(models, planes)
        return product * product / denominator
    p = planes[:, 0:3]
    inverse_depth = 1.0 / _forms(models[:, :, 2], p)
    u = _forms(models[:, :, 0], p) * inverse_depth - planes[:, None, 3]
    v = _forms(models[:, :, 1], p) * inverse_depth - planes[:, None, 4]
    return u * u + v * v


def _products_and_denominators(models: Tensor, planes: Tensor) -> Tuple[Tensor, Tensor]:
    p, q = planes[:, 0:3], planes[:, 3:6]
    a, b = _forms(models[:, :, 0], p), _forms(models[:, :, 1], p)
    c, d = _forms(models[..., 0], q), _forms(models[..., 1], q)
    product = a * planes[:, None, 3] + b * planes[:, None, 4] + _forms(models[:, :, 2], p)
    return product, a * a + b * b + c * c + d * d


def model_costs(models: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """Costs (B, S) of models (B, S, 3, 3) of any scale; infinite for models that are not finite."""
    cost = _summed_cost(_unit(models, planes), planes, epipolar)
    return _or_infinite(cost, cost < float("inf"))


@primitive
def _summed_cost(unit: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """``_cost`` in parts, each small enough that its intermediate results fit into the cache."""
    count = 32
    return _with_parts(torch.zeros_like(unit[:, :, 0, 0]), count, unit, _in_parts(planes, count), epipolar)


def _unit(models: Tensor, planes: Tensor) -> Tensor:
    """Models scaled to length 1 (zeros stay zeros), in the precision of the planes, without gradient."""
    fixed = models.detach()
    length = torch.sqrt((fixed * fixed).sum(-1, keepdim=True).sum(-2, keepdim=True))
    return (fixed / torch.where(length > 0, length, torch.ones_like(length))).to(planes.dtype)


def _or_infinite(cost: Tensor, valid: Tensor) -> Tensor:
    return torch.where(valid, cost, torch.full_like(cost, float("inf")))


def _cost(models: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    return torch.minimum(model_errors(models, planes, epipolar), planes[:, None, 6]).sum(-1)


# One fused loop, which stores no error.
_summed_cost.lowering("native", "vjp")(_cost)


def _in_parts(planes: Tensor, parts: int) -> Tensor:
    """(parts, B, 7, n): the points in parts of equal size, padded with points that cost nothing because their
    bound is 0."""
    count = planes.size(2)
    # more than one for any count, because a tracer makes a size of 1 a constant
    size = count // parts + 2
    index = torch.arange(size * parts, device=planes.device)
    inside = (index < count).to(planes.dtype)
    padded = planes.index_select(2, torch.clamp(index, max=count - 1))
    padded = torch.cat([padded[:, 0:6], padded[:, 6:7] * inside], 1)
    return padded.unflatten(2, [parts, size]).permute(2, 0, 1, 3).contiguous()


@repeated
def _with_parts(cost: Tensor, k: Tensor, models: Tensor, parts: Tensor, epipolar: bool) -> Tensor:
    return cost + _cost(models, parts.index_select(0, k.reshape(1))[0], epipolar)


def best_of_each(models: Tensor, exists: Tensor, planes: Tensor) -> Tuple[Tensor, Tensor]:
    """For each sample, the solution of (B, S, c, 3, 3) with the lowest cost at 32 points, and whether one
    exists: (B, S, 3, 3), (B, S).
    """
    index = torch.floor(_spread(32, planes) * planes.size(2)).to(torch.int64)
    jury = planes.index_select(2, torch.clamp(index, max=planes.size(2) - 1))
    cost = _cost(_unit(models.flatten(1, 2), planes), jury, True).unflatten(
        1, [models.size(1), models.size(2)]
    )
    exists = exists & (cost < float("inf"))
    pick = torch.argmin(_or_infinite(cost, exists), dim=-1)[:, :, None, None, None]
    return models.gather(2, pick.expand([models.size(0), models.size(1), 1, 3, 3]))[:, :, 0], exists.any(-1)


def best_model(models: Tensor, exists: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """The model (B, 3, 3) of (B, S, 3, 3) with the lowest cost, the first of equals; zeros if none exists."""
    return best_models(models, exists, planes, epipolar, 1)[:, 0]


def best_models(models: Tensor, exists: Tensor, planes: Tensor, epipolar: bool, count: int) -> Tensor:
    """The ``count`` models (B, count, 3, 3) with the lowest costs, ascending, equals in their order; zeros
    for missing ones."""
    models = torch.where(exists[..., None, None], models, torch.zeros_like(models))
    return chosen(models, _cheapest(models, exists, planes, epipolar, count))


@primitive
def _cheapest(models: Tensor, exists: Tensor, planes: Tensor, epipolar: bool, count: int) -> Tensor:
    """The indices (B, count) of the ``count`` models (B, S, 3, 3) with the lowest costs; models that do not
    exist are zeros."""
    return least(_or_infinite(model_costs(models, planes, epipolar), exists), count)


@_cheapest.lowering("native", when=lambda models, exists, planes, *_: kernels.has_kernel(planes))
def _cheapest_kernel(models: Tensor, exists: Tensor, planes: Tensor, epipolar: bool, count: int) -> Tensor:
    return kernels.score_models(_unit(models, planes).contiguous(), planes.contiguous(), epipolar, count)


def least(cost: Tensor, count: int) -> Tensor:
    """The indices (B, count) of the ``count`` lowest costs of (B, S), equals in their order.

    >>> least(torch.tensor([[3.0, 1.0, 2.0, 1.0]]), 3)
    tensor([[1, 3, 2]])
    """
    place = torch.arange(cost.size(1), device=cost.device)
    found = [torch.argmin(cost, dim=1)[:, None]]
    for k in range(1, count):
        cost = _or_infinite(cost, place != found[k - 1])
        found.append(torch.argmin(cost, dim=1)[:, None])
    return torch.cat(found, 1)


def chosen(models: Tensor, index: Tensor) -> Tensor:
    """The models of (B, S, 3, 3) at indices (B, n)."""
    return models.gather(1, index[:, :, None, None].expand([models.size(0), index.size(1), 3, 3]))


def inliers(model: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """The points (B, N) at which the error of a model (B, 3, 3) is less than the bound; none if the model is
    zeros."""
    return model_errors(_unit(model[:, None], planes), planes, epipolar)[:, 0] < planes[:, 6]


def near_weights(model: Tensor, planes: Tensor, epipolar: bool, least: int, k: Tensor, steps: int) -> Tensor:
    """1 for the points (B, N) to which the k-th of ``steps`` refinements of a model (B, 3, 3) is fitted, 0
    for others, in float64.

    These are the points within a multiple of the threshold, which falls from nearly 3 to 1: the model of a
    sample is too far off for all inliers to be within the threshold itself (O. Chum, J. Matas, J. Kittler,
    Locally optimized RANSAC, DAGM 2003). If they are fewer than ``least``, all points are used.
    """
    factor = 1.0 + 2.0 * (1.0 - (k + 1).to(planes.dtype) / steps)
    mask = (
        model_errors(_unit(model[:, None], planes), planes, epipolar)[:, 0] < planes[:, 6] * factor * factor
    )
    enough = mask.to(torch.int64).sum(1, keepdim=True) >= least
    return ((mask | ~enough) & (planes[:, 6] > 0)).to(torch.float64)


def costs_less(model: Tensor, fitted: Tensor, planes: Tensor, epipolar: bool) -> Tensor:
    """Whether (B,) a model costs less than the one fitted to its inliers; False for zeros."""
    cost = _cost(_unit(torch.stack([model, fitted], 1), planes), planes, epipolar)
    # The cost of a model that is not finite is NaN.
    return (cost[:, 0] < float("inf")) & ~(cost[:, 1] <= cost[:, 0])


def sampson_denominators(model: Tensor, planes: Tensor) -> Tensor:
    """The denominators (B, N) of Sampson's distances, by which the squares of x2^T F x1 are divided, up to a
    common factor, in float64."""
    denominators = _products_and_denominators(_unit(model[:, None], planes), planes)[1]
    return torch.clamp(denominators[:, 0].to(torch.float64), min=1e-30)


def moved_back(H: Tensor, t1: Tensor, t2: Tensor) -> Tensor:
    """The homography T2^-1 H T1 of points before they were moved."""
    return small_matmul(small_matmul(inverse3x3(t2), H), t1)
