"""Angles of vectors."""

import math

import torch
from torch import Tensor

from ..core.lowering import primitive


@primitive
def angle_of(y: Tensor, x: Tensor) -> Tensor:
    """``torch.atan2``, correct in ONNX too. The exporter's own form gives 0 for NaN and for two infinities,
    and -pi for a zero y and a negative x, for which PyTorch has pi. In ONNX a zero of either sign counts as
    +0; PyTorch has -pi for y = -0 and a negative x, and pi or -pi for a zero y and x = -0.

    >>> angle_of(torch.tensor([1.0, 0.0, torch.nan]), torch.tensor([0.0, -1.0, 1.0]))
    tensor([1.5708, 3.1416,    nan])
    """
    return torch.atan2(y, x)


@angle_of.lowering("onnx")
def _by_quotient(y: Tensor, x: Tensor) -> Tensor:
    x = torch.where(x == 0, torch.zeros_like(x), x)  # a quotient by -0 has the wrong sign
    # For two zeros or two infinities the ratio is set to 0, 1 or -1.
    angle = torch.atan(torch.where(y.abs() == x.abs(), torch.sign(y) * torch.sign(x), y / x))
    return torch.where(x < 0, torch.where(y < 0, angle - math.pi, angle + math.pi), angle)
