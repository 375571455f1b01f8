"""geometry.solvers against NumPy's roots, polynomials, determinants and least squares."""

from typing import Callable
from unittest.mock import patch

import mpmath
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.geometry.solvers import (
    determinant_to_polynomial,
    find_affine,
    multiply_deg_one_poly,
    multiply_deg_two_one_poly,
    null_vector_3x4,
    solve_cubic,
    solve_quadratic,
    solve_quartic,
)
from chiasm.primitives.core.lowering import PRIMITIVES
from chiasm.primitives.linalg.polynomials import real_roots

SOLVERS = {2: solve_quadratic, 3: solve_cubic, 4: solve_quartic}


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64) * 2.0 - 1.0


def with_roots(degree: int, real: int, count: int, scale: float) -> tuple[Tensor, np.ndarray]:
    """Polynomials with ``real`` real roots, and these roots in descending order, padded with zeros."""
    roots = rand(count, real, seed=degree).numpy() * scale
    pairs = rand(count, degree - real, seed=real).numpy() * scale
    coeffs = []
    for k in range(count):
        p = np.poly(roots[k]) if real else np.ones(1)
        for a, b in pairs[k].reshape(-1, 2):
            p = np.polymul(p, [1.0, -2.0 * a, a * a + b * b])
        coeffs.append(p * (1.5 - k % 4))
    return torch.from_numpy(np.array(coeffs)), np.concatenate(
        [-np.sort(-roots, 1), np.zeros((count, degree - real))], 1
    )


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_real_roots_of_either_precision(dtype: torch.dtype) -> None:
    roots = np.array([[-40.0, -3.0, 0.5, 2.0], [-1.0, 0.0, 1.0, 1000.0]])
    coeffs = np.stack([np.poly(r)[::-1] for r in roots])  # whole numbers and halves, exact in float32
    u, exists = real_roots(torch.tensor(coeffs, dtype=dtype))
    assert u.dtype == torch.float64 and exists.all()
    np.testing.assert_allclose(u / (1 - u.abs()), roots, rtol=1e-8, atol=1e-8)


def test_a_kernel_finds_roots_in_float64_only() -> None:
    lowering = PRIMITIVES["chiasm.primitives.linalg.polynomials._found"].lowerings[0]
    with patch.object(torch.compiler, "is_exporting", lambda: True):
        assert lowering.when(torch.ones(3, 2).double(), 48) and not lowering.when(torch.ones(3, 2), 48)


@pytest.mark.parametrize("scale", [1e-2, 1.0, 1e3])
@pytest.mark.parametrize(("degree", "real"), [(2, 0), (2, 2), (3, 1), (3, 3), (4, 0), (4, 2), (4, 4)])
def test_roots(degree: int, real: int, scale: float) -> None:
    coeffs, expected = with_roots(degree, real, 500, scale)
    np.testing.assert_allclose(SOLVERS[degree](coeffs), expected, rtol=0, atol=1e-8 * scale)
    single = SOLVERS[degree](coeffs.float().reshape(5, 100, -1))
    assert single.dtype == torch.float32 and single.shape == (5, 100, degree)


KNOWN = [
    ([1, -2, 1], [1, 1]),
    ([1, 0, 1], [0, 0]),
    ([0, 2, -4], [2, 0]),
    ([0, 0, 3], [0, 0]),
    ([3, 0, 0], [0, 0]),
    ([1, -1e8, 1], [1e8, 1e-8]),
    ([1, -3, 3, -1], [1, 1, 1]),
    ([1, -4, 5, -2], [2, 1, 1]),
    ([1, 0, 1, 0], [0, 0, 0]),
    ([0, 1, -3, 2], [2, 1, 0]),
    ([0, 0, 2, -4], [2, 0, 0]),
    ([0, 0, 0, 3], [0, 0, 0]),
    ([1, 0, 0, 8], [-2, 0, 0]),
    ([1e-12, 1, -3, 2], [2, 1, -1e12]),
    ([1e-10, 1, -3, 1e-10], [3, 1e-10 / 3, -1e10]),
    ([1, 1e10, 1, 1e-10], [-1e10, 0, 0]),
    ([1, -10, 35, -50, 24], [4, 3, 2, 1]),
    ([1, 0, -5, 0, 4], [2, 1, -1, -2]),
    ([1, 0, 2, 0, 1], [0, 0, 0, 0]),
    ([1, 0, -2, 0, 1], [1, 1, -1, -1]),
    ([1, -4, 6, -4, 1], [1, 1, 1, 1]),
    ([1, -8, 23, -28, 12], [3, 2, 2, 1]),
    ([1, -3, 3, -3, 2], [2, 1, 0, 0]),
    ([0, 1, -6, 11, -6], [3, 2, 1, 0]),
    ([0, 0, 1, -3, 2], [2, 1, 0, 0]),
    ([1e-12, 1, -6, 11, -6], [3, 2, 1, -1e12]),
    ([1e-10, 1, -3, 2, 1e-10], [2, 1, -5e-11, -1e10]),
    ([1e-10, 1, -3, 1e-10, 1e-25], [3, 1e-10 / 3, -1e-15, -1e10]),
    ([1, 0, 1e20, 0, 1], [0, 0, 0, 0]),
]


