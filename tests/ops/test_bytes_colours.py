"""Colour conversions of bytes against OpenCV, bit for bit if documented so, in both layouts."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from test_bytes import SIZES, as_frame, both_layouts, every_colour, frame
from torch import Tensor

from chiasm.color import (
    bgr_to_rgb,
    bgr_to_rgba,
    grayscale_to_rgb,
    hls_to_rgb,
    hsl_to_rgb,
    hsv_to_rgb,
    lab_to_rgb,
    luv_to_rgb,
    planar_yuv_to_rgb,
    rgb_to_bgr,
    rgb_to_hls,
    rgb_to_hsl,
    rgb_to_lab,
    rgb_to_luv,
    rgb_to_rgba,
    rgb_to_xyz,
    rgb_to_y,
    rgb_to_ycbcr,
    rgb_to_yuv,
    rgb_to_yuv420,
    rgb_to_yuv422,
    rgba_to_bgr,
    rgba_to_rgb,
    sepia,
    xyz_to_rgb,
    ycbcr_to_rgb,
    yuv420_to_rgb,
    yuv422_to_rgb,
    yuv_to_rgb,
)

ORDERS = {
    bgr_to_rgb: (3, cv2.COLOR_BGR2RGB),
    rgb_to_bgr: (3, cv2.COLOR_RGB2BGR),
    rgba_to_rgb: (4, cv2.COLOR_RGBA2RGB),
    rgba_to_bgr: (4, cv2.COLOR_RGBA2BGR),
    grayscale_to_rgb: (1, cv2.COLOR_GRAY2RGB),
}


@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize("op", ORDERS, ids=lambda op: op.__name__)
def test_orders_of_channels_are_opencvs(op: Callable[..., Tensor], height: int, width: int) -> None:
    channels, code = ORDERS[op]
    image = frame(height, width, channels)
    expected = cv2.cvtColor(image, code)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(op(x)), expected)
    words = image.astype(np.uint16) * 257
    for x in both_layouts(words):
        result = op(x)
        assert result.dtype == torch.uint16
        actual = result[0].to(torch.int32).permute(1, 2, 0).numpy()
        np.testing.assert_array_equal(actual, cv2.cvtColor(words, code))


@pytest.mark.parametrize(
    ("op", "code"), [(rgb_to_rgba, cv2.COLOR_RGB2RGBA), (bgr_to_rgba, cv2.COLOR_BGR2RGBA)]
)
def test_alpha_is_appended(op: Callable[..., Tensor], code: int) -> None:
    image, alpha = frame(13, 17), frame(13, 17, 1, seed=1)
    expected = cv2.cvtColor(image, code)
    for x, a in zip(both_layouts(image), both_layouts(alpha), strict=True):
        np.testing.assert_array_equal(as_frame(op(x, 255.0)), expected)
        expected[..., 3] = 9
        np.testing.assert_array_equal(as_frame(op(x, 9.0)), expected)
        expected[..., 3] = alpha[..., 0]
        np.testing.assert_array_equal(as_frame(op(x, a)), expected)
        expected[..., 3] = 255


def second_last(image: np.ndarray) -> np.ndarray:
    """Swap the chroma: OpenCV has the red difference first."""
    return np.ascontiguousarray(image[..., [0, 2, 1]])


MIXED: dict[Callable[..., Tensor], Callable[[np.ndarray], np.ndarray]] = {
    rgb_to_ycbcr: lambda image: second_last(cv2.cvtColor(image, cv2.COLOR_RGB2YCrCb)),
    ycbcr_to_rgb: lambda image: cv2.cvtColor(second_last(image), cv2.COLOR_YCrCb2RGB),
    rgb_to_yuv: lambda image: cv2.cvtColor(image, cv2.COLOR_RGB2YUV),
    yuv_to_rgb: lambda image: cv2.cvtColor(image, cv2.COLOR_YUV2RGB),
    rgb_to_xyz: lambda image: cv2.cvtColor(image, cv2.COLOR_RGB2XYZ),
    xyz_to_rgb: lambda image: cv2.cvtColor(image, cv2.COLOR_XYZ2RGB),
    hls_to_rgb: lambda image: cv2.cvtColor(image, cv2.COLOR_HLS2RGB),
    hsl_to_rgb: lambda image: cv2.cvtColor(second_last(image), cv2.COLOR_HLS2RGB),
    rgb_to_y: lambda image: cv2.cvtColor(image, cv2.COLOR_RGB2YCrCb)[..., :1],
}


@pytest.mark.parametrize("op", MIXED, ids=lambda op: op.__name__)
def test_mixtures_are_opencvs(op: Callable[..., Tensor]) -> None:
    for image in (every_colour(), *(frame(*size) for size in SIZES)):
        expected = MIXED[op](image)
        for x in both_layouts(image):
            np.testing.assert_array_equal(as_frame(op(x)), expected)


def test_hls_is_within_a_level_of_opencvs() -> None:
    image = every_colour()
    expected = cv2.cvtColor(image, cv2.COLOR_RGB2HLS).astype(int)
    low, high = image.min(-1).astype(int), image.max(-1).astype(int)
    for x in both_layouts(image):
        result = as_frame(rgb_to_hls(x))
        difference = np.abs(result - expected)
        difference[..., 0] = np.minimum(difference[..., 0], 180 - difference[..., 0])
        assert difference.max() <= 1
        assert (difference > 0).mean() < 0.05
        assert result[..., 0].max() < 180
        np.testing.assert_array_equal(result[..., 1], (low + high + 1) // 2)
        np.testing.assert_array_equal(as_frame(rgb_to_hsl(x)), second_last(result))


def from_hue(hue: np.ndarray, value: np.ndarray, chroma: np.ndarray) -> np.ndarray:
    """A. R. Smith's hexagon; hue in sixths of a turn."""
    places = [(n + hue) % 6 for n in (5, 3, 1)]
    return np.stack([value - chroma * np.clip(np.minimum(p, 4 - p), 0, 1) for p in places], -1)


