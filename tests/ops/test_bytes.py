"""Ops on images of bytes against OpenCV and Pillow, bit for bit if documented so, in both layouts."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from PIL import Image, ImageOps
from torch import Tensor

from chiasm import enhance, filters
from chiasm.color import bgr_to_grayscale, rgb_to_grayscale, rgb_to_hsv
from chiasm.enhance import (
    adjust_brightness,
    adjust_brightness_accumulative,
    adjust_contrast,
    adjust_gamma,
    invert,
    posterize,
    solarize,
    threshold,
)
from chiasm.filters import (
    box_blur,
    gaussian_blur2d,
    laplacian,
    sobel,
    spatial_gradient,
)
from chiasm.geometry.transform import hflip, resize, rot180, transpose, vflip

SIZES = [(37, 53), (8, 120), (1, 1), (64, 9)]


def frame(height: int, width: int, channels: int = 3, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, channels), dtype=np.uint8)


def both_layouts(image: np.ndarray) -> list[Tensor]:
    """(1, C, H, W), stored pixel by pixel, and plane after plane."""
    interleaved = torch.from_numpy(image)[None].permute(0, 3, 1, 2)
    return [interleaved, interleaved.contiguous()]


def as_frame(result: Tensor) -> np.ndarray:
    assert result.dtype == torch.uint8
    return result[0].permute(1, 2, 0).numpy()


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(
    ("size", "sigma"), [((3, 3), (0.8, 0.8)), ((5, 9), (1.1, 2.0)), ((31, 1), (5.0, 1.0))]
)
@pytest.mark.parametrize(
    ("border", "flag"),
    [
        ("reflect", cv2.BORDER_REFLECT_101),
        ("replicate", cv2.BORDER_REPLICATE),
        ("constant", cv2.BORDER_CONSTANT),
    ],
)
def test_gaussian_blur_is_opencvs(channels: int, size, sigma, border: str, flag: int) -> None:
    image = frame(37, 53, channels)
    expected = cv2.GaussianBlur(image, size[::-1], sigma[1], sigmaY=sigma[0], borderType=flag)
    for x in both_layouts(image):
        for s in (sigma, torch.tensor([sigma])):
            result = as_frame(gaussian_blur2d(x, size, s, border))
            np.testing.assert_array_equal(result.squeeze(), expected.squeeze())


def test_gaussian_blur_of_each_sample_has_its_sigma() -> None:
    image = frame(20, 30)
    x = both_layouts(image)[0].expand(2, -1, -1, -1)
    result = gaussian_blur2d(x, 5, torch.tensor([[1.0, 1.0], [1.5, 0.7]]))
    np.testing.assert_array_equal(as_frame(result[:1]), cv2.GaussianBlur(image, (5, 5), 1.0))
    np.testing.assert_array_equal(as_frame(result[1:]), cv2.GaussianBlur(image, (5, 5), 0.7, sigmaY=1.5))


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("size", [(3, 3), (5, 5), (1, 9), (15, 15), (31, 7)])
@pytest.mark.parametrize(
    ("border", "flag"),
    [
        ("reflect", cv2.BORDER_REFLECT_101),
        ("replicate", cv2.BORDER_REPLICATE),
        ("constant", cv2.BORDER_CONSTANT),
    ],
)
def test_box_blur_of_odd_windows_is_opencvs(channels: int, size, border: str, flag: int) -> None:
    image = frame(37, 53, channels)
    expected = cv2.blur(image, size[::-1], borderType=flag)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(box_blur(x, size, border)).squeeze(), expected.squeeze())


@pytest.mark.parametrize("size", [(2, 2), (4, 1), (6, 3), (16, 16)])
def test_box_blur_rounds_halves_to_even(size) -> None:
    image = frame(64, 80) // 64 * 17  # few levels, so that many results are halves
    (top, bottom), (left, right) = (((k - 1) // 2, k // 2) for k in size)
    padded = np.pad(image.astype(np.float64), ((top, bottom), (left, right), (0, 0)), "reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, size, (0, 1))
    expected = np.rint(windows.sum((-2, -1)) / (size[0] * size[1]))
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(box_blur(x, size)), expected)


def test_box_blur_of_the_largest_windows_is_exact() -> None:
    image = np.full((3, 4, 3), 255, np.uint8)
    image[1, 2] = 0
    for x in both_layouts(image):
        result = as_frame(box_blur(x, (255, 257), "replicate"))
        padded = np.pad(image.astype(np.float64), ((127, 127), (128, 128), (0, 0)), "edge")
        windows = np.lib.stride_tricks.sliding_window_view(padded, (255, 257), (0, 1))
        np.testing.assert_array_equal(result, np.rint(windows.sum((-2, -1)) / (255 * 257)))


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_first_derivatives_are_opencvs(channels: int, height: int, width: int) -> None:
    image = frame(height, width, channels)
    image[: height // 2] = image[: height // 2] // 128 * 255  # the largest differences too
    expected = [
        cv2.Sobel(image, cv2.CV_16S, dx, 1 - dx, ksize=3, borderType=cv2.BORDER_REPLICATE) for dx in (1, 0)
    ]
    central = np.pad(image.astype(np.int16), ((1, 1), (1, 1), (0, 0)), "edge")
    for x in both_layouts(image):
        result = spatial_gradient(x, "sobel", 1, normalized=False)
        assert result.dtype == torch.int16
        for i in range(2):
            actual = result[0, :, i].permute(1, 2, 0).numpy()
            np.testing.assert_array_equal(actual, expected[i].reshape(image.shape))
        dx, dy = spatial_gradient(x, "diff", 1, normalized=False)[0].permute(1, 2, 3, 0).numpy()
        np.testing.assert_array_equal(dx, central[1:-1, 2:] - central[1:-1, :-2])
        np.testing.assert_array_equal(dy, central[2:, 1:-1] - central[:-2, 1:-1])


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_sobel_is_the_length_of_opencvs_derivatives(channels: int, height: int, width: int) -> None:
    image = frame(height, width, channels)
    image[: height // 2] //= 32  # roots that are halves
    dx, dy = (
        cv2.Sobel(image, cv2.CV_64F, d, 1 - d, ksize=3, borderType=cv2.BORDER_REPLICATE) for d in (1, 0)
    )
    length = np.sqrt(dx * dx + dy * dy).reshape(image.shape)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(sobel(x)), np.rint(length / 8))
        np.testing.assert_array_equal(as_frame(sobel(x, normalized=False)), np.minimum(np.rint(length), 255))


@pytest.mark.parametrize("size", [(3, 3), (1, 3), (11, 11), (43, 3)])
def test_laplacian_is_opencvs_filter(size: tuple[int, int]) -> None:
    image = frame(50, 53)
    image[:25] = image[:25] // 255 * 255  # single bright pixels: the largest sums
    taps = np.ones(size)
    taps[size[0] // 2, size[1] // 2] = 1 - taps.size
    for border, flag in (("reflect", cv2.BORDER_REFLECT_101), ("constant", cv2.BORDER_CONSTANT)):
        expected = cv2.filter2D(image.astype(np.float64), -1, taps, borderType=flag)
        for x in both_layouts(image):
            result = laplacian(x, size, border, normalized=False)
            assert result.dtype == torch.int16
            np.testing.assert_array_equal(result[0].permute(1, 2, 0).numpy(), np.rint(expected))


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_grey_is_opencvs(height: int, width: int) -> None:
    image = frame(height, width)
    for x in both_layouts(image):
        rgb, bgr = as_frame(rgb_to_grayscale(x)), as_frame(bgr_to_grayscale(x))
        np.testing.assert_array_equal(rgb[..., 0], cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        np.testing.assert_array_equal(bgr[..., 0], cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))


def every_colour() -> np.ndarray:
    """Every fifth level of each channel, and all greys."""
    steps = np.arange(0, 256, 5, dtype=np.uint8)
    colours = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 1, 3)
    return np.concatenate([colours, np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(-1, 1, 3)])


def test_hsv_is_within_a_level_of_opencvs() -> None:
    image = every_colour()
    expected = cv2.cvtColor(image, cv2.COLOR_RGB2HSV).astype(int)
    for x in both_layouts(image):
        result = as_frame(rgb_to_hsv(x))
        difference = np.abs(result - expected)
        difference[..., 0] = np.minimum(difference[..., 0], 180 - difference[..., 0])
        assert difference.max() <= 1
        assert (difference > 0).mean() < 0.03
        assert result[..., 0].max() < 180


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize("size", [(20, 30), (100, 33), (5, 5), (1, 1)])
def test_resizing_is_opencvs(channels: int, height: int, width: int, size: tuple[int, int]) -> None:
    image = frame(height, width, channels)
    for x in both_layouts(image):
        for interpolation, flag in (("bilinear", cv2.INTER_LINEAR_EXACT), ("nearest", cv2.INTER_NEAREST)):
            expected = cv2.resize(image, size[::-1], interpolation=flag)
            result = as_frame(resize(x, size, interpolation))
            np.testing.assert_array_equal(result.squeeze(), expected.squeeze())


def cubic_matrix(in_size: int, out_size: int, corners: bool) -> np.ndarray:
    """Keys' weights, a = -3/4, of all source pixels for each output pixel of a line, in 1/2^11."""
    matrix = np.zeros((out_size, in_size), np.int64)
    for i in range(out_size):
        at = i * (in_size - 1) / max(out_size - 1, 1) if corners else (i + 0.5) * in_size / out_size - 0.5
        first = int(np.floor(at))
        for k in range(first - 1, first + 3):
            d = abs(at - k)
            weight = 1.25 * d**3 - 2.25 * d**2 + 1 if d < 1 else -0.75 * (d**3 - 5 * d**2 + 8 * d - 4)
            matrix[i, min(max(k, 0), in_size - 1)] += round(2048 * weight)
    return matrix


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize("size", [(20, 30), (100, 33), (5, 5), (1, 1)])
def test_bicubic_resizing_is_the_definition_and_a_level_from_opencvs(
    channels: int, height: int, width: int, size: tuple[int, int]
) -> None:
    image = frame(height, width, channels)
    image[: height // 2] = image[: height // 2] // 128 * 255
    theirs = cv2.resize(image, size[::-1], interpolation=cv2.INTER_CUBIC).reshape(*size, channels)
    for corners in (False, True):
        down, across = cubic_matrix(height, size[0], corners), cubic_matrix(width, size[1], corners)
        sums = np.einsum("ih,hwc,jw->ijc", down, image.astype(np.int64), across)
        for x in both_layouts(image):
            result = as_frame(resize(x, size, "bicubic", align_corners=corners))
            np.testing.assert_array_equal(result, np.clip((sums + 2**21) >> 22, 0, 255))
            if not corners:
                assert np.abs(result - theirs.astype(int)).max() <= 1


def test_resizing_with_the_corners_aligned_is_the_definition_rounded() -> None:
    image = frame(13, 17)
    expected = resize(both_layouts(image)[1].double(), (30, 40), align_corners=True)
    for x in both_layouts(image):
        result = resize(x, (30, 40), align_corners=True)
        assert (result.double() - expected).abs().max() < 0.5 + 2.0  # weights are in 1/256: two levels of 255
        assert torch.equal(result[..., ::29, ::39], x[..., ::12, ::16])


@pytest.mark.parametrize("dtype", [torch.int16, torch.uint16])
def test_nearest_takes_images_of_16_bits(dtype: torch.dtype) -> None:
    image = frame(13, 17, 1).astype(np.int32) * 100
    x = torch.from_numpy(image).to(dtype)[None].permute(0, 3, 1, 2)
    result = resize(x, (7, 30), "nearest")
    assert result.dtype == dtype
    expected = cv2.resize(image.astype(np.int16), (30, 7), interpolation=cv2.INTER_NEAREST)
    np.testing.assert_array_equal(result[0, 0].to(torch.int32).numpy(), expected)


@pytest.mark.parametrize("dtype", [np.uint8, np.int16])
def test_flips_are_opencvs(dtype: type[np.generic]) -> None:
    image = (frame(13, 17).astype(np.int32) * 100).astype(dtype)
    for x in both_layouts(image):
        for flip, code in ((hflip, 1), (vflip, 0), (rot180, -1)):
            result = flip(x)
            assert result.dtype == x.dtype
            np.testing.assert_array_equal(result[0].permute(1, 2, 0).numpy(), cv2.flip(image, code))


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.uint16, np.float32])
def test_transpose_is_opencvs(dtype: type[np.generic]) -> None:
    image = (frame(13, 17).astype(np.int32) * 100).astype(dtype)
    for x in both_layouts(image):
        result = transpose(x)
        assert result.dtype == x.dtype
        np.testing.assert_array_equal(result[0].permute(1, 2, 0).numpy(), cv2.transpose(image))
        left = cv2.rotate(image, cv2.ROTATE_90_COUNTERCLOCKWISE)
        np.testing.assert_array_equal(transpose(hflip(x))[0].permute(1, 2, 0).numpy(), left)
        right = cv2.rotate(image, cv2.ROTATE_90_CLOCKWISE)
        np.testing.assert_array_equal(hflip(transpose(x))[0].permute(1, 2, 0).numpy(), right)


