"""The operators that translations to ONNX are made of, without types: onnxscript declares arguments by ONNX's
types and results by unions of them; but Python's numbers will do, and values have attributes of their own."""

from __future__ import annotations

from typing import Any

from onnxscript import opset18
from onnxscript.function_libs.torch_lib.ops import core  # pyright: ignore[reportMissingTypeStubs]

#: ONNX's own, of opset 18.
op: Any = opset18
#: torch.onnx's translations of PyTorch's operators.
torch_onnx: Any = core
