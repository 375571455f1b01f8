# onnxscript's values have the operators of numbers, which its types do not say.
# pyright: reportArgumentType=false, reportReturnType=false, reportCallIssue=false
# pyright: reportAttributeAccessIssue=false
"""Shifts of bytes in ONNX: torch.onnx makes int8 of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import onnx_ir
import torch
from onnxscript import opset18 as op
from onnxscript.function_libs.torch_lib.ops import core

aten = torch.ops.aten


def _translation(direction: str, other_types: Callable, numbers: Callable) -> Callable:
    """aten::bitwise_right_shift or aten::bitwise_left_shift, by a tensor or by a number."""

    def shift(self: Any, other: Any) -> Any:
        by_tensor = isinstance(other, onnx_ir.Value)
        if self.dtype != onnx_ir.DataType.UINT8 or (by_tensor and other.dtype != onnx_ir.DataType.UINT8):
            return other_types(self, other) if by_tensor else numbers(self, other)
        zero = op.CastLike(op.Constant(value_int=0), self)
        if not by_tensor:
            # a byte has 8 bits: no shift is longer
            if not 0 <= other < 8:
                return op.Mul(self, zero)
            return op.BitShift(self, op.CastLike(op.Constant(value_int=other), self), direction=direction)
        last = op.CastLike(op.Constant(value_int=7), self)
        longer = op.Greater(other, last)
        return op.Where(longer, zero, op.BitShift(self, op.Where(longer, last, other), direction=direction))

    return shift


_right = _translation("RIGHT", core.aten_bitwise_right_shift, core.aten_bitwise_right_shift_tensor_scalar)
_left = _translation("LEFT", core.aten_bitwise_left_shift, core.aten_bitwise_left_shift_tensor_scalar)

#: For torch.onnx.export: how operators are translated.
SHIFTS: dict[Callable, Callable] = {
    aten.__rshift__.Scalar: _right,
    aten.__rshift__.Tensor: _right,
    aten.bitwise_right_shift.Tensor: _right,
    aten.bitwise_right_shift.Tensor_Scalar: _right,
    aten.__lshift__.Scalar: _left,
    aten.__lshift__.Tensor: _left,
    aten.bitwise_left_shift.Tensor: _left,
    aten.bitwise_left_shift.Tensor_Scalar: _left,
}
