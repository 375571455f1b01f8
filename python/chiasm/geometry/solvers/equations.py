"""Real roots of equations of degree two to four.

Closed forms in float64, polished by Newton's method. They see no gradient: the derivative of a root x of p is -dp(x) / p'(x), by one
more step. Among the roots, minus infinity stands for one that is not there.
"""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.checks import check_last
from ...primitives.target import native_forward, onnx_forward


def solve_quadratic(coeffs: Tensor) -> Tensor:
    """Real roots of a x^2 + b x + c = 0.

    Without cancellation: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 1.8. A discriminant within rounding of 0
    gives a double root. Where a is 0 the equation is linear.

    Args:
        coeffs: (*, 3), floating point, a, b, c.

    Returns:
        (*, 2), in descending order, followed by zeros for the roots that are missing or complex. A double root is there twice; its
        gradient is 0.

    Raises:
        TypeError, ValueError: if coeffs is not a floating-point (*, 3) tensor.

    Example:
        >>> solve_quadratic(torch.tensor([[1.0, -3.0, 2.0], [1.0, 0.0, 1.0], [0.0, 2.0, -8.0]]))
        tensor([[2., 1.],
                [0., 0.],
                [4., 0.]])
    """
    check_last(coeffs, 3, "coeffs")
    c = coeffs.to(torch.float64)
    return _finished(c, _quadratic(c.detach())).to(coeffs.dtype)


def solve_cubic(coeffs: Tensor) -> Tensor:
    """Real roots of a x^3 + b x^2 + c x + d = 0.

    By Cardano's formula, or by cosines where there are three. A discriminant within rounding of 0 gives a double root. Where a is 0
    the equation is quadratic. One root may be very large or very small; where both are, by more than 1e7 or so from the third, it is lost.

    Args:
        coeffs: (*, 4), floating point, a, b, c, d.

    Returns:
        (*, 3), in descending order, followed by zeros for the roots that are missing or complex. A multiple root is there as
        often; its gradient is 0.

    Raises:
        TypeError, ValueError: if coeffs is not a floating-point (*, 4) tensor.

    Example:
        >>> solve_cubic(torch.tensor([[1.0, -6.0, 11.0, -6.0], [1.0, 0.0, 0.0, -8.0]]))
        tensor([[3., 2., 1.],
                [2., 0., 0.]])
    """
    check_last(coeffs, 4, "coeffs")
    c = coeffs.to(torch.float64)
    return _finished(c, _cubic(c.detach())).to(coeffs.dtype)


def solve_quartic(coeffs: Tensor) -> Tensor:
    """Real roots of a x^4 + b x^3 + c x^2 + d x + e = 0.

    By Ferrari's method: two quadratic factors from the largest root of the resolvent cubic. Where a is 0 the equation is cubic.

    Args:
        coeffs: (*, 5), floating point, a, b, c, d, e.

    Returns:
        (*, 4), in descending order, followed by zeros for the roots that are missing or complex. A double root is there twice; its
        gradient is 0.

    Raises:
        TypeError, ValueError: if coeffs is not a floating-point (*, 5) tensor.

    Example:
        >>> solve_quartic(torch.tensor([[1.0, -10.0, 35.0, -50.0, 24.0], [1.0, 0.0, 0.0, 0.0, -16.0]]))
        tensor([[ 4.,  3.,  2.,  1.],
                [ 2., -2.,  0.,  0.]])
    """
    check_last(coeffs, 5, "coeffs")
    c = coeffs.to(torch.float64)
    return _finished(c, _quartic(c.detach())).to(coeffs.dtype)


def _quadratic(c: Tensor) -> Tensor:
    return _of_quadratic(c[..., 0], c[..., 1], c[..., 2], torch.zeros_like(c[..., 0]))


def _of_quadratic(a: Tensor, b: Tensor, c: Tensor, rounding: Tensor) -> Tensor:
    """Roots of a x^2 + b x + c; a discriminant that is no less than minus its own rounding, or that given, counts as 0."""
    product = 4.0 * a * c
    discriminant = b * b - product
    real = discriminant >= -torch.maximum(rounding, 1e-15 * (b * b + product.abs()))
    root = torch.sqrt(torch.clamp(discriminant, min=0.0))
    q = -0.5 * (b + torch.where(b >= 0, root, -root))
    # the linear root is the second
    first = _ratio(q, a)
    second = torch.where(q == 0, torch.where(a == 0, _missing(a), torch.zeros_like(a)), _ratio(c, q))
    return torch.where(real[..., None], torch.stack([first, second], -1), _missing(a)[..., None])


