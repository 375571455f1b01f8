"""Whitening against NumPy's eigendecomposition."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from photos import photo
from torch import Tensor

from chiasm import enhance
from chiasm.primitives.linalg.matrix_roots import spd_square_roots


def patches(count: int, channels: int, size: int, dtype: torch.dtype = torch.float64) -> Tensor:
    """Neighbouring patches of a photograph: strongly correlated features."""
    x = photo(1, channels, 60, 60, dtype)[0]
    return torch.stack(
        [x[:, i % 50 : i % 50 + size, i // 3 % 50 : i // 3 % 50 + size] for i in range(0, 7 * count, 7)]
    )


def power(rows: np.ndarray, exponent: float, unbiased: bool, eps: float) -> np.ndarray:
    covariance = np.cov(rows, rowvar=False, ddof=int(unbiased))
    values, vectors = np.linalg.eigh(covariance)
    return vectors @ np.diag((values + eps) ** exponent) @ vectors.T


@pytest.mark.parametrize("unbiased", [True, False])
@pytest.mark.parametrize(("count", "channels", "size"), [(40, 1, 3), (100, 3, 2), (9, 7, 2)])
def test_zca_equals_eigh(count: int, channels: int, size: int, unbiased: bool) -> None:
    x = patches(count, channels, size)
    rows = x.flatten(1).numpy()
    matrix, mean, inverse = enhance.zca_mean(x, 0, unbiased, 1e-5, True)
    np.testing.assert_allclose(mean, rows.mean(0, keepdims=True), atol=1e-12)
    np.testing.assert_allclose(matrix, power(rows, -0.5, unbiased, 1e-5), rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(inverse, power(rows, 0.5, unbiased, 1e-5), atol=1e-9)
    assert enhance.zca_mean(x)[2] is None


@pytest.mark.parametrize("dim", [0, 1, -1])
def test_whitened_features_are_uncorrelated(dim: int) -> None:
    x = patches(200, 1, 3).movedim(0, dim)
    white = enhance.zca_whiten(x, dim, eps=1e-9)
    assert white.shape == x.shape
    np.testing.assert_allclose(
        np.cov(white.movedim(dim, 0).flatten(1).numpy(), rowvar=False), np.eye(9), atol=1e-3
    )


def test_float32_data_are_whitened_in_float64() -> None:
    x = patches(100, 3, 2)
    exact = enhance.zca_whiten(x)
    torch.testing.assert_close(enhance.zca_whiten(x.float()).double(), exact, atol=2e-3, rtol=0)


def test_gradients() -> None:
    x = patches(12, 1, 2).requires_grad_(True)
    assert torch.autograd.gradcheck(
        lambda x: enhance.zca_mean(x, eps=1e-3, return_inverse=True), [x], fast_mode=True
    )
    assert torch.autograd.gradcheck(lambda x: enhance.zca_whiten(x, eps=1e-3), [x], fast_mode=True)


def test_gradient_with_equal_eigenvalues() -> None:
    # an eigendecomposition has no gradient here
    x = torch.cat([torch.eye(4), -torch.eye(4)]).double().requires_grad_(True)
    assert torch.autograd.gradcheck(lambda x: enhance.zca_whiten(x, eps=1e-3), [x], fast_mode=True)


@pytest.mark.parametrize("dim", [0, 1, 2, -1])
def test_linear_transform(dim: int) -> None:
    x = photo(1, 3, 5, 4, torch.float64)[0]
    generator = torch.Generator().manual_seed(1)
    rows = np.moveaxis(x.numpy(), dim, 0)
    features = rows[0].size
    matrix = torch.rand(features, features, generator=generator, dtype=torch.float64)
    mean = torch.rand(1, features, generator=generator, dtype=torch.float64)
    expected = ((rows.reshape(rows.shape[0], -1) - mean.numpy()) @ matrix.numpy()).reshape(rows.shape)
    np.testing.assert_allclose(
        enhance.linear_transform(x, matrix, mean, dim), np.moveaxis(expected, 0, dim), atol=1e-12
    )


@pytest.mark.parametrize("condition", [1.0, 1e3, 1e9])
@pytest.mark.parametrize("size", [1, 2, 30])
def test_square_roots_equal_eigh(size: int, condition: float) -> None:
    basis = np.linalg.qr(np.random.default_rng(size).normal(size=(size, size)))[0]
    values = np.geomspace(100.0, 100.0 / condition, size)
    root, inverse = spd_square_roots(torch.from_numpy(basis @ np.diag(values) @ basis.T))
    np.testing.assert_allclose(root, basis @ np.diag(values**0.5) @ basis.T, atol=1e-8)
    expected = basis @ np.diag(values**-0.5) @ basis.T
    np.testing.assert_allclose(inverse, expected, atol=1e-6 * abs(expected).max())


X = torch.zeros(4, 3, 2)
EYE = torch.eye(6)
WRONG = [
    (lambda: enhance.zca_mean(X.int()), TypeError, "inp: expected a floating-point tensor"),
    (lambda: enhance.zca_mean(X[0, 0]), ValueError, "inp: expected at least two dimensions"),
    (lambda: enhance.zca_whiten(X, 3), ValueError, "dim: expected a dimension of a tensor with 3, got 3"),
    (
        lambda: enhance.linear_transform(X, EYE[:, :5], EYE[:1]),
        ValueError,
        r"transform_matrix: expected shape \(6, 6\), got \[6, 5\]",
    ),
    (
        lambda: enhance.linear_transform(X, EYE, EYE[:1, :5]),
        ValueError,
        r"mean_vector: expected shape \(1, 6\), got \[1, 5\]",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
