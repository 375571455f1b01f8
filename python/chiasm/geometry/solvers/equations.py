"""Real roots of equations of degree two to four.

Closed forms in float64 give one root, Newton's method polishes it, and the equation that is left without it
has the others: a closed form moves the roots to their mean, where those much smaller than another would be
lost. None of this sees a gradient: the derivative of a root x of p is -dp(x) / p'(x), by one more step. Among
the roots, minus infinity stands for one that is not there.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_last
from ...primitives.core.lowering import carries_derivative


def solve_quadratic(coeffs: Tensor) -> Tensor:
    """Real roots of a x^2 + b x + c = 0.

    Without cancellation: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 1.8. A
    discriminant within rounding of 0 gives a double root. Where a is 0 the equation is linear.

    Args:
        coeffs: (*, 3), floating point, a, b, c.

    Returns:
        (*, 2), in descending order, followed by zeros for the roots that are missing or complex. A double
        root is there twice; its gradient is 0.

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

    The outermost root by Cardano's formula, or by a cosine where there are three, and the others of the
    quadratic that is left: W. Kahan, To Solve a Real Cubic Equation, 1986. Each root is as exact as rounding
    of the coefficients leaves it, however far apart their sizes are. A discriminant within rounding of 0
    gives a double root. Where a is 0 the equation is quadratic.

    Args:
        coeffs: (*, 4), floating point, a, b, c, d.

    Returns:
        (*, 3), in descending order, followed by zeros for the roots that are missing or complex. A multiple
        root is there as often; its gradient is 0.

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

    One root by Ferrari's method (two quadratic factors from the largest root of the resolvent cubic), and the
    others of the cubic that is left. Each root is as exact as rounding of the coefficients leaves it, however
    far apart their sizes are. A double root that is nearer than a tenth or so to two others may be taken for
    a complex pair. Where a is 0 the equation is cubic.

    Args:
        coeffs: (*, 5), floating point, a, b, c, d, e.

    Returns:
        (*, 4), in descending order, followed by zeros for the roots that are missing or complex. A double
        root is there twice; its gradient is 0.

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
    """Roots of a x^2 + b x + c; a discriminant that is no less than minus its own rounding, or that given,
    counts as 0."""
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
    """The root that is farther from the roots' mean than the others' real parts, and those of the quadratic
    that is left without it."""
    a = coeffs[..., 0]
    x = _polished(coeffs, _outer_root(coeffs)[..., None])[..., 0]
    rest, bound = _deflated(coeffs, x)
    sums = 2.0 * rest[..., 1].abs() * bound[..., 1] + 4.0 * a.abs() * bound[..., 2]
    # The discriminant's error due to the rounding of x: its derivative by x is -2 a (3 a x + b), unless the
    # quadratic is from the last coefficients.
    error = _rounding_of_root(coeffs, x)
    steep = 2.0 * (a * (3.0 * a * x + coeffs[..., 1])).abs() * error
    relative = sums * error / torch.where(x == 0, torch.ones_like(x), x.abs())
    rounding = 1e-15 * (sums + torch.minimum(steep, relative))
    pair = _of_quadratic(a, rest[..., 1], rest[..., 2], rounding)
    lower_degree = torch.cat([_quadratic(coeffs[..., 1:]), _missing(a)[..., None]], -1)
    roots = torch.where((a == 0)[..., None], lower_degree, torch.cat([x[..., None], pair], -1))
    return _polished(coeffs, roots)


def _rounding_of_root(coeffs: Tensor, x: Tensor) -> Tensor:
    """How far a root moves per relative change of the coefficients, at most; 0 for a multiple root."""
    _value, slope, _size = _values(coeffs, x[..., None])
    flat = slope == 0
    ratio = _terms(coeffs, x[..., None]) / torch.where(flat, torch.ones_like(slope), slope.abs())
    return torch.where(flat, torch.zeros_like(ratio), ratio)[..., 0]


