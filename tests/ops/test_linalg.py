"""The primitives' linear algebra against NumPy in float64; docs/linalg.md lists all errors."""

from fractions import Fraction
from typing import Callable

import numpy as np
import pytest
import torch
from linalg_accuracy import MEASURES, SHAPES, general, symmetric, unitary
from torch import Tensor

from chiasm.primitives.core.target import exporting
from chiasm.primitives.linalg.eigen import svd, symmetric_eigen
from chiasm.primitives.linalg.matrices import cofactors, cross4, det, inverse, solve
from chiasm.primitives.linalg.qr import null_vector, pointed, qr

#: measures whose error does not grow with the condition number
STABLE = {name for name in MEASURES if name.startswith(("symmetric_eigen", "svd", "qr"))}


def rand(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64).to(dtype)


@pytest.mark.parametrize("condition", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("n", [2, 3, 4, 5, 9])
@pytest.mark.parametrize("name", MEASURES)
def test_equals_numpy(name: str, n: int, condition: float) -> None:
    measure, make, _ = MEASURES[name]
    for shape in SHAPES:
        m = make(n, condition, shape)
        limit = 0.0 if name in STABLE else 1e-15 * n * condition
        assert measure(m) < max(limit, 4e-14), shape
        assert measure(m.float()) < max(limit, 1e-6), shape


@pytest.mark.parametrize("function", [inverse, det, symmetric_eigen, svd, qr, null_vector])
def test_batch_shapes(function: Callable) -> None:
    m = rand(2, 3, 4, 4)
    whole = function(m + m.transpose(-1, -2))
    for part in ((1, 2), (0,), ()):
        single = function((m + m.transpose(-1, -2))[part])
        for a, b in zip(as_tuple(single), as_tuple(whole)):
            torch.testing.assert_close(a, b[part], rtol=1e-12, atol=1e-12)


def test_solve_broadcasts() -> None:
    a, b = rand(4, 4), rand(5, 4, 2, seed=1)
    torch.testing.assert_close(a @ solve(a, b), b)
    torch.testing.assert_close(solve(a.expand(5, 4, 4), b[0]), torch.linalg.solve(a, b[0]).expand(5, 4, 2))


def as_tuple(result: object) -> tuple[Tensor, ...]:
    return (result,) if isinstance(result, Tensor) else tuple(result)


@pytest.mark.parametrize("n", range(1, 11))
def test_every_size(n: int) -> None:
    m = rand(6, n, n, seed=n)
    np.testing.assert_allclose(inverse(m), np.linalg.inv(m.numpy()), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(det(m), np.linalg.det(m.numpy()), rtol=1e-9)
    np.testing.assert_allclose(svd(m)[1], np.linalg.svd(m.numpy())[1], atol=1e-13)
    np.testing.assert_allclose(
        symmetric_eigen(m + m.mT)[0], np.linalg.eigvalsh((m + m.mT).numpy()), atol=1e-13
    )


def test_pivots_on_the_diagonal_may_be_zero() -> None:
    cyclic = torch.eye(6, dtype=torch.float64).roll(1, 0)
    torch.testing.assert_close(inverse(cyclic), cyclic.mT)
    assert det(cyclic) == np.linalg.det(cyclic.numpy())
    assert det(cyclic[:5, 1:]).item() == pytest.approx(np.linalg.det(cyclic[:5, 1:].numpy()))


def test_cofactors_and_cross() -> None:
    for n in (1, 2, 3, 4):
        m = rand(5, n, n)
        np.testing.assert_allclose(
            cofactors(m).mT,
            np.linalg.inv(m.numpy()) * np.linalg.det(m.numpy())[:, None, None],
            rtol=1e-9,
            atol=1e-12,
        )
    a, b, c, d = rand(4, 3, 4).unbind()
    np.testing.assert_allclose(
        (cross4(a, b, c) * d).sum(-1), np.linalg.det(torch.stack([d, a, b, c], -2).numpy()), rtol=1e-10
    )


REPEATED = {
    "zero": torch.zeros(3, 3),
    "identity": torch.eye(3),
    "rank one": torch.ones(3, 3),
    "two equal": torch.tensor([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]),
    "essential": torch.tensor([[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]]),
}


@pytest.mark.parametrize("name", REPEATED)
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_repeated_and_zero_values(name: str, dtype: torch.dtype) -> None:
    m = REPEATED[name].to(dtype)
    for u, s, v in (svd(m), svd(torch.cat([m, torch.zeros(2, 3, dtype=dtype)]))):
        np.testing.assert_allclose(s, np.linalg.svd(m.numpy())[1], atol=1e-6)
        torch.testing.assert_close((u * s @ v.mT)[:3], m, rtol=0, atol=2e-6)
        assert max(unitary(u[None]), unitary(v[None])) < 1e-6
    values, vectors = symmetric_eigen(m + m.mT)
    np.testing.assert_allclose(values, np.linalg.eigvalsh((m + m.mT).numpy()), atol=2e-6)
    assert unitary(vectors[None]) < 1e-6


@pytest.mark.parametrize("name", REPEATED)
@pytest.mark.parametrize("function", [svd, symmetric_eigen, null_vector])
def test_gradients_are_finite_at_repeated_values(function: Callable, name: str) -> None:
    m = REPEATED[name].clone().requires_grad_(True)
    total = sum(((torch.arange(o.numel()).reshape(o.shape) + 1.0) * o).sum() for o in as_tuple(function(m)))
    [gradient] = torch.autograd.grad(total, m)
    assert gradient.isfinite().all() and gradient.abs().max() < 1e4


@pytest.mark.parametrize("n", [2, 3, 4, 6])
@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_determinants_of_nearly_singular_matrices(n: int, dtype: torch.dtype) -> None:
    """Exact determinants, by fractions, for matrices with one singular value of 1 and the others 1e-6."""
    m = general(n, 1e6, "one large")[:20].to(dtype) * 1e3
    for one, found in zip(m, det(m).tolist()):
        expected = float(exact_determinant([[Fraction(v) for v in row] for row in one.tolist()]))
        assert found == pytest.approx(expected, rel=1e-8 if dtype == torch.float64 else 1.2e-7)


def exact_determinant(rows: list[list[Fraction]]) -> Fraction:
    if len(rows) == 1:
        return rows[0][0]
    minors = ([r[:k] + r[k + 1 :] for r in rows[1:]] for k in range(len(rows)))
    return sum(
        ((-1) ** k * rows[0][k] * exact_determinant(minor) for k, minor in enumerate(minors)), Fraction(0)
    )


@pytest.mark.parametrize("n", [3, 5])
def test_determinants_gradient_is_finite_at_singular_matrices(n: int) -> None:
    for m in (torch.zeros(n, n), torch.ones(n, n)):
        m.requires_grad_(True)
        [gradient] = torch.autograd.grad(det(m), m)
        assert gradient.isfinite().all()


def test_rotation_nearest_to_a_matrix_is_differentiable_at_repeated_singular_values() -> None:
    def polar(m: Tensor) -> Tensor:
        u, _, v = svd(m)
        return u @ v.mT

    for m in (
        2.0 * torch.eye(3, dtype=torch.float64),
        torch.linalg.qr(rand(3, 3))[0],
        torch.diag(torch.tensor([1.0, 1.0, 0.5], dtype=torch.float64)),
    ):
        assert torch.autograd.gradcheck(polar, (m.requires_grad_(True),))


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_gradients(n: int) -> None:
    square = rand(2, n, n, seed=n).requires_grad_(True)
    tall = rand(2, n + 2, n, seed=n).requires_grad_(True)
    wide = rand(2, n - 1, n, seed=n).requires_grad_(True)
    for function, active in (
        (inverse, square),
        (det, square),
        (symmetric_eigen, square),
        (svd, square),
        (svd, tall),
        (qr, tall),
        (null_vector, tall),
        (null_vector, wide),
    ):
        assert torch.autograd.gradcheck(function, (active,), fast_mode=True)
    assert torch.autograd.gradcheck(
        solve, (square, tall[:, :n].detach().requires_grad_(True)), fast_mode=True
    )


@pytest.mark.parametrize("n", [3, 5])
def test_second_derivatives(n: int) -> None:
    square = rand(2, n, n, seed=n).requires_grad_(True)
    for function in (inverse, det):
        assert torch.autograd.gradgradcheck(function, (square,), fast_mode=True)
    assert torch.autograd.gradgradcheck(solve, (square, rand(2, n, 1).requires_grad_(True)), fast_mode=True)


@pytest.mark.parametrize("values", [[1.0, 1.0, 0.0], [2.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 0.0]])
def test_vectors_do_not_depend_on_rounding(values: list[float]) -> None:
    """Noise of one unit in the last place rotates no vector, even if values are repeated, as in essential
    matrices."""
    q1, q2 = torch.linalg.qr(rand(200, 3, 3))[0], torch.linalg.qr(rand(200, 3, 3, seed=1))[0]
    s = torch.tensor(values, dtype=torch.float64)
    for function, m in ((svd, (q1 * s) @ q2), (symmetric_eigen, (q1 * s) @ q1.mT)):
        first, second = function(m), function(m * (1.0 + 1e-16 * rand(200, 3, 3, seed=2)))
        for a, b in zip(first, second):
            torch.testing.assert_close(a, b, rtol=0, atol=1e-10)


def test_signs() -> None:
    vectors = rand(4, 5, 3)
    torch.testing.assert_close(vectors * pointed(vectors), -vectors * pointed(-vectors))
    assert (pointed(null_vector(rand(4, 2, 3))[..., None]) == 1).all()


@pytest.mark.parametrize("function", [inverse, det, symmetric_eigen, svd, qr, null_vector])
def test_scripts_and_target_forms(function: Callable) -> None:
    scripted = torch.jit.script(function)
    for n in (3, 4, 6):
        m = rand(2, n, n, seed=n)
        expected = as_tuple(function(m))
        forms = [scripted(m)]
        for target in ("onnx", "native", "vjp"):
            with exporting(target):
                forms.append(function(m))
        for form in forms:
            for a, e in zip(as_tuple(form), expected):
                torch.testing.assert_close(a, e, rtol=1e-11, atol=1e-11)


def test_null_vector_of_ill_conditioned_points() -> None:
    """Pixel coordinates without normalisation: m^T m has no correct digit of the second smallest singular
    value."""
    m = general(9, 1e7, "even")
    rows = m[:, :8]
    expected = torch.from_numpy(np.linalg.svd(rows.numpy())[2][:, -1])
    cosine = (null_vector(rows) * expected).sum(1).abs()
    assert (1 - cosine).max() < 1e-12


def test_symmetric_part_is_taken() -> None:
    m = symmetric(4, 10.0, "even")
    skew = rand(4, 4)
    torch.testing.assert_close(
        symmetric_eigen(m + skew - skew.mT), symmetric_eigen(m), rtol=1e-10, atol=1e-10
    )