def _cubic(coeffs: Tensor) -> Tensor:
    a = coeffs[..., 0]
    turned, chosen = _well_led(coeffs, 1.0 / 3.0)
    monic = _monic(chosen)
    third, c, d = monic[..., 1] / 3.0, monic[..., 2], monic[..., 3]
    # x = t - third leaves t^3 + 3 p t + 2 h
    p = c / 3.0 - third * third
    cube = third * third * third
    h = cube + 0.5 * (d - third * c)
    discriminant = h * h + p * p * p
    rounding = 2.0 * h.abs() * (cube.abs() + 0.5 * (d.abs() + (third * c).abs())) + 3.0 * p * p * (c.abs() / 3.0 + third * third)
    three = discriminant <= 2e-15 * rounding
    size = torch.pow(h.abs() + torch.sqrt(torch.clamp(discriminant, min=0.0)), 1.0 / 3.0)
    u = torch.where(h >= 0, -size, size)
    v = torch.where(u == 0, torch.zeros_like(u), -p / torch.where(u == 0, torch.ones_like(u), u))
    only = torch.stack([u + v - third, _missing(a), _missing(a)], -1)
    cosine, sine = _third_of_angle(h.abs(), torch.sqrt(torch.clamp(-discriminant, min=0.0)))
    cosines = torch.stack([cosine, 0.8660254037844386 * sine - 0.5 * cosine, -0.8660254037844386 * sine - 0.5 * cosine], -1)
    radius = torch.sqrt(torch.clamp(-p, min=0.0)) * torch.where(h > 0, -2.0, 2.0).to(p.dtype)
    roots = _turned_back(torch.where(three[..., None], radius[..., None] * cosines - third[..., None], only), turned)
    lower_degree = torch.cat([_quadratic(coeffs[..., 1:]), _missing(a)[..., None]], -1)
    return _polished(coeffs, torch.where((a == 0)[..., None], lower_degree, roots))


def _third_of_angle(x: Tensor, y: Tensor) -> Tuple[Tensor, Tensor]:
    """Cosine and sine of a third of the angle of (x, y), between 0 and a right angle: ONNX Runtime has no arc functions in float64."""
    length = torch.sqrt(x * x + y * y)
    length = torch.where(length == 0, torch.ones_like(length), length)
    whole = x / length
    cosine = 0.8660254037844386 + 0.1339745962155614 * whole
    for _ in range(4):
        squared = cosine * cosine
        cosine = cosine - (cosine * (4.0 * squared - 3.0) - whole) / (12.0 * squared - 3.0)
    return cosine, y / length / (4.0 * cosine * cosine - 1.0)


def _quartic(coeffs: Tensor) -> Tensor:
    a = coeffs[..., 0]
    turned, chosen = _well_led(coeffs, 0.5)
    monic = _monic(chosen)
    fourth, c, d, e = 0.25 * monic[..., 1], monic[..., 2], monic[..., 3], monic[..., 4]
    # x = y - fourth leaves y^4 + p y^2 + q y + r
    square = fourth * fourth
    p = c - 6.0 * square
    q = d - 2.0 * fourth * c + 8.0 * square * fourth
    r = e - fourth * d + square * c - 3.0 * square * square
    resolvent = torch.stack([torch.ones_like(p), p, 0.25 * p * p - r, -0.125 * q * q], -1)
    # together with what is left where a is 0
    cubics = _cubic(torch.stack([resolvent, coeffs[..., 1:]], 0))
    m = torch.clamp(cubics[0].amax(-1), min=0.0)
    # (y^2 + p / 2 + m)^2 = 2 m (y - q / (4 m))^2
    middle = 0.5 * p + m
    slope = torch.sqrt(2.0 * m)
    large = m > 1e-8 * (p.abs() + torch.sqrt(r.abs()))
    by_root = torch.sqrt(torch.clamp(middle * middle - r, min=0.0))
    shift = torch.where(large, q / (2.0 * torch.where(large, slope, torch.ones_like(slope))), torch.where(q >= 0, by_root, -by_root))
    rounding = 4e-14 * (c.abs() + 6.0 * square + 4.0 * (m + shift.abs()))
    one = torch.ones_like(p)
    upper = _of_quadratic(one, -slope, middle + shift, rounding)
    lower = _of_quadratic(one, slope, middle - shift, rounding)
    roots = _turned_back(torch.cat([upper, lower], -1) - fourth[..., None], turned)
    lower_degree = torch.cat([cubics[1], _missing(a)[..., None]], -1)
    return _polished(coeffs, torch.where((a == 0)[..., None], lower_degree, roots))


