"""Morphology, medians and ranks of integers equal OpenCV's and SciPy's bit for bit."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import chw, frame, hwc
from torch import Tensor

from chiasm.filters import median_blur, percentile_filter, rank_filter
from chiasm.morphology import (
    bottom_hat,
    closing,
    dilation,
    erosion,
    gradient,
    max_filter2d,
    min_filter2d,
    opening,
    top_hat,
)

OPERATIONS = {
    dilation: cv2.MORPH_DILATE,
    erosion: cv2.MORPH_ERODE,
    opening: cv2.MORPH_OPEN,
    closing: cv2.MORPH_CLOSE,
    gradient: cv2.MORPH_GRADIENT,
    top_hat: cv2.MORPH_TOPHAT,
    bottom_hat: cv2.MORPH_BLACKHAT,
}
ELEMENTS = {
    "box": np.ones((3, 3), np.uint8),
    "row": np.ones((1, 7), np.uint8),
    "cross": cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)),
    "ellipse": cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 7)),
    "ring": np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], np.uint8),
}
OPENCV_BORDER = {
    "reflect": cv2.BORDER_REFLECT_101,
    "replicate": cv2.BORDER_REPLICATE,
    "constant": cv2.BORDER_CONSTANT,
}
SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}
DTYPES = (torch.uint8, torch.int16, torch.uint16)


def pixels(dtype: torch.dtype, height: int, width: int, interleaved: bool) -> Tensor:
    """(1, 3, H, W), over the whole range of the type."""
    x = frame(height, width).permute(2, 0, 1)[None]
    if dtype != torch.uint8:
        x = (x.to(torch.int32) * 257 - (32768 if dtype == torch.int16 else 0)).to(dtype)
    return x if interleaved else x.contiguous()


@pytest.mark.parametrize("interleaved", [True, False], ids=["frame", "planes"])
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
@pytest.mark.parametrize("op", OPERATIONS, ids=lambda op: op.__name__)
def test_morphology_is_opencvs(
    op: Callable[..., Tensor], element: np.ndarray, dtype: torch.dtype, interleaved: bool
) -> None:
    x = pixels(dtype, 41, 54, interleaved)
    actual = op(x, torch.from_numpy(element))
    assert actual.dtype == dtype
    np.testing.assert_array_equal(actual[0], chw(cv2.morphologyEx(hwc(x), OPERATIONS[op], element)))


@pytest.mark.parametrize("border", OPENCV_BORDER)
@pytest.mark.parametrize("op", [dilation, erosion], ids=lambda op: op.__name__)
def test_borders_are_opencvs(op: Callable[..., Tensor], border: str) -> None:
    lopsided = np.array([[1, 1, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 1, 0, 1]], np.uint8)
    x = pixels(torch.uint8, 23, 31, True)
    actual = op(x, torch.from_numpy(lopsided), border_type=border, border_value=100.0)
    theirs = lopsided[::-1, ::-1].copy() if op is dilation else lopsided
    expected = cv2.morphologyEx(
        hwc(x), OPERATIONS[op], theirs, borderType=OPENCV_BORDER[border], borderValue=(100,) * 4
    )
    np.testing.assert_array_equal(actual[0], chw(expected))


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_extremes_and_ranks_are_scipys(dtype: torch.dtype, border: str) -> None:
    x = pixels(dtype, 20, 27, True)
    for ours, theirs in (
        (max_filter2d(x, (3, 7), border), lambda p: ndi.maximum_filter(p, (3, 7), mode=SCIPY_MODE[border])),
        (min_filter2d(x, (5, 1), border), lambda p: ndi.minimum_filter(p, (5, 1), mode=SCIPY_MODE[border])),
        (
            rank_filter(x, -2, (3, 5), border),
            lambda p: ndi.rank_filter(p, -2, (3, 5), mode=SCIPY_MODE[border]),
        ),
        (
            percentile_filter(x, 20.0, 3, border),
            lambda p: ndi.percentile_filter(p, 20.0, 3, mode=SCIPY_MODE[border]),
        ),
        (median_blur(x, (1, 9), border), lambda p: ndi.median_filter(p, (1, 9), mode=SCIPY_MODE[border])),
    ):
        assert ours.dtype == dtype
        np.testing.assert_array_equal(ours[0], np.stack([theirs(p.numpy()) for p in x[0]]))


@pytest.mark.parametrize("interleaved", [True, False], ids=["frame", "planes"])
@pytest.mark.parametrize(
    ("dtype", "size"),
    [(torch.uint8, n) for n in (3, 5, 7, 11)] + [(d, n) for d in DTYPES[1:] for n in (3, 5)],
)
def test_median_is_opencvs(dtype: torch.dtype, size: int, interleaved: bool) -> None:
    x = pixels(dtype, 33, 46, interleaved)
    np.testing.assert_array_equal(median_blur(x, size, "replicate")[0], chw(cv2.medianBlur(hwc(x), size)))


def test_an_element_of_nothing_leaves_the_types_ends() -> None:
    x, nothing = pixels(torch.int16, 5, 6, False), torch.zeros(3, 3)
    assert torch.equal(dilation(x, nothing), torch.full_like(x, -32768))
    assert torch.equal(erosion(x, nothing), torch.full_like(x, 32767))


def test_the_gradient_stops_at_the_types_ends() -> None:
    x = torch.tensor([[[[-30000, 30000]]]], dtype=torch.int16)
    assert gradient(x, torch.ones(1, 3)).tolist() == [[[[32767, 32767]]]]


X, BOX = pixels(torch.uint8, 8, 8, True), torch.ones(3, 3)
WRONG = [
    (lambda: dilation(X, BOX, BOX), TypeError, "structuring_element: expected None, as elements for whole"),
    (lambda: gradient(X.long(), BOX), TypeError, "tensor: expected a floating-point, uint8, int16 or uint16"),
    (lambda: median_blur(X.bool(), 3), TypeError, "input: expected a floating-point, uint8, int16 or uint16"),
    (lambda: max_filter2d(X.int(), 3), TypeError, "input: expected a floating-point, uint8, int16 or uint16"),
    *(
        (
            lambda value=value: erosion(X, BOX, border_type="constant", border_value=value),
            ValueError,
            f"border_value: expected a number of dtype torch.uint8, got {value}",
        )
        for value in (-1.0, 256.0, 0.5)
    ),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
