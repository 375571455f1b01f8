"""Edge magnitudes and derivatives of volumes against OpenCV, scikit-image, NumPy and SciPy."""

import math

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import skimage.filters
import torch
from borders import SHAPES, per_plane
from photos import photo
from test_bytes import SIZES, as_frame, both_layouts, frame

from chiasm.filters import (
    filter2d,
    filter3d,
    get_spatial_gradient_kernel2d,
    get_spatial_gradient_kernel3d,
    prewitt,
    roberts,
    scharr,
    spatial_gradient,
    spatial_gradient3d,
)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    ("ours", "theirs", "factor"),
    [
        (scharr, skimage.filters.scharr, math.sqrt(2)),
        (prewitt, skimage.filters.prewitt, math.sqrt(2)),
        (roberts, skimage.filters.roberts, 1.0),
    ],
)
def test_magnitudes_equal_scikit_image(
    shape: tuple[int, ...], ours: object, theirs: object, factor: float
) -> None:
    x = photo(*shape, torch.float64)
    expected = per_plane(x, theirs)
    np.testing.assert_allclose(ours(x, eps=0.0) * factor, expected, atol=1e-12)


@pytest.mark.parametrize("normalized", [True, False])
def test_scharr_equals_opencv(normalized: bool) -> None:
    x = photo(2, 3, 31, 26)
    scale = 1 / 32 if normalized else 1.0

    def magnitude(p: np.ndarray) -> np.ndarray:
        return np.hypot(
            *(
                cv2.Scharr(p, cv2.CV_32F, i, 1 - i, scale=scale, borderType=cv2.BORDER_REPLICATE)
                for i in (0, 1)
            )
        )

    np.testing.assert_allclose(scharr(x, normalized, 0.0), per_plane(x, magnitude), atol=3e-5 * scale)


@pytest.mark.parametrize("smooth, mode", [((3, 10, 3), "scharr"), ((1, 1, 1), "prewitt")])
def test_derivatives_are_sums_of_smoothed_differences(smooth: tuple[int, ...], mode: str) -> None:
    x = photo(2, 3, 17, 22, torch.float64)
    along = np.outer(smooth, [-1, 0, 1]) / (2 * sum(smooth))
    for normalized, factor in ((True, 1), (False, 2 * sum(smooth))):
        actual = spatial_gradient(x, mode, normalized=normalized)
        for k, kernel in enumerate((along, along.T)):
            expected = per_plane(x, lambda p, kernel=kernel: ndi.correlate(p, kernel, mode="nearest"))
            np.testing.assert_allclose(actual[:, :, k], factor * expected, atol=1e-12)


