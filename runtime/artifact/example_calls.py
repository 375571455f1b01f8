"""Finds calls that the declaration of a kernel allows, and calls that it forbids, for tests.

A call is the values of all names in a declaration: sizes, numbers, enumerators, and for an int64 tensor that
conditions name, some of its entries. They are searched for one after the other among small sizes and the
numbers at which a condition begins or ceases to hold, in an order that depends on the call's number: the same
declarations give the same calls everywhere.
"""

import ast
import functools
import hashlib
import itertools
import math
from typing import Any, Dict, Iterator, List, Optional, Sequence, Set, Tuple

from kernels.declarations import CONSTANTS, ENUMERATIONS
from kernels.schema import INT32_MAX, DeclarationError, Kernel, identifiers

Call = Dict[str, Any]

#: The sizes and whole numbers that are tried first: less than a vector and slightly more, parts of two and of
#: four vectors, more than a tile's rows. Sizes are 0 in some calls.
SMALL = (1, 2, 3, 4, 5, 9, 17, 33, 67, 261)
#: The same for numbers that are no sizes.
NUMBERS = (1, 2, 3, 4, 5, 9, 33)
#: The same for numbers of images and of channels.
FEW = (1, 2, 3, 4)
#: Tried last, for what is forbidden.
LARGE = (2**10, 2**20, 2**30)
FLOATS = (0.5, 0.0, 1.0, -1.0, 0.125, 1e-6, 255.5, -3.0)
SPECIAL = (math.inf, math.nan, -math.inf, 1e10, -0.0, 5e-324, -1e300)
#: The most values of a tensor, and the most that all sizes may multiply to: a bound of the time of a call.
MOST_VALUES, MOST_WORK = 2**13, 2**18
#: The steps of a search that finds nothing.
MOST_STEPS = 3000
#: How many entries are found for each int64 tensor that conditions name; tests repeat them.
ENTRIES = 4
#: The leading sizes "...", which the tests' tensors have as (count, 1).
FOLDED = "count"

#: The number of a call that is not allowed.
FORBIDDEN = -1

_ANY = (-(2**63), 2**63 - 1)
_KNOWN = {"__builtins__": {}, "INT32_MAX": INT32_MAX, **CONSTANTS}
_ENUMERATORS = {e.name: e.values for e in ENUMERATIONS}


class Expression:
    """A condition or a size of a result, and the names in it."""

    def __init__(self, text: str, kernel: Kernel) -> None:
        self.text, self.kernel = text, kernel
        self.names = {name for name in identifiers(text, kernel.name) if name not in _KNOWN}
        self._code = compile(text, text, "eval")
        node = ast.parse(text, mode="eval").body
        self._pairs: List[Tuple[ast.expr, ast.cmpop, ast.expr]] = []
        if isinstance(node, ast.Compare):
            self._pairs = list(zip([node.left, *node.comparators], node.ops, node.comparators))
        #: The name that it says is equal to something.
        self.equated = [
            left.id
            for left, operator, _ in self._pairs
            if isinstance(left, ast.Name) and isinstance(operator, ast.Eq)
        ]

    @property
    def comparisons(self) -> List["Expression"]:
        """Each comparison in a chain."""
        if len(self._pairs) < 2:
            return [self]
        chain = (ast.Compare(left, [operator], [right]) for left, operator, right in self._pairs)
        return [Expression(ast.unparse(one), self.kernel) for one in chain]

    def value(self, call: Call) -> Any:
        return eval(self._code, _KNOWN, call)

    def holds(self, call: Call) -> bool:
        try:
            return bool(self.value(call))
        except ZeroDivisionError:
            return False

    def suggestions(self, name: str, call: Call) -> Iterator[Tuple[int, bool]]:
        """Numbers for ``name``, given the other values: those around which a comparison changes, and whether
        it is that of two equal values."""
        for left, operator, right in self._pairs:
            inside = {n.id for side in (left, right) for n in ast.walk(side) if isinstance(n, ast.Name)}
            if name not in inside or not inside <= {name, *call, *_KNOWN}:
                continue
            if isinstance(operator, ast.In) and isinstance(right, ast.Tuple):
                sides = right.elts if isinstance(left, ast.Name) and left.id == name else [left]
                yield from ((_value(side, call), False) for side in sides)
            elif isinstance(left, ast.BinOp) and isinstance(left.op, ast.Mod):
                yield from ((n, False) for n in self._with_remainder(left, _value(right, call), name, call))
            else:
                try:
                    at_0, at_1 = (
                        _value(left, {**call, name: x}) - _value(right, {**call, name: x}) for x in (0, 1)
                    )
                except (TypeError, ZeroDivisionError):
                    continue
                if at_1 != at_0:
                    root = -at_0 // (at_1 - at_0)
                    is_equal = isinstance(operator, ast.Eq)
                    yield from ((n, is_equal and n == root) for n in (root, root + 1, root - 1))

    @staticmethod
    def _with_remainder(left: ast.BinOp, remainder: int, name: str, call: Call) -> Iterator[int]:
        if isinstance(left.right, ast.Name) and left.right.id == name:
            whole = _value(left.left, call)
            yield from (d for d in (*SMALL, whole) if d and (whole - remainder) % d == 0)
            return
        known = [n for side in (left.left, left.right) for n in ast.walk(side)]
        factors = [call[n.id] for n in known if isinstance(n, ast.Name) and n.id in call]
        factors += [n.value for n in known if isinstance(n, ast.Constant)]
        product = math.prod(factor for factor in factors if isinstance(factor, int))
        yield from (product * small + remainder for small in SMALL)


