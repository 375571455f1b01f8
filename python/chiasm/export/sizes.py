"""The sizes of tensors in a manifest: integers, symbols, + - * // ( )."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.FloorDiv: lambda a, b: a // b,
}
#: An int, or a torch.SymInt.
Size = TypeVar("Size")


def evaluate(expression: str, symbols: Mapping[str, Size]) -> Size | int:
    """The value of a size expression.

    Raises
    ------
    ValueError
        If it is not an expression, or has a symbol without a value.

    Examples
    --------
    >>> evaluate("(H - 2) // 2", {"H": 9})
    3
    """

    def value(e: ast.expr) -> Size | int:
        if isinstance(e, ast.Constant) and isinstance(e.value, int):
            return e.value
        if isinstance(e, ast.Name) and e.id in symbols:
            return symbols[e.id]
        if isinstance(e, ast.UnaryOp) and isinstance(e.op, ast.USub):
            return _OPERATORS[ast.Sub](0, value(e.operand))
        if isinstance(e, ast.BinOp) and type(e.op) in _OPERATORS:
            return _OPERATORS[type(e.op)](value(e.left), value(e.right))
        raise ValueError(f"{ast.unparse(e)!r}, which is not made of integers, symbols, + - * //")

    return value(ast.parse(expression.strip(), mode="eval").body)
