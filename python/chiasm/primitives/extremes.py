"""Maxima and minima over rectangles, by doubling the window's length, along columns and then along rows."""

import torch
from torch import Tensor

from .padding import join_columns, padded_parts


def rectangle_extreme(x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float = 0.0) -> Tensor:
    """The largest or smallest value in the centred rectangle of odd size around each pixel of (B, C, H, W).

    >>> rectangle_extreme(torch.tensor([[[[0, 3, 1, 2]]]]), 1, 3, "constant", True)
    tensor([[[[3, 3, 3, 2]]]])
    """
    ry, rx = rows // 2, columns // 2
    tall = join_columns([_along(p, 2, rows, largest) for p in padded_parts(x, ry, ry, 0, 0, border_type, value)])
    return join_columns([_along(p, 3, columns, largest) for p in padded_parts(tall, 0, 0, rx, rx, border_type, value)])


def _along(p: Tensor, dim: int, count: int, largest: bool) -> Tensor:
    """The extreme of each ``count`` successive entries along ``dim``."""
    size = p.size(dim) - count + 1
    length = 1
    while length < count:
        # Two windows of this length make one of up to twice the length; what they share does no harm.
        step = min(length, count - length)
        left, right = p.narrow(dim, 0, p.size(dim) - step), p.narrow(dim, step, p.size(dim) - step)
        p = torch.maximum(left, right) if largest else torch.minimum(left, right)
        length = length + step
    return p.narrow(dim, 0, size)