def _outer_root(coeffs: Tensor) -> Tensor:
    """One root of a cubic, up to rounding of the largest."""
    monic, scale = _scaled(coeffs)
    third, c, d = monic[..., 1] / 3.0, monic[..., 2], monic[..., 3]
    # x = t - third leaves t^3 + 3 p t + 2 h
    p = c / 3.0 - third * third
    h = third * third * third + 0.5 * (d - third * c)
    discriminant = h * h + p * p * p
    size = torch.pow(h.abs() + torch.sqrt(torch.clamp(discriminant, min=0.0)), 1.0 / 3.0)
    u = torch.where(h >= 0, -size, size)
    v = torch.where(u == 0, torch.zeros_like(u), -p / torch.where(u == 0, torch.ones_like(u), u))
    # u + v, where that cancels as a quotient
    whole = torch.where(p > 0, u * u + p + v * v, torch.ones_like(p))
    only = torch.where(p > 0, -2.0 * h / whole, u + v)
    cosine, _sine = _third_of_angle(h.abs(), torch.sqrt(torch.clamp(-discriminant, min=0.0)))
    radius = 2.0 * torch.sqrt(torch.clamp(-p, min=0.0))
    outer = torch.where(discriminant > 0, only, torch.where(h > 0, -radius, radius) * cosine)
    return scale * (outer - third)


def _third_of_angle(x: Tensor, y: Tensor) -> Tuple[Tensor, Tensor]:
    """Cosine and sine of a third of the angle of (x, y), between 0 and a right angle: ONNX Runtime has no arc
    functions in float64."""
    length = torch.sqrt(x * x + y * y)
    length = torch.where(length == 0, torch.ones_like(length), length)
    whole = x / length
    cosine = 0.8660254037844386 + 0.1339745962155614 * whole
    for _ in range(4):
        squared = cosine * cosine
        cosine = cosine - (cosine * (4.0 * squared - 3.0) - whole) / (12.0 * squared - 3.0)
    return cosine, y / length / (4.0 * cosine * cosine - 1.0)


def _quartic(coeffs: Tensor) -> Tensor:
    """One root that is found well, and those of the cubic that is left without it."""
    a = coeffs[..., 0]
    # If the roots have very different sizes, Ferrari's method finds only the large ones, and the small ones
    # from the equation for 1 / x.
    found = _by_ferrari(torch.stack([coeffs, coeffs.flip(-1)], 0))
    turned = torch.where(
        found[1] == 0,
        torch.zeros_like(found[1]),
        1.0 / torch.where(found[1] == 0, torch.ones_like(found[1]), found[1]),
    )
    candidates = _polished(coeffs, torch.cat([found[0], turned], -1))
    value, slope, _size = _values(coeffs, candidates)
    terms = _terms(coeffs, candidates)
    steepness = (candidates * slope).abs() / torch.where(terms == 0, torch.ones_like(terms), terms)
    isolation = torch.where(value.abs() <= 4e-15 * terms, steepness, -torch.ones_like(terms))
    best = torch.argmax(isolation, dim=-1, keepdim=True)
    x = candidates.gather(-1, best)[..., 0]
    exists = isolation.amax(-1) >= 0
    rest, _bound = _deflated(coeffs, x)
    linear = (a == 0)[..., None]
    others = _cubic(torch.where(linear, coeffs[..., 1:], rest))
    roots = torch.cat([torch.where(a == 0, _missing(x), x)[..., None], others], -1)
    return _polished(coeffs, torch.where(exists[..., None] | linear, roots, _missing(roots)))


def _by_ferrari(coeffs: Tensor) -> Tensor:
    """Four candidates for the real roots, the complex ones' real parts among them, up to rounding of the
    largest."""
    monic, scale = _scaled(coeffs)
    fourth, c, d, e = 0.25 * monic[..., 1], monic[..., 2], monic[..., 3], monic[..., 4]
    # x = y - fourth leaves y^4 + p y^2 + q y + r
    square = fourth * fourth
    p = c - 6.0 * square
    q = d - 2.0 * fourth * c + 8.0 * square * fourth
    r = e - fourth * d + square * c - 3.0 * square * square
    m = torch.clamp(
        _cubic(torch.stack([torch.ones_like(p), p, 0.25 * p * p - r, -0.125 * q * q], -1)).amax(-1), min=0.0
    )
    # (y^2 + p / 2 + m)^2 = 2 m (y - q / (4 m))^2
    middle = 0.5 * p + m
    slope = torch.sqrt(2.0 * m)
    large = m > 1e-8 * (p.abs() + torch.sqrt(r.abs()))
    by_root = torch.sqrt(torch.clamp(middle * middle - r, min=0.0))
    shift = torch.where(
        large,
        q / (2.0 * torch.where(large, slope, torch.ones_like(slope))),
        torch.where(q >= 0, by_root, -by_root),
    )
    always = torch.full_like(p, float("inf"))
    upper = _of_quadratic(torch.ones_like(p), -slope, middle + shift, always)
    lower = _of_quadratic(torch.ones_like(p), slope, middle - shift, always)
    return scale[..., None] * (torch.cat([upper, lower], -1) - fourth[..., None])


