"""Filter taps against OpenCV, SciPy and NumPy; the motion filters against a rotated line."""

import math
from typing import List

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import scipy.special
import scipy.stats
import torch
from borders import CV_BORDER, per_plane
from photos import photo
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm import filters
from chiasm.filters import (
    gabor,
    gaussian,
    get_binary_kernel2d,
    get_box_kernel1d,
    get_box_kernel2d,
    get_diff_kernel2d,
    get_gabor_kernel2d,
    get_gaussian_discrete_kernel1d,
    get_gaussian_erf_kernel1d,
    get_gaussian_kernel1d,
    get_gaussian_kernel2d,
    get_gaussian_kernel3d,
    get_hanning_kernel1d,
    get_hanning_kernel2d,
    get_laplacian_kernel1d,
    get_laplacian_kernel2d,
    get_motion_kernel2d,
    get_motion_kernel3d,
    get_sobel_kernel2d,
    get_spatial_gradient_kernel2d,
    get_spatial_gradient_kernel3d,
    laplacian_1d,
    motion_blur,
    motion_blur3d,
)

SIGMAS = torch.tensor([0.3, 0.8, 2.0, 4.5], dtype=torch.float64)


def unit_sum(weights: np.ndarray) -> np.ndarray:
    return weights / weights.sum()


@pytest.mark.parametrize("size", [1, 3, 4, 7])
def test_gaussian_equals_the_normal_density(size: int) -> None:
    middle = (size - 1) / 2
    means = torch.tensor([0.2, 1.0, size / 2, size + 1.0], dtype=torch.float64)
    centred, shifted = gaussian(size, SIGMAS), gaussian(size, SIGMAS, means)
    for k, (sigma, mean) in enumerate(zip(SIGMAS.tolist(), means.tolist(), strict=True)):
        density = unit_sum(scipy.stats.norm.pdf(np.arange(size), middle, sigma))
        np.testing.assert_allclose(centred[k], density, atol=1e-14)
        moved = mean - 0.5 if size % 2 == 0 else mean
        log = scipy.stats.norm.logpdf(np.arange(size), moved, sigma)
        np.testing.assert_allclose(shifted[k], unit_sum(np.exp(log - log.max())), atol=1e-9)


@pytest.mark.parametrize("size", [1, 5, 6, 11])
def test_erf_equals_the_integrated_density(size: int) -> None:
    actual = get_gaussian_erf_kernel1d(size, SIGMAS, force_even=True)
    edges = np.arange(size + 1) - size / 2
    for k, sigma in enumerate(SIGMAS.tolist()):
        np.testing.assert_allclose(
            actual[k], unit_sum(np.diff(scipy.stats.norm.cdf(edges, 0.0, sigma))), atol=1e-14
        )


