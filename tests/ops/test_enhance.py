"""Intensity changes against Pillow, OpenCV, scikit-image and NumPy."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import chw, hwc, photo
from PIL import Image, ImageEnhance, ImageOps
from skimage import exposure
from torch import Tensor

from chiasm import enhance

SIZES = [(37, 53), (64, 31), (3, 4)]
FACTORS = [0.0, 0.4, 1.0, 1.7]


def pil(x: Tensor, sample: int = 0) -> Image.Image:
    """One sample as a Pillow image; its levels are exact, because photographs have 256 levels."""
    return Image.fromarray(np.round(hwc(x, sample) * 255).astype(np.uint8))


def levels(image: Image.Image) -> np.ndarray:
    """The inverse of ``pil``, in [0, 1]."""
    return chw(np.asarray(image).astype(np.float64) / 255)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "enhancer"),
    [
        ("adjust_brightness_accumulative", ImageEnhance.Brightness),
        ("adjust_contrast", ImageEnhance.Brightness),  # Szeliski's contrast is Pillow's brightness
        ("adjust_contrast_with_mean_subtraction", ImageEnhance.Contrast),
        ("adjust_saturation_with_gray_subtraction", ImageEnhance.Color),
        ("sharpness", ImageEnhance.Sharpness),
    ],
)
def test_equals_pillow_but_for_its_rounding(
    name: str, enhancer: Callable, size: tuple[int, int], factor: float
) -> None:
    x = photo(2, 3, *size, torch.float64)
    function = getattr(enhance, name)
    actual = function(x, factor)
    for b in range(2):
        # Pillow rounds the degenerate image (an error that the factor amplifies) and truncates the result to
        # a level
        expected = levels(enhancer(pil(x, b)).enhance(factor))
        np.testing.assert_allclose(actual[b], expected, atol=(1.01 + 1.01 * abs(1 - factor)) / 255)
    both = function(x, torch.tensor([factor, 0.8], dtype=torch.float64))
    torch.testing.assert_close(both[0], actual[0], rtol=0, atol=1e-12)
    torch.testing.assert_close(both[1], function(x[1:], 0.8)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 5, 7])
@pytest.mark.parametrize("factor", FACTORS)
def test_contrast_of_any_channels(channels: int, factor: float) -> None:
    x = photo(3, channels, 9, 14, torch.float64)
    mean = x.numpy().mean((1, 2, 3), keepdims=True)
    expected = np.clip(mean + factor * (x.numpy() - mean), 0, 1)
    np.testing.assert_allclose(enhance.adjust_contrast_with_mean_subtraction(x, factor), expected, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 7])
def test_sharpness_by_definition(channels: int) -> None:
    x = photo(2, channels, 12, 15, torch.float64)
    kernel = np.array([[1, 1, 1], [1, 5, 1], [1, 1, 1]]) / 13
    actual = enhance.sharpness(x, torch.tensor([0.3, 2.5], dtype=torch.float64)).numpy()
    for b, factor in enumerate((0.3, 2.5)):
        for c in range(channels):
            plane = x[b, c].numpy()
            smooth = plane.copy()
            smooth[1:-1, 1:-1] = cv2.filter2D(plane, -1, kernel)[1:-1, 1:-1]
            np.testing.assert_allclose(
                actual[b, c], np.clip(smooth + factor * (plane - smooth), 0, 1), atol=1e-12
            )


@pytest.mark.parametrize("factor", [-0.4, 0.0, 0.3])
def test_brightness(factor: float) -> None:
    x = photo(2, 5, 8, 9, torch.float64)
    np.testing.assert_allclose(
        enhance.adjust_brightness(x, factor), np.clip(x.numpy() + factor, 0, 1), atol=1e-12
    )
    np.testing.assert_allclose(enhance.adjust_brightness(x, factor, False), x.numpy() + factor, atol=1e-12)
    np.testing.assert_allclose(
        enhance.adjust_brightness_accumulative(x, 3.0, False), x.numpy() * 3.0, atol=1e-12
    )
    np.testing.assert_allclose(enhance.adjust_contrast(x, 3.0, False), x.numpy() * 3.0, atol=1e-12)


@pytest.mark.parametrize("gamma", [0.0, 0.4, 1.0, 2.2])
def test_gamma_equals_skimage(gamma: float) -> None:
    x = photo(2, 3, 21, 17, torch.float64)
    x[..., 0] = 0.0
    expected = exposure.adjust_gamma(x.numpy(), gamma, 0.9)
    np.testing.assert_allclose(enhance.adjust_gamma(x, gamma, 0.9), np.clip(expected, 0, 1), atol=1e-12)
    each = enhance.adjust_gamma(
        x, torch.tensor([1.5, gamma], dtype=torch.float64), torch.tensor(0.9, dtype=torch.float64)
    )
    np.testing.assert_allclose(each[1], np.clip(expected[1], 0, 1), atol=1e-12)


def test_gamma_has_a_gradient_at_zero() -> None:
    x = torch.tensor([[0.0, 0.25]], requires_grad=True)
    gamma = torch.tensor([0.5], requires_grad=True)
    enhance.adjust_gamma(x, gamma).sum().backward()
    np.testing.assert_allclose(x.grad, [[0.0, 1.0]])
    np.testing.assert_allclose(gamma.grad, [0.5 * np.log(0.25)], rtol=1e-6)


@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("gain", [0.7, 1.4])
def test_log_and_sigmoid_equal_skimage(gain: float, inverse: bool) -> None:
    x = photo(2, 3, 21, 17, torch.float64)
    expected = exposure.adjust_log(x.numpy(), gain, inverse)
    np.testing.assert_allclose(enhance.adjust_log(x, gain, inverse, False), expected, atol=1e-12)
    np.testing.assert_allclose(enhance.adjust_log(x, gain, inverse), np.clip(expected, 0, 1), atol=1e-12)
    expected = exposure.adjust_sigmoid(x.numpy(), 0.4, 10 * gain, inverse)
    np.testing.assert_allclose(enhance.adjust_sigmoid(x, 0.4, 10 * gain, inverse), expected, atol=1e-12)


@pytest.mark.parametrize("bits", range(1, 9))
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_posterize_equals_pillow(bits: int, dtype: torch.dtype) -> None:
    x = torch.arange(256, dtype=dtype).reshape(1, 1, 16, 16).repeat(2, 3, 1, 1) / 255
    expected = levels(ImageOps.posterize(pil(x), bits))
    np.testing.assert_allclose(enhance.posterize(x, bits)[0], expected, atol=1e-7)
    each = enhance.posterize(x, torch.tensor([0, bits]))
    np.testing.assert_allclose(each[1], expected, atol=1e-7)
    assert not each[0].any()


@pytest.mark.parametrize("threshold", [0, 1, 100, 128, 256])
def test_solarize_and_invert_equal_pillow(threshold: int) -> None:
    x = photo(2, 3, 23, 18, torch.float64)
    for b in range(2):
        expected = levels(ImageOps.solarize(pil(x, b), threshold))
        np.testing.assert_allclose(enhance.solarize(x, threshold / 255)[b], expected, atol=1e-12)
        np.testing.assert_allclose(enhance.invert(x)[b], levels(ImageOps.invert(pil(x, b))), atol=1e-12)


def test_solarize_additions() -> None:
    x = photo(2, 1, 8, 9, torch.float64)
    actual = enhance.solarize(
        x, torch.tensor([0.5, 0.2], dtype=torch.float64), torch.tensor([0.3, -0.3], dtype=torch.float64)
    )
    for b, (limit, addition) in enumerate(((0.5, 0.3), (0.2, -0.3))):
        moved = np.clip(x[b].numpy() + addition, 0, 1)
        np.testing.assert_allclose(actual[b], np.where(moved < limit, moved, 1 - moved), atol=1e-12)


def test_invert_with_white() -> None:
    x = photo(2, 3, 4, 5, torch.float64)
    actual = enhance.invert(x, torch.tensor([1.0, 255.0], dtype=torch.float64)).numpy()
    np.testing.assert_allclose(actual, np.array([1.0, 255.0])[:, None, None, None] - x.numpy(), atol=1e-12)


CV_THRESHOLD = {
    "binary": cv2.THRESH_BINARY,
    "binary_inv": cv2.THRESH_BINARY_INV,
    "trunc": cv2.THRESH_TRUNC,
    "tozero": cv2.THRESH_TOZERO,
    "tozero_inv": cv2.THRESH_TOZERO_INV,
}


@pytest.mark.parametrize("kind", CV_THRESHOLD)
@pytest.mark.parametrize("thresh", [0.0, 128 / 255, 0.7])
def test_threshold_equals_opencv(kind: str, thresh: float) -> None:
    x = photo(2, 3, 23, 18)
    for b in range(2):
        expected = chw(cv2.threshold(hwc(x, b), thresh, 0.9, CV_THRESHOLD[kind])[1])
        np.testing.assert_allclose(enhance.threshold(x, thresh, 0.9, kind)[b], expected, atol=1e-7)
        each = enhance.threshold(x, torch.full([2], thresh), torch.tensor(0.9), kind)
        np.testing.assert_array_equal(each[b], enhance.threshold(x, thresh, 0.9, kind)[b])


@pytest.mark.parametrize("channels", [1, 3, 7])
def test_add_weighted_equals_opencv(channels: int) -> None:
    x, y = photo(2, channels, 23, 18), photo(2, channels, 23, 18).flip(0)
    for b in range(2):
        expected = cv2.addWeighted(x[b].numpy(), 0.3, y[b].numpy(), -0.6, 0.1)
        np.testing.assert_allclose(enhance.add_weighted(x, 0.3, y, -0.6, 0.1)[b], expected, atol=1e-6)
    actual = enhance.add_weighted(x, torch.tensor([0.3, 1.0]), y, torch.tensor(-0.6), x)
    np.testing.assert_allclose(actual[0], 1.3 * x[0].numpy() - 0.6 * y[0].numpy(), atol=1e-6)


def test_shift_rgb() -> None:
    x = photo(2, 3, 9, 7, torch.float64)
    shifts = torch.tensor([[0.3, -0.2], [0.0, 0.5], [-0.6, 0.1]], dtype=torch.float64)
    expected = np.clip(x.numpy() + shifts.numpy().T[:, :, None, None], 0, 1)
    np.testing.assert_allclose(enhance.shift_rgb(x, shifts[0], shifts[1], shifts[2]), expected, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_denormalize(channels: int) -> None:
    x = photo(2, channels, 7, 9, torch.float64)
    mean = torch.linspace(0.1, 0.8, 2 * channels, dtype=torch.float64).reshape(2, channels)
    std = torch.linspace(0.5, 0.9, 2 * channels, dtype=torch.float64).reshape(2, channels)
    expected = x.numpy() * std.numpy()[:, :, None, None] + mean.numpy()[:, :, None, None]
    np.testing.assert_allclose(enhance.denormalize(x, mean, std), expected, atol=1e-12)
    torch.testing.assert_close(enhance.denormalize(enhance.normalize(x, mean, std), mean, std), x)
    np.testing.assert_allclose(enhance.denormalize(x, 0.5, 2.0), x.numpy() * 2 + 0.5, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_min_max_equals_opencv(channels: int) -> None:
    x = photo(2, channels, 17, 23)
    actual = enhance.normalize_min_max(x, -1.0, 3.0, eps=0.0)
    for b in range(2):
        for c in range(channels):
            expected = cv2.normalize(x[b, c].numpy(), None, -1.0, 3.0, cv2.NORM_MINMAX)
            np.testing.assert_allclose(actual[b, c], expected, atol=2e-6)
    assert (enhance.normalize_min_max(torch.ones(1, 1, 2, 2)) == 0).all()


@pytest.mark.parametrize("size", SIZES)
def test_integral_equals_opencv(size: tuple[int, int]) -> None:
    x = photo(2, 3, *size, torch.float64)
    actual = enhance.integral_image(x)
    for b in range(2):
        np.testing.assert_allclose(actual[b], chw(cv2.integral(hwc(x, b)))[:, 1:, 1:], rtol=1e-12)
    np.testing.assert_allclose(enhance.integral_tensor(x), np.cumsum(x.numpy(), -1), rtol=1e-12)
    np.testing.assert_allclose(
        enhance.integral_tensor(x, (0, 2)), np.cumsum(np.cumsum(x.numpy(), 0), 2), rtol=1e-12
    )


IMAGE_OPS = [
    lambda x: enhance.adjust_brightness(x, 0.1),
    lambda x: enhance.adjust_contrast_with_mean_subtraction(x, 0.8),
    lambda x: enhance.adjust_saturation_with_gray_subtraction(x, 0.8),
    lambda x: enhance.adjust_gamma(x, 0.8, 0.9),
    enhance.adjust_log,
    enhance.adjust_sigmoid,
    enhance.normalize_min_max,
    enhance.invert,
    enhance.solarize,
    lambda x: enhance.sharpness(x, 1.5),
    lambda x: enhance.posterize(x, 4),
    lambda x: enhance.threshold(x, 0.5, 1.0, "tozero"),
]


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
@pytest.mark.parametrize("index", range(len(IMAGE_OPS)))
def test_half_precision(index: int, dtype: torch.dtype) -> None:
    x = torch.linspace(0.02, 0.93, 2 * 3 * 5 * 7).reshape(2, 3, 5, 7).to(dtype)
    result = IMAGE_OPS[index](x)
    assert result.dtype == dtype
    torch.testing.assert_close(result.double(), IMAGE_OPS[index](x.double()), atol=4e-2, rtol=2e-2)


X = torch.zeros(2, 3, 8, 8)
BYTES = X.to(torch.uint8)
WRONG = [
    (
        lambda: enhance.adjust_brightness(BYTES.int(), 0.1),
        TypeError,
        "image: expected a floating-point or uint8",
    ),
    (
        lambda: enhance.adjust_contrast(X, torch.ones(3)),
        ValueError,
        r"factor: expected a number, .* got \[3\]",
    ),
    (
        lambda: enhance.adjust_gamma(X, 1.0, torch.ones(2, 1)),
        ValueError,
        r"gain: expected a number, .* got \[2, 1\]",
    ),
    (
        lambda: enhance.adjust_contrast_with_mean_subtraction(X[0, 0], 1.0),
        ValueError,
        r"image: expected shape \(\*, C, H, W\)",
    ),
    (
        lambda: enhance.adjust_saturation_with_gray_subtraction(X[:, :2], 1.0),
        ValueError,
        r"image: expected shape \(\*, 3, H, W\)",
    ),
    (lambda: enhance.add_weighted(X, 1.0, X[0], 1.0, 0.0), ValueError, "src2: expected src1's shape"),
    (
        lambda: enhance.shift_rgb(X, X[0, 0, 0], X[:, 0, 0, 0], X[:, 0, 0, 0]),
        ValueError,
        r"r_shift: .* got \[8\]",
    ),
    (lambda: enhance.posterize(X, 9), ValueError, "bits: expected 0 to 8, got 9"),
    (lambda: enhance.posterize(X, torch.ones(2)), TypeError, "bits: expected an integer tensor"),
    (lambda: enhance.threshold(X, 0.5, 1.0, "otsu"), ValueError, "type: expected one of .*'otsu'"),
    (lambda: enhance.sharpness(X[:, :, :2], 1.0), ValueError, "input: expected H and W of at least 3"),
    (lambda: enhance.integral_image(X[0, 0, 0]), ValueError, r"image: expected shape \(\*, H, W\)"),
    (
        lambda: enhance.integral_tensor(X, [4]),
        ValueError,
        "dim: expected dimensions of a tensor with 4, got 4",
    ),
    (lambda: enhance.integral_tensor(X, []), ValueError, "dim: expected at least one dimension"),
    (lambda: enhance.normalize_min_max(X[0, 0, 0]), ValueError, r"input: expected shape \(\*, H, W\)"),
    (lambda: enhance.denormalize(X[0, 0, 0], 0.0, 1.0), ValueError, r"data: expected shape \(B, C, \*\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_half_precision_is_float32_rounded_once(dtype: torch.dtype) -> None:
    x = torch.rand(2, 2, 300, 300, generator=torch.Generator().manual_seed(3)).to(dtype)
    x[0, 0] = 0.5
    cases: list[Callable[[Tensor], Tensor]] = [
        enhance.normalize_min_max,
        lambda x: enhance.normalize_min_max(60000.0 * (2.0 * x - 1.0), -1.0, 2.0),
        lambda x: enhance.equalize_clahe(x, 2.0, (1, 1), slow_and_differentiable=True),  # 90000 pixels a tile
    ]
    for case in cases:
        out = case(x)
        assert out.dtype == dtype
        assert out.isfinite().all()
    assert torch.equal(cases[0](x), cases[0](x.float()).to(dtype))
    assert torch.equal(cases[2](x), cases[2](x.float()).to(dtype))
    assert not enhance.normalize_min_max(x)[0, 0].any()
