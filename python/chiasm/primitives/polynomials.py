"""Real roots of polynomials of any degree, in a fixed number of steps."""

from typing import List, Tuple

import torch
from torch import Tensor

from .loops import repeat


def real_roots(coefficients: Tensor, steps: int = 48) -> Tuple[Tensor, Tensor]:
    """Real roots of polynomials (..., n + 1), coefficients from the constant on: places u (..., n), ascending, and which of them exist.

    The root is u / (1 - |u|): u goes from -1 to 1 while x goes from minus to plus infinity, so that no root is out of reach.
    Between two neighbouring roots of its derivative a polynomial is monotone and has at most one root, which bisection finds; so the
    roots of all derivatives are found one after the other. Where there is no root, the interval's lower end stands in its place, which
    does no harm as one more point between which the next polynomial is monotone. A double root is found twice or not at all.

    >>> u, exists = real_roots(torch.tensor([-6.0, 11.0, -6.0, 1.0], dtype=torch.float64))
    >>> (u / (1.0 - u.abs())).round(decimals=6), exists
    (tensor([1., 2., 3.], dtype=torch.float64), tensor([True, True, True]))
    """
    c = coefficients.detach()
    c = c / (c.abs().amax(-1, keepdim=True) + 1e-300)
    degree = c.size(-1) - 1
    derivatives: List[Tensor] = [c]
    for k in range(degree - 1):
        last = derivatives[k]
        powers = torch.arange(1, degree + 1 - k, device=c.device).to(c.dtype)
        derivatives.append(last[..., 1:] * powers)
    one = torch.ones_like(c[..., :1])
    bounds = torch.cat([-one, one], -1)
    roots = one
    exists = one > 0
    for k in range(degree):
        polynomial = derivatives[degree - 1 - k]
        low, high = bounds[..., :-1], bounds[..., 1:]
        rising = _value(polynomial, low) < 0
        exists = rising != (_value(polynomial, high) < 0)
        state = torch.stack([low, torch.where(exists, high, low)], -2)
        if torch.jit.is_scripting():
            for _ in range(steps):
                state = _halved(state, torch.zeros([], dtype=torch.int64), polynomial, rising)
        else:
            state = repeat(_halved, state, (polynomial, rising), steps)
        roots = 0.5 * (state[..., 0, :] + state[..., 1, :])
        bounds = torch.cat([-one, roots, one], -1)
    return roots, exists


def _halved(state: Tensor, k: Tensor, polynomial: Tensor, rising: Tensor) -> Tensor:
    """The half of each interval, lower ends and upper ends (..., 2, m), in which the sign changes."""
    low, high = state[..., 0, :], state[..., 1, :]
    middle = 0.5 * (low + high)
    before = (_value(polynomial, middle) < 0) == rising
    return torch.stack([torch.where(before, middle, low), torch.where(before, high, middle)], -2)


def _value(polynomial: Tensor, u: Tensor) -> Tensor:
    """The polynomial (..., d + 1) at u / (1 - |u|) (..., m), times (1 - |u|)^d."""
    power = torch.arange(polynomial.size(-1), device=u.device).to(u.dtype)
    terms = torch.pow(u[..., None], power) * torch.pow(1.0 - u.abs()[..., None], polynomial.size(-1) - 1 - power)
    return (terms * polynomial[..., None, :]).sum(-1)
