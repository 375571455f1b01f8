"""Indices in ONNX, in which every operator counts negative indices from the end.

`gather`, `scatter`, `index_select`, `embedding` and similar operators reject a negative index, so it is
replaced with one that ONNX rejects too. An index that cannot be negative, such as a position or a clamped
index, is unchanged.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Collection, Sequence
from typing import Any, cast

import torch
from torch.export import ExportedProgram
from torch.fx import Graph, GraphModule, Node

from ..internals import is_operator, schema_of
from .onnx_division import limits_of

aten = torch.ops.aten
#: The place of the index among the arguments.
_INDEX = {
    aten.gather.default: 2,
    aten.take_along_dim.default: 1,
    aten.index_select.default: 2,
    aten.index_add.default: 2,
    aten.index_add_.default: 2,
    aten.index_copy.default: 2,
    aten.index_copy_.default: 2,
    aten.scatter.src: 2,
    aten.scatter_.src: 2,
    aten.scatter.value: 2,
    aten.scatter_.value: 2,
    aten.scatter_add.default: 2,
    aten.scatter_add_.default: 2,
    aten.scatter_reduce.two: 2,
    aten.scatter_reduce_.two: 2,
    aten.embedding.default: 1,
}
#: Operators with a list of indices, of int64 in ONNX.
_LISTS = (aten.index.Tensor, aten.index_put.default, aten.index_put_.default)
_SHORT = (torch.int8, torch.int16, torch.int32)
Interval = tuple[float, float]


def check_indices(program: ExportedProgram, checked: Collection[Node] = ()) -> None:
    """In place: for operators that reject negative indices, replace these with indices that are out of range;
    convert indices of shorter types to int64. Nodes that are `checked` stay as they are."""
    for module in list(program.graph_module.modules()):
        if not isinstance(module, GraphModule):
            continue
        intervals = Intervals(program, module.graph)
        for node in [node for node in module.graph.nodes if node not in checked]:
            place = _INDEX.get(node.target)
            with module.graph.inserting_before(node):
                if place is not None and intervals.of(node.args[place])[0] < 0:
                    node.update_arg(place, _refused_below_zero(node.args[place]))
                if node.target in _LISTS:
                    node.update_arg(1, [index and _widened(index) for index in node.args[1]])
        module.recompile()


def _refused_below_zero(index: Node) -> Node:
    value = index.meta["val"]
    negative = index.graph.call_function(aten.lt.Scalar, (index, 0))
    negative.meta["val"] = value < 0
    least = torch.iinfo(value.dtype).min
    refused = index.graph.call_function(aten.masked_fill.Scalar, (index, negative, least))
    refused.meta["val"] = torch.empty_like(value)
    return refused


def _widened(index: Node) -> Node:
    if index.meta["val"].dtype not in _SHORT:
        return index
    widened = index.graph.call_function(aten._to_copy.default, (index,), {"dtype": torch.int64})
    widened.meta["val"] = index.meta["val"].to(torch.int64)
    return widened


class Intervals:
    """The intervals of the values of a graph's nodes."""

    def __init__(self, program: ExportedProgram, graph: Graph) -> None:
        self._constants: dict[str, Any] = {
            spec.arg.name: program.constants[spec.target]
            for spec in program.graph_signature.input_specs
            if spec.target in program.constants
        }
        self._known: dict[Node, Interval] = {}
        # A later write may change the value of another node of which this one is a part.
        self._written = any(
            is_operator(n.target)
            and schema_of(n.target).is_mutable
            and not n.args[0].meta["val"].dtype.is_floating_point
            for n in graph.nodes
        )

    def of(self, value: Any) -> Interval:
        if isinstance(value, (int, float)):
            return value, value
        if isinstance(value, torch.SymInt):
            return limits_of(value)
        if not isinstance(value, Node):
            return -math.inf, math.inf
        if value not in self._known:
            self._known[value] = self._found(value)
        return self._known[value]

    def _found(self, node: Node) -> Interval:
        made: Any = node.meta.get("val")
        if isinstance(made, torch.SymInt):
            return self.of(made)
        if not isinstance(made, torch.Tensor):
            return -math.inf, math.inf
        limits = _limits(made.dtype)
        if self._written:
            return limits
        constant: Any = self._constants.get(node.name) if node.op == "placeholder" else None
        if constant is not None and constant.numel():
            return constant.min().item(), constant.max().item()
        low, high = _RULES.get(node.target, _unknown)(self, node)
        # Values that do not fit wrap around.
        return (low, high) if limits[0] <= low and high <= limits[1] else limits


def _limits(dtype: torch.dtype) -> Interval:
    if dtype == torch.bool:
        return 0, 1
    if dtype.is_floating_point or dtype.is_complex:
        return -math.inf, math.inf
    return torch.iinfo(dtype).min, torch.iinfo(dtype).max


def _unknown(_: Intervals, node: Node) -> Interval:
    return _limits(node.meta["val"].dtype)


