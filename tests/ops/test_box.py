"""Box blur, Laplacian, unsharp mask and difference of Gaussians against OpenCV, SciPy and scikit-image."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import skimage.filters
import torch
from borders import CV_BORDER, SCIPY_MODE, SHAPES, per_plane
from photos import chw, hwc, photo

from chiasm.filters import box_blur, difference_of_gaussians, get_laplacian_kernel2d, laplacian, unsharp_mask
from chiasm.primitives.core.target import exporting

X = torch.zeros(2, 3, 8, 9)


@pytest.mark.parametrize("border", CV_BORDER)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("size", [(3, 3), (5, 7), (1, 3)])
def test_box_equals_opencv(shape: tuple[int, ...], border: str, size: tuple[int, int]) -> None:
    x = photo(*shape)
    actual = box_blur(x, size, border)
    for b in range(shape[0]):
        expected = np.stack([cv2.blur(p.numpy(), size[::-1], borderType=CV_BORDER[border]) for p in x[b]])
        np.testing.assert_allclose(actual[b], expected, atol=1e-6)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [3, 8, 11, (4, 5)])
@pytest.mark.parametrize("separable", [True, False])
def test_box_equals_scipy(border: str, size: int | tuple[int, int], separable: bool) -> None:
    x = photo(2, 2, 21, 18, torch.float64)
    ky, kx = (size, size) if isinstance(size, int) else size
    origin = [(ky - 1) // 2 - ky // 2, (kx - 1) // 2 - kx // 2]
    expected = per_plane(x, lambda p: ndi.uniform_filter(p, (ky, kx), mode=SCIPY_MODE[border], origin=origin))
    np.testing.assert_allclose(box_blur(x, size, border, separable), expected, atol=1e-12)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(3, 3), (5, 7), (1, 3)])
def test_laplacian_equals_scipy(border: str, size: tuple[int, int]) -> None:
    x = photo(2, 7, 17, 20, torch.float64)
    kernel = np.ones(size)
    kernel[size[0] // 2, size[1] // 2] = 1 - kernel.size
    for normalized in (True, False):
        taps = kernel / np.abs(kernel).sum() if normalized else kernel
        expected = per_plane(x, lambda p, taps=taps: ndi.correlate(p, taps, mode=SCIPY_MODE[border]))
        np.testing.assert_allclose(laplacian(x, size, border, normalized), expected, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_laplacian_equals_opencv_with_its_kernel(shape: tuple[int, ...]) -> None:
    x, kernel = photo(*shape), get_laplacian_kernel2d(3).numpy()
    actual = laplacian(x, 3, "replicate", normalized=False)
    expected = per_plane(x, lambda p: cv2.filter2D(p, -1, kernel, borderType=cv2.BORDER_REPLICATE))
    np.testing.assert_allclose(actual, expected, atol=1e-5)


@pytest.mark.parametrize("border", CV_BORDER)
def test_unsharp_equals_opencv(border: str) -> None:
    x = photo(2, 3, 29, 34)
    actual = unsharp_mask(x, (5, 7), (1.2, 2.0), border)
    for b in range(2):
        blurred = cv2.GaussianBlur(hwc(x, b), (7, 5), sigmaX=2.0, sigmaY=1.2, borderType=CV_BORDER[border])
        np.testing.assert_allclose(
            actual[b], chw(cv2.addWeighted(hwc(x, b), 2.0, blurred, -1.0, 0.0)), atol=2e-6
        )


@pytest.mark.parametrize("border", SCIPY_MODE)
def test_unsharp_in_native_form_and_every_border(border: str) -> None:
    x = photo(2, 3, 19, 18, torch.float64)
    expected = unsharp_mask(x, (5, 7), torch.tensor([[1.2, 2.0]], dtype=torch.float64), border)
    for target in ("eager", "onnx", "native"):
        with exporting(target):
            torch.testing.assert_close(
                unsharp_mask(x, (5, 7), (1.2, 2.0), border), expected, rtol=1e-12, atol=1e-12
            )


def test_unsharp_equals_scikit_image_within_the_border() -> None:
    # scikit-image repeats the edge pixel, chiasm reflects about it, so pixels within the kernel's radius of
    # the border are not compared.
    x, sigma = photo(2, 1, 40, 37, torch.float64), 1.5
    radius = int(4 * sigma + 0.5)
    sigmas = torch.tensor([[sigma, sigma]], dtype=torch.float64)
    actual = unsharp_mask(x, 2 * radius + 1, sigmas)[..., radius:-radius, radius:-radius]
    expected = per_plane(
        x, lambda p: skimage.filters.unsharp_mask(p, radius=sigma, amount=1, preserve_range=True)
    )
    np.testing.assert_allclose(actual, expected[..., radius:-radius, radius:-radius], atol=1e-12)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("sigmas", [(1.0, None), (0.7, 2.3)])
def test_difference_of_gaussians_equals_scikit_image(border: str, sigmas: tuple[float, float | None]) -> None:
    x = photo(2, 3, 33, 30, torch.float64)
    actual = difference_of_gaussians(x, sigmas[0], sigmas[1], border)
    for b in range(2):
        expected = skimage.filters.difference_of_gaussians(
            x[b].numpy(), *sigmas, mode=SCIPY_MODE[border], channel_axis=0
        )
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


WRONG = [
    (lambda: box_blur(X[0], 3), ValueError, "input: expected shape"),
    (lambda: box_blur(X.int(), 3), TypeError, "input: expected a floating-point"),
    (lambda: box_blur(X, (3, 0)), ValueError, r"kernel_size: expected positive sizes, got \(3, 0\)"),
    (lambda: box_blur(X, 3, "mirror"), ValueError, "border_type: expected one of"),
    (lambda: laplacian(X, 4), ValueError, r"kernel_size: expected odd .* got \(4, 4\)"),
    (lambda: laplacian(X, 1), ValueError, r"kernel_size: expected more than one pixel, got \(1, 1\)"),
    (lambda: unsharp_mask(X[0], 3, (1.0, 1.0)), ValueError, "input: expected shape"),
    (lambda: unsharp_mask(X, 3, torch.ones(3)), ValueError, "sigma: expected shape"),
    (lambda: difference_of_gaussians(X, 2.0, 1.0), ValueError, "high_sigma: expected .* got 2.0 and 1.0"),
    (lambda: difference_of_gaussians(X, 2.0, 1e30), ValueError, "sigma: .* at most 65535 taps, got 8000000"),
    (lambda: difference_of_gaussians(X, 0.0), ValueError, "high_sigma: expected 0 < low_sigma"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
