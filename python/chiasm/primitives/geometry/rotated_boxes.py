"""Boxes cx, cy, width, height, angle in degrees, like OpenCV's RotatedRect: overlaps of pairs."""

import math
from typing import Tuple

import torch
from torch import Tensor


def rotated_intersections(a: Tensor, b: Tensor) -> Tensor:
    """The areas (...) of the intersections of boxes (..., 5); they broadcast.

    The first box is clipped against one side of the second after the other, in the frame in which these are
    parallel to the axes: I. Sutherland, G. Hodgman, Reentrant Polygon Clipping, CACM 17(1), 1974. Each cut of
    a convex polygon adds at most one corner, so 8 slots suffice; an unused slot repeats a corner, which adds
    no area.

    >>> square = torch.tensor([0.0, 0.0, 2.0, 2.0, 0.0])
    >>> rotated_intersections(square, torch.tensor([1.0, 1.0, 2.0, 2.0, 90.0]))
    tensor(1.)
    """
    turn, frame = (a[..., 4] - b[..., 4]) * (math.pi / 180.0), b[..., 4] * (math.pi / 180.0)
    across, down = a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]
    x = across * torch.cos(frame) + down * torch.sin(frame)
    y = down * torch.cos(frame) - across * torch.sin(frame)
    # The corners in order, without a constant tensor, which the body of a loop cannot have.
    wide, high = a[..., 2:3] * 0.5, a[..., 3:4] * 0.5
    wide, high = torch.cat([-wide, wide, wide, -wide], -1), torch.cat([-high, -high, high, high], -1)
    cos, sin = torch.cos(turn)[..., None], torch.sin(turn)[..., None]
    x, y = x[..., None] + wide * cos - high * sin, y[..., None] + wide * sin + high * cos
    half_width, half_height = b[..., 2:3] * 0.5, b[..., 3:4] * 0.5
    x, y = _cut(x, y, half_width - x)
    x, y = _cut(x, y, half_width + x)
    x, y = _cut(x, y, half_height - y)
    x, y = _cut(x, y, half_height + y)
    doubled = x * _next(y) - _next(x) * y
    return 0.5 * doubled.sum(-1).abs()


def _next(x: Tensor) -> Tensor:
    return torch.cat([x[..., 1:], x[..., :1]], -1)


def _cut(x: Tensor, y: Tensor, inside: Tensor) -> Tuple[Tensor, Tensor]:
    """The part of a convex polygon with corners x and y (..., n) where ``inside``, the distance from a line,
    is not negative: n + 1 corners."""
    follows = _next(inside)
    is_in, then_in = inside >= 0.0, follows >= 0.0
    crosses = is_in != then_in
    apart = torch.where(crosses, inside - follows, torch.ones_like(inside))
    part = torch.where(crosses, inside / apart, torch.zeros_like(inside))
    # The edge on which the polygon leaves. If rounding yields more than one such edge, their mean.
    leaves = (is_in & ~then_in).to(x.dtype)
    share = leaves / leaves.sum(-1, keepdim=True).clamp(min=1.0)
    # One more corner follows that edge.
    place = torch.arange(inside.size(-1) + 1, device=x.device)
    last = inside.size(-1) - 1
    edge = torch.where(leaves.amax(-1) > 0, leaves.argmax(-1), torch.full_like(leaves.argmax(-1), last))
    return (
        _one_more(x, part, share, is_in, then_in, place - edge[..., None]),
        _one_more(y, part, share, is_in, then_in, place - edge[..., None]),
    )


def _one_more(
    x: Tensor, part: Tensor, share: Tensor, is_in: Tensor, then_in: Tensor, behind: Tensor
) -> Tensor:
    """One coordinate of the remaining polygon: the corners inside, the point where the polygon enters, and
    the point where it leaves, which also replaces corners outside."""
    crossing = x + part * (_next(x) - x)
    leaving = (crossing * share).sum(-1, keepdim=True)
    corners = torch.where(is_in, x, torch.where(then_in, crossing, leaving))
    early = torch.cat([corners, corners[..., -1:]], -1)
    late = torch.cat([corners[..., :1], corners], -1)
    # If no edge leaves, all corners are inside or none is: repeat the last corner, which adds no area.
    out = torch.where(share.amax(-1, keepdim=True) > 0, leaving, corners[..., -1:])
    return torch.where(behind <= 0, early, torch.where(behind == 1, out, late))


def rotated_overlaps(a: Tensor, b: Tensor) -> Tuple[Tensor, Tensor]:
    """The areas (...) of the intersections and of the unions of boxes (..., 5)."""
    common = rotated_intersections(a, b)
    return common, a[..., 2] * a[..., 3] + b[..., 2] * b[..., 3] - common
