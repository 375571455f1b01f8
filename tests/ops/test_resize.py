"""Resizing against torch, OpenCV and Pillow."""

import cv2
import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import chw, hwc, photo
from PIL import Image

from chiasm.geometry.transform import Resize, resize

SIZES = [(37, 53), (20, 90), (74, 26), (10, 13), (1, 1), (64, 31)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic"])
@pytest.mark.parametrize("align_corners", [False, True])
def test_equals_torch(size: tuple[int, int], interpolation: str, align_corners: bool) -> None:
    x = photo(2, 5, 37, 53, torch.float64)
    expected = F.interpolate(x, size, mode=interpolation, align_corners=align_corners)
    torch.testing.assert_close(resize(x, size, interpolation, align_corners), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("size", [s for s in SIZES if s != (1, 1)])
@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic"])
def test_antialias_equals_torch(size: tuple[int, int], interpolation: str) -> None:
    x = photo(2, 3, 37, 53, torch.float64)
    expected = F.interpolate(x, size, mode=interpolation, antialias=True)
    torch.testing.assert_close(resize(x, size, interpolation, antialias=True), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("source", [100, 7, 2])
@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic"])
def test_antialias_with_corners_equals_torch(source: int, interpolation: str) -> None:
    generator = torch.Generator().manual_seed(source)
    x = torch.rand(1, 2, source, source, generator=generator, dtype=torch.float64)
    for size in ((3, 3), (2, 5), (7, 4), (9, 20)):
        expected = F.interpolate(x, size, mode=interpolation, align_corners=True, antialias=True)
        actual = resize(x, size, interpolation=interpolation, align_corners=True, antialias=True)
        torch.testing.assert_close(actual, expected, rtol=1e-12, atol=1e-12)


def test_antialias_with_corners_makes_one_pixel_a_mean() -> None:
    x = torch.rand(1, 1, 1, 9, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    weights = 1 - np.abs(np.arange(9) + 0.5 - 4.0) / 8.0  # a triangle of the width of the image
    expected = (x.numpy() * weights).sum() / weights.sum()
    actual = resize(x, (1, 1), interpolation="bilinear", align_corners=True, antialias=True)
    np.testing.assert_allclose(actual.flatten(), [expected], rtol=1e-12)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("interpolation", "flag"), [("bilinear", cv2.INTER_LINEAR), ("bicubic", cv2.INTER_CUBIC)]
)
@pytest.mark.parametrize("channels", [1, 3])
def test_equals_opencv(size: tuple[int, int], interpolation: str, flag: int, channels: int) -> None:
    x = photo(2, channels, 37, 53)
    for b in range(2):
        expected = chw(cv2.resize(hwc(x, b), size[::-1], interpolation=flag))
        np.testing.assert_allclose(resize(x, size, interpolation)[b], expected, atol=2e-5)


@pytest.mark.parametrize("size", SIZES)
def test_nearest_takes_the_exact_floor(size: tuple[int, int]) -> None:
    x = photo(2, 3, 37, 53)
    rows = [i * 37 // size[0] for i in range(size[0])]
    columns = [j * 53 // size[1] for j in range(size[1])]
    assert torch.equal(resize(x, size, "nearest"), x[:, :, rows][..., columns])


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("interpolation", "flag"),
    [("bilinear", Image.Resampling.BILINEAR), ("bicubic", Image.Resampling.BICUBIC)],
)
def test_antialias_equals_pillow(size: tuple[int, int], interpolation: str, flag: int) -> None:
    x = photo(1, 1, 37, 53)
    expected = np.asarray(Image.fromarray(x[0, 0].numpy()).resize(size[::-1], flag))
    np.testing.assert_allclose(resize(x, size, interpolation, antialias=True)[0, 0], expected, atol=1e-5)


@pytest.mark.parametrize("size", SIZES)
def test_lanczos_equals_pillow(size: tuple[int, int]) -> None:
    x = photo(1, 1, 37, 53)
    expected = np.asarray(Image.fromarray(x[0, 0].numpy()).resize(size[::-1], Image.Resampling.LANCZOS))
    np.testing.assert_allclose(resize(x, size, "lanczos", antialias=True)[0, 0], expected, atol=1e-5)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("channels", [1, 3])
def test_lanczos4_equals_opencv(size: tuple[int, int], channels: int) -> None:
    x = photo(2, channels, 37, 53)
    for b in range(2):
        expected = chw(cv2.resize(hwc(x, b), size[::-1], interpolation=cv2.INTER_LANCZOS4))
        np.testing.assert_allclose(resize(x, size, "lanczos4")[b], expected, atol=2e-5)
        image = np.rint(255 * hwc(x, b)).astype(np.uint8)
        levels = chw(cv2.resize(image, size[::-1], interpolation=cv2.INTER_LANCZOS4).astype(np.int32))
        made = resize(torch.from_numpy(np.ascontiguousarray(chw(image)))[None], size, "lanczos4")[0]
        assert made.dtype == torch.uint8 and np.abs(made.numpy() - levels).max() <= 1


def test_lanczos4_is_the_kernel_of_four_lobes() -> None:
    x = photo(1, 2, 20, 31, torch.float64)
    place = (np.arange(70) + 0.5) * 31 / 70 - 0.5
    pixel = np.floor(place)[:, None] + np.arange(-3, 5)
    apart = place[:, None] - pixel
    weight = np.sinc(apart) * np.sinc(apart / 4)
    weight /= weight.sum(1, keepdims=True)
    expected = (x.numpy()[..., pixel.clip(0, 30).astype(int)] * weight).sum(-1)
    np.testing.assert_allclose(resize(x, (20, 70), "lanczos4"), expected, atol=1e-12)


@pytest.mark.parametrize("size", [(37, 53), (36, 52), (20, 30), (10, 13), (5, 53), (1, 1)])
@pytest.mark.parametrize("channels", [1, 3])
def test_area_equals_opencv_where_it_reduces(size: tuple[int, int], channels: int) -> None:
    x = photo(2, channels, 37, 53)
    for b in range(2):
        expected = chw(cv2.resize(hwc(x, b), size[::-1], interpolation=cv2.INTER_AREA))
        np.testing.assert_allclose(resize(x, size, "area")[b], expected, atol=2e-5)


@pytest.mark.parametrize("size", [(74, 106), (40, 60), (37, 100)])
def test_area_is_a_mean_where_it_enlarges(size: tuple[int, int]) -> None:
    """The reference repeats every pixel so that the size becomes a multiple of the output's, and averages
    blocks."""
    x = photo(1, 2, 37, 53, torch.float64)
    whole = x.repeat_interleave(size[0], 2).repeat_interleave(size[1], 3)
    expected = F.avg_pool2d(whole, (37, 53))
    torch.testing.assert_close(resize(x, size, "area"), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("side", "expected"), [("short", (20, 30)), ("long", (13, 20)), ("vert", (20, 30)), ("horz", (13, 20))]
)
def test_one_size_keeps_the_aspect(side: str, expected: tuple[int, int]) -> None:
    x = photo(1, 3, 40, 60)
    assert resize(x, 20, side=side).shape[2:] == expected
    assert (
        Resize(20, side=side)(x.transpose(2, 3)).shape[2:]
        == {
            "short": (30, 20),
            "long": (20, 13),
            "vert": (20, 13),
            "horz": (30, 20),
        }[side]
    )
