"""Converts the settings that the constructors of augmentations take into the settings that the functions
take."""

import math
from enum import Enum
from numbers import Real
from typing import Any, Callable, List, Optional, Sequence, Tuple, Union

import numpy as np
import torch
from torch import Tensor

Reader = Callable[[str, Any], Any]
Numbers = Union[float, Sequence[float], Tensor]
WholeNumbers = Union[int, Sequence[int], Tensor]


def about(center: float, least: float, greatest: float) -> Reader:
    """A number x stands for ``center - x`` to ``center + x``, limited to [least, greatest]; two numbers are
    the range itself.

    >>> about(1.0, 0.0, 2.0)("brightness", 0.25)
    (0.75, 1.25)
    """

    def read(name: str, value: Numbers) -> Tuple[float, float]:
        found = numbers(name, value)
        if len(found) == 2 and found[0] <= found[1]:
            return found[0], found[1]
        if len(found) != 1:
            raise ValueError(f"{name}: expected a number, or a range (low, high), got {value}")
        if found[0] < 0.0:
            raise ValueError(f"{name}: expected a number that is not negative, got {value}")
        return float(max(center - found[0], least)), float(min(center + found[0], greatest))

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


def fixed(name: str, value: Numbers) -> Tuple[float, float]:
    """A number stands for itself as both bounds.

    >>> fixed("gain", 0.5)
    (0.5, 0.5)
    """
    found = numbers(name, value)
    if len(found) > 2:
        raise ValueError(f"{name}: expected a number, or two, got {value}")
    return found[0], found[-1]


def bits(name: str, value: WholeNumbers) -> Tuple[int, int]:
    """A number x stands for x to 8."""
    found = whole_numbers(name, value)
    return found[0], found[1] if len(found) == 2 else 8


def whole(name: str, value: WholeNumbers) -> Tuple[int, int]:
    """Two whole numbers; one stands for both.

    >>> whole("kernel_size", 3)
    (3, 3)
    """
    low, high = fixed(name, whole_numbers(name, value))
    return int(low), int(high)


def word(name: str, value: Union[str, Enum]) -> str:
    """A string, or the name of an enum member in lower case."""
    found = getattr(value, "name", value)
    if not isinstance(found, str):
        raise TypeError(f"{name}: expected a string, got {value!r}")
    return value if isinstance(value, str) else found.lower()


def vector(name: str, value: Numbers) -> Tensor:
    """One or several numbers as a tensor (N,)."""
    if isinstance(value, Tensor):
        return value.to(torch.float32).reshape(-1)
    return torch.tensor(numbers(name, value), dtype=torch.float32)


def plain(name: str, value: Any) -> Any:
    """The value itself."""
    return value


def number(name: str, value: float) -> float:
    """A number as a float, since TorchScript distinguishes it from a whole one."""
    found = numbers(name, value)
    if len(found) != 1:
        raise ValueError(f"{name}: expected a number, got {value}")
    return found[0]


def number_or_tensor(name: str, value: Union[float, Tensor]) -> Union[float, Tensor]:
    """A number, or a tensor of several as it is."""
    if isinstance(value, Tensor):
        return number(name, float(value)) if value.numel() == 1 else value
    return number(name, value)


def list_of_whole(name: str, value: Optional[WholeNumbers]) -> Optional[List[int]]:
    """One number or several as a list, None as None."""
    return None if value is None else whole_numbers(name, value)


def one_whole(name: str, value: int) -> int:
    """A whole number.

    >>> one_whole("n", 2.0)
    2
    """
    found = whole_numbers(name, value)
    if len(found) != 1:
        raise ValueError(f"{name}: expected a whole number, got {value}")
    return found[0]


def numbers(name: str, value: Any) -> List[float]:
    """One finite number or several.

    >>> numbers("size", (3, 4.5))
    [3.0, 4.5]
    """
    if isinstance(value, (Tensor, np.ndarray)):
        value = value.tolist()
    given = list(value) if isinstance(value, (list, tuple)) else [value]
    if not given or not all(isinstance(v, Real) or (isinstance(v, Tensor) and v.numel() == 1) for v in given):
        raise TypeError(f"{name}: expected a number, or several, got {value!r}")
    found = [float(v) for v in given]
    if not all(math.isfinite(v) for v in found):
        raise ValueError(f"{name}: expected finite numbers, got {value}")
    return found


def whole_numbers(name: str, value: Any) -> List[int]:
    """One whole number or several."""
    found = numbers(name, value)
    if any(n != int(n) for n in found):
        raise ValueError(f"{name}: expected whole numbers, got {value}")
    return [int(n) for n in found]