def _value(node: ast.expr, call: Call) -> Any:
    return eval(_compiled(node), _KNOWN, call)


@functools.cache
def _compiled(node: ast.expr) -> Any:
    return compile(ast.Expression(node), "", "eval")


class Search:
    """Searches for calls of a kernel."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.conditions = [Expression(text, kernel) for text in kernel.conditions]
        self.shapes = [[size if size != "..." else FOLDED for size in t.shape or ()] for t in kernel.tensors]
        sizes = dict.fromkeys(s for shape in self.shapes for s in shape if s.isidentifier())
        numbers = {a.name: a.type for a in kernel.arguments if a.shape is None}
        compared = {name for condition in self.conditions for name in condition.names}
        self.entries = [t.name for t in kernel.tensors if t.type == "int64" and t.name in compared]
        self.limits = {limited: (low, high) for limited, low, high in kernel.tried}
        self.sizes = list(sizes)
        self.types = numbers
        #: Those with few values, of which every combination is tried.
        self.choices = {
            name: _ENUMERATORS.get(kind, (0, 1))
            for name, kind in numbers.items()
            if kind == "bool" or kind in _ENUMERATORS
        }
        # Numbers before sizes: a row of pixels with a given number of channels is easy to find. What a
        # condition equates with others' values comes later, and last what no condition names.
        equated = {name for condition in self.conditions for name in condition.equated}
        order = [*self.choices, *(n for n in numbers if n not in self.choices), *sizes]
        free = {name for name, kind in numbers.items() if kind == "float"} - compared
        self.order = sorted(order, key=lambda name: (name in free, name in equated))
        #: Numbers of images and channels: the first size of tensors with three or more, N if it is one that
        #: is first, and C if it is never last.
        first, last = (
            {shape[0] for shape in self.shapes if shape},
            {shape[-1] for shape in self.shapes if shape},
        )
        self.few = {shape[0] for shape in self.shapes if len(shape) > 2} | (first & {"N"}) | ({"C"} - last)
        self.result = [
            Expression(FOLDED if size == "..." else size, kernel) for size in kernel.result.shape or ()
        ]

    def allowed(self, number: int) -> Optional[Call]:
        """The allowed call with a number. The first has the smallest sizes; then each size is 0 once."""
        zero = self.sizes[number - 1] if 1 <= number <= len(self.sizes) else ""
        order = self.order if not zero else [zero, *(name for name in self.order if name != zero)]
        first = [c for c in self.conditions if not c.names & set(self.entries)]
        for call in self._assign(order, first, number, zero, small=True):
            found = self._entries(call, number)
            if found is not None:
                return {**call, **found}
        return None

    def forbidden(self) -> Iterator[Tuple[str, Call]]:
        """For each comparison in the conditions a call for which those before hold, and it does not; if
        possible, it is the only one; and if it bounds a number or entries alone, one with the furthest value.
        Omits comparisons that those before imply."""
        for i, condition in enumerate(self.conditions):
            before, after = self.conditions[:i], self.conditions[i + 1 :]
            for broken in condition.comparisons:
                found = self._breaking(broken, before + after) or self._breaking(broken, before)
                if found is None:
                    continue
                yield condition.text, found
                name = min(broken.names)
                if len(broken.names) == 1 and name not in self.sizes and isinstance(found[name], int):
                    far = {**found, name: _ANY[1] if found[name] > 0 else _ANY[0]}
                    if not broken.holds(far) and all(c.holds(far) for c in before):
                        yield condition.text, far

    def _breaking(self, broken: Expression, others: Sequence[Expression]) -> Optional[Call]:
        order: List[str] = []
        rest = sorted([*self.order, *self.entries], key=lambda name: name not in broken.names)
        while rest:  # next what depends on the values so far
            near = {name for c in self.conditions if c.names & set(order) for name in c.names}
            order.append(next((name for name in rest if name in near), rest[0]))
            rest.remove(order[-1])
        return next(self._assign(order, others, FORBIDDEN, "", small=False, broken=broken), None)

    def _entries(self, call: Call, number: int) -> Optional[Call]:
        """Entries for all int64 tensors that conditions name, or None if there are none."""
        shapes = dict(zip((t.name for t in self.kernel.tensors), self.shapes))
        empty = {name for name in self.entries if any(call.get(size) == 0 for size in shapes[name])}
        found: List[Call] = []
        conditions = [c for c in self.conditions if c.names & (set(self.entries) - empty)]
        for i in range(ENTRIES):
            complete = next(
                self._assign(self.entries, conditions, (number + 1) * ENTRIES + i, "", True, call), None
            )
            if complete is None:
                return None
            found.append(complete)
        return {name: [complete[name] for complete in found] for name in self.entries}

    def _assign(
        self,
        order: Sequence[str],
        conditions: Sequence[Expression],
        number: int,
        zero: str,
        small: bool,
        start: Optional[Call] = None,
        broken: Optional[Expression] = None,
    ) -> Iterator[Call]:
        steps = itertools.count()
        relevant = [*conditions, *([broken] if broken else [])]

        def extend(call: Call, i: int) -> Iterator[Call]:
            if i == len(order):
                yield dict(call)
                return
            name = order[i]
            for value in self._candidates(name, call, number, zero, relevant):
                if next(steps) > MOST_STEPS:
                    return
                call[name] = value
                if self._is_open(name, call, conditions, small, broken):
                    yield from extend(call, i + 1)
                del call[name]

        yield from extend(dict(start or {}), 0)

    def _is_open(
        self,
        name: str,
        call: Call,
        conditions: Sequence[Expression],
        small: bool,
        broken: Optional[Expression],
    ) -> bool:
        """Whether nothing speaks against the values so far, of which the last is that of ``name``."""
        known = set(call)
        if broken is not None and broken.names <= known and broken.holds(call):
            return False
        if any(name in c.names and c.names <= known and not c.holds(call) for c in conditions):
            return False
        least = 1 if small else 0
        counts = [
            math.prod(max(least, call.get(s, 1)) if s.isidentifier() else int(s) for s in shape)
            for shape in self.shapes
        ]
        if not small:
            # The conditions on entries are checked for those that there are.
            if broken and broken.names & set(self.entries) and name in self.sizes and call[name] == 0:
                return False
            return all(
                count <= (MOST_VALUES if tensor.name in self.entries else 2**60)
                for tensor, count in zip(self.kernel.tensors, counts)
            )
        if math.prod(max(1, call[s]) for s in self.sizes if s in call) > MOST_WORK:
            return False
        if max(counts) > MOST_VALUES:
            return False
        result = [size.value(call) for size in self.result if size.names <= known]
        return min(result, default=0) >= 0 and math.prod(max(1, size) for size in result) <= MOST_VALUES

    def _candidates(
        self, name: str, call: Call, number: int, zero: str, conditions: Sequence[Expression]
    ) -> List[Any]:
        if name in self.choices:
            place = 1
            for other, values in self.choices.items():
                if other == name:
                    return _rotated(values, max(number, 0) // place)
                place *= len(values)
        turn = 0
        if number > 0:
            text = f"{self.kernel.name} {name} {number}"
            turn = int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little")
        if self.types.get(name) == "float":
            return [*_rotated(SPECIAL, turn), *FLOATS] if number % 4 == 3 else _rotated(FLOATS, turn)
        if name == zero:
            return [0]
        near = [pair for c in conditions if name in c.names for pair in c.suggestions(name, call)]
        equal = sorted({n for n, is_equal in near if is_equal})
        found: Set[int] = {n for n, _ in near}
        # A size beyond the small ones is one that conditions ask for.
        found.update(FEW if name in self.few else SMALL if name in self.sizes else NUMBERS)
        limits = self.limits.get(name, _ANY)
        if number == FORBIDDEN:
            found.update(LARGE)
            limits = _ANY
        if name in self.sizes:
            found = {n for n in found if n >= 0} | {0}
        low, high = limits
        # Positive numbers as a rule: the others end most calls early.
        rare = sorted((n for n in found if low <= n <= min(high, 0)), reverse=True)
        usual = sorted(n for n in found if max(low, 1) <= n <= high)
        huge = []
        if number > 0:
            alone = [c for c in conditions if c.names == {name}]
            usual = [n for n in usual if all(c.holds({name: n}) for c in alone)]
            # The limits of numbers in some calls only: with them, many kernels do little else.
            huge = [n for n in usual if n > SMALL[-1]][-2:]
            usual = [n for n in usual if n <= SMALL[-1]]
            if name in self.sizes or name in self.entries or number % 4 == 1:
                usual, huge = usual + huge, []
        if name in self.entries:
            return _rotated([*usual, *rare], turn)
        # If one is too large, then the next smaller ones.
        first = turn % max(1, len(usual))
        return [*equal, *reversed(usual[: first + 1]), *usual[first + 1 :], *huge, *rare]


def _rotated(values: Sequence[Any], turn: int) -> List[Any]:
    return [*values[turn % len(values) :], *values[: turn % len(values)]] if values else []


@functools.cache
def allowed(kernel: Kernel, count: int) -> List[Call]:
    """Up to ``count`` different calls."""
    search = Search(kernel)
    found: Dict[str, Call] = {}
    for number in range(count):
        call = search.allowed(number)
        if call is not None:
            found.setdefault(str(sorted(call.items())), call)
        elif number > len(search.sizes) and not found:
            break
    if not found:
        raise DeclarationError(
            f"kernel {kernel.name}: no small sizes and numbers meet its conditions together, so no"
            " test can call it"
        )
    return list(found.values())
