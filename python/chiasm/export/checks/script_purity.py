# TorchScript's graphs are in a private module of torch, and passes over them without types.
# pyright: reportPrivateUsage=false, reportUnknownMemberType=false
"""The checks of purity.py on TorchScript, which has the branches that depend on data and that a single run
does not take.

Each value of the graph is traced back to the origin of its memory: an input, a state of the module, or the
operator that allocated it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import torch

from ..errors import quoted_line
from .purity import MARKERS, draw_error, impure, is_random, write_error

_STATE = "a state of the module"
#: If one of these arguments is this constant, an operator draws no random numbers.
_QUIET = {"train": False, "training": False, "p": 0.0, "dropout": 0.0, "dropout_p": 0.0}


def check_script(name: str, scripted: torch.jit.ScriptModule, dtypes: Mapping[str, tuple[str, ...]]) -> None:
    """Reject a scripted op that writes into an input or a state, draws random numbers or prints, in any
    branch.

    `dtypes` are those that each input may have: `to` another dtype is a copy.
    """
    graph = _graph(scripted)
    nodes = list(_nodes(graph))
    origins = _origins(graph, nodes, dtypes)
    for node in nodes:
        where = quoted_line(str(node.sourceRange()))
        if node.kind() == "prim::SetAttr" and next(node.inputs()).node().kind() != "prim::CreateObject":
            # An attribute of an object that the op creates, such as torch.no_grad(), is not a state
            inputs = (quoted_line(str(v.node().sourceRange())) for v in node.inputs())
            raise impure(
                name,
                f"it changes its attribute {node.s('name')!r}",
                where or next(filter(None, inputs), None),
                None,
                "instead: make the state an input and an output of the op",
            )
        if node.kind() == "prim::Print":
            raise impure(
                name,
                "it prints, which TorchScript would do at every call and the other formats never",
                where,
                None,
                "instead: remove the print",
            )
        schema = _schema(node)
        if schema is None or node.kind() in MARKERS:
            continue
        for argument, value in zip(schema.arguments, node.inputs()):
            elements = str(value.type()) == "Tensor" or node.kind().startswith("aten::_foreach")
            if (
                argument.alias_info is not None
                and argument.alias_info.is_write
                and elements
                and (found := origins[value.debugName()])
            ):
                target = min(found)
                raise write_error(name, None if target == _STATE else target, where, _spelled(node))
        if _is_random(node, schema):
            raise draw_error(name, where, _spelled(node))


def _graph(scripted: torch.jit.ScriptModule) -> torch._C.Graph:
    """The op's graph without calls, and without the branches of training."""
    try:
        graph = torch.jit.freeze(scripted, optimize_numerics=False).graph
    except RuntimeError:  # a module that cannot be frozen is read as it is, with both branches
        graph = scripted.inlined_graph
    graph = graph.copy()
    torch._C._jit_pass_inline(graph)
    return graph


def _nodes(block: Any) -> Iterator[torch._C.Node]:
    for node in block.nodes():
        yield node
        for inner in node.blocks():
            yield from _nodes(inner)


def _schema(node: torch._C.Node) -> Any:
    text = node.schema()
    return None if text == "(no schema)" else torch._C.parse_schema(text)


def _spelled(node: torch._C.Node) -> str:
    return node.kind().replace("::", ".")


def _origins(
    graph: Any, nodes: list[torch._C.Node], dtypes: Mapping[str, tuple[str, ...]]
) -> Mapping[str, set[str]]:
    """From the names of values to the inputs, or the state, whose memory they may share."""
    origins: dict[str, set[str]] = defaultdict(set)
    for value, key in zip(list(graph.inputs())[1:], dtypes, strict=True):
        origins[value.debugName()] = {key}
    schemas = [_schema(node) for node in nodes]
    size = -1
    # Repeat until nothing is added: values pass through loops
    while size != (size := sum(map(len, origins.values()))):
        for node, schema in zip(nodes, schemas, strict=True):
            for value, found in _flows(node, schema, origins, dtypes):
                if "Tensor" in str(value.type()):
                    origins[value.debugName()] |= found
    return origins


