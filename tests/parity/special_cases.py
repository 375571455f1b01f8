"""Special values for any op: which values replace which elements, and which of eager Python's results depend
on them and not on rounding."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

Inputs = dict[str, Tensor]

#: The value that an element gets; "negated" and the integers' "wrong sign" depend on the tensor's own values.
FLOATS = (
    "nan",
    "inf",
    "-inf",
    "0",
    "denormal",
    "1e10",
    "-1e10",
    "3e9",
    "-3e9",
    "1e38",
    "-1e38",
    "largest",
    "negated",
)
INTEGERS = ("least", "largest", "0", "-1", "-5", "1000000000", "256")
PATTERNS = ("all", "one", "row")
#: Whole matrices (last two dimensions) for solvers: of rank one, and of rank one less than full.
MATRICES = ("rank one", "equal rows")


@dataclass(frozen=True)
class Case:
    """A tensor of an op's inputs, the value to put into it, and the place."""

    tensor: str
    value: str
    pattern: str

    def __str__(self) -> str:
        return f"{self.tensor}={self.value}, {self.pattern}"


def cases(inputs: Inputs) -> Iterator[Case]:
    """All cases for an op's inputs, beginning with those that found most bugs."""
    for pattern in PATTERNS:
        for name, tensor in inputs.items():
            if (
                tensor.numel() == 0
                or (pattern != "all" and tensor.dim() == 0)
                or (pattern == "row" and tensor.dim() < 2)
            ):
                continue
            values = FLOATS if tensor.is_floating_point() else INTEGERS
            for value in values:
                if filled(tensor, value) is not None:
                    yield Case(name, value, pattern)
    for name, tensor in inputs.items():
        if (
            tensor.is_floating_point()
            and tensor.dim() >= 2
            and 1 < tensor.size(-2) <= 8
            and 1 < tensor.size(-1) <= 8
        ):
            for value in MATRICES:
                yield Case(name, value, "all")


def filled(tensor: Tensor, value: str) -> Tensor | None:
    """A tensor of special values, from which a case takes its elements; None if the dtype cannot represent
    the value."""
    if tensor.is_floating_point():
        limits = torch.finfo(tensor.dtype)
        if value == "negated":
            return -tensor
        number = {"denormal": limits.tiny / 8, "largest": limits.max}.get(value)
        number = float(value) if number is None else number
        return (
            None
            if abs(number) > limits.max and number not in (float("inf"), float("-inf"))
            else torch.full_like(tensor, number)
        )
    if tensor.dtype == torch.bool:
        return torch.full_like(tensor, value == "-1") if value in ("0", "-1") else None
    limits = torch.iinfo(tensor.dtype)
    number = {"least": limits.min, "largest": limits.max}.get(value)
    number = int(value) if number is None else number
    return torch.full_like(tensor, number) if limits.min <= number <= limits.max else None


def apply(inputs: Inputs, case: Case) -> Inputs:
    """The inputs with the case's values in them."""
    tensor = inputs[case.tensor]
    if case.value == "rank one":
        changed = tensor[..., :1] * tensor[..., :1, :]
    elif case.value == "equal rows":
        changed = torch.cat([tensor[..., :1, :], tensor[..., :1, :], tensor[..., 2:, :]], -2)
    else:
        values = filled(tensor, case.value)
        assert values is not None, case
        changed = values if case.pattern == "all" else tensor.clone()
        if case.pattern == "one":
            changed.view(-1)[tensor.numel() // 2] = values.view(-1)[tensor.numel() // 2]
        elif case.pattern == "row":
            rows = changed.view(-1, tensor.size(-1))
            rows[rows.size(0) // 2] = values.view(-1, tensor.size(-1))[rows.size(0) // 2]
    return inputs | {case.tensor: changed.contiguous()}


def doubled(inputs: Inputs) -> Inputs:
    """The same numbers in float64."""
    return {n: t.double() if t.is_floating_point() else t for n, t in inputs.items()}


def shaken(inputs: Inputs, seed: int, rtol: float) -> Inputs:
    """The inputs with each number changed by up to 128 of its dtype's roundings, or an eighth of the
    tolerance; special values stay."""
    generator = torch.Generator().manual_seed(seed)
    return {n: _shaken(t, generator, rtol) if t.is_floating_point() else t for n, t in inputs.items()}


def _shaken(t: Tensor, generator: torch.Generator, rtol: float) -> Tensor:
    limits = torch.finfo(t.dtype)
    most = min(128.0 * limits.eps, rtol / 8)
    share = (torch.rand(t.shape, generator=generator, dtype=torch.float64) * 2.0 - 1.0) * most
    moved = (t.double() * (1.0 + share)).clamp(-limits.max, limits.max).to(t.dtype)
    return torch.where(t.isfinite(), moved, t)


def agreeing(a: Tensor, b: Tensor, atol: float, rtol: float) -> Tensor:
    """A mask: true where two results are equal, both NaN, or within the tolerance."""
    a, b = a.double(), b.double()
    near = (a - b).abs() <= atol + rtol * b.abs()  # false for infinities; equal infinities are covered next
    return (a == b) | (a.isnan() & b.isnan()) | (near & a.isfinite() & b.isfinite())


def determined(result: Tensor, others: Sequence[Tensor], atol: float, rtol: float) -> Tensor:
    """True where eager Python's result depends on the input and not on rounding: there it is the same in
    float64 and for shaken inputs.

    Only there must other engines give the same: for example, whether sums of the largest numbers overflow
    depends on their order.
    """
    known = torch.ones_like(result, dtype=torch.bool)
    if result.is_floating_point():
        # Within a rounding of infinity
        known = ~(result.isfinite() & (result.abs() > torch.finfo(result.dtype).max / 4))
    for other in others:
        if other.shape == result.shape:
            known = known & agreeing(other, result, atol, rtol)
    return known