@pytest.mark.parametrize(("coeffs", "roots"), KNOWN, ids=[str(c) for c, _ in KNOWN])
def test_known_equations(coeffs: list[float], roots: list[float]) -> None:
    c = torch.tensor(coeffs, dtype=torch.float64, requires_grad=True)
    found = SOLVERS[len(roots)](c)
    np.testing.assert_allclose(found.detach(), roots, rtol=2e-7, atol=1e-12)
    [gradient] = torch.autograd.grad(found.sum(), c)
    assert gradient.isfinite().all()


def of_all_sizes(degree: int, spread: float, count: int) -> np.ndarray:
    """Polynomials whose roots, real or in pairs, have sizes from 10^-spread to 10^spread."""
    generator = np.random.default_rng(degree)
    made = []
    for k in range(count):
        p = np.ones(1)
        for _ in range(k % (degree // 2 + 1)):
            size, angle = 10.0 ** generator.uniform(-spread, spread), generator.uniform(0.1, 3.0)
            p = np.polymul(p, [1.0, -2.0 * size * np.cos(angle), size * size])
        while len(p) <= degree:
            p = np.polymul(
                p, [1.0, generator.choice([-1.0, 1.0]) * 10.0 ** generator.uniform(-spread, spread)]
            )
        made.append(p)
    return np.array(made)


@pytest.mark.parametrize("spread", [2, 6, 12])
@pytest.mark.parametrize("degree", [3, 4])
def test_roots_of_very_different_sizes(degree: int, spread: float) -> None:
    """Each root is as accurate as an error of half a unit in the last place of the coefficients allows; the
    truth has 60 digits."""
    coeffs = of_all_sizes(degree, spread, 60)
    found = SOLVERS[degree](torch.from_numpy(coeffs)).numpy()
    with mpmath.workdps(60):
        for c, roots in zip(coeffs, found):
            exact = mpmath.polyroots([mpmath.mpf(v) for v in c], maxsteps=500, extraprec=600)
            real = np.sort([float(x.real) for x in exact if abs(x.imag) <= 1e-7 * abs(x)])[::-1]
            terms = np.polyval(abs(c), abs(real)) / abs(np.polyval(np.polyder(c), real))
            assert (abs(roots[: len(real)] - real) <= 2e-16 * (terms + abs(real))).all(), (c, roots, real)
            assert (roots[len(real) :] == 0).all()


@pytest.mark.parametrize("degree", SOLVERS)
def test_gradients_of_roots(degree: int) -> None:
    for real in range(degree % 2, degree + 1, 2):
        roots = torch.arange(real, dtype=torch.float64) - 0.7
        p = np.poly(roots.numpy()) if real else np.ones(1)
        for k in range((degree - real) // 2):
            p = np.polymul(p, [1.0, 0.4 * k, 2.0])
        assert torch.autograd.gradcheck(
            SOLVERS[degree], (torch.from_numpy(2.0 * p)[None].requires_grad_(True),)
        )


def test_null_vector_3x4() -> None:
    A = rand(6, 3, 4)
    n = null_vector_3x4(A)
    assert (A @ n[..., None]).abs().max() < 1e-14
    minors = [(-1) ** k * np.linalg.det(np.delete(A.numpy(), k, 2)) for k in range(4)]
    np.testing.assert_allclose(n, np.stack(minors, 1), rtol=1e-10, atol=1e-13)


def powers(x: np.ndarray, y: np.ndarray, z: np.ndarray, degree: int) -> np.ndarray:
    """The monomials at points, in the documented order of the functions."""
    one = np.ones_like(x)
    if degree == 1:
        return np.stack([x, y, z, one], -1)
    if degree == 2:
        return np.stack([x * x, x * y, x * z, x, y * y, y * z, y, z * z, z, one], -1)
    third = [
        x**3,
        y**3,
        x * x * y,
        x * y * y,
        x * x * z,
        x * x,
        y * y * z,
        y * y,
        x * y * z,
        x * y,
        x * z * z,
        x * z,
        x,
        y * z * z,
        y * z,
        y,
        z**3,
        z * z,
        z,
        one,
    ]
    return np.stack(third, -1)


def test_products_of_polynomials_have_the_products_of_their_values() -> None:
    a, b, c = rand(4).numpy(), rand(4, seed=1).numpy(), rand(10, seed=2).numpy()
    x, y, z = rand(3, 30, seed=3).numpy()
    first, second = powers(x, y, z, 1), powers(x, y, z, 2)
    square = multiply_deg_one_poly(torch.from_numpy(a), torch.from_numpy(b)[None])
    np.testing.assert_allclose(second @ square[0].numpy(), (first @ a) * (first @ b), atol=1e-13)
    cube = multiply_deg_two_one_poly(torch.from_numpy(c)[None], torch.from_numpy(a))
    np.testing.assert_allclose(powers(x, y, z, 3) @ cube[0].numpy(), (second @ c) * (first @ a), atol=1e-13)


def test_determinant_to_polynomial() -> None:
    A = rand(5, 3, 13)
    found = determinant_to_polynomial(A).numpy()
    for z in np.linspace(-1.5, 1.5, 13):
        values = np.stack(
            [
                np.polyval(np.moveaxis(A.numpy()[..., part], -1, 0), z)
                for part in (slice(0, 4), slice(4, 8), slice(8, 13))
            ],
            -1,
        )
        np.testing.assert_allclose(np.polyval(found.T[::-1], z), np.linalg.det(values), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("count", [3, 4, 50])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_find_affine_equals_least_squares(count: int, dtype: torch.dtype) -> None:
    corners = torch.tensor([[0.0, 0.0], [1000.0, 0.0], [0.0, 1000.0]], dtype=torch.float64).repeat(17, 1)[
        :count
    ]
    p = (corners + 200.0 * rand(2, count, 2)).to(dtype)
    q = (
        p.double() @ torch.tensor([[1.1, -0.2], [0.3, 0.8]], dtype=torch.float64)
        - 40.0
        + rand(2, count, 2, seed=1)
    ).to(dtype)
    w = rand(2, count, seed=2).abs().to(dtype) + 0.1
    for weights in (None, w):
        found = find_affine(p, q, weights)
        assert found.dtype == dtype and found[:, 2].tolist() == [[0.0, 0.0, 1.0]] * 2
        for b in range(2):
            root = np.ones((count, 1)) if weights is None else np.sqrt(w[b].double().numpy())[:, None]
            a = np.hstack([p[b].double().numpy(), np.ones((count, 1))]) * root
            expected = np.linalg.lstsq(a, q[b].double().numpy() * root, rcond=None)[0].T
            np.testing.assert_allclose(
                found[b, :2], expected, rtol=1e-9 if dtype == torch.float64 else 1e-6, atol=1e-9
            )


P = torch.zeros(1, 3, 2)

WRONG = [
    (
        lambda: solve_quadratic(torch.zeros(2, 4)),
        ValueError,
        r"coeffs: expected shape \(\*, 3\), got \[2, 4\]",
    ),
    (lambda: solve_cubic(torch.zeros(4).int()), TypeError, "coeffs: expected a floating-point"),
    (lambda: solve_quartic(torch.zeros(4)), ValueError, r"coeffs: expected shape \(\*, 5\)"),
    (
        lambda: null_vector_3x4(torch.zeros(1, 4, 4)),
        ValueError,
        r"A: expected shape \(\*, 3, 4\), got \[1, 4, 4\]",
    ),
    (
        lambda: multiply_deg_one_poly(torch.zeros(3), torch.zeros(4)),
        ValueError,
        r"a: expected shape \(\*, 4\)",
    ),
    (
        lambda: multiply_deg_two_one_poly(torch.zeros(10), torch.zeros(10)),
        ValueError,
        r"b: expected shape \(\*, 4\)",
    ),
    (
        lambda: determinant_to_polynomial(torch.zeros(1, 3, 12)),
        ValueError,
        r"A: expected shape \(\*, 3, 13\), got \[1, 3, 12\]",
    ),
    (
        lambda: find_affine(P[:, :2], P[:, :2]),
        ValueError,
        r"points1: expected shape \(B, N, 2\) with N of at least 3, got \[1, 2, 2\]",
    ),
    (
        lambda: find_affine(P, P[0]),
        ValueError,
        r"points2: expected shape \(B, 3, 2\) like points1, got \[3, 2\]",
    ),
    (lambda: find_affine(P, P, P), ValueError, r"weights: expected shape \(B, 3\), got \[1, 3, 2\]"),
    (lambda: find_affine(P, P.int()), TypeError, "points2: expected a floating-point"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
