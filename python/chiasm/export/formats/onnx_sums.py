"""Sums of whole numbers in ONNX.

ONNX Runtime adds whole numbers of 64 bits as float64, which is exact up to 2^53. Sums that may be larger are
added in three parts of the numbers' bits, each of which is exact, and wrap around as PyTorch's do.
"""

from __future__ import annotations

import math
from typing import Any, cast

import torch
from torch import Tensor
from torch.export import ExportedProgram
from torch.fx import GraphModule, Node

from ..tracing.expansion import expand, replace
from .onnx_division import limits_of
from .onnx_indices import Intervals

aten = torch.ops.aten
#: Of float64, and a number of values that no tensor has: they would be a terabyte.
_EXACT, _MOST_VALUES = 1 << 53, 1 << 37
_BITS = 22


def split_sums(program: ExportedProgram) -> None:
    """In place: write sums of int64 whose values are not known to be small as sums of parts."""
    for module in list(program.graph_module.modules()):
        if not isinstance(module, GraphModule):
            continue
        intervals = Intervals(program, module.graph)
        for node in list(module.graph.nodes):
            if node.target in (aten.sum.default, aten.sum.dim_IntList) and not _is_exact(node, intervals):
                replace(node, cast("Node", expand(node, {}, {}, _in_parts)), program)
        module.recompile()


def _is_exact(node: Node, intervals: Intervals) -> bool:
    values: Any = node.args[0]
    if node.meta["val"].dtype != torch.int64:
        return True
    low, high = intervals.of(values)
    count = math.prod(limits_of(size)[1] for size in values.meta["val"].shape)
    return max(-low, high) * min(count, _MOST_VALUES) <= _EXACT


def _in_parts(x: Tensor, *arguments: Any, **keywords: Any) -> Tensor:
    x = x.to(torch.int64)
    mask = (1 << _BITS) - 1
    parts = x & mask, (x >> _BITS) & mask, x >> 2 * _BITS
    low, middle, high = (part.sum(*arguments, **keywords) for part in parts)
    return low + (middle << _BITS) + (high << 2 * _BITS)