def _same(of: Intervals, node: Node) -> Interval:
    """Views, selections and casts."""
    low, high = of.of(node.args[0])
    if node.meta["val"].dtype.is_floating_point or not math.isfinite(low + high):
        return low, high
    return math.floor(low), math.ceil(high)


def _clamped(of: Intervals, node: Node) -> Interval:
    low, high = of.of(node.args[0])
    if node.meta["val"].dtype.is_floating_point and not math.isfinite(low + high):
        return low, high  # a clamp lets NaN pass
    least, most = (*node.args[1:], None, None)[:2]
    if least is not None:
        low, high = max(low, of.of(least)[0]), max(high, of.of(least)[1])
    if most is not None:
        low, high = min(low, of.of(most)[0]), min(high, of.of(most)[1])
    return low, high


def _positions(of: Intervals, node: Node) -> Interval:
    start, end, step = {1: (0, *node.args, 1), 2: (*node.args, 1), 3: node.args}[len(node.args)]
    if of.of(step)[0] > 0:
        return of.of(start)[0], of.of(end)[1]
    return (of.of(end)[0] + 1, of.of(start)[1]) if of.of(step)[1] < 0 else _unknown(of, node)


def _joined(of: Intervals, node: Node) -> Interval:
    parts = [of.of(part) for part in cast("Sequence[Any]", node.args[0])]
    return min(low for low, _ in parts), max(high for _, high in parts)


def _chosen(of: Intervals, node: Node) -> Interval:
    (a, b), (c, d) = of.of(node.args[1]), of.of(node.args[2])
    return min(a, c), max(b, d)


def _by_ends(compute: Callable[[float, float], float]) -> Callable[[Intervals, Node], Interval]:
    """The interval of an operation that is monotonic in each argument."""

    def rule(of: Intervals, node: Node) -> Interval:
        a, b = of.of(node.args[0]), of.of(node.args[1])
        if not all(map(math.isfinite, (*a, *b))) or node.kwargs.get("alpha", 1) != 1:
            return _unknown(of, node)
        ends = [compute(x, y) for x in a for y in b]
        return min(ends), max(ends)

    return rule


def _quotient(of: Intervals, node: Node) -> Interval:
    (a, b), (c, d) = of.of(node.args[0]), of.of(node.args[1])
    if not math.isfinite(a + b) or c < 1:
        return _unknown(of, node)
    low, high = min(a / c, a / d), max(b / c, b / d)
    return (low, high) if node.meta["val"].dtype.is_floating_point else (math.floor(low), math.ceil(high))


def _remainder(of: Intervals, node: Node) -> Interval:
    low, high = of.of(node.args[1])
    return (0, high) if low > 0 and not node.meta["val"].dtype.is_floating_point else _unknown(of, node)


def _taken(of: Intervals, node: Node) -> Interval:
    """The indices of extreme values, or of values before sorting."""
    made: Any
    which: Any
    made, which = node.args
    return _place(of, node) if which == 1 and made.target in _WITH_PLACES else _unknown(of, node)


def _place(of: Intervals, node: Node) -> Interval:
    return 0, 1 << 47  # the bytes that a process can address


_WITH_PLACES = (
    aten.topk.default,
    aten.sort.default,
    aten.sort.stable,
    aten.max.dim,
    aten.min.dim,
)
_RULES: dict[Any, Callable[[Intervals, Node], Interval]] = {
    **dict.fromkeys(
        (
            aten._to_copy.default,
            aten.to.dtype,
            aten.to.device,
            aten.to.dtype_layout,
            aten.clone.default,
            aten.view.default,
            aten.reshape.default,
            aten.expand.default,
            aten.unsqueeze.default,
            aten.squeeze.dim,
            aten.squeeze.dims,
            aten.permute.default,
            aten.transpose.int,
            aten.t.default,
            aten.select.int,
            aten.slice.Tensor,
            aten.flip.default,
            aten.flatten.using_ints,
            aten.unflatten.int,
            aten.detach.default,
            aten.contiguous.default,
            aten.index_select.default,
            aten.gather.default,
            aten.repeat.default,
            aten.floor.default,
            aten.ceil.default,
            aten.round.default,
            aten.trunc.default,
        ),
        _same,
    ),
    **dict.fromkeys((aten.clamp.default, aten.clamp.Tensor, aten.clamp_min.default), _clamped),
    **dict.fromkeys((aten.arange.default, aten.arange.start, aten.arange.start_step), _positions),
    **dict.fromkeys((aten.cat.default, aten.stack.default), _joined),
    **dict.fromkeys((aten.argmax.default, aten.argmin.default, aten.argsort.default), _place),
    aten.where.self: _chosen,
    aten.add.Tensor: _by_ends(operator.add),
    aten.sub.Tensor: _by_ends(operator.sub),
    aten.mul.Tensor: _by_ends(operator.mul),
    aten.minimum.default: _by_ends(min),
    aten.maximum.default: _by_ends(max),
    aten.div.Tensor: _quotient,
    aten.div.Tensor_mode: _quotient,
    aten.floor_divide.default: _quotient,
    aten.remainder.Scalar: _remainder,
    aten.remainder.Tensor: _remainder,
    operator.getitem: _taken,
}