def test_unnormalized_kernels() -> None:
    # On a ramp, Prewitt's kernels give 2 * 3, and Roberts' a diagonal difference of 1 in both directions.
    ramp = torch.arange(6.0).expand(1, 1, 5, 6)
    assert prewitt(ramp, False, 0.0)[0, 0, 2, 2] == 6
    assert roberts(ramp, False, 0.0)[0, 0, 2, 2] == torch.tensor(2.0).sqrt()


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_scharr_is_opencvs(channels: int, height: int, width: int) -> None:
    image = frame(height, width, channels)
    image[: height // 2] = image[: height // 2] // 128 * 255  # the largest differences too
    border = cv2.BORDER_REPLICATE
    both = [cv2.Scharr(image, cv2.CV_16S, dx, 1 - dx, borderType=border) for dx in (1, 0)]
    dx, dy = (each.reshape(image.shape).astype(np.float64) for each in both)
    length = np.sqrt(dx * dx + dy * dy)
    for x in both_layouts(image):
        result = spatial_gradient(x, "scharr", normalized=False)
        assert result.dtype == torch.int16
        np.testing.assert_array_equal(result[0, :, 0].permute(1, 2, 0).numpy(), dx)
        np.testing.assert_array_equal(result[0, :, 1].permute(1, 2, 0).numpy(), dy)
        np.testing.assert_array_equal(as_frame(scharr(x)), np.rint(length / 32))
        np.testing.assert_array_equal(as_frame(scharr(x, False)), np.minimum(np.rint(length), 255))


@pytest.mark.parametrize("low", [False, True])
def test_prewitt_and_roberts_are_the_lengths_of_derivatives(low: bool) -> None:
    image = frame(13, 17)
    image //= 32 if low else 1  # roots that are halves
    whole = image.astype(np.float64)
    planes = np.moveaxis(whole, 2, 0)
    dx, dy = (np.stack([ndi.prewitt(p, i, mode="nearest") for p in planes], 2) for i in (1, 0))
    length = np.sqrt(dx * dx + dy * dy)
    wide = np.pad(whole, ((0, 1), (0, 1), (0, 0)), "edge")
    cross = (wide[:-1, :-1] - wide[1:, 1:]) ** 2 + (wide[:-1, 1:] - wide[1:, :-1]) ** 2
    for x in both_layouts(image):
        derivatives = spatial_gradient(x, "prewitt", normalized=False)[0].permute(1, 2, 3, 0).numpy()
        np.testing.assert_array_equal(derivatives, np.stack([dx, dy]))
        np.testing.assert_array_equal(as_frame(prewitt(x)), np.rint(length / 6))
        np.testing.assert_array_equal(as_frame(prewitt(x, False)), np.minimum(np.rint(length), 255))
        np.testing.assert_array_equal(as_frame(roberts(x)), np.rint(np.sqrt(cross / 2)))
        np.testing.assert_array_equal(as_frame(roberts(x, False)), np.minimum(np.rint(np.sqrt(cross)), 255))


@pytest.mark.parametrize("op", [scharr, prewitt, roberts])
def test_gradient_is_finite_on_flat_images(op: object) -> None:
    x = torch.full((1, 1, 5, 5), 0.5, requires_grad=True)
    op(x).sum().backward()
    assert torch.isfinite(x.grad).all()


@pytest.mark.parametrize("mode", ["sobel", "diff"])
@pytest.mark.parametrize("order", [1, 2])
def test_spatial_gradient_correlates_with_its_kernels(mode: str, order: int) -> None:
    x = photo(2, 3, 17, 22, torch.float64)
    actual = spatial_gradient(x, mode, order, normalized=False)
    for k, kernel in enumerate(get_spatial_gradient_kernel2d(mode, order, dtype=torch.float64)):
        expected = per_plane(x, lambda p, kernel=kernel: ndi.correlate(p, kernel.numpy(), mode="nearest"))
        np.testing.assert_allclose(actual[:, :, k], expected, atol=1e-12)
        np.testing.assert_allclose(filter2d(x, kernel, "replicate"), expected, atol=1e-12)


def volume() -> torch.Tensor:
    return torch.stack(
        [photo(2, 3, 14, 15, torch.float64)[:, :, i : i + 9, i // 2 : i // 2 + 12] for i in range(6)], 2
    )


def test_3d_gradient_equals_numpy() -> None:
    x = volume()
    actual = spatial_gradient3d(x)[:, :, :, 1:-1, 1:-1, 1:-1]
    dz, dy, dx = np.gradient(x.numpy(), axis=(2, 3, 4))
    np.testing.assert_allclose(actual, np.stack([dx, dy, dz], 2)[:, :, :, 1:-1, 1:-1, 1:-1], atol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_3d_gradient_correlates_with_its_kernels(order: int) -> None:
    x = volume()
    actual = spatial_gradient3d(x, "diff", order)
    assert torch.equal(torch.jit.script(spatial_gradient3d)(x, "diff", order), actual)
    for k, kernel in enumerate(get_spatial_gradient_kernel3d("diff", order, dtype=torch.float64)):
        expected = per_plane(
            x, lambda v, kernel=kernel: ndi.correlate(v, kernel[0].numpy(), mode="nearest"), 3
        )
        np.testing.assert_allclose(actual[:, :, k], expected, atol=1e-12)
        np.testing.assert_allclose(filter3d(x, kernel), expected, atol=1e-12)


X = torch.zeros(1, 3, 8, 8)
V = torch.zeros(1, 1, 4, 5, 6)
WRONG = [
    (lambda: scharr(X[0]), ValueError, r"input: expected shape \(B, C, H, W\)"),
    (lambda: prewitt(X.int()), TypeError, "input: expected a floating-point"),
    (lambda: roberts(X.int()), TypeError, "input: expected a floating-point"),
    (lambda: spatial_gradient3d(X), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (lambda: spatial_gradient3d(V.int()), TypeError, "input: expected a floating-point"),
    (lambda: spatial_gradient3d(V, "sobel"), ValueError, "mode: expected one of .*'sobel'"),
    (lambda: spatial_gradient3d(V, order=3), ValueError, "order: expected 1 or 2, got 3"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
