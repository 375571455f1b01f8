"""Powers of positive numbers."""

import torch
from torch import Tensor

from ..core.lowering import primitive


@primitive
def power(x: Tensor, exponent: float) -> Tensor:
    """x ** exponent for positive x. In native code, float32 x must be normal if the exponent is 1/3, 2.4 or
    1/2.4 (those of colour spaces).

    >>> power(torch.tensor([8.0, 27.0]), 1.0 / 3.0)
    tensor([2., 3.])
    """
    return torch.pow(x, exponent)


@power.lowering(
    "native", when=lambda x, exponent: x.dtype == torch.float32 and exponent in (1.0 / 3.0, 2.4, 1.0 / 2.4)
)
def _by_roots(x: Tensor, exponent: float) -> Tensor:
    if exponent == 1.0 / 3.0:
        return _cube_root(x)
    if exponent == 2.4:
        return torch.pow((x * _inverse_root(x, 5, 1277937320.0)).abs(), 3)
    root = _cube_root(x)
    return root * torch.sqrt(torch.sqrt(root))


def _affords_a_logarithm(x: Tensor, *_: object) -> bool:
    """Compiled code and ONNX Runtime have vectorised exponentials and logarithms but a slow ``pow``. The
    power by logarithm has an error of ``exponent * log(x)`` roundings, too much for half precision."""
    return x.dtype == torch.float32 or x.dtype == torch.float64


@power.lowering("native", "onnx", when=_affords_a_logarithm)
def _by_logarithm(x: Tensor, exponent: float) -> Tensor:
    return torch.exp(torch.log(x) * exponent)


def _cube_root(x: Tensor) -> Tensor:
    return x * torch.pow(_inverse_root(x, 3, 1419917306.0), 2)


def _inverse_root(x: Tensor, n: int, origin: float) -> Tensor:
    """x ** (-1 / n) in float32, by Newton's method for z^-n = x: only products, in a third of the time of a
    logarithm and an exponential.

    The first guess is the number whose bits, read as an integer, are ``origin`` minus an n-th of x's. It is
    within 3.5 %, because that integer is nearly a logarithm (W. Kahan). After three steps the error is 4
    roundings. AOTInductor expands a value's whole computation wherever the value is named, before it removes
    duplicates: powers by ``pow`` name it once.
    """
    bits = x.view(torch.int32).to(torch.float32)
    z = (origin - bits * (1.0 / n)).to(torch.int32).view(torch.float32)
    for _ in range(3):
        half = torch.pow(z, (n + 1) // 2)
        z = z * (1.0 + 1.0 / n) - half * (half * (x * (1.0 / n)))
    return z


@primitive
def power_each(x: Tensor, exponent: Tensor) -> Tensor:
    """x ** exponent with a tensor of exponents that are not negative. Negative x counts as zero. At x = 0 the
    gradient is zero, although it is infinite for an exponent below 1.

    >>> power_each(torch.tensor([4.0, 0.0, -1.0]), torch.tensor(0.5))
    tensor([2., 0., 0.])
    """
    empty = x <= 0  # False for NaN, which stays NaN, as in ``pow``
    raised = torch.pow(torch.where(empty, torch.ones_like(x), x), exponent)
    # 0 ** 0 is 1
    return torch.where(empty, (exponent == 0).to(x.dtype), raised)


@power_each.lowering("onnx")
def _limited(x: Tensor, exponent: Tensor) -> Tensor:
    # in ONNX Runtime, the definition's two selections would take longer than ``pow``
    return torch.pow(x.clamp(min=0.0), exponent)


@power_each.lowering("native", when=_affords_a_logarithm)
def _each_by_logarithm(x: Tensor, exponent: Tensor) -> Tensor:
    empty = x <= 0
    raised = torch.exp(torch.log(torch.where(empty, torch.ones_like(x), x)) * exponent)
    return torch.where(empty, (exponent == 0).to(x.dtype), raised)
