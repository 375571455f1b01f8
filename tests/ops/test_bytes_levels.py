"""Ops that count, compare and weight levels of bytes, against OpenCV and Pillow, in both layouts."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from PIL import Image, ImageOps
from test_bytes import as_frame, both_layouts, frame
from torch import Tensor

from chiasm.enhance import (
    add_weighted,
    autocontrast,
    count_histogram,
    equalize,
    equalize_clahe,
    integral_image,
    integral_tensor,
    normalize,
)
from chiasm.filters import in_range, otsu_threshold


def images() -> list[np.ndarray]:
    """Images with all levels, with few, with only bright ones, and with a single one."""
    image = frame(61, 83)
    dark = (image.astype(int) ** 2 // 300).astype(np.uint8)
    return [image, dark, image // 64 * 50, 200 + image // 16, np.full((4, 5, 3), 77, np.uint8), image[:1, :1]]


@pytest.mark.parametrize("image", images(), ids=range(6))
def test_equalized_levels_are_pillows(image: np.ndarray) -> None:
    pillow = Image.fromarray(image)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(equalize(x)), np.asarray(ImageOps.equalize(pillow)))
        planes = torch.round(255 * equalize(x.contiguous() / 255))
        np.testing.assert_array_equal(as_frame(planes.to(torch.uint8)), as_frame(equalize(x)))


@pytest.mark.parametrize("image", images(), ids=range(6))
@pytest.mark.parametrize("cutoff", [0.0, (1.0, 2.5)])
def test_stretched_levels_are_the_quotients_rounded_down(image: np.ndarray, cutoff) -> None:
    pillow = np.asarray(ImageOps.autocontrast(Image.fromarray(image), cutoff)).astype(int)
    for x in both_layouts(image):
        # Rounding in Pillow gives one level less at some integers.
        difference = as_frame(autocontrast(x, cutoff)) - pillow
        assert difference.min() >= 0 and difference.max() <= 1
    low, high = image.min((0, 1)).astype(int), image.max((0, 1)).astype(int)
    if cutoff == 0.0 and (high > low).all():
        np.testing.assert_array_equal(
            as_frame(autocontrast(both_layouts(image)[0])), (image - low) * 255 // (high - low)
        )


@pytest.mark.parametrize("image", images(), ids=range(6))
def test_sums_from_the_corner_are_opencvs(image: np.ndarray) -> None:
    expected = cv2.integral(image)[1:, 1:]
    for x in both_layouts(image):
        for sums in (integral_image(x), integral_tensor(x, [2, 3])):
            assert sums.dtype == torch.int32
            np.testing.assert_array_equal(sums[0].permute(1, 2, 0), expected)
        rows = integral_tensor(x)[0].permute(1, 2, 0)
        np.testing.assert_array_equal(rows, image.cumsum(1, dtype=np.int32))


def test_sums_are_no_larger_than_their_type() -> None:
    white = torch.full((1, 8421507), 255, dtype=torch.uint8)
    last = integral_image(white)[0, -5:].tolist()
    assert last == [min(255 * k, 2**31 - 1) for k in range(8421503, 8421508)]


@pytest.mark.parametrize(("bins", "low", "high"), [(256, 0.0, 256.0), (37, 10.5, 200.0), (3, -5.0, 300.0)])
def test_counts_are_opencvs(bins: int, low: float, high: float) -> None:
    image = frame(61, 83)
    expected = np.stack([cv2.calcHist([image], [c], None, [bins], [low, high]).ravel() for c in range(3)])
    for x in both_layouts(image):
        counts = count_histogram(x, bins, low, high)
        assert counts.dtype == torch.int64
        np.testing.assert_array_equal(counts[0], expected)


@pytest.mark.parametrize("image", images()[:4], ids=range(4))
def test_otsu_is_opencvs(image: np.ndarray) -> None:
    for x in both_layouts(image):
        kept, threshold = otsu_threshold(x)
        mask = otsu_threshold(x, return_mask=True)[0]
        assert kept.dtype == threshold.dtype == torch.uint8 and mask.dtype == torch.bool
        for c in range(3):
            limit, expected = cv2.threshold(
                np.ascontiguousarray(image[..., c]), 0, 0, cv2.THRESH_TOZERO | cv2.THRESH_OTSU
            )
            assert threshold[0, c] == limit
            np.testing.assert_array_equal(kept[0, c], expected)
            np.testing.assert_array_equal(mask[0, c], expected > 0)


def test_a_plane_of_one_level_is_its_own_threshold() -> None:
    x = torch.full((2, 3, 4, 5), 77, dtype=torch.uint8)
    kept, threshold = otsu_threshold(x)
    assert (threshold == 77).all() and (kept == 0).all()


@pytest.mark.parametrize(
    ("lower", "upper"),
    [([50, 0, 100], [200, 255, 101]), ([-3, 20, 0], [300, 20, 10]), ([9, 9, 9], [8, 8, 8])],
)
def test_ranges_are_opencvs(lower: list[float], upper: list[float]) -> None:
    image = frame(61, 83) // 10 * 10
    expected = cv2.inRange(image, np.array(lower, float), np.array(upper, float))
    for x in both_layouts(image):
        for low, high in ((lower, upper), (torch.tensor(lower), torch.tensor([upper]))):
            mask = in_range(x, low, high, return_mask=True)
            np.testing.assert_array_equal(as_frame(mask)[..., 0], expected)
            kept = as_frame(in_range(x, low, high))
            np.testing.assert_array_equal(kept, cv2.bitwise_and(image, image, mask=expected))
    between = in_range(both_layouts(image)[0], [99.5] * 3, [100.4] * 3, return_mask=True)
    np.testing.assert_array_equal(as_frame(between)[..., 0], 255 * (image == 100).all(-1))


@pytest.mark.parametrize(("alpha", "beta", "gamma"), [(0.5, 0.5, 0.0), (0.3, 0.9, -20.0), (-1.0, 2.0, 7.25)])
def test_weighted_sums_are_rounded_once(alpha: float, beta: float, gamma: float) -> None:
    first, second = frame(61, 83), frame(61, 83, seed=1)
    a, b, c = np.float32([alpha, beta, gamma])
    total = first.astype(np.float32) * a + second.astype(np.float32) * b + c
    assert total.dtype == np.float32
    expected = np.clip(np.rint(total), 0, 255)
    theirs = cv2.addWeighted(first, alpha, second, beta, gamma).astype(int)
    for x, y in zip(both_layouts(first), both_layouts(second), strict=True):
        result = as_frame(add_weighted(x, alpha, y, beta, gamma))
        np.testing.assert_array_equal(result, expected)
        assert np.abs(result - theirs).max() <= 1
        tensors = [torch.tensor([v], dtype=torch.float64) for v in (alpha, beta, gamma)]
        np.testing.assert_array_equal(
            as_frame(add_weighted(x, tensors[0], y, tensors[1], tensors[2])), expected
        )


@pytest.mark.parametrize("size", [(64, 80), (61, 83)])
def test_clahe_is_opencvs(size: tuple[int, int]) -> None:
    image = frame(*size)
    clahe = cv2.createCLAHE(4.0, (4, 3))
    for x in both_layouts(image):
        result = as_frame(equalize_clahe(x, 4.0, (3, 4)))
        for c in range(3):
            np.testing.assert_array_equal(result[..., c], clahe.apply(np.ascontiguousarray(image[..., c])))


def test_normalized_levels_are_numbers() -> None:
    image = frame(61, 83)
    mean, std = np.array([123.675, 116.28, 103.53]), np.array([58.395, 57.12, 57.375])
    for x in both_layouts(image):
        result = normalize(x, torch.from_numpy(mean), torch.from_numpy(std))
        assert result.dtype == torch.float32
        np.testing.assert_allclose(result[0].permute(1, 2, 0), (image - mean) / std, rtol=1e-5, atol=1e-6)


X = both_layouts(frame(9, 8))[0]
WHOLE = X.to(torch.int32)
KINDS = "expected a floating-point or uint8 tensor"


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: equalize(WHOLE), TypeError, f"input: {KINDS}"),
        (lambda: autocontrast(WHOLE), TypeError, f"image: {KINDS}"),
        (lambda: count_histogram(WHOLE), TypeError, f"image: {KINDS}"),
        (
            lambda: in_range(WHOLE, [1.0] * 3, [2.0] * 3),
            TypeError,
            "input: expected a floating-point, uint8",
        ),
        (lambda: in_range(X, [1.0] * 2, [2.0] * 3), ValueError, r"lower: expected shape \(C,\)"),
        (lambda: normalize(WHOLE, 0.0, 1.0), TypeError, f"data: {KINDS}"),
        (
            lambda: otsu_threshold(X, 100),
            ValueError,
            "nbins, slow_and_differentiable: expected 256",
        ),
        (
            lambda: add_weighted(X, 1.0, X / 255, 1.0, 0.0),
            TypeError,
            "src2: expected src1's dtype",
        ),
        (
            lambda: add_weighted(X / 255, 1.0, X, 1.0, 0.0),
            TypeError,
            "src2: expected src1's dtype",
        ),
        (
            lambda: equalize_clahe(X, grid_size=(2, 2), slow_and_differentiable=True),
            TypeError,
            "input: expected a floating-point tensor",
        ),
    ],
)
def test_wrong_arguments(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
