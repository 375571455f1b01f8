"""Thresholds against OpenCV and scikit-image, on photographs of 8-bit levels."""

import cv2
import numpy as np
import pytest
import skimage.filters
import torch
from borders import per_plane
from photos import photo
from torch import Tensor

from chiasm.filters import adaptive_threshold, in_range, otsu_threshold

X = torch.zeros(1, 3, 8, 9)


def levels(*shape: int) -> Tensor:
    """Random bytes."""
    return (photo(*shape, torch.float64) * 255).round().to(torch.uint8)


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_in_range_equals_opencv(channels: int) -> None:
    x = levels(2, channels, 23, 31).double()
    lower = torch.tensor([[40.0] * channels, [30.0] * channels], dtype=torch.float64)
    upper = lower + torch.tensor([[120.0], [100.0]], dtype=torch.float64)
    mask, kept = in_range(x, lower, upper, True), in_range(x, lower, upper)
    for b in range(2):
        image = np.ascontiguousarray(x[b].permute(1, 2, 0).to(torch.uint8).numpy())
        expected = cv2.inRange(image, lower[b].numpy(), upper[b].numpy()) / 255
        assert 0 < expected.mean() < 1
        np.testing.assert_array_equal(mask[b, 0], expected)
        np.testing.assert_array_equal(kept[b], x[b] * expected)
    numbers = in_range(x, lower[0].tolist(), upper[0].tolist(), True)
    assert torch.equal(numbers[0], mask[0])
    assert torch.equal(in_range(x, tuple(lower[0].tolist()), upper[0], True), numbers)


@pytest.mark.parametrize("size", [3, 5, 11])
@pytest.mark.parametrize("c", [0.0, 2.0, -3.0, 4.5])
@pytest.mark.parametrize("kind", ["binary", "binary_inv"])
def test_adaptive_mean_equals_opencv(size: int, c: float, kind: str) -> None:
    bytes_ = levels(2, 3, 29, 34)
    flag = cv2.THRESH_BINARY if kind == "binary" else cv2.THRESH_BINARY_INV
    expected = per_plane(
        bytes_, lambda p: cv2.adaptiveThreshold(p, 200, cv2.ADAPTIVE_THRESH_MEAN_C, flag, size, c)
    )
    for dtype in (torch.float32, torch.float64):
        np.testing.assert_array_equal(
            adaptive_threshold(bytes_.to(dtype), 200.0, "mean", kind, size, c), expected
        )


@pytest.mark.parametrize("size", [3, 5, 7, 9, 11, 15])
@pytest.mark.parametrize("kind", ["binary", "binary_inv"])
def test_adaptive_gaussian_equals_opencv(size: int, kind: str) -> None:
    bytes_ = levels(2, 3, 29, 34)
    flag = cv2.THRESH_BINARY if kind == "binary" else cv2.THRESH_BINARY_INV
    expected = per_plane(
        bytes_, lambda p: cv2.adaptiveThreshold(p, 255, cv2.ADAPTIVE_THRESH_GAUSSIAN_C, flag, size, 2)
    )
    # Means of large blocks are not exact: within a rounding error of half a level, either result is allowed.
    mean = per_plane(
        bytes_.double(), lambda p: cv2.GaussianBlur(p, (size, size), 0, borderType=cv2.BORDER_REPLICATE)
    )
    clear = (np.abs(mean - np.floor(mean) - 0.5) > 1e-4) | (size < 11)
    assert clear.mean() > 0.99
    for dtype in (torch.float32, torch.float64):
        actual = adaptive_threshold(bytes_.to(dtype), 255.0, "gaussian", kind, size, 2.0)
        np.testing.assert_array_equal(actual.numpy()[clear], expected[clear])


def test_adaptive_unrounded_equals_scikit_image() -> None:
    x = photo(2, 3, 25, 28, torch.float64)
    actual = adaptive_threshold(x, 1.0, "mean", "binary", 7, 0.0215, rounded=False)
    expected = per_plane(x, lambda p: p > skimage.filters.threshold_local(p, 7, "mean", 0.0215, "nearest"))
    np.testing.assert_array_equal(actual, expected)


@pytest.mark.parametrize("shape", [(1, 1, 61, 83), (3, 3, 64, 50), (2, 7, 33, 40)])
@pytest.mark.parametrize("nbins", [256, 64])
def test_otsu_equals_scikit_image(shape: tuple[int, ...], nbins: int) -> None:
    x = photo(*shape, torch.float64)
    kept, thresholds = otsu_threshold(x, nbins)
    mask, _ = otsu_threshold(x, nbins, return_mask=True)
    assert thresholds.shape == shape[:2]
    expected = per_plane(x, lambda p: np.float64(skimage.filters.threshold_otsu(p, nbins)))
    np.testing.assert_allclose(thresholds, expected, atol=1e-12)
    width = (x.amax((2, 3)) - x.amin((2, 3))).numpy() / nbins
    # scikit-image's classes are whole bins, and its threshold is a bin's centre.
    np.testing.assert_array_equal(mask, x.numpy() >= (expected + width / 2 - 1e-12)[..., None, None])
    np.testing.assert_array_equal(kept, np.where(mask, x, 0))


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_otsu_separates_as_opencv(dtype: torch.dtype) -> None:
    bytes_ = levels(3, 3, 90, 110)
    bytes_[..., 0, 0], bytes_[..., 0, 1] = 0, 255  # the whole range: a bin for each level
    mask, _ = otsu_threshold(bytes_.to(dtype) / 255, return_mask=True)
    expected = per_plane(bytes_, lambda p: cv2.threshold(p, 0, 1, cv2.THRESH_OTSU)[1])
    assert 0 < expected.mean() < 1
    np.testing.assert_array_equal(mask, expected)


