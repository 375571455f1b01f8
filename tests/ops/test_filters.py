"""Filters against OpenCV and SciPy, in every border mode."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import chw, hwc, photo
from torch import Tensor

from chiasm.filters import (
    BilateralBlur,
    GaussianBlur2d,
    MedianBlur,
    Sobel,
    bilateral_blur,
    gaussian_blur2d,
    get_gaussian_kernel1d,
    median_blur,
    sobel,
    spatial_gradient,
)

SHAPES = [(1, 1, 37, 53), (2, 3, 64, 31), (3, 5, 19, 20)]
CV_BORDER = {
    "reflect": cv2.BORDER_REFLECT_101,
    "replicate": cv2.BORDER_REPLICATE,
    "constant": cv2.BORDER_CONSTANT,
}
SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}
NUMPY_MODE = {"reflect": "reflect", "replicate": "edge", "circular": "wrap", "constant": "constant"}


def per_plane(x: Tensor, function: object) -> np.ndarray:
    planes = x.numpy().reshape(-1, *x.shape[2:])
    return np.stack([function(p) for p in planes]).reshape(x.shape)


@pytest.mark.parametrize("size", [1, 3, 5, 31])
@pytest.mark.parametrize("sigma", [0.3, 1.0, 4.0])
def test_gaussian_kernel_equals_opencv(size: int, sigma: float) -> None:
    actual = get_gaussian_kernel1d(size, sigma, dtype=torch.float64)
    np.testing.assert_allclose(actual[0], cv2.getGaussianKernel(size, sigma)[:, 0], atol=1e-12)
    batch = get_gaussian_kernel1d(size, torch.tensor([sigma, 2 * sigma], dtype=torch.float64))
    np.testing.assert_allclose(batch[1], cv2.getGaussianKernel(size, 2 * sigma)[:, 0], atol=1e-12)


def test_even_gaussian_kernel_is_symmetric() -> None:
    kernel = get_gaussian_kernel1d(4, 1.0, force_even=True)[0]
    assert torch.equal(kernel, kernel.flip(0))


@pytest.mark.parametrize("border", CV_BORDER)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("separable", [True, False])
def test_gaussian_equals_opencv(shape: tuple[int, ...], border: str, separable: bool) -> None:
    x = photo(*shape)
    actual = gaussian_blur2d(x, (7, 5), (1.3, 0.8), border, separable)
    for b in range(shape[0]):
        expected = cv2.GaussianBlur(hwc(x, b), (5, 7), sigmaX=0.8, sigmaY=1.3, borderType=CV_BORDER[border])
        np.testing.assert_allclose(actual[b], chw(expected), atol=1e-6)


@pytest.mark.parametrize("border", SCIPY_MODE)
def test_gaussian_per_sample_sigma_equals_scipy(border: str) -> None:
    x = photo(3, 2, 21, 18, torch.float64)
    sigma = torch.tensor([[0.5, 1.0], [1.5, 0.7], [2.0, 2.0]], dtype=torch.float64)
    actual = gaussian_blur2d(x, (5, 7), sigma, border)
    for b in range(3):
        expected = x[b].numpy()
        for axis, size in ((1, 5), (2, 7)):
            taps = cv2.getGaussianKernel(size, float(sigma[b, axis - 1]))[:, 0]
            expected = ndi.correlate1d(expected, taps, axis=axis, mode=SCIPY_MODE[border])
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("normalized", [True, False])
def test_sobel_equals_opencv(shape: tuple[int, ...], normalized: bool) -> None:
    x = photo(*shape)
    scale = 1 / 8 if normalized else 1.0
    magnitude, gradient = sobel(x, normalized, 0.0), spatial_gradient(x, normalized=normalized)
    for b in range(shape[0]):
        dx, dy = (
            chw(cv2.Sobel(hwc(x, b), cv2.CV_32F, i, 1 - i, scale=scale, borderType=cv2.BORDER_REPLICATE))
            for i in (1, 0)
        )
        np.testing.assert_allclose(gradient[b, :, 0], dx, atol=2e-6)
        np.testing.assert_allclose(gradient[b, :, 1], dy, atol=2e-6)
        np.testing.assert_allclose(magnitude[b], np.hypot(dx, dy), atol=2e-6)


def test_sobel_eps_keeps_the_gradient_finite() -> None:
    x = torch.full((1, 1, 5, 5), 0.5, requires_grad=True)
    Sobel()(x).sum().backward()
    assert torch.isfinite(x.grad).all()


SECOND_DIFF = (
    np.array([[0, 0, 0], [1, -2, 1], [0, 0, 0]]),
    np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]]) / 4,
    np.array([[0, 1, 0], [0, -2, 0], [0, 1, 0]]),
)


def test_second_derivatives() -> None:
    x = photo(2, 3, 17, 22, torch.float64)
    actual = spatial_gradient(x, "diff", 2)
    for k, kernel in enumerate(SECOND_DIFF):
        expected = per_plane(x, lambda p, kernel=kernel: ndi.correlate(p, kernel, mode="nearest"))
        np.testing.assert_allclose(actual[:, :, k], expected, atol=1e-12)
    actual = spatial_gradient(x, "sobel", 2)
    for k, (dx, dy) in enumerate(((2, 0), (1, 1), (0, 2))):
        expected = per_plane(
            x,
            lambda p, dx=dx, dy=dy: cv2.Sobel(
                p, cv2.CV_64F, dx, dy, ksize=5, borderType=cv2.BORDER_REPLICATE
            ),
        )
        np.testing.assert_allclose(actual[:, :, k], expected / 64, atol=1e-12)


@pytest.mark.parametrize("mode", ["sobel", "diff"])
def test_second_derivatives_of_a_quadric_are_exact(mode: str) -> None:
    y, x = torch.meshgrid(torch.arange(9.0), torch.arange(11.0), indexing="ij")
    quadric = 3 * x * x + 5 * x * y - 7 * y * y + 2 * x - y
    second = spatial_gradient(quadric[None, None], mode, 2)[0, 0, :, 2:-2, 2:-2]
    assert second.eq(torch.tensor([6.0, 5.0, -14.0])[:, None, None]).all()


def test_central_difference_equals_numpy() -> None:
    x = photo(1, 1, 9, 12, torch.float64)
    dy, dx = np.gradient(x[0, 0].numpy())
    actual = spatial_gradient(x, "diff")[0, 0, :, 1:-1, 1:-1]
    np.testing.assert_allclose(actual, np.stack([dx, dy])[:, 1:-1, 1:-1], atol=1e-12)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(3, 3), (5, 5), (7, 7), (3, 5), (7, 1), (1, 3)])
def test_median_equals_scipy(size: tuple[int, int], border: str) -> None:
    x = photo(2, 3, 19, 23)
    expected = per_plane(x, lambda p: ndi.median_filter(p, size, mode=SCIPY_MODE[border]))
    np.testing.assert_array_equal(median_blur(x, size, border), expected)


@pytest.mark.parametrize("size", [3, 5])
def test_median_equals_opencv(size: int) -> None:
    x = photo(1, 3, 41, 30)
    np.testing.assert_array_equal(MedianBlur(size, "replicate")(x)[0], chw(cv2.medianBlur(hwc(x), size)))


def bilateral_by_definition(
    x: np.ndarray, size: int, color: float, space: float, border: str, distance: str
) -> np.ndarray:
    r = size // 2
    p = np.pad(x, ((0, 0), (r, r), (r, r)), NUMPY_MODE[border])
    out = np.empty_like(x)
    grid = np.arange(-r, r + 1)
    closeness = np.exp(-(grid[:, None] ** 2 + grid[None, :] ** 2) / (2 * space**2))
    for i in range(x.shape[1]):
        for j in range(x.shape[2]):
            window = p[:, i : i + size, j : j + size]
            difference = window - x[:, i : i + 1, j : j + 1]
            squared = np.abs(difference).sum(0) ** 2 if distance == "l1" else (difference**2).sum(0)
            weight = closeness * np.exp(-squared / (2 * color**2))
            out[:, i, j] = (window * weight).sum((1, 2)) / weight.sum()
    return out


@pytest.mark.parametrize("border", NUMPY_MODE)
@pytest.mark.parametrize("distance", ["l1", "l2"])
@pytest.mark.parametrize("channels", [1, 3, 5])
def test_bilateral_by_definition(border: str, distance: str, channels: int) -> None:
    x = photo(2, channels, 12, 15, torch.float64)
    actual = bilateral_blur(x, 5, 0.1, (1.5, 1.5), border, distance)
    for b in range(2):
        expected = bilateral_by_definition(x[b].numpy(), 5, 0.1, 1.5, border, distance)
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3])
def test_bilateral_equals_opencv_on_the_disc(channels: int) -> None:
    # OpenCV's 3x3 window is the disc of radius 1; with a narrow sigma, the corners that it omits have no
    # weight.
    x = photo(1, channels, 25, 31)
    expected = cv2.bilateralFilter(hwc(x), 3, 0.2, 0.2, borderType=cv2.BORDER_REFLECT_101)
    np.testing.assert_allclose(BilateralBlur(3, 0.2, (0.2, 0.2))(x)[0], chw(expected), atol=1e-4)


def test_module_classes() -> None:
    x = photo(2, 3, 20, 20)
    chain = torch.nn.Sequential(GaussianBlur2d((3, 3), (1.0, 1.0)), MedianBlur(3), Sobel())
    expected = sobel(median_blur(gaussian_blur2d(x, (3, 3), (1.0, 1.0)), 3))
    assert torch.equal(chain(x), expected)
    assert torch.equal(torch.jit.script(chain)(x), expected)
