"""Three things that PyTorch's exporters do slowly for ops with symbolic sizes, put in their place while chiasm exports.

Together they were more than half of an export's time; the results are the same.
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
    operators = set()
    for module in program.graph_module.modules():  # the bodies of loops too
        for node in list(module.graph.nodes) if isinstance(module, torch.fx.GraphModule) else ():
            if node.target is torch.ops.aten.detach_.default:  # of a constant: there is nothing to detach from
                node.replace_all_uses_with(node.args[0])
                module.graph.erase_node(node)
            elif isinstance(node.target, torch._ops.OpOverload):
                operators.add(node.target)
    if all(o in known and o not in table and not o._schema.is_mutable for o in operators):
        return program
    return program.run_decompositions(table)
