"""Quotients and remainders of integers in ONNX.

torch.onnx divides integers in float32, where 16777217 is 16777216, and truncates quotients of negative sizes.
ONNX Runtime's own division of integers ends the process for a divisor of 0, and for the smallest integer
divided by -1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import onnx_ir
import torch
from torch.fx import Graph, Node

from ..internals import FLOOR_DIVISION, bounds_of, expression_of, limits_of_symbols
from .onnx_operators import op, torch_onnx

aten = torch.ops.aten


def quotient(self: Any, other: Any, rounding_mode: str | None = None) -> Any:
    """aten::div with a rounding mode."""
    if not self.dtype.is_integer() or rounding_mode is None:
        return torch_onnx.aten_div_mode(self, other, rounding_mode)
    return _floor(self, other) if rounding_mode == "floor" else _truncated(self, other)[0]


def floor_quotient(self: Any, other: Any) -> Any:
    """aten::floor_divide."""
    return _floor(self, other) if self.dtype.is_integer() else torch_onnx.aten_floor_divide(self, other)


def size_quotient(self: Any, other: Any) -> Any:
    """`a // b` of sizes; b is positive, a may be negative."""
    return op.Div(op.Sub(self, op.Mod(self, other)), other)


def natural_quotient(self: Any, other: Any) -> Any:
    """`a // b` of sizes, neither of which is negative."""
    if isinstance(self, int) and self == 1:
        # ONNX Runtime makes c / b of 1 / b * c, also of whole numbers.
        return op.Cast(op.Equal(other, op.Constant(value_int=1)), to=onnx_ir.DataType.INT64)
    return op.Div(self, other)


def limits_of(size: int | torch.SymInt) -> tuple[float, float]:
    """The smallest and the greatest value of a size."""
    if not isinstance(size, torch.SymInt):
        return size, size
    bounds = bounds_of(expression_of(size), limits_of_symbols(size))
    return float(bounds.lower), float(bounds.upper)


def mark_natural_quotients(graph: Graph) -> None:
    """Mark the quotients of sizes without negative numbers, by the sizes' limits, for the translation."""
    for node in graph.find_nodes(op="call_function", target=FLOOR_DIVISION):
        dividend = node.args[0].meta["val"] if isinstance(node.args[0], Node) else node.args[0]
        if limits_of(dividend)[0] >= 0:
            node.target = natural_quotient


def remainder(self: Any, other: Any) -> Any:
    """aten::remainder, which has the divisor's sign."""
    other = _operand(self, other)
    if not self.dtype.is_integer():
        return torch_onnx.aten_remainder(self, other)
    divisor, valid = _divisor(self, other)
    rest = op.Mod(self, divisor)
    return rest if valid is None else op.Add(rest, valid)


def rest_of_truncated(self: Any, other: Any) -> Any:
    """aten::fmod, which has the dividend's sign. ONNX Runtime computes Mod with fmod=1 in float64."""
    other = _operand(self, other)
    if not self.dtype.is_integer():
        return op.Mod(self, other, fmod=1)
    whole, divisor = _truncated(self, other)
    return op.Sub(self, op.Mul(whole, divisor))


def _floor(a: Any, b: Any) -> Any:
    whole, divisor = _truncated(a, b)
    if not a.dtype.is_signed():
        return whole
    rest = op.Sub(a, op.Mul(whole, divisor))
    zero = _number(a, 0)
    below = op.And(
        op.Not(op.Equal(rest, zero)), op.Not(op.Equal(op.Less(rest, zero), op.Less(divisor, zero)))
    )
    return op.Sub(whole, op.CastLike(below, a))


def _truncated(a: Any, b: Any) -> tuple[Any, Any]:
    """The quotient without its fraction, and the divisor as a value."""
    divisor, valid = _divisor(a, b)
    if valid is None:
        return op.Div(a, divisor), divisor
    b = _value(a, b)
    dividend = op.Where(op.Equal(b, _number(a, -1)), op.Neg(a), a) if a.dtype.is_signed() else a
    return op.Add(op.Div(dividend, divisor), valid), b


def _divisor(a: Any, b: Any) -> tuple[Any, Any]:
    """A divisor that is safe for ONNX Runtime, with 1 in place of 0 and -1; and a number to add to the
    result: 0, or the error of a Gather if a divisor is 0. A constant divisor without these stays, and needs
    no number."""
    constant: Any = b.const_value.numpy() if isinstance(b, onnx_ir.Value) and b.const_value is not None else b
    b = _value(a, b)
    if constant is not b and not np.isin(constant, (0, -1)).any():
        return b, None
    one, zero = _number(a, 1), _number(a, 0)
    none = op.Equal(b, zero)
    unsafe = op.Or(none, op.Equal(b, _number(a, -1))) if a.dtype.is_signed() else none
    index = op.ReduceMax(op.Cast(none, to=onnx_ir.DataType.INT64), keepdims=0)
    return op.Where(unsafe, one, b), op.CastLike(op.Gather(op.Constant(value_ints=[0]), index), a)


def _operand(like: Any, other: Any) -> Any:
    """A number or a size beside a tensor, in the tensor's dtype."""
    if isinstance(other, onnx_ir.Value):
        return other if other.dtype == like.dtype else op.CastLike(other, like)
    return other if like.dtype.is_integer() else op.Constant(value=onnx_ir.tensor(other, dtype=like.dtype))


def _value(like: Any, number: Any) -> Any:
    return number if isinstance(number, onnx_ir.Value) else _number(like, number)


def _number(like: Any, value: int) -> Any:
    return op.CastLike(op.Constant(value_int=value), like)


#: For torch.onnx.export: how operators are translated.
TRANSLATIONS: dict[Callable[..., Any], Callable[..., Any]] = {
    aten.div.Tensor_mode: quotient,
    aten.div.Scalar_mode: quotient,
    aten.floor_divide.default: floor_quotient,
    aten.remainder.Tensor: remainder,
    aten.remainder.Scalar: remainder,
    aten.fmod.Tensor: rest_of_truncated,
    aten.fmod.Scalar: rest_of_truncated,
    FLOOR_DIVISION: size_quotient,
    natural_quotient: natural_quotient,
}
