"""Kernel histograms by their definitions in NumPy, and against SciPy."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from photos import photo
from scipy.stats import gaussian_kde

from chiasm import enhance

CENTRES = torch.linspace(0.0, 1.0, 12, dtype=torch.float64)
BANDWIDTH = torch.tensor(0.07, dtype=torch.float64)


def weights(values: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * ((values[:, None] - CENTRES.numpy()) / 0.07) ** 2)


def test_histogram_by_definition() -> None:
    x = photo(3, 1, 17, 23, torch.float64).flatten(1)
    actual = enhance.histogram(x, CENTRES, BANDWIDTH)
    for b in range(3):
        density = weights(x[b].numpy()).mean(0)
        np.testing.assert_allclose(actual[b], density / density.sum(), atol=1e-9)


def test_histogram_equals_scipy() -> None:
    x = photo(2, 1, 17, 23, torch.float64).flatten(1)
    for b in range(2):
        values = x[b].numpy()
        expected = gaussian_kde(values, 0.07 / values.std(ddof=1))(CENTRES.numpy())
        np.testing.assert_allclose(
            enhance.histogram(x, CENTRES, BANDWIDTH[None])[b], expected / expected.sum(), atol=1e-8
        )


def test_joint_histogram_by_definition() -> None:
    x = photo(2, 2, 17, 23, torch.float64).flatten(2)
    actual = enhance.histogram2d(x[:, 0], x[:, 1], CENTRES, BANDWIDTH)
    for b in range(2):
        joint = weights(x[b, 0].numpy()).T @ weights(x[b, 1].numpy())
        np.testing.assert_allclose(actual[b], joint / joint.sum(), atol=1e-9)


KERNELS = {
    "triangular": lambda u: np.maximum(1 - u, 0),
    "uniform": lambda u: (u <= 1).astype(float),
    "epanechnikov": lambda u: np.maximum(1 - u * u, 0),
    "gaussian": lambda u: np.exp(-0.5 * u * u),
}


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("bandwidth", [None, 11.3])
def test_image_histogram_by_definition(kernel: str, bandwidth: float | None) -> None:
    x = photo(2, 3, 17, 23, torch.float64) * 255
    counts, density = enhance.image_histogram2d(x, 0.0, 255.0, 30, bandwidth, None, True, kernel)
    width = bandwidth or 255 / 30
    centres = (np.arange(30) + 0.5) * width
    u = np.abs(x.flatten(2).numpy()[..., None] - centres) / width
    expected = KERNELS[kernel](u).sum(2)
    np.testing.assert_allclose(counts, expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(density, expected / expected.sum(-1, keepdims=True), rtol=1e-9, atol=1e-9)
    single, zeros = enhance.image_histogram2d(x[0, 1], 0.0, 255.0, 30, bandwidth, kernel=kernel)
    torch.testing.assert_close(single, counts[0, 1])
    assert zeros.shape == single.shape
    assert not zeros.any()


def test_narrow_bins_at_the_levels_count_them() -> None:
    x = photo(1, 2, 17, 23)
    levels = (x * 255).round()
    counts, _ = enhance.image_histogram2d(levels, n_bins=256, bandwidth=0.5, centers=torch.arange(256.0))
    for c in range(2):
        expected = np.bincount(levels[0, c].flatten().int().numpy(), minlength=256)
        np.testing.assert_allclose(counts[0, c], expected, atol=1e-3)


X = torch.zeros(2, 3, 4, 5)
V = torch.zeros(2, 9)
ONE = torch.ones(1)
WRONG = [
    (lambda: enhance.histogram(V.int(), CENTRES, ONE), TypeError, "x: expected a floating-point tensor"),
    (lambda: enhance.histogram(X, CENTRES, ONE), ValueError, r"x: expected shape \(B, N\)"),
    (lambda: enhance.histogram(V, V, ONE), ValueError, r"bins: expected shape \(K,\)"),
    (
        lambda: enhance.histogram(V, CENTRES, torch.ones(2)),
        ValueError,
        r"bandwidth: expected a scalar tensor or \(1,\), got \[2\]",
    ),
    (
        lambda: enhance.histogram2d(V, V[:, 1:], CENTRES, ONE),
        ValueError,
        r"x2: expected x1's shape \[2, 9\], got \[2, 8\]",
    ),
    (lambda: enhance.image_histogram2d(V[0]), ValueError, r"image: expected shape \(\*, H, W\)"),
    (lambda: enhance.image_histogram2d(X, n_bins=0), ValueError, "n_bins: expected a positive number, got 0"),
    (
        lambda: enhance.image_histogram2d(X, bandwidth=0.0),
        ValueError,
        "bandwidth: expected a positive number, got 0.0",
    ),
    (
        lambda: enhance.image_histogram2d(X, n_bins=4, centers=CENTRES),
        ValueError,
        r"centers: expected shape \(4,\), got \[12\]",
    ),
    (lambda: enhance.image_histogram2d(X, kernel="cosine"), ValueError, "kernel: expected one of .*'cosine'"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
