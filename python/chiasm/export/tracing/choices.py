# torch declares a node's argument as a union of all possible types.
# pyright: reportAssignmentType=false
"""Choices that are the same for every input, such as a probability of 1."""

from __future__ import annotations

import torch
from torch.export import ExportedProgram
from torch.fx import Node

from .expansion import replace

_ATEN = torch.ops.aten
_WHERE = _ATEN.where.self
#: Operators whose result has the values of the first argument, in another shape.
_MOVES = {
    _ATEN.unsqueeze.default,
    _ATEN.view.default,
    _ATEN.reshape.default,
    _ATEN.expand.default,
    _ATEN.select.int,
    _ATEN.slice.Tensor,
}
_ONES = {_ATEN.ones.default, _ATEN.ones_like.default}


def remove_certain_choices(program: ExportedProgram) -> None:
    """Replace `where(True, x, y)` by x: compiled code would load y, and choose, at every element."""
    for node in list(program.graph.nodes):
        if node.target is not _WHERE or not _is_true(node.args[0]):
            continue
        chosen = node.args[1]
        if chosen.op != "call_function":  # the result would be an input itself
            continue
        value, whole = chosen.meta["val"], node.meta["val"]
        if value.dtype == whole.dtype and value.shape == whole.shape:
            replace(node, chosen, program)
    program.graph.eliminate_dead_code()


def _is_true(node: Node) -> bool:
    while node.target in _MOVES:
        node = node.args[0]
    return node.target in _ONES