def _flows(
    node: Any, schema: Any, origins: Mapping[str, set[str]], dtypes: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[Any, set[str]]]:
    """The values whose memory a node determines, and the origins of that memory."""
    kind, inputs, outputs = node.kind(), list(node.inputs()), list(node.outputs())
    of = [origins[v.debugName()] for v in inputs]
    whole = set[str]().union(*of)
    if kind == "prim::GetAttr":
        yield outputs[0], {_STATE}
    elif kind == "prim::If":
        for block in node.blocks():
            yield from ((o, origins[v.debugName()]) for o, v in zip(outputs, block.outputs(), strict=True))
    elif kind == "prim::Loop":
        (block,) = node.blocks()
        for inside, begin, end, outside in zip(
            list(block.inputs())[1:], inputs[2:], list(block.outputs())[1:], outputs, strict=True
        ):
            carried = origins[begin.debugName()] | origins[end.debugName()]
            yield inside, carried
            yield outside, carried
    elif kind in ("prim::TupleUnpack", "prim::ListUnpack") and inputs[0].node().kind() in (
        "prim::TupleConstruct",
        "prim::ListConstruct",
    ):
        # The lengths differ only in a branch that cannot be taken
        yield from ((o, origins[v.debugName()]) for o, v in zip(outputs, inputs[0].node().inputs()))
    elif schema is None:
        yield from ((o, whole) for o in outputs)
    elif kind == "aten::to" and _casts(schema, inputs, whole, dtypes):
        return
    else:
        for returned, value in zip(schema.returns, outputs):
            if returned.alias_info is not None:
                sets = returned.alias_info.before_set | returned.alias_info.after_set
                shared = [
                    o
                    for a, o in zip(schema.arguments, of)
                    if "*" in str(sets)
                    or (a.alias_info and sets & (a.alias_info.before_set | a.alias_info.after_set))
                ]
                yield value, set[str]().union(*shared)
        if (
            schema.arguments
            and schema.arguments[0].alias_info
            and schema.arguments[0].alias_info.is_write
            and "List" in str(inputs[0].type().kind())
        ):
            yield inputs[0], whole  # a list to which something is added


@cache
def _dtypes() -> dict[int, str]:
    """The names of dtypes by TorchScript's numbers for them, as TorchScript gives them."""
    dtypes = {value for value in vars(torch).values() if isinstance(value, torch.dtype)}
    names = [str(dtype).removeprefix("torch.") for dtype in dtypes]
    source = "".join(f"def {name}_() -> int:\n  return torch.{name}\n" for name in names)
    unit = torch.jit.CompilationUnit(source)
    return {getattr(unit, f"{name}_")(): name for name in names}


def _casts(schema: Any, inputs: list[Any], origins: set[str], dtypes: Mapping[str, tuple[str, ...]]) -> bool:
    """Whether a `to` changes the dtype of every possible input, so that it is a copy."""
    for argument, value in zip(schema.arguments, inputs):
        if argument.name == "dtype" and value.node().kind() == "prim::Constant":
            wanted = _dtypes().get(value.toIValue())
            return (
                _STATE not in origins
                and all(wanted not in dtypes[key] for key in origins)
                and wanted is not None
            )
    return False


def _is_random(node: Any, schema: Any) -> bool:
    if not node.kind().startswith("aten::"):
        return False
    operator = getattr(
        getattr(torch.ops.aten, node.kind()[6:], None), schema.overload_name or "default", None
    )
    if not is_random(operator):
        return False
    constants = {
        a.name: v.toIValue()
        for a, v in zip(schema.arguments, node.inputs())
        if v.node().kind() == "prim::Constant"
    }
    return not any(
        constants.get(key) == quiet and constants.get(key) is not None for key, quiet in _QUIET.items()
    )
