"""Windows and geometry of bytes against OpenCV, bit for bit if documented so, in both layouts."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from PIL import Image, ImageEnhance
from test_bytes import as_frame, both_layouts, frame
from torch import Tensor

from chiasm.enhance import sharpness
from chiasm.filters import adaptive_threshold, filter2d, filter2d_separable, unsharp_mask
from chiasm.geometry.transform import (
    build_pyramid,
    pyrdown,
    pyrup,
    remap,
    rotate,
    warp_affine,
    warp_perspective,
    warp_polar,
)

SIZES = [(37, 53), (8, 120), (3, 3), (64, 9)]


def smooth(height: int, width: int, channels: int = 3) -> np.ndarray:
    return cv2.GaussianBlur(frame(height, width, channels), (0, 0), 3).reshape(height, width, channels)


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_levels_of_pyramids_are_opencvs(channels: int, height: int, width: int) -> None:
    image = frame(height, width, channels)
    image[: height // 2] = image[: height // 2] // 128 * 255  # the largest sums too
    for x in both_layouts(image):
        for border, flag in (("reflect", cv2.BORDER_REFLECT_101), ("replicate", cv2.BORDER_REPLICATE)):
            result = as_frame(pyrdown(x, border, sampling="alternate"))
            np.testing.assert_array_equal(result.squeeze(), cv2.pyrDown(image, borderType=flag).squeeze())
        result = as_frame(pyrup(x, sampling="alternate"))
        np.testing.assert_array_equal(result.squeeze(), cv2.pyrUp(image).squeeze())


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_levels_of_pyramids_of_floats_are_opencvs(height: int, width: int) -> None:
    image = np.random.default_rng(0).random((height, width))
    x = torch.from_numpy(image)[None, None]
    down, up = pyrdown(x, sampling="alternate"), pyrup(x, sampling="alternate")
    np.testing.assert_allclose(down[0, 0], cv2.pyrDown(image), atol=1e-12)
    np.testing.assert_allclose(up[0, 0], cv2.pyrUp(image), atol=1e-12)
    small = x[..., :4, :5].requires_grad_()
    assert torch.autograd.gradcheck(lambda p: pyrdown(p, sampling="alternate"), (small[..., :3, :3],))
    assert torch.autograd.gradcheck(lambda p: pyrup(p, sampling="alternate"), (small[..., :3, :3],))


@pytest.mark.parametrize("channels", [1, 3])
def test_pyramids_are_opencvs(channels: int) -> None:
    image = frame(37, 53, channels)
    half = cv2.pyrDown(image)
    expected = [image, half, cv2.pyrDown(half)]
    for x in both_layouts(image):
        for level, wanted in zip(build_pyramid(x, 3, sampling="alternate"), expected, strict=True):
            np.testing.assert_array_equal(as_frame(level).squeeze(), wanted.squeeze())


BORDERS = [
    ("reflect", cv2.BORDER_REFLECT_101),
    ("replicate", cv2.BORDER_REPLICATE),
    ("constant", cv2.BORDER_CONSTANT),
]


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("size", [(1, 1), (3, 3), (5, 7), (2, 4)])
@pytest.mark.parametrize(("border", "flag"), BORDERS)
def test_correlation_is_opencvs(channels: int, size: tuple[int, int], border: str, flag: int) -> None:
    image = frame(37, 53, channels)
    image[:18] = image[:18] // 128 * 255
    random = np.random.default_rng(2)
    anchor = ((size[1] - 1) // 2, (size[0] - 1) // 2)
    whole = random.integers(-300, 300, size) / 256
    for taps, allowed in ((whole, 0), (random.normal(0, 0.3, size), 1), (np.ones(size) / 9, 1)):
        expected = cv2.filter2D(image, -1, taps, anchor=anchor, borderType=flag).reshape(image.shape)
        for x in both_layouts(image):
            for kernel in (torch.from_numpy(taps), torch.from_numpy(taps).float()[None]):
                result = as_frame(filter2d(x, kernel, border))
                apart = np.abs(result.astype(int) - expected)
                assert apart.max() <= allowed
                assert (apart > 0).mean() < 0.05
                (top, left), (height, width) = (anchor[1], anchor[0]), (38 - size[0], 54 - size[1])
                np.testing.assert_array_equal(
                    as_frame(filter2d(x, kernel, border, padding="valid")),
                    result[top : top + height, left : left + width],
                )


def test_sums_of_bytes_are_exact_whatever_the_taps() -> None:
    """The largest sums with the largest taps, against the definition in integers."""
    image = np.full((9, 11, 3), 255, np.uint8)
    image[4, 5] = 254
    for factor in (1e-7, 1.0 / 3.0, 1.0, 77.0, 65000.0):
        taps = np.full((5, 5), factor / 25.0)
        taps[2, 2] = 0.0
        step = min(2.0**k for k in range(-23, 24) if 255 * (taps.sum() / 2.0**k + 12.5) < 2**24)
        whole = np.rint(taps / step).astype(np.int64)
        assert 2**22 < whole.sum() * 255 < 2**24 or step == 2.0**-23
        sums = cv2.filter2D(image.astype(np.float64), -1, whole.astype(np.float64)).astype(np.int64)
        expected = np.clip(np.rint(sums * step), 0, 255)
        for x in both_layouts(image):
            np.testing.assert_array_equal(as_frame(filter2d(x, torch.from_numpy(taps))), expected)


def test_taps_that_are_no_numbers_are_limited() -> None:
    image = frame(9, 8)
    for x in both_layouts(image):
        taps = torch.tensor([[torch.nan, torch.inf, 0.0], [0.0, torch.nan, 0.0]])
        np.testing.assert_array_equal(as_frame(filter2d(x, taps)), (image > 0) * 255)
        np.testing.assert_array_equal(as_frame(filter2d(x, -taps)), 0 * image)
        flat = 0 * x + 7
        assert torch.equal(sharpness(flat, torch.inf), flat)


def test_each_sample_has_its_taps() -> None:
    image = frame(20, 30)
    x = both_layouts(image)[0].expand(2, -1, -1, -1)
    taps = torch.tensor([[[0.25, 0.5, 0.25]], [[0.0, 0.0, 3.0]]])
    result = filter2d(x, taps, "replicate")
    for i in range(2):
        expected = cv2.filter2D(image, -1, taps[i].numpy(), borderType=cv2.BORDER_REPLICATE)
        np.testing.assert_array_equal(as_frame(result[i : i + 1]), expected)
    turned = filter2d(x, taps[1], "replicate", behaviour="conv", normalized=True)
    np.testing.assert_array_equal(as_frame(turned[:1])[:, 1:], image[:, :-1])


@pytest.mark.parametrize(("border", "flag"), BORDERS)
def test_separable_correlation_is_that_with_the_product(border: str, flag: int) -> None:
    image = frame(37, 53)
    along, down = np.array([0.1, 0.2, 0.4, 0.2, 0.1]), np.array([0.3, 0.5, 0.2])
    expected = cv2.sepFilter2D(image.astype(np.float64), -1, along, down, borderType=flag)
    for x in both_layouts(image):
        kernels = (torch.from_numpy(along), torch.from_numpy(down))
        result = as_frame(filter2d_separable(x, kernels[0], kernels[1], border))
        assert np.abs(result - expected).max() < 0.55
        product = kernels[1][:, None] * kernels[0]
        np.testing.assert_array_equal(result, as_frame(filter2d(x, product, border)))


@pytest.mark.parametrize(("border", "flag"), BORDERS)
def test_unsharp_mask_is_opencvs(border: str, flag: int) -> None:
    image = frame(37, 53)
    blurred = cv2.GaussianBlur(image, (5, 3), 1.2, sigmaY=0.8, borderType=flag)
    expected = cv2.addWeighted(image, 2.0, blurred, -1.0, 0.0)
    for x in both_layouts(image):
        for sigma in ((0.8, 1.2), torch.tensor([[0.8, 1.2]])):
            np.testing.assert_array_equal(as_frame(unsharp_mask(x, (3, 5), sigma, border)), expected)


@pytest.mark.parametrize("factor", [0.0, 0.3, 0.7, 1.0, 1.9, 5.0])
def test_sharpness_is_pillows(factor: float) -> None:
    image = frame(37, 53)
    image[:18] = image[:18] // 128 * 255
    expected = np.asarray(ImageEnhance.Sharpness(Image.fromarray(image)).enhance(factor)).astype(int)
    for x in both_layouts(image):
        for given in (factor, torch.tensor([factor])):
            apart = np.abs(as_frame(sharpness(x, given)) - expected)
            assert apart.max() <= 1
            assert (apart > 0).mean() < 5e-3


@pytest.mark.parametrize("c", [0.0, 2.0, -1.5, 7.2])
@pytest.mark.parametrize("size", [3, 5, 9, 31])
def test_adaptive_threshold_is_opencvs(size: int, c: float) -> None:
    image = frame(37, 53, 1)
    ways = (("mean", cv2.ADAPTIVE_THRESH_MEAN_C), ("gaussian", cv2.ADAPTIVE_THRESH_GAUSSIAN_C))
    types = (("binary", cv2.THRESH_BINARY), ("binary_inv", cv2.THRESH_BINARY_INV))
    for method, way in ways:
        for kind, flag in types:
            expected = cv2.adaptiveThreshold(image[..., 0], 201.0, way, flag, size, c)
            for x in both_layouts(image):
                result = as_frame(adaptive_threshold(x, 201.0, method, kind, size, c))[..., 0]
                if method == "mean":
                    np.testing.assert_array_equal(result, expected)
                assert (result != expected).mean() < 0.02


PADDINGS = [
    ("zeros", True, cv2.BORDER_CONSTANT),
    ("border", True, cv2.BORDER_REPLICATE),
    ("reflection", True, cv2.BORDER_REFLECT_101),
    ("reflection", False, cv2.BORDER_REFLECT),
]
WAYS = ("bilinear", "nearest")
FLAGS = {"bilinear": cv2.INTER_LINEAR, "nearest": cv2.INTER_NEAREST, "bicubic": cv2.INTER_CUBIC}


def read_at(image: np.ndarray, x: np.ndarray, y: np.ndarray, padding: str) -> np.ndarray:
    """The bilinear definition in integers: OpenCV's 8-bit remap, version 4.6. Version 5 does not round
    positions."""
    at = np.rint(np.stack([y, x]).astype(np.float64) * 32).astype(np.int64)
    first, (down, across) = at >> 5, at & 31
    padded = np.pad(
        image.astype(np.int64),
        ((99, 99), (99, 99), (0, 0)),
        {"zeros": "constant", "border": "edge", "reflection": "reflect"}[padding],
    )
    rows = [
        sum(
            padded[first[0] + 99 + i, first[1] + 99 + j] * (across if j else 32 - across)[..., None]
            for j in (0, 1)
        )
        for i in (0, 1)
    ]
    return (rows[0] * (32 - down)[..., None] + rows[1] * down[..., None] + 512) >> 10


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("padding", "corners", "border"), PADDINGS[:3])
def test_remap_is_its_definition_and_opencvs(channels: int, padding: str, corners: bool, border: int) -> None:
    random = np.random.default_rng(1)
    at_x = random.uniform(-9, 62, (40, 50)).astype(np.float32)
    at_y = random.uniform(-9, 46, (40, 50)).astype(np.float32)
    at_x[0], at_y[0] = np.arange(50) / 64, np.arange(50) / 2  # halfway between steps, and between pixels
    for image in (frame(37, 53, channels), smooth(37, 53, channels)):
        expected = {
            "bilinear": read_at(image, at_x, at_y, padding),
            "nearest": cv2.remap(image, at_x, at_y, cv2.INTER_NEAREST, borderMode=border),
        }
        maps = (torch.from_numpy(at_x)[None], torch.from_numpy(at_y)[None])
        for x in both_layouts(image):
            for m in (maps, [p.double() for p in maps]):
                for mode, wanted in expected.items():
                    result = as_frame(remap(x, m[0], m[1], mode, padding, align_corners=corners))
                    np.testing.assert_array_equal(result, wanted.reshape(result.shape))
    # for the smooth image
    theirs = cv2.remap(image, at_x, at_y, cv2.INTER_LINEAR, borderMode=border).reshape(40, 50, channels)
    apart = np.abs(expected["bilinear"] - theirs)
    assert (apart > 1).mean() < (0.02 if padding == "zeros" else 1e-3)


def keys(distance: np.ndarray) -> np.ndarray:
    """Keys' kernel with a = -3/4 of distances in 1/32 pixel, in 1/2^17."""
    d = np.abs(distance)
    near = 5 * d**3 - 9 * 32 * d**2 + 4 * 32**3
    far = -3 * d**3 + 15 * 32 * d**2 - 24 * 32**2 * d + 12 * 32**3
    return np.where(d < 32, near, np.where(d < 64, far, 0))


