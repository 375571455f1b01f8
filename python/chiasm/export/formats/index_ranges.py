"""Finds which indices of a compiled loop are in range for any data: bounds on the nodes of Inductor's loop
bodies, as expressions of sizes.

Inductor's own bounds are numbers, so they cannot express that `clamp(i, 0, W - 1)` is less than `W`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import sympy
import torch

from ..internals import bounds_of

#: Integers up to here are exact in a floating type: a greater bound may be rounded up to the limit itself.
_EXACT = {torch.float64: 1 << 53, torch.float32: 1 << 24, torch.float16: 1 << 11, torch.bfloat16: 1 << 8}
_MOST_BOUNDS = 4


@dataclass(frozen=True)
class _Range:
    """The known bounds of a value, whether it is certainly a number (not NaN), and its largest magnitude:
    arithmetic on values that are certainly finite produces no NaN."""

    lows: tuple[sympy.Expr, ...] = ()
    highs: tuple[sympy.Expr, ...] = ()
    number: bool = False
    dtype: torch.dtype | None = None
    magnitude: float = math.inf


class IndexRanges:
    """The ranges of one compilation. The range of a buffer is derived from the earlier loop that stored it,
    and cached."""

    #: How many buffers a bound is followed through.
    _DEPTH = 8

    def __init__(self) -> None:
        self._buffers: dict[tuple[int, str], _Range] = {}
        self._depth = 0

    def proves(self, node: Any, size: Any, wrapped: bool) -> bool:
        """Whether the index that a node of a loop body computes is certainly in [0, size), or in [-size,
        size) if it is `wrapped`."""
        if not isinstance(node, torch.fx.Node):
            return False
        V = _inductor()
        # In a kernel, sizes have the names of its arguments.
        named = {inner: outer for outer, inner in V.kernel.args.sizevars.items()}
        loops = {
            v: n.subs({s: named[s.name] for s in n.free_symbols if s.name in named})
            for v, n in V.kernel.var_ranges().items()
        }
        found = _Ranges(V.interpreter.submodules["get_index"], loops, self._stored).of(node)
        size = sympy.sympify(size)
        lowest = -size if wrapped else sympy.Integer(0)
        return any(_not_negative(low - lowest) for low in found.lows) and any(
            _not_negative(size - 1 - high) for high in found.highs
        )

    def _stored(self, name: str) -> _Range:
        """The range of the values that an earlier loop stored in a buffer."""
        V = _inductor()
        key = (id(V.graph), name)
        if key not in self._buffers:
            buffer = V.graph.scheduler.name_to_buf.get(name)
            body = getattr(getattr(buffer, "defining_op", None), "_body", None)
            if body is None or name in V.graph.mutated_buffers or self._depth == self._DEPTH:
                return _Range()
            stores = [n for n in body.root_block.graph.nodes if n.target == "store" and n.args[1] == name]
            if len(stores) != 1 or stores[0].kwargs or any(mode is not None for mode in stores[0].args[4:]):
                return _Range()
            self._depth += 1
            self._buffers[key] = _Ranges(body.indexing_exprs.__getitem__, body.var_ranges, self._stored).of(
                stores[0].args[3]
            )
            self._depth -= 1
        return self._buffers[key]


def _inductor() -> Any:
    """Inductor's state: the kernel, the graph and the loop body that it compiles."""
    from torch._inductor.virtualized import V

    return V


def depends_on_data(node: Any) -> bool:
    """Whether a node of a loop body is computed from a tensor's values, not from sizes and positions
    alone."""
    seen: set[torch.fx.Node] = set()
    todo = [node]
    while todo:
        node = todo.pop()
        if not isinstance(node, torch.fx.Node) or node in seen:
            continue
        seen.add(node)
        if node.op == "call_module" and str(node.target) != "get_index":
            return True
        if str(node.target) in ("load", "reduction", "scan", "sort", "bucketize", "frexp"):
            return True
        todo.extend(node.all_input_nodes)
    return False


