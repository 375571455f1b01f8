# torch.export keeps what it assumed of sizes in a private member.
# pyright: reportPrivateUsage=false
"""Branches on sizes: a graph has the branch that the trace took, and an allowed size may need another."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy
import torch
from torch.export import ExportedProgram

from ..errors import ExportError
from ..patches.tracing import Guard
from ..sizes import evaluate
from ..spec import Spec, TensorSpec

#: The number of allowed sizes that are tried, besides the limits.
_TRIALS = 200
#: With more elements in an input, sizes are not tried: the op may take hours for them.
_MOST_ELEMENTS = 1 << 22


@dataclass(frozen=True)
class Doubt:
    """Sizes for which a graph was not made, although it may be right for them: for example, a slice may or
    may not cover its whole axis. `text` is the reason, for the error if the graph is wrong for these
    sizes."""

    sizes: dict[str, int]
    text: str


def doubts_of(
    program: ExportedProgram,
    spec: Spec,
    tensors: Sequence[TensorSpec],
    names: dict[sympy.Symbol, str],
    guards: Sequence[Guard],
) -> list[Doubt]:
    """The smallest allowed sizes for which each assumption of a graph does not hold.

    Args:
        program: the traced graph.
        spec: its symbols' limits.
        tensors: the graph's inputs.
        names: the graph's symbols to the spec's.
        guards: what the trace assumed, each with the line of the op.

    Raises:
        ExportError: an assumption fails only for sizes that are too large to try.
    """
    doubts: list[Doubt] = []
    candidates = [(sizes, {t.name: _Shape(t, sizes) for t in tensors}) for sizes in _allowed(spec)]
    candidates.sort(key=lambda candidate: _elements(candidate[1]))
    for condition in program._guards_code or ():
        failing = next((c for c in candidates if not _holds(condition, c[1])), None)
        if failing is None:
            continue
        sizes, shapes = failing
        text = _text(condition, sizes, names, guards)
        if _elements(shapes) > _MOST_ELEMENTS:
            raise ExportError(f"{spec.name}: cannot be exported to a graph{text}")
        doubts.append(Doubt(sizes, text))
    return doubts


class _Shape:
    """The parts of a tensor that conditions read."""

    def __init__(self, tensor: TensorSpec, sizes: dict[str, int]) -> None:
        self._sizes = [int(evaluate(d, sizes)) if isinstance(d, str) else d for d in tensor.shape]

    def size(self) -> list[int]:
        return self._sizes


def _allowed(spec: Spec) -> Iterator[dict[str, int]]:
    """Sizes within the limits: all ends, each symbol at its ends alone, and random sizes, small ones as often
    as large ones."""
    limits = spec.used_symbols()
    chance = random.Random(0)

    def middle(low: int, high: int) -> int:
        return min(high, max(low, int(low * (high / max(low, 1)) ** chance.random())))

    for end in (0, 1):
        yield {name: ends[end] for name, ends in limits.items()}
        for one in limits:
            yield {n: ends[end] if n == one else middle(*ends) for n, ends in limits.items()}
    for _ in range(_TRIALS):
        yield {name: middle(*ends) for name, ends in limits.items()}


def _holds(condition: str, shapes: dict[str, _Shape]) -> bool:
    try:
        # torch.export's own text, a comparison of sizes.
        return bool(eval(condition, {"L": shapes, "torch": torch}))
    except (NameError, TypeError, AttributeError, KeyError):  # the condition is not about sizes
        return True
    except ZeroDivisionError:
        return False


def _elements(shapes: dict[str, _Shape]) -> int:
    return max(math.prod(shape.size()) for shape in shapes.values())


def _text(
    condition: str, sizes: dict[str, int], names: dict[sympy.Symbol, str], guards: Sequence[Guard]
) -> str:
    values = {symbol: sizes[name] for symbol, name in names.items() if name in sizes}
    lines = [line for expression, line in guards if sympy.simplify(expression.subs(values)) == sympy.false]
    fact = re.sub(r"L\['(\w+)'\]\.size\(\)\[(\d+)\]", r"\1.shape[\2]", condition)
    where = f"\n  at {lines[0]}" if lines else ""
    text = ", ".join(f"{name}={size}" for name, size in sizes.items())
    return (
        f"{where}\n"
        f"  because: the graph has the branch for {fact} alone, and the spec's symbols allow {text}\n"
        "  instead: narrow the symbols' limits in the spec (symbols={...}), choose by torch.where, or export"
        " the branches as ops of their own"
    )
