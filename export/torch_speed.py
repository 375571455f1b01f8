"""What PyTorch's exporters do slowly, put in its place while chiasm exports.

The first three were together more than half of an export's time, and change nothing in the results.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

import sympy
import torch
from torch.export import ExportedProgram


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
    """torch.onnx without reading its 1500 operator definitions at each export, and without tracing a graph again that has
    nothing in it to decompose. It may change the program that it is given."""
    from torch.onnx._internal.exporter import _fx_passes, _registration

    registry = _registry()
    with (
        fast_tracing(),
        patch.object(_registration.ONNXRegistry, "from_torchlib", staticmethod(lambda **_: registry)),
        patch.object(_fx_passes, "decompose_with_registry", _decomposed),
    ):
        yield


@contextmanager
def plain_minima() -> Iterator[None]:
    """Native float32 minima and maxima of one instruction. PyTorch's, which pass NaN on, take three, and networks of them are all
    that a median or a dilation does."""
    from torch._inductor.codegen.cpp import CppVecOverrides

    def plain(name: str) -> staticmethod:
        careful = getattr(CppVecOverrides, f"{name}imum")

        def code(a: Any, b: Any) -> str:
            if a.dtype == b.dtype == torch.float32:
                return f"decltype({a})(_mm256_{name}_ps({a}, {b}))"
            return careful(a, b)

        return staticmethod(code)

    with patch.object(CppVecOverrides, "minimum", plain("min")), patch.object(CppVecOverrides, "maximum", plain("max")):
        yield


@cache
def _registry() -> Any:
    from torch.onnx._internal.exporter import _registration

    return _registration.ONNXRegistry.from_torchlib()


@cache
def _known_and_decomposed(registry: Any) -> tuple[frozenset, dict]:
    """The operators that have an ONNX form, and those that are to be decomposed."""
    from torch.onnx._internal.exporter import _decomp

    known = frozenset(_decomp.get_onnx_implemented_overloads(registry))
    return known, _decomp.create_onnx_friendly_decomposition_table(set(known))


def _decomposed(program: ExportedProgram, registry: Any) -> ExportedProgram:
    known, table = _known_and_decomposed(registry)
    graph = program.graph_module.graph
    for node in list(graph.nodes):
        if node.target is torch.ops.aten.detach_.default:  # of a constant: there is nothing to detach from
            node.replace_all_uses_with(node.args[0])
            graph.erase_node(node)
    operators = {n.target for n in graph.nodes if n.op == "call_function" and isinstance(n.target, torch._ops.OpOverload)}
    if all(o in known and o not in table and not o._schema.is_mutable for o in operators):
        return program
    return program.run_decompositions(table)
