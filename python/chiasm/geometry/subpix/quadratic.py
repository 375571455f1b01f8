"""Subvoxel maxima of volumes, by a quadratic through the neighbours.

M. Brown, D. Lowe, Invariant Features from Interest Point Groups, BMVC 2002. With derivatives g and H by
central differences, the extremum of the quadratic is at -H^-1 g from the voxel, and its value is higher by g
. (-H^-1 g) / 2. If this is too far, a neighbouring voxel is tried. The quadratic is solved at every voxel, in
float64, together with the voxel to try next; so the time does not depend on the number of maxima.
"""

from typing import Optional, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ...primitives.core.checks import check_tensor
from ...primitives.core.materialise import materialised
from ...primitives.features.extrema import largest
from ...primitives.numbers.ranking import stable_topk
from ...primitives.resampling.volumes import check_volume, voxel_axes
from ...primitives.resampling.warping import position_dtype
from .suppression import nms3d


def conv_quad_interp3d(
    input: Tensor,
    n_iters: int = 5,
    strict_maxima_bonus: Optional[float] = None,
    max_subpixel_shift: float = 0.6,
    precomputed_nms_mask: Optional[Tensor] = None,
    dilation_radius: int = 1,
    allow_scale_steps: bool = True,
) -> Tuple[Tensor, Tensor]:
    """Refine the strict maxima of volumes like ``iterative_quad_interp3d``, but only within their
    neighbourhood.

    Args:
        input: (B, C, D, H, W), floating point, without NaN; D is called the scale.
        n_iters: the maximum number of voxels that are tried from each maximum.
        strict_maxima_bonus: not used, here so that Kornia's calls work.
        max_subpixel_shift: the next voxel is tried if the distance along an axis is greater than this.
        precomputed_nms_mask: (B, C, D, H, W), bool, the voxels to refine instead of the strict maxima of
            3x3x3 neighbourhoods; they may be minima.
        dilation_radius: all tried voxels must be within this distance, along each axis, from one of the
            maxima.
        allow_scale_steps: True allows the next voxel to have another scale.

    Returns:
        positions (B, C, 3, D, H, W), scale, x and y in voxels; values (B, C, D, H, W). Differentiable in
        input.

    Raises:
        TypeError: if input is not floating point or the mask not bool.
        ValueError: if input is not 5-D, the mask of another shape, n_iters not positive or dilation_radius
            negative.

    Example:
        >>> z, y, x = torch.arange(5.0)[:, None, None], torch.arange(5.0)[:, None], torch.arange(6.0)
        >>> bowl = 9.0 - (z - 2.0) ** 2 - (y - 1.75) ** 2 - (x - 3.25) ** 2
        >>> positions, values = conv_quad_interp3d(bowl[None, None])
        >>> positions[0, 0, :, 2, 2, 3], values[0, 0, 2, 2, 3]
        (tensor([2.0000, 3.2500, 1.7500]), tensor(9.))
    """
    mask = _checked_mask(input, n_iters, precomputed_nms_mask)
    if dilation_radius < 0:
        raise ValueError(f"dilation_radius: expected a number >= 0, got {dilation_radius}")
    return _refined(
        input, mask, _dilated(mask, dilation_radius), n_iters, max_subpixel_shift, allow_scale_steps
    )


def iterative_quad_interp3d(
    input: Tensor,
    n_iters: int = 5,
    strict_maxima_bonus: Optional[float] = None,
    max_subpixel_shift: float = 0.6,
    allow_scale_steps: bool = True,
    precomputed_nms_mask: Optional[Tensor] = None,
    max_candidates: Optional[int] = None,
) -> Tuple[Tensor, Tensor]:
    """Refine the strict maxima of volumes to a fraction of a voxel.

    A maximum is moved to the extremum of the quadratic through its neighbours. If this is farther than
    max_subpixel_shift along an axis, the search continues from the next voxel, one step along each such axis,
    and so on. The maximum stays unchanged in these cases: no tried voxel is near enough; a tried voxel lies
    on the volume's border; a quadratic has no extremum (the determinant of its Hessian H is at most 1e-7 max
    |H|^3); the extremum is more than 1.5 away from the last voxel. (Voxels of a mask on the border also stay
    unchanged; Kornia refines them from the next inner voxel.)

    Args:
        input: (B, C, D, H, W), floating point, without NaN; D is called the scale.
        n_iters: the maximum number of voxels that are tried from each maximum.
        strict_maxima_bonus: not used, here so that Kornia's calls work.
        max_subpixel_shift: the next voxel is tried if the distance along an axis is greater than this.
        allow_scale_steps: True allows the next voxel to have another scale.
        precomputed_nms_mask: (B, C, D, H, W), bool, the voxels to refine instead of the strict maxima of
            3x3x3 neighbourhoods; they may be minima.
        max_candidates: refine at most this many maxima of each (D, H, W), those with the largest values; of
            equal values the first.

    Returns:
        positions (B, C, 3, D, H, W), scale, x and y in voxels: refined at the maxima, the voxel's own
        position elsewhere; values (B, C, D, H, W): those of the quadratic at the maxima, those of input
        elsewhere. Differentiable in input.

    Raises:
        TypeError: if input is not floating point or the mask not bool.
        ValueError: if input is not 5-D, the mask of another shape, n_iters not positive or max_candidates
            negative.

    Example:
        >>> z, y, x = torch.arange(5.0)[:, None, None], torch.arange(5.0)[:, None], torch.arange(6.0)
        >>> bowl = 9.0 - (z - 2.0) ** 2 - (y - 1.75) ** 2 - (x - 3.25) ** 2
        >>> positions, values = iterative_quad_interp3d(bowl[None, None])
        >>> positions[0, 0, :, 2, 2, 3], values[0, 0, 2, 2, 3]
        (tensor([2.0000, 3.2500, 1.7500]), tensor(9.))
    """
    mask = _checked_mask(input, n_iters, precomputed_nms_mask)
    if max_candidates is not None:
        mask = _strongest(input, mask, max_candidates)
    return _refined(input, mask, torch.ones_like(mask), n_iters, max_subpixel_shift, allow_scale_steps)


