# TorchScript's graphs are in a private module of torch.
# pyright: reportPrivateUsage=false, reportUnknownMemberType=false, reportUnknownVariableType=false
"""Quotients of integers in TorchScript that do not end the process.

PyTorch's own do: the smallest integer divided by -1, if the quotient of tensors is truncated; and for numbers
of Python, `a // -1` and `a % -1` of it and any `a % 0`. A quotient that is rounded down is an error for a
divisor of 0.
"""

from __future__ import annotations

from typing import Any, Optional

import torch
from torch import Tensor

from ..checks.quotients import rounded_to_zero


def _quotient(a: Tensor, b: Tensor, rounding_mode: Optional[str]) -> Tensor:
    if rounding_mode is None or rounding_mode != "trunc" or a.is_floating_point() or b.is_floating_point():
        return torch.div(a, b, rounding_mode=rounding_mode)
    return rounded_to_zero(a, b, torch.div(a, b, rounding_mode="floor"))


def _quotient_by_number(a: Tensor, b: Tensor, rounding_mode: Optional[str]) -> Tensor:
    """The divisor is a number, which does not decide the result's dtype as a tensor does."""
    number = b.item()
    if rounding_mode is None or rounding_mode != "trunc" or a.is_floating_point() or b.is_floating_point():
        return torch.div(a, number, rounding_mode=rounding_mode)
    return rounded_to_zero(a, b, torch.div(a, number, rounding_mode="floor"))


def _whole(a: int, b: int) -> int:
    return -a if b == -1 else a // b


def _rest(a: int, b: int) -> int:
    return 0 if b == -1 else a - a // b * b


def _stored(result: Tensor, out: Tensor) -> Tensor:
    return torch.mul(result, 1, out=out)


def _replaced(a: Tensor, result: Tensor) -> Tensor:
    return a.copy_(result)


def guard_quotients(scripted: torch.jit.ScriptModule) -> None:
    """Replace these quotients in a program, unless the divisor is a constant other than -1. A program without
    them stays as it is."""
    calls: Any = scripted.graph.copy()
    torch._C._jit_pass_inline(calls)
    if not _unsafe(calls):
        return
    graph: Any = scripted.graph
    torch._C._jit_pass_inline(graph)
    for node in _unsafe(graph):
        graph.setInsertPoint(node)
        if node.kind() in _OF_NUMBERS:
            node.output().replaceAllUsesWith(_inserted(graph, _OF_NUMBERS[node.kind()], *node.inputs()))
            node.destroy()
            continue
        a, b, mode, *out = node.inputs()
        form = _quotient
        if str(b.type()) != "Tensor":
            form = _quotient_by_number
            b = graph.insertNode(graph.create("prim::NumToTensor", [b], 1)).output()
        result = _inserted(graph, form, a, b, mode)
        if out:
            result = _inserted(graph, _stored, result, *out)
        elif node.kind().endswith("_"):
            result = _inserted(graph, _replaced, a, result)
        node.output().replaceAllUsesWith(result)
        node.destroy()
    graph.setInsertPoint(graph.return_node())


_OF_NUMBERS = {"aten::floordiv": _whole, "aten::remainder": _rest}


def _unsafe(graph: Any) -> list[torch._C.Node]:
    """The quotients that may end the process."""
    kinds = ("aten::div", "aten::div_", "aten::divide", "aten::divide_")
    divisions = [node for kind in kinds for node in graph.findAllNodes(kind, recurse=True)]
    of_numbers = [
        node
        for kind in _OF_NUMBERS
        for node in graph.findAllNodes(kind, recurse=True)
        if all(str(value.type()) == "int" for value in node.inputs()) and not _is_safe(list(node.inputs())[1])
    ]
    return of_numbers + [
        node for node in divisions if node.inputsSize() > 2 and _may_overflow(*list(node.inputs())[1:3])
    ]


def _is_safe(divisor: Any) -> bool:
    return divisor.node().kind() == "prim::Constant" and divisor.toIValue() not in (0, -1)


def _may_overflow(divisor: Any, rounding_mode: Any) -> bool:
    constant, mode = (value.node().kind() == "prim::Constant" for value in (divisor, rounding_mode))
    safe = constant and isinstance(divisor.toIValue(), (int, float)) and divisor.toIValue() != -1
    return not safe and not (mode and rounding_mode.toIValue() != "trunc")


def _inserted(graph: Any, function: Any, *values: Any) -> Any:
    """The result of a function that is written into the graph at its insert point."""
    body: Any = torch.jit.script(function).graph.copy()
    torch._C._jit_pass_inline(body)
    return graph.insertGraph(body, list(values))[0]
