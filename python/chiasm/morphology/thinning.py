"""Skeletons of binary images."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.core.loops import until_stable
from ..primitives.filters.padding import stencil


def skeletonize(input: Tensor, num_iters: int = 10000) -> Tensor:
    """Thin shapes to lines one pixel wide, by peeling their outlines until nothing changes.

    Not in Kornia. T. Y. Zhang, C. Y. Suen, A fast parallel algorithm for thinning digital patterns, CACM
    27(3), 1984, as printed there: squares of 2 x 2 pixels vanish, and scikit-image's
    ``skeletonize(method="zhang")``, whose table also takes some corners, differs by single pixels. A round
    peels a pixel from every side, so half a shape's width of rounds is enough.

    Args:
        input: (B, C, H, W), floating point; pixels above 0 are set. Outside the image none is.
        num_iters: the most rounds.

    Returns:
        (B, C, H, W), 0 or 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or num_iters is negative.

    Example:
        >>> skeletonize(torch.ones(1, 1, 3, 7))[0, 0]
        tensor([[0., 0., 0., 0., 0., 0., 0.],
                [0., 1., 1., 1., 1., 0., 0.],
                [0., 0., 0., 0., 0., 0., 0.]])
    """
    return _thinned(input, num_iters, True)


def thin(input: Tensor, num_iters: int = 10000) -> Tensor:
    """Thin shapes to lines one pixel wide, keeping every connected shape.

    Not in Kornia. Z. Guo, R. W. Hall, Parallel thinning with two-subiteration algorithms, CACM 32(3), 1989;
    scikit-image's ``thin``.

    Args:
        input: (B, C, H, W), floating point; pixels above 0 are set. Outside the image none is.
        num_iters: the most rounds.

    Returns:
        (B, C, H, W), 0 or 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or num_iters is negative.

    Example:
        >>> thin(torch.ones(1, 1, 3, 7))[0, 0]
        tensor([[0., 0., 0., 0., 0., 0., 0.],
                [0., 1., 1., 1., 1., 1., 0.],
                [0., 0., 0., 0., 0., 0., 0.]])
    """
    return _thinned(input, num_iters, False)


def _thinned(input: Tensor, num_iters: int, zhang: bool) -> Tensor:
    check_image(input, "input")
    if num_iters < 0:
        raise ValueError(f"num_iters: expected at least 0, got {num_iters}")
    state = (input > 0).to(torch.int32)
    return _peeled(state, num_iters, zhang).to(input.dtype)


@until_stable
def _peeled(state: Tensor, k: Tensor, zhang: bool) -> Tensor:
    """A round: the outline on two sides, then on the other two."""
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
    """Which pixels go: the ends of no line, that break none, on the south-east outline first, then on the
    north-west one."""
    count = torch.zeros_like(ring[0])
    rises = torch.zeros_like(ring[0])
    for n in range(8):
        count = count + ring[n]
        rises = rises + (1 - ring[n]) * ring[(n + 1) % 8]
    north, east, south, west = ring[0], ring[2], ring[4], ring[6]
    inner = east * south * (north + west) if first else north * west * (east + south)
    return (count >= 2) & (count <= 6) & (rises == 1) & (inner == 0)


def _guo_hall(ring: List[Tensor], first: bool) -> Tensor:
    """Which pixels go, by the conditions G1, G2 and G3 of the paper, whose neighbours run counter-clockwise
    from the east."""
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
