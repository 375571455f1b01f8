"""Numbers in float64 graphs: torch.onnx writes every Python number as float32 and casts it, so that 1 / 3
becomes 0.33333334 and 1e-300 becomes 0. The operators below make tensors of numbers in the wanted dtype."""

from __future__ import annotations

from typing import Any

import torch
from onnxscript import ir

from ..formats.onnx_operators import op


def _number(value: Any, dtype: int) -> Any:
    """A number as a constant of that dtype; a computed size, which is already a tensor, is cast."""
    if isinstance(value, (bool, int, float)):
        return op.Constant(value=ir.tensor(value, dtype=ir.DataType(dtype)))
    return op.Cast(value, to=dtype)


def _scalar_tensor(
    s: Any, dtype: int = ir.DataType.FLOAT, layout: str = "", device: str = "", pin_memory: bool = False
) -> Any:
    return _number(s, ir.DataType.FLOAT if dtype == -1 else dtype)


def _full(
    size: Any, fill_value: Any, dtype: int = -1, layout: str = "", device: str = "", pin_memory: bool = False
) -> Any:
    value = fill_value if dtype == -1 else _number(fill_value, dtype)
    return op.Expand(value, op.Cast(size, to=ir.DataType.INT64))


def _full_like(
    self: Any,
    fill_value: Any,
    dtype: int = -1,
    layout: str = "",
    device: str = "",
    pin_memory: bool = False,
    memory_format: str = "",
) -> Any:
    return op.Expand(_number(fill_value, self.dtype if dtype == -1 else dtype), op.Shape(self))


def register(registry: Any) -> None:
    """Put them into torch.onnx's registry, before its own."""
    registry.register_op(torch.ops.aten.scalar_tensor.default, _scalar_tensor)
    registry.register_op(torch.ops.aten.full.default, _full)
    registry.register_op(torch.ops.aten.full_like.default, _full_like)
