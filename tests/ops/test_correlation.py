"""filter2d and related filters against OpenCV and SciPy, in every border mode."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import scipy.signal
import torch
from borders import CV_BORDER, SCIPY_MODE, SHAPES, per_plane
from photos import chw, hwc, photo
from torch import Tensor

from chiasm import filters
from chiasm.filters import (
    convolve2d,
    convolve3d,
    correlate2d,
    correlate3d,
    fft_conv,
    filter2d,
    filter2d_separable,
    filter3d,
)
from chiasm.primitives.core.target import exporting
from chiasm.primitives.filters.correlation import box_sums, sum_shifts
from chiasm.primitives.filters.derivatives import gradient

X = torch.zeros(2, 3, 8, 9)
V = torch.zeros(2, 3, 4, 5, 6)


def random(*shape: int) -> Tensor:
    generator = torch.Generator().manual_seed(sum(shape))
    return torch.rand(shape, generator=generator, dtype=torch.float64) * 2 - 1


def volume(dtype: torch.dtype = torch.float64) -> Tensor:
    """Two volumes of two channels, whose slices are neighbouring crops of photographs: (2, 2, 5, 9, 12)."""
    return torch.stack(
        [photo(2, 2, 13, 15, dtype)[:, :, i : i + 9, i // 2 : i // 2 + 12] for i in range(5)], 2
    )


@pytest.mark.parametrize("border", CV_BORDER)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("size", [(3, 3), (5, 3), (1, 7), (9, 1)])
def test_filter2d_equals_opencv(shape: tuple[int, ...], border: str, size: tuple[int, int]) -> None:
    x, kernel = photo(*shape), random(*size).float()
    actual = filter2d(x, kernel, border)
    for b in range(shape[0]):
        expected = np.stack(
            [cv2.filter2D(p.numpy(), -1, kernel.numpy(), borderType=CV_BORDER[border]) for p in x[b]]
        )
        np.testing.assert_allclose(actual[b], expected, atol=3e-6)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(3, 5), (4, 3), (2, 6)])
def test_a_kernel_per_sample_equals_scipy(border: str, size: tuple[int, int]) -> None:
    x, kernels = photo(3, 2, 19, 22, torch.float64), random(3, *size)
    actual = {name: filter2d(x, kernels, border, behaviour=name) for name in ("corr", "conv")}
    # The anchor of an even kernel is one pixel before SciPy's.
    origin = [(size[0] - 1) // 2 - size[0] // 2, (size[1] - 1) // 2 - size[1] // 2]
    for b in range(3):
        for name, kernel in (("corr", kernels[b].numpy()), ("conv", kernels[b].numpy()[::-1, ::-1])):
            expected = np.stack(
                [ndi.correlate(p.numpy(), kernel, mode=SCIPY_MODE[border], origin=origin) for p in x[b]]
            )
            np.testing.assert_allclose(actual[name][b], expected, atol=1e-12)


@pytest.mark.parametrize("size", [(3, 3), (4, 5)])
def test_valid_equals_scipy_signal(size: tuple[int, int]) -> None:
    x, kernel = photo(2, 7, 15, 12, torch.float64), random(*size)
    expected = per_plane(x, lambda p: scipy.signal.correlate2d(p, kernel.numpy(), "valid"))
    np.testing.assert_allclose(correlate2d(x, kernel, padding="valid"), expected, atol=1e-12)
    by_fft = per_plane(x, lambda p: scipy.signal.fftconvolve(p, kernel.numpy(), "valid"))
    np.testing.assert_allclose(fft_conv(x, kernel, padding="valid", behaviour="conv"), by_fft, atol=1e-12)
    np.testing.assert_allclose(convolve2d(x, kernel, padding="valid"), by_fft, atol=1e-12)


def test_normalized_divides_by_the_sum_of_magnitudes() -> None:
    x, kernels = photo(2, 3, 12, 11, torch.float64), random(2, 3, 3)
    actual = convolve2d(x, kernels, "replicate", normalized=True)
    for b in range(2):
        kernel = kernels[b].numpy() / np.abs(kernels[b].numpy()).sum()
        expected = np.stack([ndi.convolve(p.numpy(), kernel, mode="nearest") for p in x[b]])
        np.testing.assert_allclose(actual[b], expected, atol=1e-12)


@pytest.mark.parametrize("border", CV_BORDER)
def test_separable_equals_opencv(border: str) -> None:
    x, kernel_x, kernel_y = photo(1, 3, 33, 27), random(5).float(), random(7).float()
    expected = cv2.sepFilter2D(hwc(x), -1, kernel_x.numpy(), kernel_y.numpy(), borderType=CV_BORDER[border])
    np.testing.assert_allclose(filter2d_separable(x, kernel_x, kernel_y, border)[0], chw(expected), atol=3e-6)


@pytest.mark.parametrize("padding", ["same", "valid"])
def test_separable_per_sample_and_even_equals_scipy(padding: str) -> None:
    x, kernel_x, kernel_y = photo(2, 2, 13, 14, torch.float64), random(2, 4), random(1, 3)
    actual = filter2d_separable(x, kernel_x, kernel_y, "circular", True, padding)
    for b in range(2):
        taps = [kernel_y[0].numpy(), kernel_x[b].numpy()]
        for plane, result in zip(x[b].numpy(), actual[b].numpy(), strict=True):
            expected = ndi.correlate1d(plane, taps[0] / np.abs(taps[0]).sum(), axis=0, mode="wrap")
            expected = ndi.correlate1d(
                expected, taps[1] / np.abs(taps[1]).sum(), axis=1, mode="wrap", origin=-1
            )
            np.testing.assert_allclose(
                result, expected if padding == "same" else expected[1:-1, 1:-2], atol=1e-12
            )


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(3, 3, 3), (1, 5, 3), (4, 2, 1)])
def test_3d_equals_scipy(border: str, size: tuple[int, int, int]) -> None:
    x, kernels = volume(), random(2, *size)
    origin = [(s - 1) // 2 - s // 2 for s in size]
    correlated, convolved = correlate3d(x, kernels, border), convolve3d(x, kernels, border, normalized=True)
    for b in range(2):
        kernel = kernels[b].numpy()
        expected = np.stack(
            [ndi.correlate(p, kernel, mode=SCIPY_MODE[border], origin=origin) for p in x[b].numpy()]
        )
        np.testing.assert_allclose(correlated[b], expected, atol=1e-12)
        kernel = kernel[::-1, ::-1, ::-1] / np.abs(kernel).sum()
        expected = np.stack(
            [ndi.correlate(p, kernel, mode=SCIPY_MODE[border], origin=origin) for p in x[b].numpy()]
        )
        np.testing.assert_allclose(convolved[b], expected, atol=1e-12)


def test_3d_shared_kernel() -> None:
    x, kernel = volume(), random(3, 3, 3)
    expected = per_plane(x, lambda v: ndi.correlate(v, kernel.numpy(), mode="nearest"), 3)
    np.testing.assert_allclose(filter3d(x, kernel), expected, atol=1e-12)
    np.testing.assert_allclose(filter3d(x, kernel[None]), expected, atol=1e-12)


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("target", ["onnx", "native", "vjp"])
def test_target_forms_in_every_border(border: str, target: str) -> None:
    x, v = photo(2, 3, 12, 13, torch.float64), volume()
    kernels = [random(3, 5), random(2, 4, 3), random(3, 3, 3), random(2, 2, 3, 4)]

    def results() -> list[Tensor]:
        planes = [filter2d(x, k, border) for k in kernels[:2]] + [
            filter2d_separable(x, random(4), random(3), border)
        ]
        sums = [box_sums(x, size, size, border, 0.5, -2.0) for size in (2, 3, 5, 6)]
        return planes + sums + [filter3d(v, k, border) for k in kernels[2:]]

    expected = results()
    with exporting(target):
        for actual, e in zip(results(), expected, strict=True):
            torch.testing.assert_close(actual, e, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("border", ["replicate", "constant"])
@pytest.mark.parametrize("width", range(1, 15))
def test_native_forms_of_narrow_images(width: int, border: str) -> None:
    x = photo(1, 2, 4, width, torch.float64)
    kernel = random(7, 7)
    mode = {"replicate": "edge", "constant": "constant"}[border]
    edged = np.pad(x.numpy(), ((0, 0), (0, 0), (3, 3), (3, 3)), mode)
    windows = np.lib.stride_tricks.sliding_window_view(edged, (7, 7), (2, 3))
    with exporting("native"):
        sums = box_sums(x, 7, 7, border)
        np.testing.assert_allclose(sums, windows.sum((4, 5)), rtol=1e-12, atol=1e-12)
        actual = filter2d(x, kernel, border)
        expected = np.einsum("bchwij,ij->bchw", windows, kernel.numpy())
        np.testing.assert_allclose(actual, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("width", range(1, 5))
def test_native_derivatives_of_narrow_images(width: int) -> None:
    x = photo(1, 1, 4, width, torch.float64)
    edged = np.pad(x.numpy(), ((0, 0), (0, 0), (1, 1), (1, 1)), "edge")
    across = (edged[..., 1:-1, 2:] - edged[..., 1:-1, :-2]) / 2
    down = (edged[..., 2:, 1:-1] - edged[..., :-2, 1:-1]) / 2
    with exporting("native"):
        actual = gradient(x, (1, 1), (1, 1), "replicate", "diff", True)
    np.testing.assert_allclose(actual, np.stack([across, down], 2), atol=1e-15)


@pytest.mark.parametrize("count", range(1, 18))
def test_sums_of_any_count(count: int) -> None:
    x = torch.arange(20.0).square()
    expected = np.convolve(x.numpy(), np.ones(count), "valid")
    np.testing.assert_array_equal(sum_shifts(x, 0, count), expected)


def test_half_precision_is_kept() -> None:
    x = photo(1, 3, 12, 11)
    for dtype in (torch.float16, torch.bfloat16):
        result = filter2d(x.to(dtype), torch.ones(3, 3), normalized=True)
        assert result.dtype == dtype
        np.testing.assert_allclose(result.float()[0], chw(cv2.blur(hwc(x), (3, 3))), atol=2e-2)


WRONG = [
    (lambda: filter2d(X[0], torch.ones(3, 3)), ValueError, r"input: expected shape \(B, C, H, W\)"),
    (lambda: filter2d(X.int(), torch.ones(3, 3)), TypeError, "input: expected a floating-point"),
    (lambda: filter2d(X, torch.ones(3, 3).int()), TypeError, "kernel: expected a floating-point"),
    (
        lambda: filter2d(X, torch.ones(3)),
        ValueError,
        r"kernel: expected shape \(kH, kW\) or \(B, kH, kW\), got \[3\]",
    ),
    (
        lambda: filter2d(X, torch.ones(3, 3, 3)),
        ValueError,
        r"kernel: expected a first dimension of 1 or input's 2, got \[3, 3, 3\]",
    ),
    (lambda: filter2d(X, torch.ones(3, 3), "mirror"), ValueError, "border_type: expected one of .*'mirror'"),
    (lambda: filter2d(X, torch.ones(3, 3), padding="full"), ValueError, "padding: expected one of .*'full'"),
    (lambda: filter2d(X, torch.ones(3, 3), behaviour="x"), ValueError, "behaviour: expected one of .*'x'"),
    (
        lambda: filter2d_separable(X, torch.ones(3, 1), torch.ones(3)),
        ValueError,
        "kernel_x: expected a first dimension",
    ),
    (
        lambda: filter2d_separable(X, torch.ones(3), torch.ones(1, 1, 3)),
        ValueError,
        "kernel_y: expected shape",
    ),
    (
        lambda: filter2d_separable(X, torch.ones(3), torch.ones(3), padding=""),
        ValueError,
        "padding: expected one of",
    ),
    (lambda: filter3d(X, torch.ones(3, 3, 3)), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (lambda: filter3d(V.int(), torch.ones(3, 3, 3)), TypeError, "input: expected a floating-point"),
    (lambda: filter3d(V, torch.ones(3, 3)), ValueError, "kernel: expected shape"),
    (lambda: filter3d(V, torch.ones(3, 3, 3), behaviour="x"), ValueError, "behaviour: expected one of"),
    (lambda: filters.convolve3d(V, torch.ones(3, 3, 3), "x"), ValueError, "border_type: expected one of"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
