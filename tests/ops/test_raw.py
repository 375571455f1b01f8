"""Bayer images against OpenCV's demosaicing, SciPy and NumPy."""

from typing import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import hwc, photo
from scipy.ndimage import convolve

from chiasm import color

#: OpenCV's code, and the colour (0, 1, 2 for red, green, blue) of the top left 2 x 2 pixels.
CFA = {
    "bg": (cv2.COLOR_BayerBG2RGB, [[0, 1], [1, 2]]),
    "gb": (cv2.COLOR_BayerGB2RGB, [[1, 0], [2, 1]]),
    "rg": (cv2.COLOR_BayerRG2RGB, [[2, 1], [1, 0]]),
    "gr": (cv2.COLOR_BayerGR2RGB, [[1, 2], [0, 1]]),
}
SIZES = [(36, 54), (37, 53), (64, 31), (2, 2), (3, 2)]

every_cfa = pytest.mark.parametrize("cfa", CFA)


def mosaic(x: torch.Tensor, cfa: str) -> np.ndarray:
    """The Bayer image (B, H, W) of (B, 3, H, W), by NumPy."""
    raw = np.zeros((x.size(0), *x.shape[2:]), x.numpy().dtype)
    for row in range(2):
        for column in range(2):
            raw[:, row::2, column::2] = x.numpy()[:, CFA[cfa][1][row][column], row::2, column::2]
    return raw


@every_cfa
@pytest.mark.parametrize("size", SIZES)
def test_to_raw_equals_slices(cfa: str, size: tuple[int, int]) -> None:
    x = photo(3, 3, *size)
    np.testing.assert_array_equal(color.rgb_to_raw(x, cfa)[:, 0], mosaic(x, cfa))


@every_cfa
def test_interior_equals_opencv(cfa: str) -> None:
    levels = torch.round(photo(3, 3, 37, 54) * 65535)
    raw = mosaic(levels, cfa)
    actual = color.raw_to_rgb(torch.from_numpy(raw)[:, None], cfa)
    for b in range(3):
        expected = cv2.cvtColor(raw[b].astype(np.uint16), CFA[cfa][0]).astype(np.float64)
        assert np.abs(hwc(actual, b) - expected)[1:-1, 1:-1].max() <= 0.5  # OpenCV rounds means to integers


@every_cfa
@pytest.mark.parametrize("dtype", [torch.uint8, torch.uint16])
def test_interior_of_whole_numbers_is_opencvs(cfa: str, dtype: torch.dtype) -> None:
    largest = torch.iinfo(dtype).max
    raw = np.random.default_rng(5).integers(0, largest, (2, 37, 54), endpoint=True)
    raw = raw.astype(np.uint8 if dtype == torch.uint8 else np.uint16)
    actual = color.raw_to_rgb(torch.from_numpy(raw)[:, None], cfa)
    assert actual.dtype == dtype
    for b in range(2):
        expected = cv2.cvtColor(raw[b], CFA[cfa][0])
        np.testing.assert_array_equal(hwc(actual, b)[1:-1, 1:-1], expected[1:-1, 1:-1])
    known = color.rgb_to_raw(actual, cfa)
    np.testing.assert_array_equal(known[:, 0], raw)
    halves = color.raw_to_rgb_2x2_downscaled(torch.from_numpy(raw)[:, None], cfa)
    exact = color.raw_to_rgb_2x2_downscaled(torch.from_numpy(raw.astype(np.float64))[:, None], cfa)
    np.testing.assert_array_equal(halves.numpy(), np.floor(exact.numpy() + 0.5))


@every_cfa
@pytest.mark.parametrize("size", SIZES)
def test_everywhere_equals_scipy(cfa: str, size: tuple[int, int]) -> None:
    """Normalised convolution of each colour's samples, mirrored at the border."""
    x = photo(2, 3, *size, torch.float64)
    raw = mosaic(x, cfa)
    actual = color.raw_to_rgb(torch.from_numpy(raw)[:, None], cfa)
    cross = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4
    square = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4
    colours = np.tile(np.array(CFA[cfa][1]), (size[0] // 2 + 1, size[1] // 2 + 1))[: size[0], : size[1]]
    for b in range(2):
        for c in range(3):
            expected = convolve(np.where(colours == c, raw[b], 0), cross if c == 1 else square, mode="mirror")
            np.testing.assert_allclose(actual[b, c], expected, atol=1e-12)


@every_cfa
def test_known_samples_are_kept(cfa: str) -> None:
    raw = photo(2, 1, 17, 22)
    assert torch.equal(color.rgb_to_raw(color.raw_to_rgb(raw, cfa), cfa), raw)


@every_cfa
@pytest.mark.parametrize("size", [(36, 54), (37, 53), (2, 3)])
def test_downscaled_equals_slices(cfa: str, size: tuple[int, int]) -> None:
    raw = photo(2, 1, *size, torch.float64)
    actual = color.raw_to_rgb_2x2_downscaled(raw, cfa)
    h, w = size[0] // 2 * 2, size[1] // 2 * 2
    expected = np.zeros((2, 3, h // 2, w // 2))
    for row in range(2):
        for column in range(2):
            c = CFA[cfa][1][row][column]
            expected[:, c] += raw.numpy()[:, 0, row:h:2, column:w:2] / (2 if c == 1 else 1)
    np.testing.assert_allclose(actual, expected, atol=1e-15)


def test_any_leading_shape() -> None:
    raw = photo(2, 1, 9, 8)
    for function in (color.raw_to_rgb, color.raw_to_rgb_2x2_downscaled):
        assert torch.equal(function(raw[0], "gb"), function(raw, "gb")[0])
        assert torch.equal(function(raw[None], "gb"), function(raw, "gb")[None])


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_dtype_is_kept(dtype: torch.dtype) -> None:
    raw = photo(1, 1, 9, 8, dtype)
    assert color.raw_to_rgb(raw, "bg").dtype == color.raw_to_rgb_2x2_downscaled(raw, "bg").dtype == dtype


RAW = torch.zeros(1, 1, 4, 4)
WRONG = [
    (
        lambda: color.raw_to_rgb(RAW, "rggb"),
        ValueError,
        "cfa: expected one of .*'bg', 'gb', 'rg', 'gr'.*, got 'rggb'",
    ),
    (
        lambda: color.raw_to_rgb(RAW.int(), "bg"),
        TypeError,
        "image: expected a floating-point, uint8 or uint16",
    ),
    (
        lambda: color.raw_to_rgb(RAW.expand(1, 3, 4, 4), "bg"),
        ValueError,
        r"image: expected shape \(\*, 1, H, W\), got \[1, 3, 4, 4\]",
    ),
    (lambda: color.raw_to_rgb_2x2_downscaled(RAW, "BG"), ValueError, "cfa: expected one of"),
    (lambda: color.raw_to_rgb_2x2_downscaled(RAW.int(), "bg"), TypeError, "image: expected a floating-point"),
    (lambda: color.raw_to_rgb_2x2_downscaled(RAW[0, 0], "bg"), ValueError, "image: expected shape"),
    (lambda: color.rgb_to_raw(RAW, "bg"), ValueError, r"image: expected shape \(\*, 3, H, W\)"),
    (lambda: color.rgb_to_raw(RAW.expand(1, 3, 4, 4), ""), ValueError, "cfa: expected one of"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=range(len(WRONG)))
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
