"""Rectangles of least area around points of a grid, by rotating calipers, exactly.

A rectangle of least area has a side along an edge of the convex hull (H. Freeman, R. Shapira, Determining the
minimum-area encasing rectangle for an arbitrary closed curve, Communications of the ACM 18(7), 1975). A
rectangle is rotated from edge to edge, by 90 degrees in total (G. Toussaint, Solving geometric problems with
the rotating calipers, MELECON 1983). The next edge at each of its sides is found among all points, as in gift
wrapping, so the hull's corners, whose number depends on data, are never listed. Coordinates are integers, and
so are the directions, which are differences of points rotated by multiples of 90 degrees: only the quotients
that are compared are rounded.
"""

from typing import List

import torch
from torch import Tensor

from ..core.loops import until_stable


def smallest_rectangle_direction(x: Tensor, y: Tensor) -> Tensor:
    """The direction (..., 2), not of length 1, of a side of the rectangle of least area around each set of
    points x and y (..., P). Its angle is at least that of the x axis and below that of the y axis; of equal
    areas the first counts.

    Points are integers of magnitude up to 2^15, in float64. A point may occur several times.

    >>> x, y = torch.tensor([0.0, 2.0, 6.0, 4.0]).double(), torch.tensor([0.0, -1.0, 7.0, 8.0]).double()
    >>> smallest_rectangle_direction(x, y)
    tensor([1., 2.], dtype=torch.float64)
    """
    none = torch.zeros_like(x[..., :1])
    start = torch.cat([none + 1.0, none], -1)
    state = torch.cat([start, _area(start, x, y), start], -1)
    # Each turn ends at a different edge, and there are no more edges than points.
    return _turned(state, x.size(-1), x, y)[..., 3:]


@until_stable
def _turned(state: Tensor, k: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """The calipers (..., 5) at the next edge: their direction, and the smallest area so far with its
    direction. Unchanged after a turn of 90 degrees."""
    a, b = state[..., 0:1], state[..., 1:2]
    along, across = a * x + b * y, a * y - b * x
    ratios: List[Tensor] = []
    falls: List[Tensor] = []
    runs: List[Tensor] = []
    # For each side: the distance of points from it, and along it from the last point that it touches.
    for height, way in [(along, across), (across, -along), (-along, -across), (-across, along)]:
        top = height.amax(-1, keepdim=True)
        touching = torch.where(height == top, way, torch.full_like(way, -float("inf")))
        run = way - touching.amax(-1, keepdim=True)
        fall = top - height
        ahead = run > 0
        ratio = torch.where(
            ahead, fall / torch.where(ahead, run, torch.ones_like(run)), torch.full_like(run, float("inf"))
        )
        nearest = ratio.argmin(-1, keepdim=True)
        ratios.append(ratio.gather(-1, nearest))
        falls.append(fall.gather(-1, nearest))
        runs.append(run.gather(-1, nearest))
    ratio = torch.cat(ratios, -1)
    first = ratio.argmin(-1, keepdim=True)
    fall, run = torch.cat(falls, -1).gather(-1, first), torch.cat(runs, -1).gather(-1, first)
    # Both contain the old direction's squared length as a factor; divided by it, they are integers again.
    length = a * a + b * b
    turned = torch.cat([a * run - b * fall, a * fall + b * run], -1) / length
    goes_on = (ratio.gather(-1, first) < float("inf")) & (turned[..., :1] > 0)
    turned = torch.where(goes_on, turned, state[..., :2])
    area = _area(turned, x, y)
    least = state[..., 2:3]
    # Equal areas that come from different quotients may round to different numbers.
    better = area < least * (1.0 - 1e-12)
    best = torch.where(better, turned, state[..., 3:])
    after = torch.cat([turned, torch.where(better, area, least), best], -1)
    return torch.where(goes_on, after, state)


def _area(direction: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """The area (..., 1) of the rectangle around points with a side of a direction (..., 2)."""
    a, b = direction[..., 0:1], direction[..., 1:2]
    along, across = a * x + b * y, a * y - b * x
    sides = (along.amax(-1, keepdim=True) - along.amin(-1, keepdim=True)) * (
        across.amax(-1, keepdim=True) - across.amin(-1, keepdim=True)
    )
    return sides / (a * a + b * b)