def _not_negative(expression: sympy.Expr) -> bool:
    """Whether an expression is >= 0 for all sizes. PyTorch assumes that a size with limits from 1 is 2 or
    more, so 1 is checked separately."""
    sizevars = _inductor().graph.sizevars
    cases = [sympy.expand(expression)]
    for symbol in cases[0].free_symbols:
        limits = sizevars.shape_env.var_to_range.get(symbol)
        if limits is None or limits.lower <= 2:
            cases += [sympy.expand(case.subs(symbol, 1)) for case in cases]
    return all(
        bool(case >= 0) if case.is_Integer else bool(sizevars.statically_known_true(sympy.Ge(case, 0)))
        for case in cases
    )


def _greatest(expression: sympy.Expr) -> Any:
    """The greatest value that an expression of sizes can take, by the sizes' limits."""
    return bounds_of(expression, _inductor().graph.sizevars.shape_env.var_to_range).upper


def _simplest(bounds: tuple[sympy.Expr, ...]) -> tuple[sympy.Expr, ...]:
    """The bounds that are worth keeping: the bounds of a clamp are shorter than those of its argument."""
    return tuple(sorted(dict.fromkeys(bounds), key=lambda b: b.count_ops())[:_MOST_BOUNDS])


class _Ranges:
    """The ranges of the nodes of one loop body. `get_index` returns the body's index expressions by name;
    their variables are in `var_ranges`."""

    def __init__(
        self,
        get_index: Callable[[str], sympy.Expr],
        var_ranges: dict[sympy.Symbol, sympy.Expr],
        stored: Callable[[str], _Range],
    ) -> None:
        self._get_index, self._var_ranges, self._stored = get_index, var_ranges, stored
        self._known: dict[Any, _Range] = {}
        self._equals: dict[tuple[Any, Any], bool] = {}

    def of(self, value: Any) -> _Range:
        if isinstance(value, (int, sympy.Integer)) and not isinstance(value, bool):
            return _Range((sympy.Integer(value),), (sympy.Integer(value),), True, torch.int64)
        if not isinstance(value, torch.fx.Node):
            return _Range()
        if value not in self._known:
            rule = getattr(self, f"_{value.target}", None) if value.op == "call_method" else None
            found = rule(value) if rule is not None else _Range()
            found = replace(found, lows=_simplest(found.lows), highs=_simplest(found.highs))
            self._known[value] = replace(found, magnitude=min(found.magnitude, self._most(found)))
        return self._known[value]

    @staticmethod
    def _most(found: _Range) -> float:
        """The largest magnitude of a value, by its bounds."""
        if not found.number:
            return math.inf
        if found.lows and found.highs:
            ends = [_greatest(found.highs[0]), _greatest(-found.lows[0])]
            if all(e.is_finite for e in map(sympy.sympify, ends)):
                return max(abs(float(e)) for e in ends)
        return math.inf if found.dtype is None or found.dtype.is_floating_point else 2.0**64

    # One rule for each operation of a loop body, whose arguments are (ops, ...).

    def _constant(self, node: Any) -> _Range:
        value, dtype = node.args[1], node.args[2]
        if math.isnan(value):
            return _Range((), (), False, dtype)
        if math.isinf(value) or int(value) != value:
            return _Range((), (), True, dtype, abs(value))
        found = _Range((sympy.Integer(int(value)),), (sympy.Integer(int(value)),), True, dtype)
        return self._represented(found, dtype)

    def _index_expr(self, node: Any) -> _Range:
        lows, highs = self._bounds(self._get_index(node.args[1].args[0]))
        found = _Range(lows, highs, True, node.args[2])
        return (
            self._represented(found, node.args[2]) if node.args[2].is_floating_point else self._fitting(found)
        )

    @staticmethod
    def _represented(found: _Range, dtype: torch.dtype) -> _Range:
        """The range of integers as a floating type: a bound that would be rounded is dropped."""
        if not dtype.is_floating_point:
            return found
        exact = _EXACT[dtype]
        lows = tuple(b for b in found.lows if abs(_greatest(sympy.Abs(b))) <= exact)
        highs = tuple(b for b in found.highs if _greatest(b) <= exact)
        fits = found.magnitude < float(torch.finfo(dtype).max)
        return _Range(lows, highs, found.number, dtype, found.magnitude if fits else math.inf)

    def _bounds(self, expression: sympy.Expr) -> tuple[tuple[sympy.Expr, ...], tuple[sympy.Expr, ...]]:
        """The bounds of an index that is an expression of the loop's variables. For a clamp, those of its
        parts."""
        from torch.utils._sympy.functions import Max, Min

        if not isinstance(expression, (Max, Min, sympy.Max, sympy.Min)):
            low, high = self._extreme(expression, greatest=False), self._extreme(expression, greatest=True)
            return () if low is None else (low,), () if high is None else (high,)
        lows, highs = zip(*map(self._bounds, expression.args), strict=True)
        if isinstance(expression, (Max, sympy.Max)):
            return sum(lows, ()), reduce(self._greater_of, highs)
        return reduce(self._less_of, lows), sum(highs, ())

    def _load(self, node: Any) -> _Range:
        dtype = _inductor().graph.get_dtype(node.args[1])
        stored = self._stored(node.args[1])
        if stored.dtype == dtype and (stored.number or stored.lows or stored.highs):
            return stored
        if dtype.is_floating_point or dtype.is_complex:
            return _Range((), (), False, dtype)
        if dtype == torch.bool:
            return _Range((sympy.Integer(0),), (sympy.Integer(1),), True, dtype)
        limits = torch.iinfo(dtype)
        return _Range((sympy.Integer(limits.min),), (sympy.Integer(limits.max),), True, dtype)

    def _to_dtype(self, node: Any) -> _Range:
        found, dtype = self.of(node.args[1]), node.args[2]
        if not found.number:  # NaN may convert to any number
            return _Range((), (), not dtype.is_floating_point, dtype)
        if dtype.is_floating_point:
            return self._represented(found, dtype)
        if dtype == torch.bool:
            return _Range((sympy.Integer(0),), (sympy.Integer(1),), True, dtype)
        if not found.lows or not found.highs:
            return _Range((), (), True, dtype)
        return self._fitting(_Range(found.lows, found.highs, True, dtype))

    def _maximum(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        highs = tuple(x for x in a.highs if x in b.highs)
        highs += self._greater_of(a.highs, b.highs) if not highs else ()
        return _Range(a.lows + b.lows, highs, a.number and b.number, a.dtype or b.dtype)

    def _minimum(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        lows = tuple(x for x in a.lows if x in b.lows)
        lows += self._less_of(a.lows, b.lows) if not lows else ()
        return _Range(lows, a.highs + b.highs, a.number and b.number, a.dtype or b.dtype)

    def _where(self, node: Any) -> _Range:
        condition, a, b = node.args[1], self.of(node.args[2]), self.of(node.args[3])
        a_number = a.number or self._says_number(condition, node.args[2], "eq")
        b_number = b.number or self._says_number(condition, node.args[3], "ne", "isnan")
        lows = tuple(x for x in a.lows if x in b.lows) or self._less_of(a.lows, b.lows)
        highs = tuple(x for x in a.highs if x in b.highs) or self._greater_of(a.highs, b.highs)
        return _Range(lows, highs, a_number and b_number, a.dtype or b.dtype, max(a.magnitude, b.magnitude))

    def _add(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        return self._computed(
            a,
            b,
            a.magnitude + b.magnitude,
            [x + y for x in a.lows for y in b.lows],
            [x + y for x in a.highs for y in b.highs],
        )

    def _sub(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        return self._computed(
            a,
            b,
            a.magnitude + b.magnitude,
            [x - y for x in a.lows for y in b.highs],
            [x - y for x in a.highs for y in b.lows],
        )

    def _mul(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        lows: list[sympy.Expr] = []
        highs: list[sympy.Expr] = []
        if any(map(_not_negative, a.lows)) and any(map(_not_negative, b.lows)):
            lows = [x * y for x in a.lows for y in b.lows if _not_negative(x) and _not_negative(y)]
            highs = [x * y for x in a.highs for y in b.highs if _not_negative(x) and _not_negative(y)]
        return self._computed(a, b, a.magnitude * b.magnitude, lows, highs)

    def _truediv(self, node: Any) -> _Range:
        a, b = self.of(node.args[1]), self.of(node.args[2])
        at_least_one = any(_not_negative(low - 1) for low in b.lows)
        return self._computed(a, b, a.magnitude if at_least_one else math.inf, [], [])

    def _neg(self, node: Any) -> _Range:
        a = self.of(node.args[1])
        return self._computed(a, a, a.magnitude, [-x for x in a.highs], [-x for x in a.lows])

    def _abs(self, node: Any) -> _Range:
        a = self.of(node.args[1])
        highs = tuple(
            bound
            for high in a.highs
            for low in a.lows
            if (bound := self._least_above(high, -low)) is not None
        )
        found = (
            _Range((sympy.Integer(0),), highs, True, a.dtype, a.magnitude)
            if a.number
            else _Range((), (), False, a.dtype, a.magnitude)
        )
        return self._fitting(found)  # abs of the smallest integer is that integer

    def _same(self, node: Any) -> _Range:
        """Rounding to an integer, any way: bounds are integers, so they still hold."""
        return self.of(node.args[1])

    _floor = _ceil = _trunc = _round = _same

    def _floor_to_int(self, node: Any) -> _Range:
        return self._to_dtype(node)

    _trunc_to_int = _ceil_to_int = _round_to_int = _floor_to_int

    # --- helpers --------------------------------------------------------------------------------------------

    def _says_number(self, condition: Any, value: Any, *names: str) -> bool:
        """Whether `condition` is value == value (value != value, isnan(value)), so that the branch of `where`
        has no NaN. If a sum or a product is not NaN, its operands are not NaN either."""
        if not isinstance(condition, torch.fx.Node) or condition.target not in names:
            return False
        tested = condition.args[1]
        if not all(self._equal(a, tested) for a in condition.args[2:]):
            return False
        parts = (
            tested.args[1:]
            if isinstance(tested, torch.fx.Node) and tested.target in ("add", "sub", "mul")
            else ()
        )
        return any(self._equal(a, value) for a in (tested, *parts))

    def _equal(self, a: Any, b: Any) -> bool:
        """Whether two nodes compute the same value: one that is used twice may occur as two nodes."""
        if not isinstance(a, torch.fx.Node) or not isinstance(b, torch.fx.Node):
            return a == b
        if a is b:
            return True
        pair = (a, b)
        if pair not in self._equals:
            alike = (
                a.op == b.op and a.target == b.target and len(a.args) == len(b.args) and a.kwargs == b.kwargs
            )
            self._equals[pair] = alike and all(self._equal(x, y) for x, y in zip(a.args, b.args, strict=True))
        return self._equals[pair]

    @staticmethod
    def _less_of(a: tuple[sympy.Expr, ...], b: tuple[sympy.Expr, ...]) -> tuple[sympy.Expr, ...]:
        return tuple(
            x if _not_negative(y - x) else y
            for x in a
            for y in b
            if _not_negative(y - x) or _not_negative(x - y)
        )

    @staticmethod
    def _greater_of(a: tuple[sympy.Expr, ...], b: tuple[sympy.Expr, ...]) -> tuple[sympy.Expr, ...]:
        return tuple(
            y if _not_negative(y - x) else x
            for x in a
            for y in b
            if _not_negative(y - x) or _not_negative(x - y)
        )

    @staticmethod
    def _least_above(a: sympy.Expr, b: sympy.Expr) -> sympy.Expr | None:
        """An upper bound of both: one of them, or something greater if no rule orders them (as W - 2 and
        1)."""
        return next(
            (
                c
                for c in (a, b, sympy.expand(a + b), sympy.expand(a + b + 1))
                if _not_negative(c - a) and _not_negative(c - b)
            ),
            None,
        )

    def _computed(
        self, a: _Range, b: _Range, magnitude: float, lows: list[sympy.Expr], highs: list[sympy.Expr]
    ) -> _Range:
        """The result of arithmetic. Integers must not overflow; a float is rounded, which keeps a bound that
        it can represent."""
        dtype = torch.promote_types(a.dtype, b.dtype) if a.dtype and b.dtype else None
        if dtype is None:
            return _Range()
        lows, highs = [sympy.expand(x) for x in lows], [sympy.expand(x) for x in highs]
        if not dtype.is_floating_point:
            return self._fitting(_Range(tuple(lows), tuple(highs), True, dtype))
        if not (a.number and b.number and magnitude < float(torch.finfo(dtype).max) / 2):
            return _Range((), (), False, dtype)
        exact = _EXACT[dtype]
        return _Range(
            tuple(x for x in lows if _greatest(-x) <= exact),
            tuple(x for x in highs if _greatest(x) <= exact),
            True,
            dtype,
            magnitude,
        )

    @staticmethod
    def _fitting(found: _Range) -> _Range:
        """`found`, without bounds if the value may not fit into its integer type."""
        if found.dtype is None or found.dtype.is_floating_point:
            return found
        limits = torch.iinfo(found.dtype) if found.dtype != torch.bool else None
        fits = (
            limits is not None
            and any(_greatest(h) <= limits.max for h in found.highs)
            and any(_greatest(-low) <= -limits.min for low in found.lows)
        )
        return found if fits else _Range((), (), True, found.dtype)

    def _extreme(self, expression: sympy.Expr, greatest: bool) -> sympy.Expr | None:
        """The least or greatest value of an expression, or a bound of it, as an expression of sizes. The
        expression must be linear in the loop's variables and in absolute values of such expressions."""
        expression = sympy.expand(expression)
        absolutes = expression.atoms(sympy.Abs)
        for absolute in (a for a in absolutes if not any(other != a and other.has(a) for other in absolutes)):
            factor = expression.coeff(absolute, 1)
            rest = sympy.expand(expression - factor * absolute)
            if not factor.is_Integer or rest.has(absolute):
                return None
            bound = (
                self._greatest_absolute(absolute.args[0])
                if bool(factor > 0) == greatest
                else sympy.Integer(0)
            )
            if bound is None:
                return None
            expression = sympy.expand(rest + factor * bound)
        for variable, size in self._var_ranges.items():
            if variable not in expression.free_symbols:
                continue
            factor = expression.coeff(variable, 1)
            rest = sympy.expand(expression - factor * variable)
            if variable in rest.free_symbols or variable in factor.free_symbols:
                return None
            if _not_negative(factor):
                rising = True
            elif _not_negative(-factor):
                rising = False
            else:
                return None
            expression = rest + factor * (size - 1 if rising == greatest else 0)
        sizes = {s for s in expression.free_symbols if s in self._size_symbols()}
        return sympy.expand(expression) if sizes == expression.free_symbols else None

    def _greatest_absolute(self, expression: sympy.Expr) -> sympy.Expr | None:
        low, high = self._extreme(expression, greatest=False), self._extreme(expression, greatest=True)
        return None if low is None or high is None else self._least_above(high, -low)

    @staticmethod
    def _size_symbols() -> set[sympy.Symbol]:
        return set(_inductor().graph.sizevars.shape_env.var_to_range)
