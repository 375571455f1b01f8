"""The JPEG codec by its definition with SciPy's DCT, and against Pillow's."""

import io
from collections.abc import Callable

import numpy as np
import pytest
import torch
from photos import chw, hwc, photo
from PIL import Image
from scipy.fft import dctn, idctn
from torch import Tensor

from chiasm.enhance import jpeg_codec_differentiable

# fmt: off
LUMA = np.reshape([
    16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55,
    14, 13, 16, 24, 40, 57, 69, 56, 14, 17, 22, 29, 51, 87, 80, 62,
    18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113, 92,
    49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99,
], (8, 8))
# fmt: on


def by_pillow(x: Tensor, sample: int, quality: int) -> tuple[np.ndarray, dict]:
    file = io.BytesIO()
    Image.fromarray((hwc(x, sample) * 255).round().astype(np.uint8)).save(
        file, "JPEG", quality=quality, subsampling=2
    )
    image = Image.open(file)
    return chw(np.asarray(image)) / 255, image.quantization


def steps(table: np.ndarray, quality: float) -> np.ndarray:
    scale = 5000 / quality if quality < 50 else 200 - 2 * quality
    exact = table * scale / 100
    whole = np.floor(exact + 0.5)
    return np.clip(whole + (exact - whole) ** 3, 1, 255)


def coded(plane: np.ndarray, table: np.ndarray) -> np.ndarray:
    out = np.empty_like(plane)
    for i in range(0, plane.shape[0], 8):
        for j in range(0, plane.shape[1], 8):
            x = dctn(plane[i : i + 8, j : j + 8], norm="ortho") / table
            whole = np.floor(x + 0.5)
            out[i : i + 8, j : j + 8] = idctn((whole + (x - whole) ** 3) * table, norm="ortho")
    return out


def by_definition(x: np.ndarray, luma: np.ndarray, chroma: np.ndarray) -> np.ndarray:
    height, width = x.shape[1:]
    p = np.pad(x * 255, ((0, 0), (0, -height % 16), (0, -width % 16)), "edge")
    kr, kb = 0.299, 0.114
    y = kr * p[0] + (1 - kr - kb) * p[1] + kb * p[2]
    cb, cr = (p[2] - y) / (2 - 2 * kb), (p[0] - y) / (2 - 2 * kr)
    half = [c.reshape(c.shape[0] // 2, 2, c.shape[1] // 2, 2).mean((1, 3)) for c in (cb, cr)]
    cb, cr = (np.kron(coded(c, chroma), np.ones((2, 2))) for c in half)
    y = coded(y - 128, luma) + 128
    red, blue = y + (2 - 2 * kr) * cr, y + (2 - 2 * kb) * cb
    green = (y - kr * red - kb * blue) / (1 - kr - kb)
    return np.clip(np.stack([red, green, blue])[:, :height, :width] / 255, 0, 1)


@pytest.mark.parametrize("size", [(37, 53), (64, 32), (5, 100)])
def test_definition(size: tuple[int, int]) -> None:
    x = photo(2, 3, *size, torch.float64)
    generator = np.random.default_rng(3)
    luma, chroma = generator.uniform(5, 60, (2, 8, 8)), generator.uniform(5, 60, (8, 8))
    quality = torch.tensor([31.7, 77.3], dtype=torch.float64)
    actual = jpeg_codec_differentiable(x, quality, torch.from_numpy(luma), torch.from_numpy(chroma))
    for b in range(2):
        expected = by_definition(
            x[b].numpy(), steps(luma[b], float(quality[b])), steps(chroma, float(quality[b]))
        )
        # the constants of JFIF's conversion have nine digits
        np.testing.assert_allclose(actual[b], expected, atol=1e-6)


@pytest.mark.parametrize(("quality", "least"), [(10, 38), (50, 41), (90, 41)])
def test_close_to_pillow(quality: int, least: float) -> None:
    x = photo(3, 3, 101, 130)
    actual = jpeg_codec_differentiable(x, torch.tensor(float(quality))).numpy()
    for b in range(3):
        expected, tables = by_pillow(x, b, quality)
        np.testing.assert_allclose(np.sort(tables[0]), np.sort(np.floor(steps(LUMA, quality) + 0.5), None))
        psnr = -10 * np.log10(((actual[b] - expected) ** 2).mean())
        assert psnr > least
        loss, pillow_loss = (((image - x[b].numpy()) ** 2).mean() for image in (actual[b], expected))
        assert 0.8 < loss / pillow_loss < 1.1


def test_quality_of_each_sample() -> None:
    x = photo(1, 3, 40, 40).repeat(3, 1, 1, 1)
    loss = (jpeg_codec_differentiable(x, torch.tensor([20.0, 60.0, 95.0])) - x).square().mean((1, 2, 3))
    assert loss[0] > 1.5 * loss[1] > 2 * loss[2] > 0


def test_gradient_reaches_image_and_quality() -> None:
    x = photo(1, 3, 20, 24, torch.float64).requires_grad_(True)
    quality = torch.tensor([60.0], dtype=torch.float64, requires_grad=True)
    (jpeg_codec_differentiable(x, quality) - x.detach()).square().mean().backward()
    assert (x.grad != 0).all()
    assert quality.grad.item() != 0


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_half_precision(dtype: torch.dtype) -> None:
    x = photo(1, 3, 32, 32)
    result = jpeg_codec_differentiable(x.to(dtype), torch.tensor([50.0]))
    assert result.dtype == dtype
    assert (result.float() - jpeg_codec_differentiable(x, torch.tensor([50.0]))).abs().mean() < 0.03


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
@pytest.mark.parametrize("quality", [1.0, 3.0, 5.0, 7.5, 30.0])
def test_half_precision_of_low_quality(dtype: torch.dtype, quality: float) -> None:
    # A grey plane has one coefficient, 8 times the level: what is left of it is known, for libjpeg's step.
    grey = torch.full((1, 3, 16, 32), 0.25, dtype=dtype)
    step = steps(LUMA, quality)[0, 0]
    coefficient = 8 * (0.25 * 255 - 128) / step
    whole = np.floor(coefficient + 0.5)
    expected = max((whole + (coefficient - whole) ** 3) * step / 8 + 128, 0) / 255
    result = jpeg_codec_differentiable(grey, torch.tensor([quality], dtype=dtype))
    np.testing.assert_allclose(result.float(), expected, atol=0.02)


X = torch.zeros(2, 3, 16, 16)
Q = torch.tensor([50.0])
WRONG = [
    (lambda: jpeg_codec_differentiable(X[:, :1], Q), ValueError, r"input: expected shape \(\*, 3, H, W\)"),
    (lambda: jpeg_codec_differentiable(X[None], Q), ValueError, r"input: expected shape \(B, 3, H, W\)"),
    (
        lambda: jpeg_codec_differentiable(X, Q.int()),
        TypeError,
        "jpeg_quality: expected a floating-point tensor",
    ),
    (
        lambda: jpeg_codec_differentiable(X, torch.ones(3)),
        ValueError,
        r"jpeg_quality: expected .* \(2,\), got \[3\]",
    ),
    (
        lambda: jpeg_codec_differentiable(X, Q, torch.ones(8)),
        ValueError,
        r"quantization_table_y: expected shape \(8, 8\)",
    ),
    (
        lambda: jpeg_codec_differentiable(X, Q, None, torch.ones(3, 8, 8)),
        ValueError,
        r"quantization_table_c: expected .* \(2, 8, 8\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
