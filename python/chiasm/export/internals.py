# A type checker knows nothing of what is used here: the annotations say what it is.
# pyright: reportPrivateUsage=false, reportUnknownMemberType=false, reportUnknownVariableType=false
"""Parts of torch that are private or without types, and that several modules need: here they get types."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypeGuard

import sympy
import torch
from torch import _decomp
from torch._ops import OpOverload
from torch.export import ExportedProgram
from torch.utils._sympy import value_ranges
from torch.utils._sympy.value_ranges import ValueRanges

#: An operator in a graph, such as `torch.ops.aten.add.Tensor`.
Operator: TypeAlias = "OpOverload[..., Any]"
#: The limits of a trace's symbols.
Limits: TypeAlias = "dict[sympy.Symbol, ValueRanges[sympy.Expr]]"

#: How a graph divides sizes.
FLOOR_DIVISION: Callable[[Any, Any], Any] = operator.floordiv


def is_operator(target: Any) -> TypeGuard[Operator]:
    """Whether what a node calls is an operator of torch."""
    return isinstance(target, OpOverload)


def schema_of(operator: Operator) -> torch.FunctionSchema:
    """An operator's declaration: its name, arguments and results."""
    return operator._schema


def expression_of(size: torch.SymInt) -> sympy.Expr:
    """A symbolic size as an expression of its trace's symbols."""
    return size.node.expr


def hint_of(size: torch.SymInt) -> int:
    """A symbolic size's value in the example of its trace."""
    return size.node.hint


def limits_of_symbols(size: torch.SymInt) -> Limits:
    """The limits of the symbols of a size's trace."""
    return size.node.shape_env.var_to_range


def limits_of_program(program: ExportedProgram) -> Limits:
    """The limits of a program's symbols."""
    return program.range_constraints


def bounds_of(expression: sympy.Expr, limits: Limits) -> ValueRanges[sympy.Expr]:
    """The least and the greatest value of an expression, by its symbols' limits."""
    return value_ranges.bound_sympy(expression, limits)


def decompositions_of(operators: Sequence[Any]) -> dict[Any, Any]:
    """PyTorch's decompositions of these operators."""
    return _decomp.get_decompositions(operators)


def run_decompositions(program: ExportedProgram, table: dict[Any, Any]) -> ExportedProgram:
    """The program, traced again with the decompositions of the table."""
    return program.run_decompositions(table)