def _checked_mask(input: Tensor, n_iters: int, mask: Optional[Tensor]) -> Tensor:
    check_volume(input, "input")
    if n_iters < 1:
        raise ValueError(f"n_iters: expected a positive number, got {n_iters}")
    if mask is None:
        return nms3d(input, 3, True)
    check_tensor(mask, "precomputed_nms_mask")
    if mask.dtype != torch.bool:
        raise TypeError(f"precomputed_nms_mask: expected dtype torch.bool, got {mask.dtype}")
    if mask.shape != input.shape:
        raise ValueError(
            f"precomputed_nms_mask: expected input's shape {list(input.shape)}, got {list(mask.shape)}"
        )
    return mask


def _dilated(mask: Tensor, radius: int) -> Tensor:
    """Whether the mask is set within ``radius`` of each voxel, along each axis."""
    x = F.pad(mask.flatten(0, 1), [radius, radius, radius, radius, radius, radius])
    for dim in range(1, 4):
        size = x.size(dim) - 2 * radius
        near = x.narrow(dim, 0, size)
        for k in range(1, 2 * radius + 1):
            near = near | x.narrow(dim, k, size)
        x = near
    return x.reshape(mask.shape)


def _strongest(input: Tensor, mask: Tensor, count: int) -> Tensor:
    """The ``count`` entries of the mask of each volume where input is largest."""
    if count < 0:
        raise ValueError(f"max_candidates: expected a number >= 0, got {count}")
    if count == 0:
        return torch.zeros_like(mask)
    lowest = -float("inf")
    values = torch.where(mask, input.detach(), torch.full_like(input, lowest)).flatten(0, 1).flatten(1)
    # A small volume may have fewer voxels than requested.
    padded = F.pad(values, [0, count], "constant", lowest)
    chosen = torch.zeros_like(padded).scatter(1, stable_topk(padded, count)[1], 1.0)
    return mask & (chosen[:, : values.size(1)] > 0.5).reshape(mask.shape)


def _refined(
    input: Tensor, mask: Tensor, reach: Tensor, n_iters: int, limit: float, scale_steps: bool
) -> Tuple[Tensor, Tensor]:
    """Positions and values, refined where ``mask`` is set; only voxels where ``reach`` is set are tried."""
    volume = input.flatten(0, 1).to(position_dtype(input.dtype))
    depth, height, width = input.size(2), input.size(3), input.size(4)
    column, row, plane = voxel_axes((depth, height, width), volume.dtype, volume.device)
    found = torch.stack([plane.expand_as(volume), column.expand_as(volume), row.expand_as(volume), volume], 1)
    if depth > 2 and height > 2 and width > 2:
        change = _changes(volume, _inner(mask), _inner(reach), n_iters, limit, scale_steps)
        found = found + F.pad(change, [1, 1, 1, 1, 1, 1])
    found = found.unflatten(0, [input.size(0), input.size(1)]).to(input.dtype)
    return found[:, :, :3], found[:, :, 3]


def _inner(mask: Tensor) -> Tensor:
    return mask.flatten(0, 1)[:, 1:-1, 1:-1, 1:-1]


