"""Pixels of whole numbers: bytes and 16 bits. Engines lack operations of these types, which are done in int32
and brought back."""

from typing import Tuple

import torch
from torch import Tensor


def narrow(x: Tensor, *_: object) -> bool:
    """Whether x is of whole numbers of 8 or 16 bits. Only lowerings ask."""
    return x.dtype in (torch.uint8, torch.int16, torch.uint16)


def ordered(x: Tensor) -> Tensor:
    """x in a type of which PyTorch has minima and maxima."""
    return x.to(torch.int32) if x.dtype == torch.uint16 else x


def pixel_range(x: Tensor) -> Tuple[int, int]:
    """The least and the largest number of x's type, of 8 or 16 bits.

    >>> pixel_range(torch.zeros(1, dtype=torch.int16))
    (-32768, 32767)
    """
    if x.dtype == torch.uint8:
        return 0, 255
    return (0, 65535) if x.dtype == torch.uint16 else (-32768, 32767)


def check_pixel_value(value: float, like: Tensor, name: str) -> None:
    """Raise ValueError unless the type of the pixels of ``like`` has the number ``value``; floating-point
    types have all."""
    if like.is_floating_point():
        return
    least, largest = pixel_range(like)
    if value < least or value > largest or value != round(value):
        raise ValueError(f"{name}: expected a number of dtype {like.dtype}, got {value}")


def saturated(value: Tensor, like: Tensor) -> Tensor:
    """int32 as the pixels of ``like``, the nearest that their type has.

    >>> saturated(torch.tensor([-3, 4, 300]), torch.zeros(1, dtype=torch.uint8))
    tensor([  0,   4, 255], dtype=torch.uint8)
    """
    low, high = pixel_range(like)
    return value.clamp(low, high).to(like.dtype)


def difference(high: Tensor, low: Tensor) -> Tensor:
    """high - low, of whole numbers the nearest that their type has.

    >>> difference(torch.tensor([5, 2], dtype=torch.uint8), torch.tensor([2, 5], dtype=torch.uint8))
    tensor([3, 0], dtype=torch.uint8)
    """
    if high.is_floating_point():
        return high - low
    # In float32, which holds both: compiled loops have twice the lanes that int64 constants leave them.
    least, largest = pixel_range(high)
    return (high.to(torch.float32) - low.to(torch.float32)).clamp(least, largest).to(high.dtype)
