"""Truncated quotients of integers in eager Python, where the smallest integer divided by -1 ends the process.

An op is tried with the values that its spec's `make_inputs` makes, which must not end the export.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode

aten = torch.ops.aten


def rounded_to_zero(a: Tensor, b: Tensor, below: Tensor) -> Tensor:
    """The truncated quotient of integers, from the one that is rounded down: `below`, which has the result's
    dtype. The smallest integer divided by -1 is itself, as in compiled code."""
    inexact = below * b.to(below.dtype) != a.to(below.dtype)
    return below + ((below < 0) & inexact).to(below.dtype)


class SafeQuotients(TorchFunctionMode):
    """Inside it, eager Python's truncated quotients of integers end no process."""

    def __torch_function__(
        self, func: Any, types: Any, args: tuple[Any, ...] = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        kwargs = kwargs or {}
        return safe(func, kwargs)(*args, **kwargs)


def safe(function: Any, kwargs: Mapping[str, Any]) -> Callable[..., Any]:
    """What to call in place of a function of torch, or an operator, with these arguments."""
    return _FORMS.get(function, function) if kwargs.get("rounding_mode") == "trunc" else function


def _quotient(input: Any, other: Any, *, rounding_mode: str, out: Tensor | None = None) -> Tensor:
    if _is_floating(input) or _is_floating(other):
        return torch.div(input, other, rounding_mode=rounding_mode, out=out)
    below = torch.div(input, other, rounding_mode="floor")
    result = rounded_to_zero(torch.as_tensor(input), torch.as_tensor(other), below)
    return result if out is None else torch.mul(result, 1, out=out)


def _in_place(input: Tensor, other: Any, *, rounding_mode: str) -> Tensor:
    if _is_floating(input) or _is_floating(other):
        return input.div_(other, rounding_mode=rounding_mode)
    return input.copy_(_quotient(input, other, rounding_mode=rounding_mode))


def _is_floating(value: Any) -> bool:
    return torch.is_floating_point(value) if isinstance(value, Tensor) else isinstance(value, float)


#: What is called with rounding_mode="trunc": functions in Python, and operators of a traced graph.
_FORMS: dict[Any, Any] = {
    torch.div: _quotient,
    aten.div.Tensor_mode: _quotient,
    aten.div.Scalar_mode: _quotient,
    aten.div_.Tensor_mode: _in_place,
    aten.div_.Scalar_mode: _in_place,
    torch.divide: _quotient,
    Tensor.div: _quotient,
    Tensor.divide: _quotient,
    Tensor.div_: _in_place,
    Tensor.divide_: _in_place,
}