@pytest.mark.parametrize(
    ("type", "flag"),
    [
        ("binary", cv2.THRESH_BINARY),
        ("binary_inv", cv2.THRESH_BINARY_INV),
        ("trunc", cv2.THRESH_TRUNC),
        ("tozero", cv2.THRESH_TOZERO),
        ("tozero_inv", cv2.THRESH_TOZERO_INV),
    ],
)
@pytest.mark.parametrize("limit", [0.0, 99.0, 254.0, 255.0])
def test_threshold_is_opencvs(type: str, flag: int, limit: float) -> None:
    image = frame(16, 40)
    expected = cv2.threshold(image, limit, 201, flag)[1]
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(threshold(x, limit, 201.0, type)), expected)
        np.testing.assert_array_equal(as_frame(threshold(x, torch.tensor([limit]), 201.0, type)), expected)


def test_what_pillow_does_to_bytes() -> None:
    image = frame(16, 40)
    pillow = Image.fromarray(image)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(invert(x)), np.asarray(ImageOps.invert(pillow)))
        for bits in (1, 3, 8):
            np.testing.assert_array_equal(
                as_frame(posterize(x, bits)), np.asarray(ImageOps.posterize(pillow, bits))
            )
            np.testing.assert_array_equal(
                as_frame(posterize(x, torch.tensor([bits]))), np.asarray(ImageOps.posterize(pillow, bits))
            )
        for limit in (1, 128, 200):
            np.testing.assert_array_equal(
                as_frame(solarize(x, float(limit))), np.asarray(ImageOps.solarize(pillow, limit))
            )


