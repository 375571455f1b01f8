"""Stumpff functions: the remainders of cosine and sine after their first terms, without cancellation."""

import torch
from torch import Tensor


def stumpff(squared: Tensor, order: int) -> Tensor:
    """c_n(s) = sum over k of (-s)^k / (2 k + n)!, smooth also at s = 0.

    With a = sqrt(s): c_0 = cos a, c_1 = sin a / a, c_2 = (1 - cos a) / s, c_3 = (a - sin a) / a^3, and so on:
    s c_{n+2} = 1 / n! - c_n. (K. Stumpff, Himmelsmechanik I, 1959.) Below s = 4 the series is used, whose 12
    terms are exact in float64.

    Args:
        squared: s, not negative, floating point.
        order: n, 0 to 5.

    Returns:
        The shape of squared.

    >>> stumpff(torch.tensor([0.0, 9.0]), 1)
    tensor([1.0000, 0.0470])
    """
    small = squared < 4.0
    low = torch.where(small, squared, torch.zeros_like(squared))
    high = torch.where(small, torch.full_like(squared, 4.0), squared)
    series = torch.ones_like(low)
    for k in range(11, 0, -1):
        series = 1.0 - series * low / float((2 * k + order - 1) * (2 * k + order))
    angle = torch.sqrt(high)
    exact = torch.cos(angle) if order % 2 == 0 else torch.sin(angle) / angle
    factorial = 1.0
    for n in range(order % 2, order, 2):
        exact = (1.0 / factorial - exact) / high
        factorial = factorial * (n + 1) * (n + 2)
    return torch.where(small, series / factorial, exact)
