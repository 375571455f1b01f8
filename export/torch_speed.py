"""What PyTorch's exporters do slowly for ops with symbolic sizes, put in its place while chiasm exports.

Together it was three quarters of an export's time; the results are the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

import sympy
import torch

from . import onnx_numbers
from .decomposition import decomposed


class _Sympy:
    """sympy, but for `simplify`: Inductor calls it to see whether an index is linear in a loop's variable, for which expanding
    does as well, in a fraction of the time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sympy, name)

    @staticmethod
    def simplify(expression: Any) -> sympy.Expr:
        return sympy.expand(expression)


@contextmanager
def fast_inductor() -> Iterator[None]:
    """AOTInductor without `sympy.simplify`."""
    from torch._inductor import sizevars

    with patch.object(sizevars, "sympy", _Sympy()):
        yield


@contextmanager
def fast_tracing() -> Iterator[None]:
    """Fake tensors without their cache: with symbolic sizes a hit costs more than computing the result's metadata again."""
    import torch._dynamo.config

    with torch._dynamo.config.patch(fake_tensor_cache_enabled=False):
        yield


@contextmanager
def fast_onnx() -> Iterator[None]:
    """torch.onnx without reading its 1500 operator definitions at each export, and without running the whole graph again: to decompose
    a few operators, and to see which types are to be promoted. It may change the program that it is given."""
    from torch.onnx._internal.exporter import _fx_passes, _registration
    from torch.onnx._internal.fx.passes import type_promotion

    registry = _registry()
    with (
        fast_tracing(),
        patch.object(_registration.ONNXRegistry, "from_torchlib", staticmethod(lambda **_: registry)),
        patch.object(_fx_passes, "decompose_with_registry", decomposed),
        patch.object(type_promotion._TypePromotionInterpreter, "run_node", _promoted),
    ):
        yield


@cache
def _registry() -> Any:
    from torch.onnx._internal.exporter import _registration

    registry = _registration.ONNXRegistry.from_torchlib()
    onnx_numbers.register(registry)
    return registry


def _promoted(interpreter: Any, node: torch.fx.Node) -> Any:
    """A node's value, once its arguments are of the types that it promotes them to. The value that tracing left with the node holds
    still, since a promoted node is followed by a cast where its type would change."""
    from torch.onnx._internal.fx.passes import type_promotion

    if node.op != "call_function" or "val" not in node.meta:
        return torch.fx.Interpreter.run_node(interpreter, node)
    with interpreter._set_current_node(node):
        if rule := type_promotion.get_type_promotion_rule(node, interpreter.type_promotion_table):
            interpreter._maybe_promote_node(node, rule)
    return node.meta["val"]
