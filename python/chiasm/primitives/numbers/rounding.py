"""Whole numbers out of floating-point ones.

Converting NaN, an infinity or what an integer cannot hold is undefined: processors, engines and vector widths
differ, and an index made of it reads anywhere. A ``clamp`` does not help, for NaN passes it.
"""

import math

import torch
from torch import Tensor

from ..core.lowering import primitive


def to_index(x: Tensor, size: int) -> Tensor:
    """The whole part of x as int64, limited to 0 to ``size`` - 1; of NaN 0.

    >>> to_index(torch.tensor([1.7, -1.0, 3e9, torch.nan]), 4)
    tensor([1, 0, 3, 0])
    """
    return known_or(x, 0.0).clamp(0, size - 1).to(torch.int64)


@primitive
def known_or(x: Tensor, value: float) -> Tensor:
    """x, and ``value`` instead of NaN.

    >>> known_or(torch.tensor([-1.0, torch.nan]), -2.0)
    tensor([-1., -2.])
    """
    return torch.nan_to_num(x, value, math.inf, -math.inf)


# What engines fuse, though in eager code it is three passes instead of one.
@known_or.lowering("onnx", "native", "vjp")
def _known_or_by_choice(x: Tensor, value: float) -> Tensor:
    return torch.where(x == x, x, torch.full_like(x, value))
