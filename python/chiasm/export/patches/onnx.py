"""torch.onnx, faster and with exact constants."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from typing import Any

import torch

from . import onnx_numbers, replaced
from .onnx_decomposition import decomposed
from .tracing import fast_tracing

#: Operators whose ONNX forms count negative classes from the end, and ignore `label_smoothing`.
_BETTER_DECOMPOSED = ("aten::cross_entropy_loss", "aten::nll_loss", "aten::nll_loss_forward")


@contextmanager
def fast_onnx() -> Generator[None]:
    """torch.onnx without reading its 1500 operator definitions at each export, and without running the whole
    graph again to decompose a few operators and to find the type promotions. It changes the given program."""
    registry = _registry()

    def the_registry(**_: Any) -> Any:
        return registry

    with (
        fast_tracing(),
        replaced(
            {
                "torch.onnx._internal.exporter._registration:ONNXRegistry.from_torchlib": staticmethod(
                    the_registry
                ),
                "torch.onnx._internal.exporter._fx_passes:decompose_with_registry": decomposed,
                "torch.onnx._internal.fx.passes.type_promotion:_TypePromotionInterpreter.run_node": _promoted,
            }
        ),
    ):
        yield


@cache
def _registry() -> Any:
    from torch.onnx._internal.exporter import _registration

    # torch.onnx parses the source text of 600 functions only to find a domain that nobody uses. The opset's
    # own domain is used instead.
    with replaced(
        {"onnxscript.values:TracedOnnxFunction.function_ir": property(lambda function: function.opset)}
    ):
        registry: Any = _registration.ONNXRegistry.from_torchlib()
    onnx_numbers.register(registry)
    for operator in _BETTER_DECOMPOSED:
        registry.functions.pop(operator)
    return registry


def _promoted(interpreter: Any, node: torch.fx.Node) -> Any:
    """A node's value after its arguments were promoted. The value from tracing is still valid, because a cast
    follows a promoted node whose type would change."""
    from torch.onnx._internal.fx.passes import type_promotion

    if node.op != "call_function" or "val" not in node.meta:
        return torch.fx.Interpreter.run_node(interpreter, node)
    with interpreter._set_current_node(node):
        if rule := type_promotion.get_type_promotion_rule(node, interpreter.type_promotion_table):
            interpreter._maybe_promote_node(node, rule)
    return node.meta["val"]