def _changes(
    volume: Tensor, mask: Tensor, reach: Tensor, n_iters: int, limit: float, scale_steps: bool
) -> Tensor:
    """How far refinement moves the inner voxels of (N, D, H, W) along scale, x and y, and how much it raises
    their values: (N, 4, d, h, w)."""
    shift, rise, regular = quadratic_extrema(volume.to(torch.float64))
    far = shift.detach()
    step = (far > limit).to(torch.int64) - (far < -limit).to(torch.int64)
    if not scale_steps:
        step = step * torch.tensor([0, 1, 1], device=step.device)[:, None, None, None]
    stays = (step[:, 0] == 0) & (step[:, 1] == 0) & (step[:, 2] == 0)
    usable = reach & regular
    place = _followed(step, usable & ~stays, n_iters)
    near = far.abs() <= 1.5
    arrived = usable & stays & near[:, 0] & near[:, 1] & near[:, 2]
    centre = volume[:, 1:-1, 1:-1, 1:-1]
    column, row, plane = voxel_axes((mask.size(1), mask.size(2), mask.size(3)), volume.dtype, volume.device)
    own = torch.stack([plane.expand_as(centre), column.expand_as(centre), row.expand_as(centre), centre], 1)
    fields = (
        torch.cat([own + torch.cat([shift, rise[:, None]], 1), arrived[:, None].to(shift.dtype)], 1)
        .to(volume.dtype)
        .flatten(2)
    )
    found = fields.gather(2, place[:, None].expand_as(fields)).unflatten(
        2, [mask.size(1), mask.size(2), mask.size(3)]
    )
    refined = mask & (found[:, 4] > 0.5)
    return torch.where(refined[:, None], found[:, :4] - own, torch.zeros_like(own))


def _followed(step: Tensor, leads_on: Tensor, n_iters: int) -> Tensor:
    """The last voxel (N, d * h * w) that is tried from each voxel; voxels with ``leads_on`` lead to the next
    one by step (N, 3, d, h, w)."""
    depth, height, width = step.size(2), step.size(3), step.size(4)
    column, row, plane = voxel_axes((depth, height, width), step.dtype, step.device)
    to_plane, to_column, to_row = plane + step[:, 0], column + step[:, 1], row + step[:, 2]
    inside = (
        (to_plane >= 0)
        & (to_plane < depth)
        & (to_column >= 0)
        & (to_column < width)
        & (to_row >= 0)
        & (to_row < height)
    )
    index = (plane * height + row) * width + column
    following = torch.where(
        leads_on & inside, (to_plane * height + to_row) * width + to_column, index
    ).flatten(1)
    following = materialised(following, 1)
    place = following if n_iters > 1 else index.expand_as(leads_on).flatten(1)
    for _ in range(n_iters - 2):
        place = following.gather(1, place)
    return place


def quadratic_extrema(v: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """For each inner voxel of (N, D, H, W): the shift to the extremum of its quadratic, the increase of the
    value, and whether an extremum exists. Shifts (N, 3, d, h, w) are along scale, x and y; 0 if there is no
    extremum.
    """
    centre = _neighbour(v, 0, 0, 0)
    up, down = _neighbour(v, 1, 0, 0), _neighbour(v, -1, 0, 0)
    right, left = _neighbour(v, 0, 0, 1), _neighbour(v, 0, 0, -1)
    below, above = _neighbour(v, 0, 1, 0), _neighbour(v, 0, -1, 0)
    gz, gx, gy = 0.5 * (up - down), 0.5 * (right - left), 0.5 * (below - above)
    zz, xx, yy = up - 2.0 * centre + down, right - 2.0 * centre + left, below - 2.0 * centre + above
    zx = 0.25 * (
        _neighbour(v, 1, 0, 1) - _neighbour(v, 1, 0, -1) - _neighbour(v, -1, 0, 1) + _neighbour(v, -1, 0, -1)
    )
    zy = 0.25 * (
        _neighbour(v, 1, 1, 0) - _neighbour(v, 1, -1, 0) - _neighbour(v, -1, 1, 0) + _neighbour(v, -1, -1, 0)
    )
    xy = 0.25 * (
        _neighbour(v, 0, 1, 1) - _neighbour(v, 0, -1, 1) - _neighbour(v, 0, 1, -1) + _neighbour(v, 0, -1, -1)
    )
    # The adjugate of the symmetric Hessian.
    a, b, c = xx * yy - xy * xy, zy * xy - zx * yy, zx * xy - zy * xx
    d, e, f = zz * yy - zy * zy, zx * zy - zz * xy, zz * xx - zx * zx
    determinant = zz * a + zx * b + zy * c
    size = largest([zz.abs(), xx.abs(), yy.abs(), zx.abs(), zy.abs(), xy.abs()])
    regular = determinant.abs() > 1e-7 * size * size * size
    scale = torch.where(
        regular,
        -1.0 / torch.where(regular, determinant, torch.ones_like(determinant)),
        torch.zeros_like(determinant),
    )
    z, x, y = (
        scale * (a * gz + b * gx + c * gy),
        scale * (b * gz + d * gx + e * gy),
        scale * (c * gz + e * gx + f * gy),
    )
    return torch.stack([z, x, y], 1), 0.5 * (gz * z + gx * x + gy * y), regular.detach()


def _neighbour(v: Tensor, slices: int, rows: int, columns: int) -> Tensor:
    """The neighbours of the inner voxels of (N, D, H, W) at the given offsets, each at most 1."""
    depth, height, width = v.size(1) - 2, v.size(2) - 2, v.size(3) - 2
    return v[
        :, 1 + slices : 1 + slices + depth, 1 + rows : 1 + rows + height, 1 + columns : 1 + columns + width
    ]