def read_cubic(image: np.ndarray, x: np.ndarray, y: np.ndarray, padding: str) -> np.ndarray:
    """The bicubic definition in integers."""
    at = np.rint(np.stack([y, x]).astype(np.float64) * 32).astype(np.int64)
    first = at >> 5
    how = {"zeros": "constant", "border": "edge", "reflection": "reflect"}[padding]
    padded = np.pad(image.astype(np.int64), ((99, 99), (99, 99), (0, 0)), how)
    total = np.zeros((*x.shape, image.shape[2]), np.int64)
    for i in range(-1, 3):
        for j in range(-1, 3):
            weight = keys(at[0] - 32 * (first[0] + i)) * keys(at[1] - 32 * (first[1] + j))
            total += padded[first[0] + 99 + i, first[1] + 99 + j] * weight[..., None]
    return np.clip((total + 2**33) >> 34, 0, 255)


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("padding", "corners", "border"), PADDINGS[:3])
def test_bicubic_remap_is_its_definition_and_opencvs(
    channels: int, padding: str, corners: bool, border: int
) -> None:
    random = np.random.default_rng(2)
    at_x = random.uniform(-9, 62, (40, 50)).astype(np.float32)
    at_y = random.uniform(-9, 46, (40, 50)).astype(np.float32)
    at_x[:30], at_y[:30] = np.rint(at_x[:30] * 32) / 32, np.rint(at_y[:30] * 32) / 32
    at_x[0], at_y[0] = np.arange(50), 7.0  # pixels themselves
    image = frame(37, 53, channels)
    image[:20] = image[:20] // 128 * 255
    theirs = cv2.remap(image, at_x, at_y, cv2.INTER_CUBIC, borderMode=border).reshape(40, 50, channels)
    maps = [torch.from_numpy(at)[None] for at in (at_x, at_y)]
    for x in both_layouts(image):
        result = as_frame(remap(x, maps[0], maps[1], "bicubic", padding, align_corners=corners))
        np.testing.assert_array_equal(result, read_cubic(image, at_x, at_y, padding))
        assert np.abs(result[:30] - theirs[:30].astype(int)).max() <= 1