def _well_led(coeffs: Tensor, power: float) -> Tuple[Tensor, Tensor]:
    """Whether to look for 1 / x, and the coefficients of that: where the leading coefficient is tiny, one root is huge, and
    a closed form, which moves the roots to their mean, would lose the others."""
    first, last = coeffs[..., 0].abs(), coeffs[..., -1].abs()
    turned = coeffs[..., 1].abs() * torch.pow(last, power) > coeffs[..., -2].abs() * torch.pow(first, power)
    return turned, torch.where(turned[..., None], coeffs.flip(-1), coeffs)


def _monic(coeffs: Tensor) -> Tensor:
    a = coeffs[..., 0:1]
    return coeffs / torch.where(a == 0, torch.ones_like(a), a)


def _turned_back(roots: Tensor, turned: Tensor) -> Tensor:
    lost = (roots < -1e30) | (roots == 0)
    return torch.where(turned[..., None], torch.where(lost, _missing(roots), 1.0 / torch.where(lost, torch.ones_like(roots), roots)), roots)


def _missing(like: Tensor) -> Tensor:
    return torch.full_like(like, -float("inf"))


def _ratio(a: Tensor, b: Tensor) -> Tensor:
    """a / b; missing where b is 0."""
    return torch.where(b == 0, _missing(a), a / torch.where(b == 0, torch.ones_like(b), b))


def _values(coeffs: Tensor, x: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The polynomial at each x, its derivative, and what of the derivative is left to the rounding: the sum of its terms' sizes."""
    value = coeffs[..., 0:1].expand_as(x)
    slope = torch.zeros_like(x)
    size = torch.zeros_like(x)
    for k in range(1, coeffs.size(-1)):
        slope = slope * x + value
        size = size * x.abs() + value.abs()
        value = value * x + coeffs[..., k : k + 1]
    return value, slope, size


def _polished(coeffs: Tensor, roots: Tensor) -> Tensor:
    """Three of Newton's steps, each where it makes the polynomial smaller."""
    missing = roots < -1e30
    x = torch.where(missing, torch.zeros_like(roots), roots)
    value, slope, _size = _values(coeffs, x)
    for _ in range(3):
        moved = x - torch.where(slope == 0, torch.zeros_like(x), value / torch.where(slope == 0, torch.ones_like(x), slope))
        new_value, new_slope, _size = _values(coeffs, moved)
        better = new_value.abs() < value.abs()
        x = torch.where(better, moved, x)
        value = torch.where(better, new_value, value)
        slope = torch.where(better, new_slope, slope)
    return torch.where(missing, roots, x)


def _finished(coeffs: Tensor, roots: Tensor) -> Tensor:
    """In descending order, with zeros for what is missing, and with the derivative by the coefficients."""
    columns = list(roots.unbind(-1))
    for end in range(len(columns) - 1, 0, -1):
        for k in range(end):
            larger, smaller = torch.maximum(columns[k], columns[k + 1]), torch.minimum(columns[k], columns[k + 1])
            columns[k], columns[k + 1] = larger, smaller
    roots = torch.stack(columns, -1)
    missing = roots < -1e30
    x = torch.where(missing, torch.zeros_like(roots), roots)
    if native_forward() or onnx_forward():
        return x
    value, slope, size = _values(coeffs, x)
    slope = slope.detach()
    flat = missing | (slope.abs() <= 1e-7 * size.detach())
    change = (value - value.detach()) / torch.where(flat, torch.ones_like(slope), slope)
    return x - torch.where(flat, torch.zeros_like(change), change)