def test_otsu_of_one_value_and_of_fewer_dimensions() -> None:
    kept, threshold = otsu_threshold(torch.full((5, 6), 0.3))
    assert threshold == 0.3 and threshold.shape == ()
    assert (kept == 0).all()
    x = photo(1, 3, 20, 21)
    assert torch.equal(otsu_threshold(x[0])[1], otsu_threshold(x)[1][0])


def soft_otsu(x: np.ndarray, nbins: int) -> float:
    """The definition of the differentiable form, in a loop."""
    low, high = x.min(), x.max()
    position = np.clip((x.ravel() - low) / (high - low) * nbins - 0.5, 0, nbins - 1)
    counts = np.zeros(nbins)
    for p in position:
        k = min(int(p), nbins - 2)
        counts[k] += 1 - (p - k)
        counts[k + 1] += p - k
    middles = low + (np.arange(nbins) + 0.5) * (high - low) / nbins
    variance = np.array(
        [
            counts[:k].sum()
            * counts[k:].sum()
            * (np.average(middles[:k], weights=counts[:k]) - np.average(middles[k:], weights=counts[k:])) ** 2
            for k in range(1, nbins)
        ]
    )
    weights = np.exp(nbins * (variance / variance.max() - 1))
    return float(np.average(middles[:-1], weights=weights))


def test_differentiable_otsu_by_definition() -> None:
    x = photo(2, 2, 24, 26, torch.float64)
    _, thresholds = otsu_threshold(x, 32, slow_and_differentiable=True)
    np.testing.assert_allclose(thresholds, per_plane(x, lambda p: np.float64(soft_otsu(p, 32))), atol=1e-12)


def test_differentiable_otsu_has_a_gradient() -> None:
    x = (
        photo(1, 1, 12, 13, torch.float64)
        + 0.01 * torch.rand(12, 13, generator=torch.Generator().manual_seed(0))
    ).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda v: otsu_threshold(v, 16, True)[1], x, eps=1e-7)
    (gradient,) = torch.autograd.grad(otsu_threshold(x, 16, True)[1].sum(), x)
    # A shift of all values shifts the threshold equally.
    torch.testing.assert_close(gradient.sum(), torch.tensor(1.0, dtype=torch.float64))
    assert (gradient != 0).sum() > 10


def test_in_range_of_values_that_are_not_finite() -> None:
    x = torch.tensor([torch.nan, torch.inf, -torch.inf, 0.5, 2.0]).reshape(1, 1, 1, 5).requires_grad_(True)
    kept = in_range(x, [0.0], [1.0])
    assert kept.flatten().tolist() == [0.0, 0.0, 0.0, 0.5, 0.0]
    assert in_range(x, [0.0], [torch.inf]).flatten().tolist() == [0.0, torch.inf, 0.0, 0.5, 2.0]
    kept.sum().backward()
    assert x.grad.flatten().tolist() == [0.0, 0.0, 0.0, 1.0, 0.0]


WRONG = [
    (lambda: in_range(X[None], [0.0], [1.0]), ValueError, r"input: expected shape \(B, C, H, W\)"),
    (lambda: in_range(X.int(), [0.0] * 3, [1.0] * 3), TypeError, "input: expected a floating-point"),
    (
        lambda: in_range(X, [0.0], [1.0] * 3),
        ValueError,
        r"lower: expected shape \(C,\) or \(B, C\) with input's 3 channels, got \[1\]",
    ),
    (lambda: in_range(X, [0.0] * 3, torch.ones(1, 1, 3)), ValueError, "upper: expected shape"),
    (lambda: adaptive_threshold(X[0], 1.0), ValueError, "input: expected shape"),
    (lambda: adaptive_threshold(X.int(), 1.0), TypeError, "input: expected a floating-point"),
    (lambda: adaptive_threshold(X, 1.0, "median"), ValueError, "adaptive_method: expected one of .*'median'"),
    (
        lambda: adaptive_threshold(X, 1.0, "mean", "trunc"),
        ValueError,
        "threshold_type: expected one of .*'trunc'",
    ),
    (lambda: adaptive_threshold(X, 1.0, block_size=4), ValueError, "block_size: expected odd"),
    (lambda: adaptive_threshold(X, 1.0, block_size=1), ValueError, "block_size: expected at least 3, got 1"),
    (lambda: otsu_threshold(X[0, 0, 0]), ValueError, r"x: expected shape \(\*, H, W\), got \[9\]"),
    (lambda: otsu_threshold(X.int()), TypeError, "x: expected a floating-point"),
    (lambda: otsu_threshold(X, 1), ValueError, "nbins: expected at least 2, got 1"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
