"""Selections in forms whose indices native code checks (patches/index_checks.py).

For a selection by a number from data, `x[i.item()]`, AOTInductor computes the address without a check; `x[i]`
with a tensor is checked. `index_select`, `index_add` and `index_copy` reject negative indices, but
AOTInductor converts them to an indexing that accepts some; `gather` and `scatter` reject them there too.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any, cast

import torch
from torch import Tensor
from torch._guards import detect_fake_mode
from torch.export import ExportedProgram
from torch.fx import Node
from torch.fx.experimental.symbolic_shapes import free_unbacked_symbols

from ..errors import ExportError
from ..internals import is_operator, run_decompositions, schema_of
from ..tracing.expansion import expand_all

aten = torch.ops.aten
_ITEMS = (aten.item.default, aten._local_scalar_dense.default)


def select_by_tensors(program: ExportedProgram, name: str) -> ExportedProgram:
    """The program with selections by tensors; it may be the given program, changed.

    Raises:
        ExportError: data decide about strides, which no check can follow.
    """
    if not any(n.target in _ITEMS for n in program.graph.nodes):
        return program
    operators = [n.target for n in program.graph.nodes if is_operator(n.target)]
    if any(schema_of(operator).is_mutable for operator in operators):
        program = run_decompositions(program, {})  # a selection that is written to is a view until then
    graph = program.graph
    for node in list(graph.nodes):
        if node.target is aten.select.int and _is_from_data(node.args[2]):
            x, dim, index = node.args
            operator, rest = aten.index.Tensor, ()
        elif node.target is aten.select_scatter.default and _is_from_data(node.args[3]):
            x, source, dim, index = node.args
            operator, rest = aten.index_put.default, (source,)
        elif node.target is aten.as_strided.default and any(map(_is_from_data, _flat(node.args[1:]))):
            raise ExportError(
                f"{name}: cannot be exported to native code\n"
                "  operator aten.as_strided\n"
                "  because: data decide where it reads, and native code has no check for that\n"
                "  instead: index by a tensor (x[i], torch.gather), whose values are checked"
            )
        else:
            continue
        with graph.inserting_before(node):
            axes = [None] * (dim % x.meta["val"].dim())
            picked = graph.call_function(operator, (x, [*axes, _as_tensor(index)], *rest))
        picked.meta = {"val": node.meta["val"], "original_aten": node.target}
        node.replace_all_uses_with(picked)
        program.graph_signature.replace_all_uses(node.name, picked.name)
        graph.erase_node(node)
    for node in reversed(list(graph.nodes)):
        if node.target in _ITEMS and not node.users:
            graph.erase_node(node)
    program.graph_module.recompile()
    return program


def refuse_negative(program: ExportedProgram) -> ExportedProgram:
    """The program in which operators that reject negative indices have a form that also rejects them in
    native code; it may be the given program, changed."""
    if any(n.target in _IN_PLACE for n in program.graph.nodes):
        program = run_decompositions(program, {})
    expand_all(program, _REFUSING)
    return program


def _index_select(x: Tensor, dim: int, index: Tensor) -> Tensor:
    shape = [*x.shape]
    shape[dim] = index.numel()
    return x.gather(dim, _along(index, dim, shape))


def _index_add(x: Tensor, dim: int, index: Tensor, source: Tensor, *, alpha: float = 1) -> Tensor:
    source = source if alpha == 1 else source * alpha
    return x.scatter_add(dim, _along(index, dim, source.shape), source)


def _index_copy(x: Tensor, dim: int, index: Tensor, source: Tensor) -> Tensor:
    return x.scatter(dim, _along(index, dim, source.shape), source)


def _along(index: Tensor, dim: int, shape: Sequence[int]) -> Tensor:
    rest = len(shape) - 1 - dim % len(shape)
    return index.to(torch.int64).reshape([-1, *[1] * rest]).expand(shape)


_REFUSING = {
    aten.index_select.default: _index_select,
    aten.index_add.default: _index_add,
    aten.index_copy.default: _index_copy,
}
_IN_PLACE = (aten.index_add_.default, aten.index_copy_.default)


def _is_from_data(argument: Any) -> bool:
    if not isinstance(argument, Node):
        return False
    value = argument.meta.get("val")
    return argument.target in _ITEMS or (
        isinstance(value, torch.SymInt) and bool(free_unbacked_symbols(value))
    )


def _as_tensor(index: Node) -> Node:
    if index.target in _ITEMS:
        return index.args[0]  # pyright: ignore[reportReturnType]
    made = index.graph.call_function(aten.scalar_tensor.default, (index,), {"dtype": torch.int64})
    mode = detect_fake_mode([n.meta.get("val") for n in index.graph.nodes])
    with mode or nullcontext():
        made.meta["val"] = torch.empty((), dtype=torch.int64)
    return made


def _flat(arguments: Sequence[Any]) -> list[Any]:
    flat: list[Any] = []
    for part in arguments:
        flat += cast("Sequence[Any]", part) if isinstance(part, (list, tuple)) else [part]
    return flat
