"""Parts of direct linear transforms: normalised points, and sums of their equations."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .matrices import small_matmul


def hartley(points: Tensor, weights: Optional[Tensor], eps: float) -> Tuple[Tensor, Tensor]:
    """Points (B, N, d) moved to centroid 0 and mean distance sqrt(d), and the similarity (B, d + 1, d + 1)
    that moves them.

    R. Hartley, In defense of the eight-point algorithm, PAMI 19(6), 1997. Both means are weighted by
    ``weights`` (B, N).

    >>> moved, similarity = hartley(torch.tensor([[[0.0, 0.0], [4.0, 0.0]]]), None, 0.0)
    >>> moved
    tensor([[[-1.4142,  0.0000],
             [ 1.4142,  0.0000]]])
    """
    share = torch.ones_like(points[..., 0]) if weights is None else weights
    share = (share / share.sum(1, keepdim=True))[..., None]
    centre = (points * share).sum(1, keepdim=True)
    offset = points - centre
    distance = _length(offset)
    size = points.size(-1)
    scale = size**0.5 / ((distance * share).sum(1) + eps)
    eye = torch.eye(size + 1, dtype=points.dtype, device=points.device)
    last = eye[size]
    similarity = scale[..., None] * (eye - last[:, None] * last) + last[:, None] * last
    shift = torch.cat([-scale * centre[:, 0], torch.zeros_like(scale)], -1)
    return offset * scale[:, None], similarity + shift[..., :, None] * last


def _length(v: Tensor) -> Tensor:
    """Lengths (..., 1) of vectors (..., d), with a finite derivative at 0."""
    squared = (v * v).sum(-1, keepdim=True)
    if v.dtype == torch.float64:
        return torch.sqrt(squared + 1e-300)  # changes no value; other types have no such number
    apart = squared > 0
    return torch.where(
        apart, torch.sqrt(torch.where(apart, squared, torch.ones_like(squared))), torch.zeros_like(squared)
    )


def _has_grams(x: Tensor, *_: object) -> bool:
    return kernels.available(x) and x.dtype == torch.float64 and x.size(-1) <= kernels.MOST_ROWS


@primitive
def normal_matrix(rows: Tensor, weights: Tensor) -> Tensor:
    """A^T W A (B, D, D) of the rows A (B, N, D) and their weights (B, N).

    >>> normal_matrix(torch.tensor([[[1.0, 2.0], [0.0, 3.0]]]), torch.tensor([[1.0, 2.0]]))
    tensor([[[ 1.,  2.],
             [ 2., 22.]]])
    """
    return small_matmul((rows * weights[..., None]).transpose(1, 2), rows)


@normal_matrix.lowering("native", when=_has_grams)
def _normal_matrix_kernel(rows: Tensor, weights: Tensor) -> Tensor:
    weights = torch.broadcast_tensors(weights, rows[..., 0])[0]
    rows = rows.expand(weights.size(0), -1, -1)
    return kernels.weighted_grams(rows.contiguous(), weights[..., None].contiguous())[:, 0]


@primitive
def projective_equations(p: Tensor, q: Tensor, weights: Tensor) -> Tensor:
    """A^T W A (B, 3k, 3k) of the equations h1.p - u h3.p = 0, h2.p - v h3.p = 0 for homogeneous p (B, N, k)
    and q = (u, v) (B, N, 2)."""
    pp = p[..., :, None] * p[..., None, :]
    u, v = q[..., 0], q[..., 1]
    s = (pp * weights[..., None, None]).sum(1)
    su = (pp * (weights * u)[..., None, None]).sum(1)
    sv = (pp * (weights * v)[..., None, None]).sum(1)
    sq = (pp * (weights * (u * u + v * v))[..., None, None]).sum(1)
    return _assembled(s, su, sv, sq)


@projective_equations.lowering("native", when=_has_grams)
def _projective_equations_kernel(p: Tensor, q: Tensor, weights: Tensor) -> Tensor:
    u, v, weights, _ = torch.broadcast_tensors(q[..., 0], q[..., 1], weights, p[..., 0])
    p = p.expand(weights.size(0), -1, -1)
    sets = torch.stack([weights, weights * u, weights * v, weights * (u * u + v * v)], -1)
    s, su, sv, sq = kernels.weighted_grams(p.contiguous(), sets).unbind(1)
    return _assembled(s, su, sv, sq)


def _assembled(s: Tensor, su: Tensor, sv: Tensor, sq: Tensor) -> Tensor:
    zero = torch.zeros_like(s)
    rows = [torch.cat([s, zero, -su], -1), torch.cat([zero, s, -sv], -1), torch.cat([-su, -sv, sq], -1)]
    return torch.cat(rows, -2)
