"""Integer pixels of 8 and 16 bits. Engines lack operations on these types, so they are done in int32 and
converted back."""

from typing import Tuple

import torch
from torch import Tensor

from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .layout import as_rows, from_rows, interleaved
from .lowering import primitive


def narrow(x: Tensor, *_: object) -> bool:
    """Whether x has integers of 8 or 16 bits. For lowerings only."""
    return x.dtype in (torch.uint8, torch.int16, torch.uint16)


def ordered(x: Tensor) -> Tensor:
    """x in a type for which PyTorch has minima, maxima and ``gather``."""
    return x.to(torch.int32) if x.dtype == torch.uint16 else x


def pixel_range(x: Tensor) -> Tuple[int, int]:
    """The smallest and the largest number of x's type, which has 8 or 16 bits.

    >>> pixel_range(torch.zeros(1, dtype=torch.int16))
    (-32768, 32767)
    """
    if x.dtype == torch.uint8:
        return 0, 255
    return (0, 65535) if x.dtype == torch.uint16 else (-32768, 32767)


def check_pixel_value(value: float, like: Tensor, name: str) -> None:
    """Raise ValueError unless the pixel type of ``like`` can represent ``value``. Floating-point types accept
    any."""
    if like.is_floating_point():
        return
    least, largest = pixel_range(like)
    if not (value >= least and value <= largest) or value != round(value):
        raise ValueError(f"{name}: expected a number of dtype {like.dtype}, got {value}")


def saturated(value: Tensor, like: Tensor) -> Tensor:
    """int32 converted to the pixel type of ``like``, saturated.

    >>> saturated(torch.tensor([-3, 4, 300]), torch.zeros(1, dtype=torch.uint8))
    tensor([  0,   4, 255], dtype=torch.uint8)
    """
    low, high = pixel_range(like)
    return value.clamp(low, high).to(like.dtype)


def has_words(x: Tensor, *_: object) -> bool:
    """Whether x has pixels of 16 bits, and native code kernels for them. For lowerings only."""
    return kernels.available(x) and x.dtype in (torch.int16, torch.uint16)


@primitive
def difference(high: Tensor, low: Tensor) -> Tensor:
    """high - low; integers saturate.

    >>> difference(torch.tensor([5, 2], dtype=torch.uint8), torch.tensor([2, 5], dtype=torch.uint8))
    tensor([3, 0], dtype=torch.uint8)
    """
    if high.is_floating_point():
        return high - low
    # In float32, which represents both exactly: int64 constants would halve the vector lanes of compiled
    # loops.
    least, largest = pixel_range(high)
    return (high.to(torch.float32) - low.to(torch.float32)).clamp(least, largest).to(high.dtype)


def _alike(x: Tensor, y: Tensor, *_: object) -> bool:
    """Whether two images have the same layout in memory, so that kernels can take them value by value."""
    return kernels.available(x) and narrow(x) and x.dim() == 4 and interleaved(x) == interleaved(y)


@difference.lowering("native", when=_alike)
def _difference_kernel(high: Tensor, low: Tensor) -> Tensor:
    rows, _ = as_rows(high)
    made = kernels.subtract_pixels(rows.flatten(1), as_rows(low)[0].flatten(1))
    return from_rows(made.unflatten(1, rows.shape[1:]), high)


@primitive
def weighted_sum(x: Tensor, y: Tensor, alpha: Tensor, beta: Tensor, gamma: Tensor) -> Tensor:
    """Bytes: x * alpha + y * beta + gamma in float32, each step rounded, then to the nearest byte, half to
    even. NaN becomes 0. Weights are float32 and broadcast against x.

    >>> x = torch.tensor([[10, 200]], dtype=torch.uint8)
    >>> weighted_sum(x, x, torch.tensor(1.0), torch.tensor(0.5), torch.tensor(-7.0))
    tensor([[  8, 255]], dtype=torch.uint8)
    """
    total = x.to(torch.float32) * alpha + y.to(torch.float32) * beta
    return known_or(torch.round(total + gamma), 0.0).clamp(0.0, 255.0).to(torch.uint8)


def one_or_per_sample(x: Tensor, *values: Tensor) -> bool:
    """Whether each tensor, which broadcasts against x, has one number, or one for each sample. For lowerings
    only."""
    # A tensor with fewer dimensions has its first size along another axis than that of the samples.
    others = [size for value in values for size in value.shape[1 if value.dim() == x.dim() else 0 :]]
    return all(isinstance(size, int) and size == 1 for size in others)


@weighted_sum.lowering("native", when=lambda x, y, *weights: _alike(x, y) and one_or_per_sample(x, *weights))
def _weighted_sum_kernel(x: Tensor, y: Tensor, alpha: Tensor, beta: Tensor, gamma: Tensor) -> Tensor:
    rows, _ = as_rows(x)
    weights = torch.stack([w.reshape(-1).expand(x.size(0)) for w in (alpha, beta, gamma)], 1)
    made = kernels.add_weighted(rows.flatten(1), as_rows(y)[0].flatten(1), weights)
    return from_rows(made.unflatten(1, rows.shape[1:]), x)
