"""Powers of positive numbers."""

import torch
from torch import Tensor

from .target import native_forward, onnx_forward


def power(x: Tensor, exponent: float) -> Tensor:
    """x ** exponent of positive x.

    >>> power(torch.tensor([8.0, 27.0]), 1.0 / 3.0)
    tensor([2., 3.])
    """
    if _by_logarithm(x):
        return torch.exp(torch.log(x) * exponent)
    return torch.pow(x, exponent)


def power_each(x: Tensor, exponent: Tensor) -> Tensor:
    """``power`` with a tensor of exponents."""
    if _by_logarithm(x):
        return torch.exp(torch.log(x) * exponent)
    return torch.pow(x, exponent)


def _by_logarithm(x: Tensor) -> bool:
    """Compiled code and ONNX Runtime have vectorised exponentials and logarithms but a slow ``pow``. The detour costs
    ``exponent * log(x)`` roundings, which half precision cannot afford."""
    return (native_forward() or onnx_forward()) and (x.dtype == torch.float32 or x.dtype == torch.float64)