def test_no_images_give_no_images() -> None:
    nothing = torch.zeros(0, 3, 4, 5, dtype=torch.uint8)
    for made in (
        enhance.invert(nothing),
        enhance.equalize(nothing),
        filters.bilateral_blur(nothing, 3, 9.0, (1.0, 1.0)),
        enhance.autocontrast(nothing),
    ):
        assert made.shape == nothing.shape and made.dtype == torch.uint8
    assert filters.in_range(nothing, [0.0] * 3, [9.0] * 3).shape == nothing.shape


def test_curves_are_their_formulas_rounded_to_even() -> None:
    image = frame(16, 40)
    x64 = image.astype(np.float64)
    expected = {
        "gamma": np.rint(255 * np.clip((x64 / 255) ** 0.45 * 1.1, 0, 1)),
        "brightness": np.rint(np.clip(x64 + 30.4, 0, 255)),
        "accumulative": np.rint(np.clip(x64 * 1.25, 0, 255)),
    }
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(adjust_gamma(x, 0.45, 1.1)), expected["gamma"])
        np.testing.assert_array_equal(as_frame(adjust_brightness(x, 30.4)), expected["brightness"])
        np.testing.assert_array_equal(
            as_frame(adjust_brightness_accumulative(x, 1.25)), expected["accumulative"]
        )
        np.testing.assert_array_equal(as_frame(adjust_contrast(x, 1.25)), expected["accumulative"])
    two = torch.cat([both_layouts(image)[1]] * 2)
    each = adjust_gamma(two, torch.tensor([0.45, 2.0]), torch.tensor([1.1, 1.0]))
    np.testing.assert_array_equal(as_frame(each[:1]), expected["gamma"])
    np.testing.assert_array_equal(as_frame(each[1:]), np.rint(255 * (x64 / 255) ** 2))


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (
            lambda x: gaussian_blur2d(x.to(torch.int32), 3, (1.0, 1.0)),
            TypeError,
            "input: expected a floating-point or uint8",
        ),
        (lambda x: box_blur(x, (256, 257)), ValueError, "kernel_size: expected at most 65536 pixels"),
        (lambda x: box_blur(x.to(torch.int32), 3), TypeError, "input: expected a floating-point or uint8"),
        (lambda x: spatial_gradient(x), ValueError, "normalized: expected False on bytes, got True"),
        (lambda x: spatial_gradient(x, order=2, normalized=False), ValueError, "order: expected 1 on bytes"),
        (lambda x: laplacian(x, 3), ValueError, "normalized: expected False on bytes, got True"),
        (
            lambda x: laplacian(x, 13, normalized=False),
            ValueError,
            "kernel_size: expected at most 129 pixels",
        ),
        (
            lambda x: resize(x.to(torch.int16), (4, 4), "bicubic", antialias=True),
            TypeError,
            "input: expected a floating-point or uint8",
        ),
        (lambda x: rgb_to_grayscale(x, torch.ones(3)), TypeError, "rgb_weights: expected None"),
        (lambda x: rgb_to_grayscale(x[:, :2]), ValueError, r"image: expected shape \(\*, 3, H, W\)"),
        (lambda x: invert(x, torch.tensor(255.0)), TypeError, "max_val: expected None"),
        (lambda x: threshold(x.to(torch.int64), 3.0), TypeError, "input: expected a floating-point, uint8"),
    ],
)
def test_what_has_no_meaning_on_bytes_says_so(call, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call(both_layouts(frame(9, 8))[1])


@pytest.mark.parametrize("limit", [-0.5, 0.5, 99.5, 99.999, 100.0, 254.5, 255.0, 300.7])
def test_trunc_comes_down_to_the_level_below(limit: float) -> None:
    x = torch.arange(256, dtype=torch.uint8).reshape(1, 1, 16, 16)
    expected = cv2.threshold(x[0, 0].numpy(), limit, 255, cv2.THRESH_TRUNC)[1]
    for call in (threshold, torch.jit.script(threshold)):
        np.testing.assert_array_equal(call(x, limit, type="trunc")[0, 0], expected)