def test_colours_of_hues_are_their_definition_rounded() -> None:
    image = np.concatenate([every_colour(), frame(100, 30).reshape(-1, 1, 3)])
    hue, second, third = np.moveaxis(image.astype(np.float64), -1, 0)
    half = third * np.minimum(second, 255 - second) / 255
    for x in both_layouts(image):
        result = as_frame(hsv_to_rgb(x))
        assert np.abs(result - from_hue(hue / 30, third, second * third / 255)).max() <= 0.5 + 1e-9
        assert np.abs(result - cv2.cvtColor(image, cv2.COLOR_HSV2RGB).astype(int)).max() <= 1
        result = as_frame(hls_to_rgb(x))
        assert np.abs(result - from_hue(hue / 30, second + half, 2 * half)).max() <= 0.5 + 1e-9


def assert_near(image: np.ndarray, op: Callable[[Tensor], Tensor], exact: np.ndarray, most: float) -> None:
    """The results differ by at most ``most`` levels from the exact numbers (H, W, 3), and are nearly always
    the nearest."""
    for x in both_layouts(image):
        result = as_frame(op(x))
        assert np.abs(result - exact).max() <= most
        assert (result == np.rint(exact)).mean() > 0.97


def test_lab_is_the_definition_nearly_rounded() -> None:
    image = every_colour()
    lab = rgb_to_lab(both_layouts(image)[1].double() / 255)[0].permute(1, 2, 0).numpy()
    exact = lab * [2.55, 1, 1] + [0, 128, 128]
    assert_near(image, rgb_to_lab, exact, 1.0)
    greys = as_frame(rgb_to_lab(both_layouts(image[-256:])[0]))
    np.testing.assert_array_equal(greys[..., 1:], 128)
    # OpenCV's tables have a fifth of the entries.
    theirs = cv2.cvtColor(image, cv2.COLOR_RGB2Lab).astype(int)
    assert np.abs(as_frame(rgb_to_lab(both_layouts(image)[0])) - theirs).max() <= 3


def test_rgb_is_what_lab_defines_nearly_rounded() -> None:
    image = np.concatenate([every_colour(), cv2.cvtColor(every_colour(), cv2.COLOR_RGB2Lab)])
    lab = (image.astype(np.float64) - [0, 128, 128]) / [2.55, 1, 1]
    rgb = lab_to_rgb(torch.from_numpy(lab).permute(2, 0, 1))
    assert_near(image, lab_to_rgb, 255 * rgb.permute(1, 2, 0).numpy(), 2.0)


def test_luv_is_the_definition_nearly_rounded() -> None:
    image = every_colour()
    luv = rgb_to_luv(both_layouts(image)[1].double() / 255)[0].permute(1, 2, 0).numpy()
    exact = (luv + [0, 134, 140]) * [2.55, 255 / 354, 255 / 262]
    assert_near(image, rgb_to_luv, exact, 1.0)
    greys = as_frame(rgb_to_luv(both_layouts(image[-256:])[0]))
    np.testing.assert_array_equal(greys[..., 1:], np.broadcast_to([97, 136], (256, 1, 2)))
    theirs = cv2.cvtColor(image, cv2.COLOR_RGB2Luv).astype(int)
    assert np.abs(as_frame(rgb_to_luv(both_layouts(image)[0])) - theirs).max() <= 1


