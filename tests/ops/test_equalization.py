"""Histograms, equalisation and matching against Pillow, OpenCV, scikit-image and NumPy, level by level."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import photo
from PIL import Image, ImageOps
from skimage import exposure
from torch import Tensor

from chiasm import contrib, enhance
from chiasm.primitives.core.target import exporting
from chiasm.primitives.images.histograms import quantize_u8, running_sum
from chiasm.primitives.numbers.search import last_not_above

SIZES = [(37, 53), (64, 48), (101, 77)]


def to_bytes(x: Tensor) -> Tensor:
    """The levels of a photograph, exactly."""
    return (x * 255).round().to(torch.uint8)


def planes(x: Tensor) -> list[np.ndarray]:
    return list(x.flatten(0, 1).numpy())


def test_levels_round_halves_up() -> None:
    exact = torch.arange(256, dtype=torch.float64) / 255
    for dtype in (torch.float64, torch.float32, torch.float16):
        np.testing.assert_array_equal(quantize_u8(exact.to(dtype)), np.arange(256))
    halves = torch.tensor([0.1, 0.3, 0.5, 0.7, 0.9], dtype=torch.float64)  # 25.5, 76.5, ...
    np.testing.assert_array_equal(quantize_u8(halves), [26, 77, 128, 179, 230])
    np.testing.assert_array_equal(
        quantize_u8(torch.tensor([-3.0, 7.0, torch.nan, torch.inf, -torch.inf])), [0, 255, 0, 255, 0]
    )


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("channels", [1, 3, 7])
def test_equalize_equals_pillow(channels: int, size: tuple[int, int]) -> None:
    x = photo(2, channels, *size)
    for actual, plane in zip(planes(to_bytes(enhance.equalize(x))), planes(to_bytes(x)), strict=True):
        np.testing.assert_array_equal(actual, np.asarray(ImageOps.equalize(Image.fromarray(plane))))


@pytest.mark.parametrize("fill", [0, 255, 100])
def test_equalize_of_few_levels(fill: int) -> None:
    x = torch.full((1, 1, 20, 21), fill / 255)
    x[..., :3] = 30 / 255
    expected = np.asarray(ImageOps.equalize(Image.fromarray(to_bytes(x)[0, 0].numpy())))
    np.testing.assert_array_equal(to_bytes(enhance.equalize(x))[0, 0], expected)
    flat = torch.full((1, 1, 20, 21), fill / 255)
    torch.testing.assert_close(enhance.equalize(flat), flat)


def test_equalize3d_equals_pillow_on_the_unfolded_volume() -> None:
    x = photo(2, 3, 40, 23).reshape(2, 3, 5, 8, 23)
    for actual, volume in zip(planes(to_bytes(enhance.equalize3d(x))), planes(to_bytes(x)), strict=True):
        expected = np.asarray(ImageOps.equalize(Image.fromarray(volume.reshape(40, 23))))
        np.testing.assert_array_equal(actual.reshape(40, 23), expected)


def stretched(plane: np.ndarray, low: float, high: float) -> np.ndarray:
    """Pillow's definition in integers: the range of the pixels without the darkest and the brightest ones."""
    pixels = np.sort(plane, None)
    left = pixels[int(pixels.size * low // 100) : pixels.size - int(pixels.size * high // 100)].astype(int)
    return np.clip((plane.astype(int) - left[0]) * 255 // (left[-1] - left[0]), 0, 255)


@pytest.mark.parametrize("cutoff", [0, 2.0, (1.0, 7.5), (0.0, 30.0)])
@pytest.mark.parametrize("size", SIZES)
def test_autocontrast_equals_pillow(size: tuple[int, int], cutoff: float | tuple[float, float]) -> None:
    x = photo(3, 3, *size)
    for actual, plane in zip(
        planes(to_bytes(enhance.autocontrast(x, cutoff))), planes(to_bytes(x)), strict=True
    ):
        expected = np.asarray(ImageOps.autocontrast(Image.fromarray(plane), cutoff)).astype(int)
        np.testing.assert_array_equal(
            actual, stretched(plane, *(cutoff if isinstance(cutoff, tuple) else (cutoff, cutoff)))
        )
        # if the exact result is an integer, Pillow's may be a level lower
        assert set(np.unique(actual - expected)) <= {0, 1}
        assert (actual != expected).mean() < 0.15


def test_autocontrast_is_exact() -> None:
    x = torch.arange(10, 100).reshape(1, 1, 9, 10) / 255
    np.testing.assert_array_equal(to_bytes(enhance.autocontrast(x)).flatten(), np.arange(90) * 255 // 89)
    flat = torch.full((1, 1, 3, 3), 0.2)
    torch.testing.assert_close(enhance.autocontrast(flat), flat)


@pytest.mark.parametrize("size", [*SIZES, (33, 40)])
@pytest.mark.parametrize("grid", [(8, 8), (4, 3), (2, 5)])
def test_clahe_equals_opencv(size: tuple[int, int], grid: tuple[int, int]) -> None:
    x = photo(2, 2, *size)
    for clip in (40.0, 3.7, 1.0, 0.0):
        actual = enhance.clahe(to_bytes(x), clip, grid)
        for a, plane in zip(planes(actual), planes(to_bytes(x)), strict=True):
            np.testing.assert_array_equal(a, cv2.createCLAHE(clip, grid).apply(plane))
        assert torch.equal(to_bytes(enhance.equalize_clahe(x, clip, grid[::-1])), actual)


def test_soft_clahe_is_the_hard_one_without_rounding() -> None:
    # Without a limit, the tiles' curves differ only by rounding to levels: half a level for the curve, half
    # for the result.
    x = photo(2, 3, 96, 64, torch.float64)
    soft = enhance.equalize_clahe(x, 0.0, (2, 2), True)
    np.testing.assert_allclose(soft, enhance.equalize_clahe(x, 0.0, (2, 2)), atol=1.01 / 255)
    # With a limit, OpenCV distributes the remainder, less than 256 pixels, to whole levels from the dark end.
    pixels = 48 * 32
    soft = enhance.equalize_clahe(x, 10.0, (2, 2), True)
    assert (soft - enhance.equalize_clahe(x, 10.0, (2, 2))).abs().max() < 255 / pixels + 1 / 255


def test_soft_clahe_follows_the_levels() -> None:
    x = photo(1, 1, 32, 32, torch.float64)
    step = 1e-3 * torch.ones_like(x)
    up = enhance.equalize_clahe(x.clamp(0.1, 0.9) + step, 0.0, (2, 2), True)
    # a shift of all levels also shifts the curves
    torch.testing.assert_close(
        up, enhance.equalize_clahe(x.clamp(0.1, 0.9), 0.0, (2, 2), True), atol=2e-2, rtol=0
    )


@pytest.mark.parametrize("bins", [1, 7, 64, 256])
@pytest.mark.parametrize("limits", [(0.0, 1.0), (0.2, 0.7), (-1.0, 1.13)])
def test_counts_equal_opencv(limits: tuple[float, float], bins: int) -> None:
    x = photo(2, 3, 37, 53)
    actual = enhance.count_histogram(x, bins, *limits).flatten(0, 1)
    for counts, plane in zip(actual, planes(x), strict=True):
        expected = cv2.calcHist([np.ascontiguousarray(plane)], [0], None, [bins], limits).reshape(-1)
        # OpenCV has float32 limits, which moves values on a bin's edge
        edges = abs(counts.numpy() - expected).sum()
        assert edges <= 0.01 * plane.size if limits != (0.0, 1.0) else edges == 0
        assert counts.sum() == expected.sum()


def test_counts_equal_numpy() -> None:
    x = torch.rand(1, 2, 40, 41, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 1.4 - 0.2
    x[0, 0, 0, :3] = torch.tensor([torch.nan, 1.0, 0.0])
    actual = enhance.count_histogram(x, 13)
    for c in range(2):
        values = x[0, c].numpy()
        np.testing.assert_array_equal(actual[0, c], np.histogram(values[values < 1], 13, (0.0, 1.0))[0])


@pytest.mark.parametrize("size", SIZES)
def test_matching_equals_skimage(size: tuple[int, int]) -> None:
    source, template = photo(2, 3, *size), photo(2, 3, 50, 61).flip(0)
    actual = contrib.histogram_matching(source, template, True)
    for b in range(2):
        expected = exposure.match_histograms(
            to_bytes(source)[b].numpy(), to_bytes(template)[b].numpy(), channel_axis=0
        )
        # scikit-image truncates the result to bytes
        np.testing.assert_array_equal(np.floor(actual[b].double().numpy() * 255 + 1e-4), expected)
    expected = exposure.match_histograms(to_bytes(source).numpy(), to_bytes(template).numpy())
    np.testing.assert_allclose(contrib.histogram_matching(source, template) * 255, expected, atol=1e-4)


def test_matching_with_few_levels() -> None:
    source = torch.tensor([[0, 100, 100, 255, 7, 7]]) / 255
    template = torch.tensor([[30, 200, 200, 201]]) / 255
    expected = exposure.match_histograms(
        to_bytes(source).numpy().astype(float), to_bytes(template).numpy().astype(float)
    )
    np.testing.assert_allclose(contrib.histogram_matching(source, template) * 255, expected, atol=1e-4)


@pytest.mark.parametrize("knots", [1, 2, 7, 300])
def test_interp_equals_numpy(knots: int) -> None:
    generator = torch.Generator().manual_seed(knots)
    xp = torch.rand(knots, generator=generator, dtype=torch.float64).sort().values
    fp = torch.rand(knots, generator=generator, dtype=torch.float64)
    x = torch.cat([torch.linspace(-0.2, 1.2, 101, dtype=torch.float64), xp]).reshape(1, -1)
    x[0, 3] = torch.nan
    expected = np.interp(x.numpy(), xp.numpy(), fp.numpy())
    expected[0, 3] = np.nan  # NumPy's too, but for one knot
    np.testing.assert_allclose(contrib.interp(x, xp, fp), expected, atol=1e-12)
    with exporting("onnx"):
        np.testing.assert_allclose(contrib.interp(x, xp, fp), expected, atol=1e-12)


@pytest.mark.parametrize("size", [1, 2, 3, 16, 17])
def test_search_in_every_form(size: int) -> None:
    table = torch.tensor([[0.0, 1.0, 1.0, 2.0, 5.0] * 4])[:, :size].sort().values
    x = torch.tensor([[-1.0, 0.0, 0.5, 1.0, 2.0, 4.0, 5.0, 9.0]])
    expected = np.searchsorted(table[0], x[0], side="right") - 1
    np.testing.assert_array_equal(last_not_above(table, x)[0], expected)
    with exporting("native"):
        np.testing.assert_array_equal(last_not_above(table, x)[0], expected)


@pytest.mark.parametrize("dtype", [torch.int32, torch.float64])
def test_running_sum_in_every_form(dtype: torch.dtype) -> None:
    x = (torch.arange(3 * 2 * 256) * 37 % 101).reshape(3, 2, 256).to(dtype)
    expected = np.cumsum(x.numpy(), -1)
    np.testing.assert_array_equal(running_sum(x), expected)
    with exporting("native"):
        np.testing.assert_array_equal(running_sum(x), expected)
        assert running_sum(x).dtype == dtype


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float64])
@pytest.mark.parametrize("name", ["equalize", "autocontrast", "equalize_clahe"])
def test_dtype_is_kept(name: str, dtype: torch.dtype) -> None:
    result = getattr(enhance, name)(photo(1, 3, 20, 30, dtype))
    assert result.dtype == dtype
    if dtype != torch.bfloat16:  # bfloat16 cannot distinguish 256 levels
        torch.testing.assert_close(
            result.float(), getattr(enhance, name)(photo(1, 3, 20, 30)), atol=1e-3, rtol=0
        )


X = torch.zeros(2, 3, 16, 16)
BYTES = X.to(torch.uint8)
WRONG = [
    (lambda: enhance.equalize(BYTES.int()), TypeError, "input: expected a floating-point or uint8 tensor"),
    (lambda: enhance.equalize(X[0, 0, 0]), ValueError, r"input: expected shape \(B, C, H, W\)"),
    (lambda: enhance.equalize3d(X), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (
        lambda: enhance.autocontrast(X, 50.0),
        ValueError,
        r"cutoff: expected percentages .* got \(50.0, 50.0\)",
    ),
    (lambda: enhance.autocontrast(X, (-1.0, 0.0)), ValueError, "cutoff: expected percentages"),
    (lambda: enhance.clahe(X), TypeError, "image: expected dtype torch.uint8, got torch.float32"),
    (lambda: enhance.clahe(BYTES[0]), ValueError, r"image: expected shape \(B, C, H, W\)"),
    (
        lambda: enhance.clahe(BYTES, 2.0, (0, 8)),
        ValueError,
        "tile_grid_size: expected positive numbers, got 8 down and 0 across",
    ),
    (
        lambda: enhance.clahe(BYTES, 2.0, (8, 16)),
        ValueError,
        "image: expected more than 16 rows and 8 columns",
    ),
    (lambda: enhance.equalize_clahe(X[0, 0, 0]), ValueError, r"input: expected shape \(\*, H, W\)"),
    (lambda: enhance.equalize_clahe(X, 2.0, (-1, 8)), ValueError, "grid_size: expected positive numbers"),
    (lambda: enhance.count_histogram(X, 0), ValueError, "n_bins: expected a positive number, got 0"),
    (
        lambda: enhance.count_histogram(X, 4, 1.0, 1.0),
        ValueError,
        "max: expected a number above min = 1.0, got 1.0",
    ),
    (lambda: contrib.interp(X, X, X), ValueError, r"xp: expected shape \(N,\)"),
    (
        lambda: contrib.interp(X, X[0, 0, 0, :0], X[0, 0, 0, :0]),
        ValueError,
        "xp: expected at least one entry",
    ),
    (
        lambda: contrib.interp(X, X[0, 0, 0], X[0, 0, 0, 1:]),
        ValueError,
        r"fp: expected xp's shape \[16\], got \[15\]",
    ),
    (lambda: contrib.histogram_matching(X, BYTES), TypeError, "template: expected a floating-point tensor"),
    (lambda: contrib.histogram_matching(X[0, 0, 0], X), ValueError, r"source: expected shapes \(\*, H, W\)"),
    (lambda: contrib.histogram_matching(X, X[:0]), ValueError, "template: expected at least one plane"),
    (
        lambda: contrib.histogram_matching(X, X[0], True),
        ValueError,
        "template: expected source's leading dimensions",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
