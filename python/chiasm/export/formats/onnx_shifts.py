"""Shifts of whole numbers in ONNX, as in PyTorch: torch.onnx makes int8 of bytes, a BitShift of 16 bits that
no engine has, and shifts by as many bits as a number has, or more, which ONNX does not define."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import onnx_ir
import torch
from onnx_ir import DataType

from .onnx_operators import op

aten = torch.ops.aten


def _translation(direction: str) -> Callable[..., Any]:
    """aten::bitwise_right_shift or aten::bitwise_left_shift, by a tensor or by a number."""

    def shift(self: Any, other: Any) -> Any:
        by_tensor = isinstance(other, onnx_ir.Value)
        own: Any = self.dtype if self.dtype is not None or not by_tensor else other.dtype
        # BitShift has uint32 and uint64 in every engine
        signed, unsigned = (
            (DataType.INT64, DataType.UINT64) if own.bitwidth == 64 else (DataType.INT32, DataType.UINT32)
        )
        zero = op.Constant(value=onnx_ir.tensor(0, dtype=signed))
        bits = op.Constant(value=onnx_ir.tensor(own.bitwidth, dtype=signed))
        if by_tensor:
            distance = op.Cast(other, to=signed)
            inside = op.And(op.Less(distance, bits), op.Not(op.Less(distance, zero)))
            distance = op.Where(inside, distance, zero)
        else:
            inside = op.Constant(value=onnx_ir.tensor(0 <= other < own.bitwidth))
            distance = op.Constant(
                value=onnx_ir.tensor(other if 0 <= other < own.bitwidth else 0, dtype=signed)
            )
        value = op.Cast(self, to=signed)
        # To the right, a negative number x is shifted as the complement of ~x, which has a sign bit of 0.
        complement = direction == "RIGHT" and own.is_signed()
        negative = op.Less(value, zero)
        if complement:
            value = op.Where(negative, op.BitwiseNot(value), value)
        shifted = op.BitShift(
            op.Cast(value, to=unsigned), op.Cast(distance, to=unsigned), direction=direction
        )
        result = op.Where(inside, op.Cast(shifted, to=signed), zero)
        if complement:
            result = op.Where(negative, op.BitwiseNot(result), result)
        return op.Cast(result, to=own)

    return shift


_right = _translation("RIGHT")
_left = _translation("LEFT")

#: For torch.onnx.export: how operators are translated.
SHIFTS: dict[Callable[..., Any], Callable[..., Any]] = {
    aten.__rshift__.Scalar: _right,
    aten.__rshift__.Tensor: _right,
    aten.bitwise_right_shift.Tensor: _right,
    aten.bitwise_right_shift.Tensor_Scalar: _right,
    aten.__lshift__.Scalar: _left,
    aten.__lshift__.Tensor: _left,
    aten.bitwise_left_shift.Tensor: _left,
    aten.bitwise_left_shift.Tensor_Scalar: _left,
}