def test_rgb_is_what_luv_defines_nearly_rounded() -> None:
    image = np.concatenate([every_colour(), cv2.cvtColor(every_colour(), cv2.COLOR_RGB2Luv)])
    luv = image / [2.55, 255 / 354, 255 / 262] - [0, 134, 140]
    rgb = luv_to_rgb(torch.from_numpy(luv).permute(2, 0, 1)).clamp(0.0, 1.0)
    assert_near(image, luv_to_rgb, 255 * rgb.permute(1, 2, 0).numpy(), 1.0)


TOUB = np.array([[0.393, 0.769, 0.189], [0.349, 0.686, 0.168], [0.272, 0.534, 0.131]])


def test_sepia_is_its_matrix_rounded() -> None:
    for image in (every_colour(), frame(37, 53), np.zeros((2, 3, 3), np.uint8)):
        toned = image.astype(np.float64) @ TOUB.T
        for x in both_layouts(image):
            plain = as_frame(sepia(x, rescale=False))
            assert np.abs(plain - toned.clip(0, 255)).max() < 0.53
            most = toned.max() + 1e-300
            assert np.abs(as_frame(sepia(x)) - 255 * toned / most).max() < 0.53
        two = torch.cat([both_layouts(image)[1], both_layouts(image)[1] // 2])
        assert torch.equal(sepia(two)[:1], sepia(two[:1])) and torch.equal(sepia(two)[1:], sepia(two[1:]))


@pytest.mark.parametrize("size", [(36, 54), (37, 53), (1, 7)])
def test_parts_of_the_chroma_are_means_of_opencvs(size: tuple[int, int]) -> None:
    image = frame(*size)
    yuv = cv2.cvtColor(image, cv2.COLOR_RGB2YUV).astype(int)
    even = np.pad(yuv, ((0, size[0] % 2), (0, size[1] % 2), (0, 0)), "edge")
    rows, columns = even.shape[0] // 2, even.shape[1] // 2
    quarters = even.reshape(rows, 2, columns, 2, 3).sum((1, 3))[..., 1:]
    halves = even.reshape(-1, columns, 2, 3).sum(2)[: size[0], :, 1:]
    for x in both_layouts(image):
        y, uv = rgb_to_yuv420(x)
        np.testing.assert_array_equal(as_frame(y)[..., 0], yuv[..., 0])
        np.testing.assert_array_equal(as_frame(uv), (quarters + 2) // 4)
        y2, uv2 = rgb_to_yuv422(x)
        assert torch.equal(y, y2)
        np.testing.assert_array_equal(as_frame(uv2), (halves + 1) // 2)
        for back, pairs, down in ((yuv420_to_rgb, uv, 2), (yuv422_to_rgb, uv2, 1)):
            full = as_frame(pairs).repeat(down, 0).repeat(2, 1)[: size[0], : size[1]]
            whole = np.concatenate([as_frame(y), full], -1)
            expected = cv2.cvtColor(whole, cv2.COLOR_YUV2RGB)
            np.testing.assert_array_equal(as_frame(back(y, pairs)), expected)
            np.testing.assert_array_equal(as_frame(planar_yuv_to_rgb(y, pairs)), expected)


X = both_layouts(frame(6, 7))[0]
WRONG = [
    (lambda: lab_to_rgb(X, clip=False), ValueError, "clip: expected True for an image of bytes, got False"),
    (lambda: rgb_to_rgba(X, 256.0), ValueError, "alpha_val: expected a number of dtype torch.uint8, got 256"),
    (lambda: bgr_to_rgba(X, 0.5), ValueError, "alpha_val: expected a number of dtype torch.uint8, got 0.5"),
    (lambda: rgba_to_rgb(rgb_to_rgba(X, 1.0), torch.ones(3)), TypeError, "image: expected a floating-point"),
    (lambda: planar_yuv_to_rgb(X[:, :1], X[:, :2].float()), TypeError, "imageuv: expected uint8 with"),
    *(
        (lambda op=op: op(X.to(torch.int32)), TypeError, "image: expected a floating-point or uint8 tensor")
        for op in (*MIXED, rgb_to_hls, rgb_to_hsl, hsv_to_rgb, rgb_to_lab, lab_to_rgb, rgb_to_luv, luv_to_rgb)
    ),
    *(
        (lambda op=op: op(X[:, :2]), ValueError, r"image: expected shape \(\*, 3, H, W\)")
        for op in (*MIXED, rgb_to_hls, rgb_to_hsl, hsv_to_rgb, rgb_to_lab, lab_to_rgb, rgb_to_luv, luv_to_rgb)
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