@pytest.mark.parametrize(("mode", "way"), [*FLAGS.items()])
def test_a_colour_lies_around_bytes(mode: str, way: int) -> None:
    image = frame(30, 40)
    colour = (7.0, 200.0, 255.0)
    back = np.array([[1.25, -0.25, -3.0], [0.5, 0.75, 2.5]])  # multiples of 1/32 pixel at every pixel
    expected = cv2.warpAffine(
        image,
        back,
        (50, 45),
        flags=way | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=colour,
    )
    whole = torch.eye(3, dtype=torch.float64)
    whole[:2] = torch.from_numpy(back)
    matrix = torch.linalg.inv(whole)[None]
    for x in both_layouts(image):
        for fill in (torch.tensor(colour), torch.tensor(colour, dtype=torch.float64) + 0.3):
            for result in (
                warp_affine(x, matrix[:, :2], (45, 50), mode, "fill", fill_value=fill),
                warp_perspective(x, matrix, (45, 50), mode, "fill", fill_value=fill),
            ):
                apart = np.abs(as_frame(result) - expected.astype(int))
                assert (apart > 1).mean() < (0.03 if mode == "nearest" else 1e-3)
                assert (as_frame(result)[40, 0] == colour).all()
        black = warp_affine(x, matrix[:, :2], (45, 50), mode, "fill")
        assert torch.equal(black, warp_affine(x, matrix[:, :2], (45, 50), mode, "zeros"))