@pytest.mark.parametrize("size", [1, 3, 7, 21, 61])
def test_discrete_equals_bessel_functions(size: int) -> None:
    sigmas = torch.cat([SIGMAS, torch.tensor([1e-3, 9.0], dtype=torch.float64)])
    orders = np.abs(np.arange(size) - size // 2)
    for dtype, tolerance in ((torch.float64, 1e-8), (torch.float32, 1e-6)):
        actual = get_gaussian_discrete_kernel1d(size, sigmas.to(dtype)[:, None])
        assert actual.dtype == dtype
        for k, sigma in enumerate(sigmas.tolist()):
            np.testing.assert_allclose(
                actual[k], unit_sum(scipy.special.ive(orders, sigma**2)), atol=tolerance
            )


def test_gaussians_of_more_dimensions_are_products() -> None:
    sigma = torch.tensor([[0.7, 1.5, 2.5], [1.0, 0.4, 3.0]], dtype=torch.float64)
    plane, volume = (
        get_gaussian_kernel2d((5, 3), sigma[:, :2]),
        get_gaussian_kernel3d((3, 4, 5), sigma, force_even=True),
    )
    for b in range(2):
        z, y, x = sigma[b].tolist()
        expected = np.outer(cv2.getGaussianKernel(5, z), cv2.getGaussianKernel(3, y))
        np.testing.assert_allclose(plane[b], expected, atol=1e-14)
        # OpenCV's even kernels do not follow its formula.
        even = unit_sum(scipy.stats.norm.pdf(np.arange(4), 1.5, y))
        taps = [cv2.getGaussianKernel(3, z)[:, 0], even, cv2.getGaussianKernel(5, x)[:, 0]]
        np.testing.assert_allclose(volume[b], np.einsum("i,j,k->ijk", *taps), atol=1e-14)
    numbers = get_gaussian_kernel2d((5, 3), (0.7, 1.5), dtype=torch.float64)
    assert torch.equal(numbers, plane[:1])
    assert torch.equal(get_gaussian_kernel3d((3, 4, 5), (0.7, 1.5, 2.5), True, torch.float64), volume[:1])


def test_kernels_of_numbers() -> None:
    np.testing.assert_array_equal(get_box_kernel1d(4), np.full((1, 4), 0.25))
    np.testing.assert_array_equal(get_box_kernel2d((2, 4)), np.full((1, 2, 4), 0.125))
    np.testing.assert_allclose(get_hanning_kernel1d(9, dtype=torch.float64), np.hanning(9), atol=1e-15)
    np.testing.assert_allclose(
        get_hanning_kernel2d((5, 8), dtype=torch.float64), np.outer(np.hanning(5), np.hanning(8)), atol=1e-15
    )
    assert get_laplacian_kernel2d((3, 5)).sum() == 0
    assert get_laplacian_kernel2d((3, 5))[1, 2] == -14
    np.testing.assert_array_equal(laplacian_1d(3), cv2.getDerivKernels(2, 0, 3)[0][:, 0])
    assert torch.equal(get_laplacian_kernel1d(5), laplacian_1d(5))
    binary = get_binary_kernel2d((2, 3))
    assert binary.shape == (6, 1, 2, 3)
    np.testing.assert_array_equal(binary.reshape(6, 6), np.eye(6))


def opencv_derivative(dx: int, dy: int, size: int) -> np.ndarray:
    along_x, along_y = cv2.getDerivKernels(dx, dy, size)
    return along_y @ along_x.T


def test_sobel_kernels_equal_opencv() -> None:
    first = np.stack([opencv_derivative(1, 0, 3), opencv_derivative(0, 1, 3)])
    np.testing.assert_array_equal(get_sobel_kernel2d(), first)
    np.testing.assert_array_equal(get_spatial_gradient_kernel2d("sobel", 1), first)
    second = np.stack([opencv_derivative(2, 0, 5), opencv_derivative(1, 1, 5), opencv_derivative(0, 2, 5)])
    np.testing.assert_array_equal(get_spatial_gradient_kernel2d("sobel", 2), second)


@pytest.mark.parametrize("order", [1, 2])
def test_difference_kernels_differentiate_polynomials(order: int) -> None:
    # On a quadric, central differences are exact, except for the factors that the kernels omit.
    y, x = np.mgrid[-1:2, -1:2].astype(float)
    image = 3 * x + 5 * y + 7 * x * x + 11 * y * y + 13 * x * y
    expected = [2 * 3, 2 * 5] if order == 1 else [2 * 7, 4 * 13, 2 * 11]
    kernels = get_spatial_gradient_kernel2d("diff", order, dtype=torch.float64).numpy()
    np.testing.assert_allclose((kernels * image).sum((1, 2)), expected)
    if order == 1:
        np.testing.assert_array_equal(get_diff_kernel2d(), kernels)


@pytest.mark.parametrize("order", [1, 2])
def test_3d_kernels_differentiate_polynomials(order: int) -> None:
    z, y, x = np.mgrid[-1:2, -1:2, -1:2].astype(float)
    volume = (
        2 * x + 3 * y + 5 * z + 7 * x * x + 11 * y * y + 13 * z * z + 17 * x * y + 19 * y * z + 23 * x * z
    )
    expected = [2, 3, 5] if order == 1 else [14, 22, 26, 4 * 17, 4 * 19, 4 * 23]
    kernels = get_spatial_gradient_kernel3d("diff", order, dtype=torch.float64).numpy()
    assert kernels.shape[1:] == (1, 3, 3, 3)
    np.testing.assert_allclose((kernels * volume).sum((1, 2, 3, 4)), expected)


@pytest.mark.parametrize("size", [(7, 7), (9, 5), (1, 3)])
def test_gabor_kernel_equals_opencv(size: tuple[int, int]) -> None:
    values = torch.tensor(
        [[2.0, 0.3, 4.0, 0.5, 0.0], [1.5, -1.2, 6.5, 1.2, 1.0], [3.0, 2.5, 3.0, 0.7, math.pi / 2]],
        dtype=torch.float64,
    )
    batch = get_gabor_kernel2d(size, *values.unbind(1))
    for b, (sigma, theta, wavelength, gamma, psi) in enumerate(values.tolist()):
        expected = cv2.getGaborKernel(size[::-1], sigma, theta, wavelength, gamma, psi, cv2.CV_64F)
        np.testing.assert_allclose(batch[b], expected, atol=1e-14)
        numbers = get_gabor_kernel2d(size, sigma, theta, wavelength, gamma, psi, torch.float64)
        np.testing.assert_allclose(numbers[0], expected, atol=1e-14)


@pytest.mark.parametrize("border", CV_BORDER)
def test_gabor_equals_opencv(border: str) -> None:
    x, theta = photo(2, 5, 23, 30, torch.float64), torch.tensor([0.4, 2.0], dtype=torch.float64)
    actual = gabor(x, (9, 7), 2.0, theta, 5.0, border_type=border)
    for b in range(2):
        kernel = cv2.getGaborKernel((7, 9), 2.0, float(theta[b]), 5.0, 0.5, 0.0, cv2.CV_64F)
        expected = np.stack([cv2.filter2D(p.numpy(), -1, kernel, borderType=CV_BORDER[border]) for p in x[b]])
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


def rotated_line(size: int, rotation: np.ndarray, direction: float, order: int) -> np.ndarray:
    """The line along the last axis, resampled at rotation.T @ position (both relative to the centre), by
    SciPy."""
    axes = rotation.shape[0]
    line = np.zeros([size] * axes)
    start = (direction + 1) / 2
    line[(size // 2,) * (axes - 1)] = start + (1 - 2 * start) * np.arange(size) / (size - 1)
    middle = np.full(axes, size // 2)
    inverse = rotation.T
    return unit_sum(
        ndi.affine_transform(line, inverse, middle - inverse @ middle, order=order, mode="grid-constant")
    )


# Angles at which no two pixels are equally near.
ANGLES = [0.0, 17.0, 45.0, 90.0, 118.0, -73.0, 200.0]


@pytest.mark.parametrize("size", [3, 5, 9])
@pytest.mark.parametrize(("mode", "order"), [("nearest", 0), ("bilinear", 1)])
def test_motion_kernel_is_a_rotated_line(size: int, mode: str, order: int) -> None:
    angles = torch.tensor(ANGLES, dtype=torch.float64)
    directions = torch.linspace(-1.0, 1.0, len(ANGLES), dtype=torch.float64)
    actual = get_motion_kernel2d(size, angles, directions, mode)
    for k, angle in enumerate(ANGLES):
        c, s = cv2.getRotationMatrix2D((0, 0), angle, 1.0)[0, :2]
        # (row, column): OpenCV's matrix is for (x, y) = (column, row).
        rotation = np.array([[c, -s], [s, c]])
        expected = rotated_line(size, rotation, float(directions[k]), order)
        np.testing.assert_allclose(actual[k], expected, atol=1e-12)
        np.testing.assert_allclose(
            get_motion_kernel2d(size, angle, float(directions[k]), mode, torch.float64)[0],
            expected,
            atol=1e-12,
        )


@pytest.mark.parametrize("angle", [30.0, 60.0, 150.0])
def test_ties_are_the_same_in_every_precision(angle: float) -> None:
    # Halfway between pixels: slightly smaller and larger angles give the same line.
    around = [angle - 1e-5, angle, angle + 1e-5]
    kernels = get_motion_kernel2d(7, torch.tensor(around, dtype=torch.float64))
    single = get_motion_kernel2d(7, torch.tensor(around, dtype=torch.float32))
    for k in range(3):
        torch.testing.assert_close(kernels[k], kernels[1])
        torch.testing.assert_close(single[k].double(), kernels[1])


VECTORS = [(0.0, 0.0, 0.0), (13.0, 41.0, -27.0), (0.0, 0.0, 45.0), (0.0, 90.0, 0.0), (-70.0, 10.0, 100.0)]


@pytest.mark.parametrize(("mode", "order"), [("nearest", 0), ("bilinear", 1)])
def test_motion_kernel3d_is_a_rotated_line(mode: str, order: int) -> None:
    vectors = torch.tensor(VECTORS, dtype=torch.float64)
    actual = get_motion_kernel3d(5, vectors, 0.3, mode)
    for k, vector in enumerate(VECTORS):
        # SciPy's rotation is of (x, y, z), the array's axes are z, y, x.
        rotation = Rotation.from_rotvec(np.radians(vector)).as_matrix()[::-1, ::-1]
        np.testing.assert_allclose(actual[k], rotated_line(5, rotation, 0.3, order), atol=1e-12)
    assert torch.equal(
        get_motion_kernel3d(5, VECTORS[1], 0.3, mode, torch.float64)[0],
        get_motion_kernel3d(5, vectors[1:2], 0.3, mode)[0],
    )


@pytest.mark.parametrize("border", CV_BORDER)
def test_motion_blur_equals_opencv(border: str) -> None:
    x = photo(2, 3, 25, 22, torch.float64)
    actual = motion_blur(x, 7, torch.tensor([20.0, 135.0], dtype=torch.float64), -0.4, border, "bilinear")
    for b, angle in enumerate((20.0, 135.0)):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        kernel = rotated_line(7, np.array([[c, -s], [s, c]]), -0.4, 1)
        expected = np.stack([cv2.filter2D(p.numpy(), -1, kernel, borderType=CV_BORDER[border]) for p in x[b]])
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


def test_motion_blur3d_equals_scipy() -> None:
    x: Tensor = photo(2, 6, 9, 11, torch.float64).reshape(2, 1, 6, 9, 11)
    kernel = rotated_line(5, Rotation.from_rotvec(np.radians(VECTORS[1])).as_matrix()[::-1, ::-1], 0.5, 0)
    expected = per_plane(x, lambda v: ndi.correlate(v, kernel, mode="nearest"), 3)
    np.testing.assert_allclose(motion_blur3d(x, 5, VECTORS[1], 0.5), expected, atol=1e-12)


def every_kernel() -> List[Tensor]:
    numbers = [
        get_box_kernel1d(3),
        get_box_kernel2d((2, 3)),
        get_binary_kernel2d(3),
        get_hanning_kernel1d(5),
        get_hanning_kernel2d((3, 4)),
    ]
    numbers += [
        get_laplacian_kernel1d(3),
        get_laplacian_kernel2d((3, 5)),
        laplacian_1d(5),
        get_sobel_kernel2d(),
        get_diff_kernel2d(),
    ]
    numbers += [get_spatial_gradient_kernel2d("sobel", 2), get_spatial_gradient_kernel3d("diff", 2)]
    gaussians = [
        get_gaussian_kernel1d(3, 1.0),
        gaussian(4, 1.0, 2.0),
        get_gaussian_erf_kernel1d(3, 1.0),
        get_gaussian_discrete_kernel1d(3, 1.0),
    ]
    gaussians += [get_gaussian_kernel2d(3, (1.0, 2.0)), get_gaussian_kernel3d(3, (1.0, 2.0, 3.0))]
    lines = [
        get_motion_kernel2d(3, 20.0),
        get_motion_kernel3d(3, (1.0, 2.0, 3.0)),
        get_gabor_kernel2d(3, 1.0, 0.1, 4.0),
    ]
    return numbers + gaussians + lines


def test_kernels_of_numbers_script() -> None:
    for actual, expected in zip(torch.jit.script(every_kernel)(), every_kernel(), strict=True):
        torch.testing.assert_close(actual, expected)


X = torch.zeros(2, 3, 8, 9)
WRONG = [
    (lambda: gaussian(0, 1.0), "window_size: expected a positive size, got 0"),
    (lambda: get_gaussian_erf_kernel1d(4, 1.0), "kernel_size: expected a positive odd size, got 4"),
    (lambda: get_gaussian_discrete_kernel1d(4, 1.0), "kernel_size: expected a positive odd size, got 4"),
    (lambda: get_gaussian_kernel2d(4, (1.0, 1.0)), "kernel_size: expected .* got 4"),
    (lambda: get_gaussian_kernel2d(3, torch.ones(3)), r"sigma: expected shape \(B, 2\), got \[3\]"),
    (lambda: get_gaussian_kernel3d(3, torch.ones(1, 2)), r"sigma: expected shape \(B, 3\), got \[1, 2\]"),
    (lambda: get_box_kernel1d(0), r"kernel_size: expected positive sizes, got \(0, 0\)"),
    (lambda: get_binary_kernel2d((0, 1)), "window_size: expected positive sizes"),
    (lambda: get_hanning_kernel1d(2), "kernel_size: expected at least 3, got 2"),
    (lambda: laplacian_1d(4), r"window_size: expected odd .* got \(4, 4\)"),
    (lambda: get_laplacian_kernel1d(4), "kernel_size: expected odd"),
    (lambda: get_spatial_gradient_kernel2d("x", 1), "mode: expected one of"),
    (lambda: get_spatial_gradient_kernel2d("diff", 3), "order: expected 1 or 2, got 3"),
    (lambda: get_spatial_gradient_kernel3d("sobel", 1), "mode: expected one of .*'sobel'"),
    (lambda: get_motion_kernel2d(4, 1.0), "kernel_size: expected an odd size of at least 3, got 4"),
    (lambda: get_motion_kernel2d(3, 1.0, mode="cubic"), "mode: expected one of .*'cubic'"),
    (lambda: get_motion_kernel3d(3, torch.ones(3)), r"angle: expected shape \(B, 3\), got \[3\]"),
    (lambda: get_gabor_kernel2d(4, 1.0, 1.0, 1.0), "kernel_size: expected odd"),
    (lambda: filters.motion_blur(X[0], 3, 1.0, 0.0), "input: expected shape"),
    (lambda: filters.motion_blur3d(X, 3, (1.0, 0.0, 0.0), 0.0), r"input: expected shape \(B, C, D, H, W\)"),
    (lambda: filters.gabor(X, 3, 1.0, 1.0, 4.0, border_type="x"), "border_type: expected one of"),
]


COUNTS = torch.ones(2, dtype=torch.int64)
WRONG_DTYPE = [
    (lambda: gaussian(3, COUNTS), "sigma"),
    (lambda: gaussian(3, 1.0, COUNTS), "mean"),
    (lambda: get_gaussian_erf_kernel1d(3, COUNTS), "sigma"),
    (lambda: get_gaussian_discrete_kernel1d(3, COUNTS), "sigma"),
    (lambda: get_gaussian_kernel2d(3, COUNTS[None]), "sigma"),
    (lambda: get_motion_kernel2d(3, COUNTS), "angle"),
    (lambda: get_motion_kernel2d(3, 1.0, COUNTS), "direction"),
    (lambda: get_motion_kernel3d(3, torch.ones(1, 3).int()), "angle"),
    (lambda: get_gabor_kernel2d(3, 1.0, COUNTS, 4.0), "theta"),
    (lambda: motion_blur(X.to(torch.uint8), 3, 30.0, 0.0), "input"),
    (lambda: motion_blur(X.to(torch.uint8), 3, torch.ones(2), 0.0), "input"),
    (lambda: gabor(X.to(torch.uint8), 3, 1.0, 0.5, 4.0), "input"),
]


@pytest.mark.parametrize(("call", "name"), WRONG_DTYPE)
def test_wrong_dtypes(call: object, name: str) -> None:
    with pytest.raises(TypeError, match=f"{name}: expected a floating-point tensor, got dtype"):
        call()


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_arguments(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()
