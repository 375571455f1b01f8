# torch's tables of decompositions, and the kinds of operators, are private.
# pyright: reportPrivateUsage=false
"""Decomposes operators without an ONNX form, in place.

`ExportedProgram.run_decompositions` traces the whole graph again, which takes longer than all the rest of the
conversion; only a few nodes need decomposition. The resulting graph is the same.
"""

from __future__ import annotations

from functools import cache
from typing import Any, cast

import torch
from torch._export.utils import _is_cia_op, _is_preservable_cia_op
from torch.export import ExportedProgram
from torch.fx import Graph, GraphModule, Node

from ..formats.onnx_division import mark_natural_quotients
from ..formats.onnx_indices import check_indices
from ..formats.onnx_sums import split_sums
from ..internals import Operator, expression_of, is_operator, run_decompositions, schema_of
from ..tracing.expansion import expand, is_fresh, replace, replace_results


def decomposed(program: ExportedProgram, registry: Any) -> ExportedProgram:
    """The program in operators that have an ONNX form, as far as possible. It changes the given program."""
    table = _table(registry)
    check_indices(program)
    checked = {n for m in program.graph_module.modules() if isinstance(m, GraphModule) for n in m.graph.nodes}
    functional = [
        _decompose_graph(m.graph, table, program)
        for m in list(program.graph_module.modules())
        if isinstance(m, GraphModule)
    ]
    program = program if all(functional) else run_decompositions(program, table)
    check_indices(program, checked)
    split_sums(program)
    for module in program.graph_module.modules():
        if isinstance(module, GraphModule):
            mark_natural_quotients(module.graph)
    return program


@cache
def _table(registry: Any) -> dict[Any, Any]:
    """Decompositions of the operators that have no ONNX form."""
    from torch.onnx._internal.exporter import _decomp

    tables = cast("Any", _decomp)
    return tables.create_onnx_friendly_decomposition_table(
        set(tables.get_onnx_implemented_overloads(registry))
    )


def _decompose_graph(graph: Graph, table: dict[Any, Any], program: ExportedProgram) -> bool:
    """Decompose the nodes of a graph: the program's, or that of a loop's body. False if a node that writes to
    its argument is left."""
    functional = True
    # The first node that computes each symbolic size: tracing again would not compute it again
    sizes: dict[Any, Node] = {}
    for node in list(graph.nodes):
        value = node.meta.get("val")
        first = sizes.setdefault(expression_of(value), node) if isinstance(value, torch.SymInt) else node
        if first is not node and node.op == "call_function":
            replace(node, first, program)
        elif node.target is torch.ops.aten._assert_tensor_metadata.default:
            graph.erase_node(node)
        elif node.target is torch.ops.aten.detach_.default:  # of a constant, which has nothing to detach from
            replace(node, node.args[0], program)
        elif is_operator(node.target):
            if schema_of(node.target).is_mutable and not _make_functional(node):
                functional = False
            elif (
                node.target in table
                or node.target is torch.ops.aten.sym_numel.default
                or _is_composite_view(node.target)
            ):
                if isinstance(value, torch.SymInt):
                    del sizes[expression_of(value)]  # the node is removed
                made = expand(node, table, sizes)
                if isinstance(made, Node):
                    replace(node, made, program)
                else:
                    replace_results(node, made, program)
    return functional


@cache
def _is_composite_view(operator: Operator) -> bool:
    """Whether the operator is composite and may return its argument: `run_decompositions` decomposes all of
    those, even if they have an ONNX form. That of `reshape` would read a size of 0 as the argument's size."""
    return _is_cia_op(operator) and not _is_preservable_cia_op(operator)


def _make_functional(node: Node) -> bool:
    """Whether the node writes to a value that no other node uses. If so, it is changed to return a new value
    instead.

    Gradients have many: `(a > 0).logical_and_(b)`.
    """
    written, operator = node.args[0], node.target
    assert is_operator(operator)
    packet = getattr(torch.ops.aten, schema_of(operator).name.removeprefix("aten::").removesuffix("_"), None)
    if not isinstance(written, Node) or not is_fresh(written) or len(written.users) > 1:
        return False
    if not hasattr(packet, operator._overloadname):
        return False
    node.target = getattr(packet, operator._overloadname)
    return True