def test_positions_that_are_no_numbers_read_nothing() -> None:
    image = frame(9, 8) | 1
    at = torch.tensor([[[torch.nan, 2.0, torch.inf, -torch.inf, 1e30, -1e30]]])
    for x in both_layouts(image):
        for mode in FLAGS:
            empty = as_frame(remap(x, at, torch.ones(1, 1, 6), mode, align_corners=True))[0]
            assert (empty[[0, 2, 3, 4, 5]] == 0).all() and (empty[1] == image[1, 2]).all()
            edge = as_frame(remap(x, at, torch.ones(1, 1, 6), mode, "border", align_corners=True))[0]
            assert (edge[0] == 0).all()
            np.testing.assert_array_equal(edge[1:], image[1, [2, 7, 0, 7, 0]])


def assert_nearly(result: Tensor, expected: np.ndarray, image: np.ndarray, share: float) -> None:
    difference = np.abs(as_frame(result).astype(int) - expected.reshape(as_frame(result).shape))
    assert (difference > 1).mean() < share, (
        f"{(difference > 1).mean()}, {difference.max()} of {np.ptp(image)}"
    )


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("padding", "corners", "border"), PADDINGS)
def test_warps_are_nearly_opencvs(channels: int, padding: str, corners: bool, border: int) -> None:
    image = smooth(120, 157, channels)
    affine = np.array([[0.9, -0.3, 12.0], [0.25, 1.1, -20.0]])
    perspective = np.array([[0.9, -0.3, 12.0], [0.25, 1.1, -20.0], [1e-3, 5e-4, 1.0]])
    size = (140, 130)
    flags = {"flags": cv2.INTER_LINEAR, "borderMode": border}
    for x in both_layouts(image):
        assert_nearly(
            warp_affine(x, torch.from_numpy(affine)[None], size, "bilinear", padding, corners),
            cv2.warpAffine(image, affine, size[::-1], **flags),
            image,
            1e-3 if padding != "zeros" else 1e-2,  # at the edge a step of 1/32 pixel is up to 8 levels
        )
        assert_nearly(
            warp_perspective(x, torch.from_numpy(perspective)[None], size, "bilinear", padding, corners),
            cv2.warpPerspective(image, perspective, size[::-1], **flags),
            image,
            1e-3 if padding != "zeros" else 1e-2,
        )


