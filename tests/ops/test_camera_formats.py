"""Camera formats against OpenCV, bit for bit, and against the standards' definitions in float64."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from test_bytes import as_frame, both_layouts, frame
from torch import Tensor

from chiasm.color import i420_to_rgb, nv12_to_rgb, nv21_to_rgb, rgb_to_nv12, uyvy_to_rgb, yuyv_to_rgb

SIZES = [(2, 2), (36, 54), (8, 120), (64, 10), (2, 4200)]


@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize(
    ("op", "code"), [(nv12_to_rgb, cv2.COLOR_YUV2RGB_NV12), (nv21_to_rgb, cv2.COLOR_YUV2RGB_NV21)]
)
def test_two_planes_are_opencvs(op: Callable[..., Tensor], code: int, height: int, width: int) -> None:
    luma, chroma = frame(height, width, 1), frame(height // 2, width // 2, 2, seed=1)
    expected = cv2.cvtColorTwoPlane(luma, chroma, code)
    for y, pairs in zip(both_layouts(luma), both_layouts(chroma), strict=True):
        np.testing.assert_array_equal(as_frame(op(y, pairs)), expected)


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_three_planes_are_opencvs(height: int, width: int) -> None:
    buffer = frame(height * 3 // 2, width, 1)
    expected = cv2.cvtColor(buffer, cv2.COLOR_YUV2RGB_I420)
    y = torch.from_numpy(buffer[:height]).permute(2, 0, 1)[None]
    half = (1, 1, height // 2, width // 2)
    u, v = (torch.from_numpy(part).reshape(half) for part in np.split(buffer[height:].reshape(-1), 2))
    np.testing.assert_array_equal(as_frame(i420_to_rgb(y, u, v)), expected)


@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize(
    ("op", "code"), [(yuyv_to_rgb, cv2.COLOR_YUV2RGB_YUYV), (uyvy_to_rgb, cv2.COLOR_YUV2RGB_UYVY)]
)
def test_packed_pixels_are_opencvs(op: Callable[..., Tensor], code: int, height: int, width: int) -> None:
    buffer = frame(height, width, 2)
    expected = cv2.cvtColor(buffer, code)
    for x in both_layouts(buffer.reshape(height, width // 2, 4)):
        np.testing.assert_array_equal(as_frame(op(x)), expected)


def by_definition(y: np.ndarray, u: np.ndarray, v: np.ndarray, standard: str) -> np.ndarray:
    """RGB by the standards' equations, E' = Y + ..., in [0, 255], not rounded."""
    red, blue = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "jpeg": (0.299, 0.114)}[standard]
    y, u, v = (x.astype(np.float64) for x in (y, u, v))
    if standard == "jpeg":
        luma, pb, pr = y / 255, (u - 128) / 255, (v - 128) / 255
    else:
        luma, pb, pr = (np.maximum(y, 16) - 16) / 219, (u - 128) / 224, (v - 128) / 224
    r, b = luma + 2 * (1 - red) * pr, luma + 2 * (1 - blue) * pb
    g = (luma - red * r - blue * b) / (1 - red - blue)
    return np.stack([r, g, b], -1).clip(0, 1) * 255


# OpenCV's factors of BT.601, which are the definition here, have three digits.
@pytest.mark.parametrize(("standard", "apart"), [("bt601", 1.0), ("bt709", 0.5001), ("jpeg", 0.5001)])
def test_standards_are_their_equations(standard: str, apart: float) -> None:
    luma, chroma = frame(40, 62, 1), frame(20, 31, 2, seed=1)
    up = chroma.repeat(2, 0).repeat(2, 1)
    expected = by_definition(luma[..., 0], up[..., 0], up[..., 1], standard)
    for y, uv in zip(both_layouts(luma), both_layouts(chroma), strict=True):
        assert np.abs(as_frame(nv12_to_rgb(y, uv, standard)) - expected).max() <= apart
        assert np.abs(as_frame(nv21_to_rgb(y, uv.flip(1), standard)) - expected).max() <= apart
    words = np.stack([luma[..., 0], up.reshape(40, 31, 4)[..., :2].reshape(40, 62)], -1)
    packed = torch.from_numpy(words.reshape(1, 40, 31, 4)).permute(0, 3, 1, 2)
    assert np.abs(as_frame(yuyv_to_rgb(packed, standard)) - expected).max() <= apart


@pytest.mark.parametrize(("height", "width"), [(5, 7), (1, 1), (3, 33)])
@pytest.mark.parametrize("fraction", [(1, 1), (1, 2), (2, 2), (4, 4)])
def test_a_pixel_has_the_nearest_chroma(height: int, width: int, fraction: tuple[int, int]) -> None:
    down, across = fraction
    luma = frame(height, width, 1)
    chroma = frame(-(-height // down), -(-width // across), 2, seed=1)
    # The same chroma at full resolution: pixel k has sample floor(k h / H)
    rows = [k * chroma.shape[0] // height for k in range(height)]
    columns = [k * chroma.shape[1] // width for k in range(width)]
    full = chroma[rows][:, columns]
    for y, pairs, every in zip(both_layouts(luma), both_layouts(chroma), both_layouts(full), strict=True):
        assert torch.equal(nv12_to_rgb(y, pairs), nv12_to_rgb(y, every))
    if fraction == (2, 2):  # a pair belongs to 2 x 2 pixels, even if the last ones are cut
        assert rows == [k // 2 for k in range(height)] and columns == [k // 2 for k in range(width)]


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_luma_and_pairs_are_opencvs(height: int, width: int) -> None:
    image = frame(height, width)
    blocks = frame(height // 2, width // 2, seed=1).repeat(2, 0).repeat(2, 1)
    for colours in (image, blocks):
        buffer = cv2.cvtColor(colours, cv2.COLOR_RGB2YUV_I420)
        u, v = (part.reshape(height // 2, width // 2) for part in np.split(buffer[height:].reshape(-1), 2))
        for x in both_layouts(colours):
            y, uv = rgb_to_nv12(x)
            np.testing.assert_array_equal(as_frame(y)[..., 0], buffer[:height])
            if colours is blocks:  # the mean of a block is its upper left pixel
                np.testing.assert_array_equal(as_frame(uv), np.stack([u, v], -1))


# OpenCV's factors of BT.601, which are the definition here, have three digits.
@pytest.mark.parametrize(("standard", "apart"), [("bt601", 1.0), ("bt709", 0.5001), ("jpeg", 0.5001)])
@pytest.mark.parametrize(("height", "width"), [(36, 54), (37, 53), (1, 7)])
def test_luma_and_pairs_are_their_equations(height: int, width: int, standard: str, apart: float) -> None:
    red, blue = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "jpeg": (0.299, 0.114)}[standard]
    image = frame(height, width)
    image[: height // 2] = image[: height // 2] // 128 * 255
    even = np.pad(image / 255, ((0, height % 2), (0, width % 2), (0, 0)), "edge")
    means = even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2, 3).mean((1, 3))
    luma, of_means = (x @ [red, 1 - red - blue, blue] for x in (image / 255, means))
    pb, pr = (means[..., 2] - of_means) / (2 - 2 * blue), (means[..., 0] - of_means) / (2 - 2 * red)
    full = standard == "jpeg"
    pairs = np.clip(128 + np.stack([pb, pr], -1) * (255 if full else 224), 0, 255)
    for x in both_layouts(image):
        y, uv = rgb_to_nv12(x, standard)
        assert (
            np.abs(as_frame(y)[..., 0] - luma * (255 if full else 219) - (0 if full else 16)).max() <= apart
        )
        assert np.abs(as_frame(uv) - pairs).max() <= apart


Y, UV = torch.zeros(1, 1, 4, 6, dtype=torch.uint8), torch.zeros(1, 2, 2, 3, dtype=torch.uint8)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: nv12_to_rgb(Y.float(), UV), TypeError, "y: expected dtype uint8"),
        (lambda: nv12_to_rgb(Y, UV[:, :1]), ValueError, "uv: expected shape"),
        (lambda: nv21_to_rgb(Y, UV.repeat(2, 1, 1, 1)), ValueError, "vu: expected the batch size 1"),
        (lambda: i420_to_rgb(Y, UV[:, :1], UV[:, :1, :1]), ValueError, "v: expected the shape"),
        (lambda: i420_to_rgb(Y[0], UV[:, :1], UV[:, :1]), ValueError, "y: expected shape"),
        (lambda: yuyv_to_rgb(UV), ValueError, "image: expected shape"),
        (lambda: rgb_to_nv12(UV), ValueError, "image: expected shape"),
        (lambda: rgb_to_nv12(torch.zeros(1, 3, 4, 6)), TypeError, "image: expected dtype uint8"),
        (lambda: nv12_to_rgb(Y, UV, "bt2020"), ValueError, "standard: expected one of"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
