"""Converts the settings that the constructors of augmentations take into the settings that the functions
take."""

import math
from typing import Any, Callable, List, Sequence, Tuple, Union

import torch
from torch import Tensor

Reader = Callable[[str, Any], Any]


def about(center: float, least: float, greatest: float) -> Reader:
    """A number x stands for ``center - x`` to ``center + x``, limited to [least, greatest]; two numbers are
    the range itself.

    >>> about(1.0, 0.0, 2.0)("brightness", 0.25)
    (0.75, 1.25)
    """

    def read(name: str, value: Any) -> Tuple[float, float]:
        numbers = _numbers(name, value)
        if len(numbers) == 2 and numbers[0] <= numbers[1]:
            return numbers[0], numbers[1]
        if len(numbers) != 1:
            raise ValueError(f"{name}: expected a number, or a range (low, high), got {value}")
        if numbers[0] < 0.0:
            raise ValueError(f"{name}: expected a number that is not negative, got {value}")
        return float(max(center - numbers[0], least)), float(min(center + numbers[0], greatest))

    return read


#: A number x stands for the range [-x, x].
symmetric = about(0.0, -math.inf, math.inf)


def ranges(name: str, value: Any, count: int) -> List[Tuple[float, float]]:
    """``count`` ranges, from a number or (least, greatest) for all, or from a number or a range for each.

    >>> ranges("degrees", (1.0, 2.0, 3.0), 3)
    [(-1.0, 1.0), (-2.0, 2.0), (-3.0, 3.0)]
    """
    if isinstance(value, Tensor):
        value = value.tolist()
    if isinstance(value, (list, tuple)) and len(value) == count:
        return [symmetric(name, each) for each in value]
    return [symmetric(name, value)] * count


def fixed(name: str, value: Any) -> Tuple[float, float]:
    """A number stands for itself as both bounds.

    >>> fixed("gain", 0.5)
    (0.5, 0.5)
    """
    numbers = _numbers(name, value)
    return numbers[0], numbers[-1]


def bits(name: str, value: Any) -> Tuple[int, int]:
    """A number x stands for x to 8."""
    numbers = _numbers(name, value)
    return int(numbers[0]), int(numbers[1]) if len(numbers) == 2 else 8


def whole(name: str, value: Any) -> Tuple[int, int]:
    """Two whole numbers; one stands for both.

    >>> whole("kernel_size", 3)
    (3, 3)
    """
    low, high = fixed(name, value)
    if low != int(low) or high != int(high):
        raise ValueError(f"{name}: expected whole numbers, got {value}")
    return int(low), int(high)


def word(name: str, value: Any) -> str:
    """A string, or the name of an enum member in lower case."""
    return value if isinstance(value, str) else str(value.name).lower()


def vector(name: str, value: Union[float, Sequence[float], Tensor]) -> Tensor:
    """One or several numbers as a tensor (N,)."""
    return torch.as_tensor(value, dtype=torch.float32).reshape(-1)


def plain(name: str, value: Any) -> Any:
    """The value itself."""
    return value


def number(name: str, value: Any) -> Any:
    """A whole number as a float, since TorchScript distinguishes the two types."""
    return float(value) if isinstance(value, int) else value


def list_of_whole(name: str, value: Any) -> Any:
    """One number or several as a list, None as None."""
    return None if value is None else [int(n) for n in _numbers(name, value)]


def _numbers(name: str, value: Any) -> List[float]:
    """One number or several."""
    if isinstance(value, Tensor):
        value = value.tolist()
    found = [float(v) for v in value] if isinstance(value, (list, tuple)) else [float(value)]
    if any(math.isnan(v) for v in found):
        raise ValueError(f"{name}: expected numbers, got {value}")
    return found
