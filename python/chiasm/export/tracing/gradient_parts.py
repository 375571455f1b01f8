# torch declares a node's argument as a union of all possible types.
# pyright: reportArgumentType=false, reportAssignmentType=false
"""Gradients of parts of tensors, in forms that engines run well.

The gradient with respect to x through `x[..., 0]` is the incoming gradient padded with zeros, and the total
gradient is a sum of these terms: for a point's x, y and z, the code would compute all three terms everywhere.
If the parts are adjacent along an axis of known size, they are concatenated instead.
"""

from __future__ import annotations

import operator
from collections import defaultdict
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias, cast

import torch
from torch import Tensor
from torch.fx import GraphModule, Node

from ..internals import hint_of

_ADD, _SELECT, _SLICE = (
    torch.ops.aten.add.Tensor,
    torch.ops.aten.select_backward.default,
    torch.ops.aten.slice_backward.default,
)
#: Along longer axes, as in images, padding is as fast.
_LONGEST = 64

Size: TypeAlias = "int | torch.SymInt"


class _Part(NamedTuple):
    """The incoming gradient for positions `start` to `end` - 1 of an axis."""

    start: int
    end: int
    term: Node


def joined(module: GraphModule) -> GraphModule:
    """The graph of a gradient with its parts joined if possible, otherwise padded."""
    graph = module.graph
    for node in list(graph.nodes):
        if node.target is _SLICE and _is_whole(node):
            node.replace_all_uses_with(node.args[0])
            graph.erase_node(node)
    for node in list(graph.nodes):
        if node.target is _ADD and not _is_term(node):
            _join_terms(node)
    for node in graph.nodes:
        if node.target is _SELECT:
            node.target = _select_backward
        elif node.target is _SLICE and node.args[5] == 1:
            node.target = _slice_backward
    graph.eliminate_dead_code()
    module.recompile()
    return module


def _is_whole(node: Node) -> bool:
    """Whether a slice covers its whole axis, as in `x[:, 0]`: PyTorch then writes the largest integer as its
    end."""
    _, _, _, start, end, step = node.args
    return (start, end, step) == (0, torch.iinfo(torch.int64).max, 1)


def _is_sum(node: Node) -> bool:
    return node.target is _ADD and not node.kwargs and all(isinstance(a, Node) for a in node.args)


def _is_term(node: Node) -> bool:
    """Whether the only user of a sum is another sum."""
    return len(node.users) == 1 and _is_sum(next(iter(node.users)))


def _terms(total: Node) -> list[Node]:
    terms: list[Node] = []
    for argument in total.args if _is_sum(total) else ():
        terms += _terms(argument) if _is_sum(argument) and _is_term(argument) else [argument]
    return terms


def _join_terms(total: Node) -> None:
    """Replace a sum by one whose terms are joined."""
    terms = _terms(total)
    parts: dict[int, list[_Part]] = defaultdict(list)
    for term in terms:
        if found := _part(term, total):
            parts[found[0]].append(found[1])
    made: list[Node] = []
    with total.graph.inserting_before(total):
        for dim, some in parts.items():
            layers: list[list[_Part]] = []  # each layer has parts that do not overlap
            for part in sorted(some, key=lambda p: p.start):
                free = [layer for layer in layers if layer[-1].end <= part.start]
                free[0].append(part) if free else layers.append([part])
            if len(layers) == len(some):
                continue
            for layer in layers:
                pieces = [(p.start, p.end, p.term.target is _SELECT, *p.term.args[:4]) for p in layer]
                made.append(_call(_join, (dim, pieces), total))
            replaced = {part.term for part in some}
            terms = [t for t in terms if t not in replaced]
        if not made:
            return
        result, *others = terms + made
        for term in others:
            result = _call(operator.add, (result, term), total)
    total.replace_all_uses_with(result)


def _call(function: Callable[..., Tensor], arguments: tuple[Any, ...], total: Node) -> Node:
    """A node with the sum's shape: the sum may itself be the incoming gradient of a part."""
    node = total.graph.call_function(function, arguments)
    node.meta["val"] = total.meta["val"]
    return node


def _part(term: Node, total: Node) -> tuple[int, _Part] | None:
    """The axis, and the part of it outside of which a term of a sum is zero, at the example's sizes."""
    if (
        term.target not in (_SELECT, _SLICE)
        or len(term.users) != 1
        or (term.target is _SLICE and term.args[5] != 1)
    ):
        return None
    shape = [_hint(size) for size in term.meta["val"].shape]
    gradient, _, dim, start = cast("tuple[Any, Any, int, Any]", term.args[:4])
    dim = dim % len(shape)
    size = shape[dim]
    if (
        size > _LONGEST
        or not isinstance(start, int)
        or shape != [_hint(size) for size in total.meta["val"].shape]
    ):
        return None
    start = start % size if start < 0 else start
    extent = 1 if term.target is _SELECT else _hint(gradient.meta["val"].shape[dim])
    return dim, _Part(start, start + extent, term)


def _hint(size: int | torch.SymInt) -> int:
    return size if isinstance(size, int) else hint_of(size)


def _join(dim: int, pieces: list[tuple[Any, ...]]) -> Tensor:
    """Parts along an axis one after the other, with zeros between them: (start, end, whether selected,
    arguments of the backward). If the axis's size turns out not to be constant, they are padded and added."""
    size = pieces[0][4][dim]
    if not isinstance(size, int):
        padded = [
            (
                _select_backward(gradient, sizes, axis, start)
                if selected
                else _slice_backward(gradient, sizes, axis, start, None, 1)
            )
            for _, _, selected, gradient, sizes, axis, start in pieces
        ]
        return sum(padded[1:], padded[0])
    parts: list[Tensor] = []
    position = 0
    for start, end, selected, gradient, *_ in pieces:
        part = gradient.unsqueeze(dim) if selected else gradient
        if start > position:
            parts.append(_zeros(part, dim, start - position))
        parts.append(part)
        position = end
    if position < size:
        parts.append(_zeros(parts[-1], dim, size - position))
    return torch.cat(parts, dim)


def _zeros(like: Tensor, dim: int, extent: int) -> Tensor:
    return like.new_zeros([*like.shape[:dim], extent, *like.shape[dim + 1 :]])


def _slice_backward(
    gradient: Tensor, input_sizes: list[int], dim: int, start: Size, end: Size | None, step: int
) -> Tensor:
    """Zeros around the gradient. This becomes one Pad in ONNX; PyTorch's own form becomes a ScatterND."""
    dim = dim % len(input_sizes)
    size = input_sizes[dim]
    if isinstance(start, int) and start < 0:
        start = start + size
    pads = [0, 0] * (len(input_sizes) - 1 - dim) + [start, size - start - gradient.shape[dim]]
    return torch.ops.aten.constant_pad_nd.default(gradient, pads, 0.0)


def _select_backward(gradient: Tensor, input_sizes: list[int], dim: int, index: Size) -> Tensor:
    dim = dim % len(input_sizes)
    return _slice_backward(gradient.unsqueeze(dim), input_sizes, dim, index, None, 1)