@pytest.mark.parametrize("mode", WAYS)
def test_warps_are_remaps_of_their_positions(mode: str) -> None:
    """Positions are multiples of 1/1024 pixel, whose sums are exact on every engine."""
    image = frame(40, 60)
    inverse = np.array([[717.0, -300.0, 3.0 * 1024], [90.0, 1280.0, -5.0 * 1024]]) / 1024
    v, u = np.mgrid[:50, :70]
    at = np.einsum("ij,jhw->ihw", inverse, np.stack([u, v, np.ones_like(u)])).astype(np.float32)
    nearest = cv2.remap(image, at[0], at[1], cv2.INTER_NEAREST)
    expected = nearest if mode == "nearest" else read_at(image, at[0], at[1], "zeros")
    whole = torch.eye(3, dtype=torch.float64)
    whole[:2] = torch.from_numpy(inverse)
    # The inverse of the inverse has rounding errors, so other matrices would not give exact half steps.
    for x in both_layouts(image):
        result = as_frame(
            remap(x, torch.from_numpy(at[:1]), torch.from_numpy(at[1:]), mode, align_corners=True)
        )
        np.testing.assert_array_equal(result, expected)
        warped = as_frame(warp_affine(x, torch.linalg.inv(whole)[None, :2], (50, 70), mode))
        assert (warped != expected).mean() < 0.02


def test_turns_by_quarters_move_pixels() -> None:
    image = frame(21, 21)
    for x in both_layouts(image):
        for mode in FLAGS:
            for turns in range(4):
                result = as_frame(rotate(x, torch.tensor([90.0 * turns]), mode=mode, padding_mode="border"))
                np.testing.assert_array_equal(result, np.rot90(image, turns))


def test_polar_views_are_nearly_opencvs() -> None:
    image = smooth(120, 157)
    expected = cv2.warpPolar(image, (64, 90), (70.0, 60.0), 50.0, cv2.INTER_LINEAR | cv2.WARP_POLAR_LINEAR)
    for x in both_layouts(image):
        result = warp_polar(x, (90, 64), torch.tensor([[70.0, 60.0]]), torch.tensor([50.0]))
        assert_nearly(result, expected, image, 1e-3)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda x: pyrdown(x), TypeError, "input: expected a floating-point tensor"),
        (lambda x: build_pyramid(x, 2), TypeError, "input: expected a floating-point tensor"),
        (lambda x: build_pyramid(x, 2, sampling="other"), ValueError, "sampling: expected one of"),
        (lambda x: pyrup(x), TypeError, "input: expected a floating-point tensor"),
        (lambda x: pyrdown(x, factor=3.0, sampling="alternate"), ValueError, "factor: expected 2 with"),
        (lambda x: pyrdown(x, sampling="other"), ValueError, "sampling: expected one of"),
        (lambda x: pyrup(x, "constant", sampling="alternate"), ValueError, "border_type: expected 'reflect'"),
        (
            lambda x: filter2d(x.int(), torch.ones(3, 3)),
            TypeError,
            "input: expected a floating-point or uint8",
        ),
        (lambda x: unsharp_mask(x.int(), 3, (1.0, 1.0)), TypeError, "input: expected a floating-point or"),
        (lambda x: adaptive_threshold(x, 300.0), ValueError, "max_value: expected a whole number, 0 to 255"),
        (
            lambda x: adaptive_threshold(x, 9.0, block_size=257),
            ValueError,
            "block_size: expected at most 255",
        ),
        (lambda x: adaptive_threshold(x, 9.0, rounded=False), ValueError, "rounded: expected True for bytes"),
        (lambda x: rotate(x.int(), torch.zeros(1)), TypeError, "expected a floating-point, uint8, int16 or"),
    ],
)
def test_what_has_no_meaning_on_bytes_says_so(call, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call(both_layouts(frame(9, 8))[1])
