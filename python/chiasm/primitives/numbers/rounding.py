"""Conversion of floating-point numbers to integers.

Converting NaN, an infinity or a number out of range to an integer is undefined: processors, engines and
vector widths differ, and such an index reads anywhere in memory. A ``clamp`` does not help, because it keeps
NaN.
"""

import math

import torch
from torch import Tensor

from ..core.lowering import primitive


def to_index(x: Tensor, size: int) -> Tensor:
    """The integer part of x as int64, limited to 0 to ``size`` - 1; 0 for NaN.

    >>> to_index(torch.tensor([1.7, -1.0, 3e9, torch.nan]), 4)
    tensor([1, 0, 3, 0])
    """
    return known_or(x, 0.0).clamp(0, size - 1).to(torch.int64)


@primitive
def known_or(x: Tensor, value: float) -> Tensor:
    """x, with ``value`` in place of NaN.

    >>> known_or(torch.tensor([-1.0, torch.nan]), -2.0)
    tensor([-1., -2.])
    """
    return torch.nan_to_num(x, value, math.inf, -math.inf)


# Engines fuse this form; in eager code it would take three passes instead of one.
@known_or.lowering("onnx", "native", "vjp")
def _known_or_by_choice(x: Tensor, value: float) -> Tensor:
    return torch.where(x == x, x, torch.full_like(x, value))
