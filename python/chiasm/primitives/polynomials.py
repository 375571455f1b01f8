"""Real roots of polynomials of any degree, in a fixed number of steps."""

from typing import List, Tuple

import torch
from torch import Tensor

from .loops import repeat


def real_roots(coefficients: Tensor) -> Tuple[Tensor, Tensor]:
    """Real roots of polynomials (..., n + 1), coefficients from the constant on: places u (..., n), ascending, and which of them exist.

    The root is u / (1 - |u|): u goes from -1 to 1 while x goes from minus to plus infinity; roots beyond 1e8 are not found.
    Between two neighbouring roots of its derivative a polynomial is monotone and has at most one root, which bisection finds; so the
    roots of all derivatives are found one after the other. Where there is no root the interval's lower end stands in its place, which
    does no harm as one more point between which the next polynomial is monotone. A double root is found twice or not at all.
    The roots are to 1e-14 of u's range; they carry no gradient.

    >>> u, exists = real_roots(torch.tensor([-6.0, 11.0, -6.0, 1.0], dtype=torch.float64))
    >>> (u / (1.0 - u.abs())).round(decimals=6), exists
    (tensor([1., 2., 3.], dtype=torch.float64), tensor([True, True, True]))
    """
    c = coefficients.detach()
    c = c / (c.abs().amax(-1, keepdim=True) + 1e-300)
    degree = c.size(-1) - 1
    derivatives = _derivatives(c)
    # Lower ends, upper ends and whether the polynomial is negative at the lower ends (..., 3, n + 1); the first interval is all.
    end = torch.full_like(c, 1.0 - 1e-8)
    state = torch.stack([end, end, torch.zeros_like(end)], -2)
    # one iteration to begin with a polynomial, 48 to halve its intervals to 1e-14
    count = 49 * degree
    if torch.jit.is_scripting():
        for k in range(count):
            state = _step(state, torch.full([], k, dtype=torch.int64, device=c.device), derivatives)
    else:
        state = repeat(_step, state, (derivatives,), count)
    low, high = state[..., 0, :degree], state[..., 1, :degree]
    return 0.5 * (low + high), high > low


def _derivatives(c: Tensor) -> Tensor:
    """The polynomials (n, ..., n + 1) from the last derivative, of degree one, to the polynomial itself; absent powers have zeros."""
    degree = c.size(-1) - 1
    rows: List[Tensor] = [c]
    power = torch.arange(1, degree + 1, device=c.device).to(c.dtype)
    for _ in range(degree - 1):
        last = rows[0]
        rows.insert(0, torch.cat([last[..., 1:] * power, torch.zeros_like(last[..., :1])], -1))
    return torch.stack(rows, 0)


def _step(state: Tensor, k: Tensor, derivatives: Tensor) -> Tensor:
    """Halve the intervals; every 49th time take their middles as the ends of the next polynomial's intervals instead."""
    low, high, negative = state[..., 0, :], state[..., 1, :], state[..., 2, :]
    phase = torch.div(k, 49, rounding_mode="floor")
    first = k == 49 * phase
    polynomial = derivatives.index_select(0, phase.reshape(1))[0]
    middle = 0.5 * (low + high)
    size = middle.size(-1)
    end = torch.full_like(middle[..., :1], 1.0 - 1e-8)
    ends = torch.cat([-end, middle[..., : size - 1]], -1)
    at = torch.where(first, ends, middle)
    value = (_value(polynomial, at) < 0).to(state.dtype)
    # halving: the lower end moves up where the sign there is still that of the lower end
    before = value == negative
    halved = torch.stack([torch.where(before, middle, low), torch.where(before, high, middle), negative], -2)
    # beginning: an interval without a change of sign shrinks to its lower end
    upper = torch.cat([ends[..., 1:], end], -1)
    upper_value = torch.cat([value[..., 1:], value[..., size - 1 :]], -1)
    begun = torch.stack([ends, torch.where(value == upper_value, ends, upper), value], -2)
    return torch.where(first, begun, halved)


def _value(polynomial: Tensor, u: Tensor) -> Tensor:
    """The polynomial (..., d + 1) at u / (1 - |u|) (..., m)."""
    x = u / (1.0 - u.abs())
    power = torch.arange(polynomial.size(-1), device=u.device).to(u.dtype)
    return (torch.pow(x[..., None], power) * polynomial[..., None, :]).sum(-1)
