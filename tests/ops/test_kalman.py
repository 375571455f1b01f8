"""Kalman filters: against the equations in information form (inverse covariances), and against least
squares."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch

from chiasm.ops import kalman_predict, kalman_update

RANDOM = np.random.default_rng(0)


def covariance(*shape: int) -> np.ndarray:
    factor = RANDOM.normal(size=(*shape, shape[-1]))
    return factor @ factor.swapaxes(-1, -2) + 0.1 * np.eye(shape[-1])


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [torch.from_numpy(a) for a in arrays]


@pytest.mark.parametrize("own", [(), (2, 3)])
@pytest.mark.parametrize(("size", "measured"), [(7, 4), (2, 1), (5, 5), (1, 1), (3, 6)])
def test_the_equations(size: int, measured: int, own: tuple[int, ...]) -> None:
    """With shared matrices, and with one per sample."""
    x, p = RANDOM.normal(size=(2, 3, size)), covariance(2, 3, size)
    f, q = RANDOM.normal(size=(*own, size, size)), covariance(*own, size)
    mean, spread = kalman_predict(*tensors(x, p, f, q))
    np.testing.assert_allclose(mean, np.einsum("...ij,...j->...i", f, x), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(spread, f @ p @ f.swapaxes(-1, -2) + q, rtol=1e-10, atol=1e-12)

    z, h, r = (
        RANDOM.normal(size=(2, 3, measured)),
        RANDOM.normal(size=(*own, measured, size)),
        covariance(*own, measured),
    )
    mean, spread = kalman_update(*tensors(x, p, z, h, r))
    weighted = h.swapaxes(-1, -2) @ np.linalg.inv(r)
    expected = np.linalg.inv(np.linalg.inv(p) + weighted @ h)
    state = expected @ (np.linalg.inv(p) @ x[..., None] + weighted @ z[..., None])
    np.testing.assert_allclose(mean, state[..., 0], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(spread, expected, rtol=1e-8, atol=1e-9)
    assert torch.equal(spread, spread.mT)


def test_a_line_through_measurements() -> None:
    """A motion with constant speed, of which only positions are measured: the filter gives the least-squares
    line."""
    z = 3.0 + 0.5 * np.arange(40) + RANDOM.normal(size=40)
    mean, spread = torch.zeros(1, 2, dtype=torch.float64), 1e9 * torch.eye(2, dtype=torch.float64)[None]
    moves, none = torch.tensor([[1.0, 1.0], [0.0, 1.0]]).double(), torch.zeros(2, 2).double()
    position, one = torch.tensor([[1.0, 0.0]]).double(), torch.ones(1, 1).double()
    for k in range(40):
        if k > 0:
            mean, spread = kalman_predict(mean, spread, moves, none)
        mean, spread = kalman_update(mean, spread, torch.tensor([[z[k]]]), position, one)
    (speed, begin), errors = np.polyfit(np.arange(40), z, 1, cov="unscaled")
    np.testing.assert_allclose(mean[0], [begin + 39 * speed, speed], rtol=1e-6)
    np.testing.assert_allclose(spread[0, 1, 1], errors[0, 0], rtol=1e-6)


def test_covariances_stay_positive_definite() -> None:
    """In float32, with a measurement that is far more certain than the state."""
    moves = torch.eye(7) + torch.diag(torch.ones(3), 4)
    mean, spread = torch.zeros(1, 7), 1e4 * torch.eye(7)[None]
    generator = torch.Generator().manual_seed(0)
    for _ in range(300):
        mean, spread = kalman_predict(mean, spread, moves, 1e-6 * torch.eye(7))
        z = torch.rand(1, 4, generator=generator)
        mean, spread = kalman_update(mean, spread, z, torch.eye(7)[:4], 1e-3 * torch.eye(4))
        assert spread.dtype == torch.float32
        assert torch.linalg.eigvalsh(spread.double()).min() > 0.0
    assert torch.isfinite(mean).all()


def test_half_precision_keeps_its_dtype() -> None:
    mean, spread = kalman_predict(*(part.half() for part in (X, P, torch.eye(3), torch.eye(3))))
    assert mean.dtype == spread.dtype == torch.float16
    assert torch.equal(mean, X.half()) and torch.equal(spread, (P + torch.eye(3)).half())


X, P, Z = torch.ones(2, 3), torch.eye(3).expand(2, 3, 3), torch.ones(2, 2)
H, R = torch.eye(3)[:2], torch.eye(2)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: kalman_predict(X.int(), P, P, P), TypeError, "mean: expected a floating-point"),
        (lambda: kalman_predict(X, P[:1], P, P), ValueError, r"covariance: expected shape \(\*, D, D\)"),
        (lambda: kalman_predict(X, P, H, P), ValueError, r"transition: expected shape \(\*, 3, 3\)"),
        (lambda: kalman_predict(X, P, P, R), ValueError, r"process_noise: expected shape"),
        (lambda: kalman_predict(X, P, torch.ones(5, 3, 3), P), ValueError, "transition: expected leading"),
        (lambda: kalman_predict(X, P, torch.ones(1, 1, 3, 3), P), ValueError, "transition: expected no more"),
        (lambda: kalman_update(X, P, Z[0], H, R), ValueError, r"measurement: expected shape \(\*, E\)"),
        (lambda: kalman_update(X, P, Z.int(), H, R), TypeError, "measurement: expected a floating-point"),
        (lambda: kalman_update(X, P, Z, R, R), ValueError, r"observation: expected shape \(\*, 2, 3\)"),
        (lambda: kalman_update(X, P, Z, H, H), ValueError, "measurement_noise: expected shape"),
    ],
)
def test_errors(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
