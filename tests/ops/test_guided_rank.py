"""Guided, joint bilateral, non-local and rank filters against SciPy, OpenCV and their definitions."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import chw, hwc, photo
from torch import Tensor

from chiasm.filters import (
    bilateral_blur,
    guided_blur,
    joint_bilateral_blur,
    median_blur,
    non_local_means,
    percentile_filter,
    rank_filter,
)

SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}
NUMPY_MODE = {"reflect": "reflect", "replicate": "edge", "circular": "wrap", "constant": "constant"}
X = torch.zeros(1, 3, 8, 8)
BYTES = torch.zeros(1, 3, 8, 8, dtype=torch.uint8)


def per_plane(x: Tensor, function: object) -> np.ndarray:
    planes = x.numpy().reshape(-1, *x.shape[2:])
    return np.stack([function(p) for p in planes]).reshape(x.shape)


# --- rank ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(3, 3), (5, 3), (1, 7), (5, 5)])
def test_rank_filter_equals_scipy(size: tuple[int, int], border: str) -> None:
    x = photo(3, 7, 12, 17, torch.float64)
    count = size[0] * size[1]
    for rank in sorted({0, 1, count // 3, count // 2, count - 2, count - 1, -1, -3}):
        expected = per_plane(
            x, lambda p, rank=rank: ndi.rank_filter(p, rank, size=size, mode=SCIPY_MODE[border])
        )
        np.testing.assert_array_equal(rank_filter(x, rank, size, border), expected)


@pytest.mark.parametrize("percentile", [0.0, 10.0, 33.3, 50.0, 80.0, 99.0, 100.0])
def test_percentile_filter_equals_scipy(percentile: float) -> None:
    x = photo(2, 1, 31, 22)
    expected = per_plane(x, lambda p: ndi.percentile_filter(p, percentile, size=(5, 3), mode="nearest"))
    np.testing.assert_array_equal(percentile_filter(x, percentile, (5, 3), "replicate"), expected)


def test_largest_median_equals_scipy() -> None:
    x = photo(1, 3, 23, 30)
    np.testing.assert_array_equal(
        median_blur(x, 7), per_plane(x, lambda p: ndi.median_filter(p, 7, mode="mirror"))
    )


# --- joint bilateral ----------------------------------------------------------------------------------------


def joint_by_definition(
    x: np.ndarray,
    guide: np.ndarray,
    size: tuple[int, int],
    color: float,
    space: tuple[float, float],
    border: str,
    distance: str,
) -> np.ndarray:
    ry, rx = (size[0] // 2, size[1] // 2)
    pads = ((0, 0), (ry, ry), (rx, rx))
    p, g = np.pad(x, pads, NUMPY_MODE[border]), np.pad(guide, pads, NUMPY_MODE[border])
    rows, columns = np.mgrid[-ry : ry + 1, -rx : rx + 1]
    closeness = np.exp(-(rows**2) / (2 * space[0] ** 2) - columns**2 / (2 * space[1] ** 2))
    out = np.empty_like(x)
    for i, j in np.ndindex(*x.shape[1:]):
        window = np.s_[:, i : i + size[0], j : j + size[1]]
        difference = g[window] - guide[:, i, j][:, None, None]
        squared = np.abs(difference).sum(0) ** 2 if distance == "l1" else (difference**2).sum(0)
        weight = closeness * np.exp(-squared / (2 * color**2))
        out[:, i, j] = (p[window] * weight).sum((1, 2)) / weight.sum()
    return out


@pytest.mark.parametrize("border", NUMPY_MODE)
@pytest.mark.parametrize("distance", ["l1", "l2"])
@pytest.mark.parametrize("channels", [(3, 1), (1, 3), (7, 5)])
def test_joint_bilateral_by_definition(channels: tuple[int, int], distance: str, border: str) -> None:
    x, guide = photo(2, channels[0], 13, 16, torch.float64), photo(4, channels[1], 13, 16, torch.float64)[1:3]
    actual = joint_bilateral_blur(x, guide, (3, 5), 0.1, (1.0, 1.7), border, distance)
    for b in range(2):
        expected = joint_by_definition(
            x[b].numpy(), guide[b].numpy(), (3, 5), 0.1, (1.0, 1.7), border, distance
        )
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


def test_joint_bilateral_shares_one_guide() -> None:
    x, guide = photo(3, 2, 14, 17), photo(1, 3, 14, 17)
    shared = joint_bilateral_blur(x, guide, 3, 0.1, (1.0, 1.0))
    assert torch.equal(shared, joint_bilateral_blur(x, guide.expand(3, 3, 14, 17), 3, 0.1, (1.0, 1.0)))


def test_joint_bilateral_guided_by_itself() -> None:
    x = photo(2, 3, 20, 21)
    sigma = torch.tensor([0.1, 0.3])
    assert torch.equal(
        joint_bilateral_blur(x, x.clone(), 5, sigma, (1.5, 1.0)), bilateral_blur(x, 5, sigma, (1.5, 1.0))
    )


# --- guided -------------------------------------------------------------------------------------------------


def guided_models(
    guide: np.ndarray, x: np.ndarray, size: tuple[int, int], eps: float, border: str
) -> np.ndarray:
    """Slopes and offset (D, C + 1, H, W) of one sample by least squares in every window, averaged."""
    pads = ((0, 0), (size[0] // 2,) * 2, (size[1] // 2,) * 2)
    g, p = np.pad(guide, pads, NUMPY_MODE[border]), np.pad(x, pads, NUMPY_MODE[border])
    channels = len(guide)
    models = np.empty((len(x), channels + 1, *x.shape[1:]))
    for i, j in np.ndindex(*x.shape[1:]):
        a = g[:, i : i + size[0], j : j + size[1]].reshape(channels, -1)
        b = p[:, i : i + size[0], j : j + size[1]].reshape(len(x), -1)
        covariance = np.cov(a, bias=True).reshape(channels, channels) + eps * np.eye(channels)
        slope = np.linalg.solve(
            covariance, (a - a.mean(1, keepdims=True)) @ (b - b.mean(1, keepdims=True)).T / a.shape[1]
        )
        models[:, :channels, i, j] = slope.T
        models[:, channels, i, j] = b.mean(1) - slope.T @ a.mean(1)
    return np.stack(
        [[ndi.uniform_filter(m, size, mode=SCIPY_MODE[border]) for m in model] for model in models]
    )


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("channels", [(1, 1), (3, 5), (7, 1)])
def test_guided_by_definition(channels: tuple[int, int], border: str) -> None:
    guide, x = photo(2, channels[0], 15, 18, torch.float64), photo(4, channels[1], 15, 18, torch.float64)[1:3]
    for eps in (0.01, torch.tensor([0.01, 0.04], dtype=torch.float64)):
        actual = guided_blur(guide, x, (3, 5), eps, border)
        for b in range(2):
            models = guided_models(
                guide[b].numpy(), x[b].numpy(), (3, 5), float(torch.as_tensor(eps).expand(2)[b]), border
            )
            expected = (models[:, :-1] * guide[b].numpy()).sum(1) + models[:, -1]
            np.testing.assert_allclose(actual[b], expected, atol=1e-10)


@pytest.mark.parametrize("shape", [(20, 26), (21, 19)])
def test_subsampled_guided_by_definition(shape: tuple[int, int]) -> None:
    guide, x = photo(1, 3, *shape, torch.float64), photo(2, 3, *shape, torch.float64)[1:]
    rows, columns = (np.arange(n // 2) * n // (n // 2) for n in shape)
    small = [t[0].numpy()[:, rows][:, :, columns] for t in (guide, x)]
    models = guided_models(*small, (3, 3), 0.02, "reflect").reshape(-1, len(rows), len(columns))
    large = np.stack([cv2.resize(m, shape[::-1], interpolation=cv2.INTER_LINEAR) for m in models]).reshape(
        3, 4, *shape
    )
    expected = (large[:, :-1] * guide[0].numpy()).sum(1) + large[:, -1]
    np.testing.assert_allclose(guided_blur(guide, x, 5, 0.02, subsample=2)[0], expected, atol=1e-6)


# --- non-local means ----------------------------------------------------------------------------------------


def nonlocal_by_definition(
    x: np.ndarray, patch: int, reach: int, h: float, sigma: float, border: str
) -> np.ndarray:
    r = patch // 2
    p = np.pad(x, ((0, 0), (reach + r,) * 2, (reach + r,) * 2), NUMPY_MODE[border])
    out = np.empty_like(x)
    for i, j in np.ndindex(*x.shape[1:]):
        here = p[:, i + reach : i + reach + patch, j + reach : j + reach + patch]
        total, weights = np.zeros(len(x)), 0.0
        for u, v in np.ndindex(2 * reach + 1, 2 * reach + 1):
            there = p[:, i + u : i + u + patch, j + v : j + v + patch]
            weight = np.exp(-max(((there - here) ** 2).mean() - 2 * sigma**2, 0) / h**2)
            total, weights = total + weight * there[:, r, r], weights + weight
        out[:, i, j] = total / weights
    return out


@pytest.mark.parametrize("border", NUMPY_MODE)
@pytest.mark.parametrize("channels", [1, 5])
def test_nonlocal_means_by_definition(channels: int, border: str) -> None:
    x = photo(2, channels, 9, 11, torch.float64)
    actual = non_local_means(x, 3, 2, 0.15, 0.02, border)
    for b in range(2):
        np.testing.assert_allclose(
            actual[b], nonlocal_by_definition(x[b].numpy(), 3, 2, 0.15, 0.02, border), atol=1e-12
        )


@pytest.mark.parametrize("channels", [1, 2, 3])
@pytest.mark.parametrize("h", [10.0, 25.0])
def test_nonlocal_means_equals_opencv(channels: int, h: float) -> None:
    levels = torch.round(photo(2, channels, 50, 61, torch.float64) * 255.0)
    actual = non_local_means(levels, 5, 6, h)
    for b in range(2):
        expected = chw(cv2.fastNlMeansDenoising(hwc(levels.to(torch.uint8), b), None, h, 5, 13))
        # OpenCV rounds its results to whole levels, and its weights too
        np.testing.assert_allclose(actual[b], expected, atol=1.0)


def test_nonlocal_means_gradient() -> None:
    x = photo(1, 2, 6, 7, torch.float64).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda t: non_local_means(t, 3, 1, 0.2), [x], fast_mode=True)


WRONG = [
    (lambda: rank_filter(X, 9, 3), ValueError, r"rank: expected -9 to 8 .* got 9"),
    (lambda: rank_filter(BYTES.int(), 0, 3), TypeError, "input: expected a floating-point, uint8, int16 or"),
    (lambda: rank_filter(X, 0, 3, "mirror"), ValueError, "border_type: expected one of"),
    (lambda: percentile_filter(X, 101.0, 3), ValueError, "percentile: expected 0 to 100, got 101"),
    (lambda: percentile_filter(X, 50.0, 4), ValueError, r"kernel_size: expected odd .* got \(4, 4\)"),
    (
        lambda: joint_bilateral_blur(X, X[:, :, 1:], 3, 0.1, (1.0, 1.0)),
        ValueError,
        "guidance: expected input's height",
    ),
    (
        lambda: joint_bilateral_blur(X, BYTES, 3, 0.1, (1.0, 1.0)),
        TypeError,
        "guidance: expected uint8 with an input of uint8",
    ),
    (lambda: guided_blur(X[:, :, 1:], X, 3, 0.1), ValueError, "guidance: expected input's batch"),
    (lambda: guided_blur(X, X, 3, 0.1, subsample=0), ValueError, "subsample: expected at least 1, got 0"),
    (lambda: guided_blur(X, X, (3, 2), 0.1), ValueError, r"kernel_size: expected odd .* got \(3, 2\)"),
    (lambda: non_local_means(X, 4), ValueError, "patch_size: expected an odd .* got 4"),
    (lambda: non_local_means(X, 3, -1), ValueError, "patch_distance: expected at least 0, got -1"),
    (lambda: non_local_means(X, 3, 1, 0.0), ValueError, "h: expected a positive number, got 0.0"),
    (lambda: non_local_means(BYTES), TypeError, "input: expected a floating-point"),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
