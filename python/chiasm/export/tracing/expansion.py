# torch declares a node's argument as a union of all possible types.
# pyright: reportArgumentType=false, reportCallIssue=false, reportReturnType=false
"""Expands operators of a graph into others, in place."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from typing import Any, cast

import torch
from torch._dispatch.python import enable_python_dispatcher
from torch._guards import detect_fake_mode
from torch.export import ExportedProgram
from torch.fx import Graph, GraphModule, Node
from torch.fx.experimental.proxy_tensor import make_fx

from ..internals import expression_of, is_operator, schema_of


def expand_all(program: ExportedProgram, forms: Mapping[Any, Callable[..., torch.Tensor]]) -> None:
    """Replace these operators in a program by what the functions do."""
    for module in list(program.graph_module.modules()):
        if not isinstance(module, GraphModule):
            continue
        for node in list(module.graph.nodes):
            if node.target in forms:
                replace(node, expand(node, {}, {}, forms[node.target]), program)
        module.recompile()


def expand(
    node: Node,
    table: dict[Any, Any],
    sizes: dict[Any, Node],
    form: Callable[..., Any] | None = None,
) -> Node | Sequence[Node | None]:
    """Insert the nodes of an operator's decomposition before it: that of the table, or a `form` of the
    operator. Returns the node of the result, or the nodes of the results."""
    arguments = node.all_input_nodes
    values = [n.meta["val"] for n in arguments]
    # make_fx looks up no decomposition for this operator
    elements = _elements if node.target is torch.ops.aten.sym_numel.default else None
    operator = cast("Callable[..., Any]", form or elements or node.target)

    def call(*given: Any) -> Any:
        args, kwargs = torch.fx.map_arg(
            (node.args, node.kwargs), dict(zip(arguments, given, strict=True)).__getitem__
        )
        return operator(*args, **kwargs)

    with detect_fake_mode([*values, node.meta["val"]]) or nullcontext(), enable_python_dispatcher():
        body = make_fx(call, decomposition_table=table)(*values).graph
    _make_functional(body)
    copies = dict(zip(body.find_nodes(op="placeholder"), arguments, strict=True))
    with node.graph.inserting_before(node):
        for inner in body.nodes:
            if inner.op != "call_function":
                continue
            value = inner.meta.get("val")  # an assertion has none
            size = expression_of(value) if isinstance(value, torch.SymInt) else None
            if size in sizes:
                copies[inner] = sizes[size]
                continue
            copy = node.graph.node_copy(inner, copies.__getitem__)
            copy.meta = node.meta | {"val": value}
            if copy.target is torch.ops.aten.sym_numel.default:
                product = expand(copy, table, sizes)
                node.graph.erase_node(copy)
                copy = product
            if size is not None:
                sizes[size] = copy
            copies[inner] = copy
    return torch.fx.map_arg(body.output_node().args[0], copies.__getitem__)


def replace(node: Node, other: Node, program: ExportedProgram) -> None:
    """Use another node in place of a node, which is removed."""
    node.replace_all_uses_with(other)
    if node.graph is program.graph:
        program.graph_signature.replace_all_uses(node.name, other.name)  # the signature names the outputs
    node.graph.erase_node(node)


def replace_results(node: Node, made: Sequence[Node | None], program: ExportedProgram) -> None:
    """The same for an operator with several results, each of which is a getitem node."""
    for taken in list(node.users):
        if taken.users:
            replace(taken, cast("Node", made[taken.args[1]]), program)
        else:  # an unused result may be missing
            node.graph.erase_node(taken)
    node.graph.erase_node(node)


def _make_functional(body: Graph) -> None:
    """`x.copy_(y)` is y, if x was computed in the body and nothing reads x or a part of it afterwards."""
    for copy in body.find_nodes(op="call_function", target=torch.ops.aten.copy_.default):
        written, value = copy.args[:2]
        users = list(written.users)
        alike = all(
            getattr(written.meta["val"], a) == getattr(value.meta["val"], a) for a in ("shape", "dtype")
        )
        if alike and users[-1] is copy and all(map(is_fresh, (written, *users[:-1]))):
            copy.replace_all_uses_with(value)
            body.erase_node(copy)


def is_fresh(node: Node) -> bool:
    """Whether the node's value cannot be another value or a part of one."""
    return is_operator(node.target) and not any(r.alias_info for r in schema_of(node.target).returns)


def _elements(tensor: torch.Tensor) -> int | torch.SymInt:
    return math.prod(tensor.shape)