def _scaled(coeffs: Tensor) -> Tuple[Tensor, Tensor]:
    """The monic polynomial of x / scale, whose coefficients are 1 at most, and scale; of no meaning where the
    first is 0."""
    a = torch.where(coeffs[..., 0] == 0, torch.ones_like(coeffs[..., 0]), coeffs[..., 0])
    monic = [coeffs[..., k] / a for k in range(coeffs.size(-1))]
    scale = monic[1].abs()
    for k in range(2, len(monic)):
        scale = torch.maximum(scale, torch.pow(monic[k].abs(), 1.0 / k))
    scale = torch.where(scale == 0, torch.ones_like(scale), scale)
    for k in range(1, len(monic)):
        for _ in range(k):
            monic[k] = monic[k] / scale
    return torch.stack(monic, -1), scale


def _deflated(coeffs: Tensor, x: Tensor) -> Tuple[Tensor, Tensor]:
    """The polynomial without its root x, and sums of the sizes of what its coefficients are sums of.

    From the first coefficients on and from the last, up to the term that is largest at x: G. Peters, J. H.
    Wilkinson, Practical problems arising in the solution of polynomial equations, J. Inst. Maths Applics 8,
    1971.
    """
    last = coeffs.size(-1) - 1
    size = x.abs()
    terms = [coeffs[..., last].abs()]
    power = torch.ones_like(x)
    for k in range(1, last + 1):
        power = power * size
        terms.append(coeffs[..., last - k].abs() * power)
    high, high_bound = [coeffs[..., 0]], [coeffs[..., 0].abs()]
    for k in range(1, last):
        high.append(high[k - 1] * x + coeffs[..., k])
        high_bound.append(high_bound[k - 1] * size + coeffs[..., k].abs())
    divisor = torch.where(x == 0, torch.ones_like(x), x)
    low, low_bound = torch.zeros_like(x), torch.zeros_like(x)
    for k in range(last - 1):
        low = (low - coeffs[..., last - k]) / divisor
        low_bound = (low_bound + coeffs[..., last - k].abs()) / divisor.abs()
        upward = _largest(terms[k + 1 :]) > _largest(terms[: k + 1])
        high[last - 1 - k] = torch.where(upward, low, high[last - 1 - k])
        high_bound[last - 1 - k] = torch.where(upward, low_bound, high_bound[last - 1 - k])
    return torch.stack(high, -1), torch.stack(high_bound, -1)


def _terms(coeffs: Tensor, x: Tensor) -> Tensor:
    """The sum of the sizes of the polynomial's terms at each x."""
    return _values(coeffs.abs(), x.abs())[0]


def _largest(values: List[Tensor]) -> Tensor:
    out = values[0]
    for value in values[1:]:
        out = torch.maximum(out, value)
    return out


def _missing(like: Tensor) -> Tensor:
    return torch.full_like(like, -float("inf"))


def _ratio(a: Tensor, b: Tensor) -> Tensor:
    """a / b; missing where b is 0."""
    return torch.where(b == 0, _missing(a), a / torch.where(b == 0, torch.ones_like(b), b))


def _values(coeffs: Tensor, x: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The polynomial at each x, its derivative, and what of the derivative is left to the rounding: the sum
    of its terms' sizes."""
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
        moved = x - torch.where(
            slope == 0, torch.zeros_like(x), value / torch.where(slope == 0, torch.ones_like(x), slope)
        )
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
            larger, smaller = (
                torch.maximum(columns[k], columns[k + 1]),
                torch.minimum(columns[k], columns[k + 1]),
            )
            columns[k], columns[k + 1] = larger, smaller
    roots = torch.stack(columns, -1)
    missing = roots < -1e30
    return _derived(torch.where(missing, torch.zeros_like(roots), roots), missing, coeffs)


@carries_derivative
def _derived(x: Tensor, missing: Tensor, coeffs: Tensor) -> Tensor:
    """The roots x, with their derivative by the coefficients."""
    value, slope, size = _values(coeffs, x)
    slope = slope.detach()
    flat = missing | (slope.abs() <= 1e-7 * size.detach())
    change = (value - value.detach()) / torch.where(flat, torch.ones_like(slope), slope)
    return x - torch.where(flat, torch.zeros_like(change), change)
