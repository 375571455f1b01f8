"""Thinning of shapes to lines, by the rules of two papers."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..filters.padding import stencil
from ..kernels import operators as kernels


@primitive
def thinned(x: Tensor, limit: int, zhang: bool) -> Tensor:
    """1 for the pixels of (B, C, H, W) above 0 that are left after at most ``limit`` rounds, and 0 elsewhere,
    by the rules of Zhang and Suen or of Guo and Hall: see ``morphology.skeletonize`` and ``morphology.thin``.

    >>> thinned(torch.ones(1, 1, 3, 5), 9, True)
    tensor([[[[0., 0., 0., 0., 0.],
              [0., 1., 1., 0., 0.],
              [0., 0., 0., 0., 0.]]]])
    """
    return _peeled((x > 0).to(torch.int32), limit, zhang).to(x.dtype)


@thinned.lowering("native", when=kernels.has_kernel)
def _thinned_kernel(x: Tensor, limit: int, zhang: bool) -> Tensor:
    return kernels.thin(x, limit, zhang)


@until_stable
def _peeled(state: Tensor, k: Tensor, zhang: bool) -> Tensor:
    """One round: removes the outline on two sides, then on the other two."""
    for first in [True, False]:
        state = _without_outline(state, (1, 1), (1, 1), "constant", zhang, first)
    return state


@stencil
def _without_outline(p: Tensor, zhang: bool, first: bool) -> Tensor:
    goes = _zhang_suen(_ring(p), first) if zhang else _guo_hall(_ring(p), first)
    height, width = p.size(2) - 2, p.size(3) - 2
    centre = p[:, :, 1 : height + 1, 1 : width + 1]
    return torch.where(goes, torch.zeros_like(centre), centre)


def _ring(p: Tensor) -> List[Tensor]:
    """The eight neighbours, clockwise from the north."""
    height, width = p.size(2) - 2, p.size(3) - 2
    steps: List[Tuple[int, int]] = [(0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0), (0, 0)]
    return [p[:, :, i : i + height, j : j + width] for i, j in steps]


def _zhang_suen(ring: List[Tensor], first: bool) -> Tensor:
    """The pixels to remove: those that are not the end of a line and whose removal breaks no line. First on
    the south-east outline, then on the north-west one."""
    count = torch.zeros_like(ring[0])
    rises = torch.zeros_like(ring[0])
    for n in range(8):
        count = count + ring[n]
        rises = rises + (1 - ring[n]) * ring[(n + 1) % 8]
    north, east, south, west = ring[0], ring[2], ring[4], ring[6]
    inner = east * south * (north + west) if first else north * west * (east + south)
    return (count >= 2) & (count <= 6) & (rises == 1) & (inner == 0)


def _guo_hall(ring: List[Tensor], first: bool) -> Tensor:
    """The pixels to remove, by the conditions G1, G2 and G3 of the paper, which numbers neighbours
    counter-clockwise from the east."""
    x = [ring[(10 - n) % 8] for n in range(8)]
    parts = torch.zeros_like(x[0])
    pairs = torch.zeros_like(x[0])
    other_pairs = torch.zeros_like(x[0])
    for n in range(4):
        side, corner, following = x[2 * n], x[2 * n + 1], x[(2 * n + 2) % 8]
        parts = parts + (1 - side) * torch.maximum(corner, following)
        pairs = pairs + torch.maximum(side, corner)
        other_pairs = other_pairs + torch.maximum(corner, following)
    fewest = torch.minimum(pairs, other_pairs)
    a = 0 if first else 4
    inner = x[a] * torch.maximum(torch.maximum(x[a + 1], x[(a + 2) % 8]), 1 - x[(a + 7) % 8])
    return (parts == 1) & (fewest >= 2) & (fewest <= 3) & (inner == 0)
