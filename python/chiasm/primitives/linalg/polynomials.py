"""Polynomials: products, and real roots of any degree in a fixed number of steps."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.loops import repeated
from ..core.lowering import primitive
from ..kernels import operators as kernels
from .matrices import small_matmul


def real_roots(coefficients: Tensor, halvings: int = 48) -> Tuple[Tensor, Tensor]:
    """Real roots of polynomials (..., n + 1), with the constant coefficient first: ascending positions u
    (..., n), float64, and whether each exists.

    The root is u / (1 - |u|): u goes from -1 to 1 while x goes from minus to plus infinity; roots beyond 1e8
    are not found. Between two neighbouring roots of its derivative, a polynomial is monotone and has at most
    one root, which bisection finds; so the roots of all derivatives are found one after the other. If an
    interval has no root, its lower end is used instead: it only splits an interval in which the next
    polynomial is monotone. A double root is found twice or not at all. Roots are accurate to 2 ** (1 -
    halvings) of u's range, 1e-14 with 48; roots closer together may be missed. Native code may halve further
    than that. Roots carry no gradient.

    >>> u, exists = real_roots(torch.tensor([-6.0, 11.0, -6.0, 1.0], dtype=torch.float64))
    >>> (u / (1.0 - u.abs())).round(decimals=6), exists
    (tensor([1., 2., 3.], dtype=torch.float64), tensor([True, True, True]))
    """
    # The axis of polynomials is last, because arithmetic on long rows is fast.
    exact = coefficients if coefficients.dtype == torch.float64 else coefficients.to(torch.float64)
    c = exact.detach().movedim(-1, 0).contiguous()
    return _found(c / (c.abs().amax(0) + 1e-300), halvings)


@primitive
def _found(c: Tensor, halvings: int) -> Tuple[Tensor, Tensor]:
    """``real_roots`` of polynomials (n + 1, ...), float64, whose largest coefficient is 1."""
    degree = c.size(0) - 1
    derivatives = _derivatives(c)
    # The intervals' lower ends, their upper ends, and whether the polynomial is negative at the lower ends:
    # (3, n + 1, ...). The first interval is the whole range.
    end = torch.full_like(c, 1.0 - 1e-8)
    state = torch.stack([end, end, torch.zeros_like(end)], 0)
    # one iteration starts a polynomial, the others halve its intervals
    count = (halvings + 1) * degree
    state = _halved(state, count, derivatives, halvings + 1)
    low, high = state[0, :degree].movedim(0, -1), state[1, :degree].movedim(0, -1)
    return 0.5 * (low + high), high > low


def _has_roots(c: Tensor, _: int) -> bool:
    return kernels.available(c) and c.dtype == torch.float64 and c.size(0) <= kernels.MOST_TERMS


@_found.lowering("native", when=_has_roots)
def _found_kernel(c: Tensor, halvings: int) -> Tuple[Tensor, Tensor]:
    both = kernels.real_roots(c.flatten(1).contiguous())
    u, exists = both[0], both[1] > 0
    return u.unflatten(1, c.shape[1:]).movedim(0, -1), exists.unflatten(1, c.shape[1:]).movedim(0, -1)


def _derivatives(c: Tensor) -> Tensor:
    """The polynomials (n, n + 1, ...) from the last derivative, of degree one, to the polynomial itself;
    coefficients of higher powers are zeros."""
    rows: List[Tensor] = [c]
    for _ in range(c.size(0) - 2):
        last = rows[0]
        powers = [last[k] * float(k) for k in range(1, c.size(0))]
        rows.insert(0, torch.stack(powers + [torch.zeros_like(last[0])], 0))
    return torch.stack(rows, 0)


@repeated
def _halved(state: Tensor, k: Tensor, derivatives: Tensor, period: int) -> Tensor:
    """Halve the intervals; every ``period``-th time, use their midpoints as the ends of the next polynomial's
    intervals instead."""
    low, high, negative = state[0], state[1], state[2]
    phase = torch.div(k, period, rounding_mode="floor")
    first = k == period * phase
    polynomial = derivatives.index_select(0, phase.reshape(1))[0]
    middle = 0.5 * (low + high)
    size = middle.size(0)
    end = torch.full_like(middle[:1], 1.0 - 1e-8)
    ends = torch.cat([-end, middle[: size - 1]], 0)
    at = torch.where(first, ends, middle)
    value = (_value(polynomial, at) < 0).to(state.dtype)
    # halving: the lower end moves to the middle if the sign is the same there
    before = value == negative
    halved = torch.stack([torch.where(before, middle, low), torch.where(before, high, middle), negative], 0)
    # starting: an interval without a change of sign shrinks to its lower end
    upper = torch.cat([ends[1:], end], 0)
    upper_value = torch.cat([value[1:], value[size - 1 :]], 0)
    begun = torch.stack([ends, torch.where(value == upper_value, ends, upper), value], 0)
    return torch.where(first, begun, halved)


def _value(polynomial: Tensor, u: Tensor) -> Tensor:
    """The polynomial (d + 1, ...) at u / (1 - |u|) (m, ...), by Horner's scheme."""
    x = u / (1.0 - u.abs())
    value = polynomial[-1]
    for k in range(2, polynomial.size(0) + 1):
        value = value * x + polynomial[-k]
    return value


@primitive
def product_of_coefficients(a: Tensor, b: Tensor, place: List[int], count: int) -> Tensor:
    """Products of all pairs of coefficients (..., n) and (..., m), added up at their places: (..., count).

    >>> product_of_coefficients(
    ...     torch.tensor([1.0, 1.0]), torch.tensor([1.0, 1.0]), [0, 1, 1, 2], 3
    ... )  # (1 + x)^2
    tensor([1., 2., 1.])
    """
    pairs = (a[..., :, None] * b[..., None, :]).flatten(-2)
    wanted = torch.tensor(place, device=a.device)[:, None] == torch.arange(count, device=a.device)[None, :]
    return small_matmul(pairs[..., None, :], wanted.to(a.dtype))[..., 0, :]


# A product with a matrix of ones and zeros takes ten times as many multiplications.
@product_of_coefficients.lowering("native")
def _fetched(a: Tensor, b: Tensor, place: List[int], count: int) -> Tensor:
    pairs = (a[..., :, None] * b[..., None, :]).flatten(-2)
    table, weights = _places(place, count)
    size = len(table) // count
    fetched = pairs.index_select(-1, torch.tensor(table, device=a.device)) * torch.tensor(
        weights, dtype=a.dtype, device=a.device
    )
    return fetched.unflatten(-1, [count, size]).sum(-1)


def _places(place: List[int], count: int) -> Tuple[List[int], List[float]]:
    """For each of ``count`` sums, the pairs that belong to it, and their weights. All lists have the same
    length: the weight is 1, or 0 for padding."""
    size = 0
    for k in range(count):
        size = max(size, place.count(k))
    table: List[int] = []
    weights: List[float] = []
    for k in range(count):
        for i in range(len(place)):
            if place[i] == k:
                table.append(i)
                weights.append(1.0)
        for _ in range(size - place.count(k)):
            table.append(0)
            weights.append(0.0)
    return table, weights
