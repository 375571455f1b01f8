"""Search in tables: sorted ones, and of truth values."""

from typing import Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive


@primitive
def last_not_above(table: Tensor, x: Tensor) -> Tensor:
    """Index of the last entry of each ascending row of ``table`` (P, M) that is not above ``x`` (P, N),
    int64; -1 if all are above.

    ``searchsorted`` has no form in ONNX and is not compiled in native code: there the index is found bit by
    bit.

    >>> last_not_above(torch.tensor([[0.0, 1.0, 1.0, 3.0]]), torch.tensor([[-1.0, 1.0, 9.0]]))
    tensor([[-1,  2,  3]])
    """
    return torch.searchsorted(table.detach().contiguous(), x.detach().contiguous(), right=True) - 1


@last_not_above.lowering("onnx", "native", "vjp")
def _bit_by_bit(table: Tensor, x: Tensor) -> Tensor:
    size = table.size(1)
    known = table.detach()
    found = torch.full_like(x, -1, dtype=torch.int64)
    # A symbolic size may be any number below 2^20.
    limit = size if isinstance(size, int) else 1 << 20
    step = 1
    while step * 2 <= limit:
        step = step * 2
    while step > 0:
        ahead = found + step
        # Not ``<=``: NaN counts as above all, as in ``searchsorted``.
        here = (ahead < size) & ~(known.gather(1, ahead.clamp(max=size - 1)) > x)
        found = torch.where(here, ahead, found)
        step = step // 2
    return found


def first_and_last(present: Tensor) -> Tuple[Tensor, Tensor]:
    """The first and the last index (*,) of true values in (*, L); 0 if there are none.

    >>> first_and_last(torch.tensor([[False, True, True, False]]))
    (tensor([1]), tensor([2]))
    """
    place = torch.arange(present.size(-1), device=present.device)
    last = torch.where(present, place, torch.zeros_like(place)).amax(-1)
    first = torch.where(present, place, torch.full_like(place, present.size(-1))).amin(-1)
    return torch.minimum(first, last), last


def interpolate(x: Tensor, table: Tensor, values: Tensor) -> Tensor:
    """Piecewise linear function through (table, values), both (P, M), at x (P, N); constant beyond the ends.

    If neighbouring entries of the table are equal, the later value counts.
    """
    size = table.size(1)
    index = last_not_above(table, x)
    left = index.clamp(0, size - 1)
    right = (index + 1).clamp(0, size - 1)
    x0 = table.gather(1, left)
    y0 = values.gather(1, left)
    width = table.gather(1, right) - x0
    inside = (index >= 0) & (width > 0)
    share = torch.where(inside, x - x0, torch.zeros_like(x)) / torch.where(
        inside, width, torch.ones_like(width)
    )
    return y0 + (values.gather(1, right) - y0) * share
