"""Canny's edges against OpenCV's, for the same gradients."""

import cv2
import numpy as np
import pytest
import torch
from photos import photo
from shapes import spiral
from test_bytes import as_frame, both_layouts, frame
from torch import Tensor

from chiasm.color import rgb_to_grayscale
from chiasm.filters import canny, gaussian_blur2d, sobel

WORDS = torch.zeros(1, 3, 8, 8, dtype=torch.int16)


def whole_numbers(shape: tuple[int, ...]) -> Tensor:
    """Grey photographs whose Sobel derivatives are integers, as cv2.Canny takes them, and fine enough that
    few are equal."""
    return torch.round(4000.0 * gaussian_blur2d(photo(*shape, torch.float64), 5, (1.0, 1.0)))


def opencv_edges(image: np.ndarray, low: float, high: float) -> np.ndarray:
    dx, dy = (
        cv2.Sobel(image, cv2.CV_64F, i, 1 - i, borderType=cv2.BORDER_REPLICATE).astype(np.int16)
        for i in (1, 0)
    )
    return cv2.Canny(dx, dy, low, high, L2gradient=True) > 0


@pytest.mark.parametrize("shape", [(1, 1, 37, 53), (3, 1, 201, 217), (2, 1, 64, 300)])
@pytest.mark.parametrize("thresholds", [(200.5, 400.5), (800.5, 2500.5), (300.5, 300.5)])
def test_equals_opencv(shape: tuple[int, ...], thresholds: tuple[float, float]) -> None:
    x = whole_numbers(shape)
    _, edges = canny(x, *thresholds, 1, (1.0, 1.0), eps=0.0)
    for b in range(shape[0]):
        expected = opencv_edges(x[b, 0].numpy(), *thresholds)
        assert expected.any()
        np.testing.assert_array_equal(edges[b, 0], expected)


def test_hysteresis_decides_on_photographs() -> None:
    # otherwise the test above would not cover it
    x = whole_numbers((1, 1, 201, 217))
    _, both = canny(x, 800.5, 2500.5, 1, (1.0, 1.0), False, 0.0)
    _, kept = canny(x, 800.5, 2500.5, 1, (1.0, 1.0), True, 0.0)
    assert set(both.unique().tolist()) == {0.0, 0.5, 1.0}
    assert (both == 1).sum() < kept.sum() < (both > 0).sum()
    assert torch.all(kept[both == 1] == 1)


def test_colour_is_blurred_grey() -> None:
    x = photo(2, 3, 45, 38)
    magnitude, edges = canny(x, kernel_size=(3, 5), sigma=(0.8, 1.1))
    full = sobel(gaussian_blur2d(rgb_to_grayscale(x), (3, 5), (0.8, 1.1)), normalized=False, eps=1e-6)
    ridge = magnitude > 0
    torch.testing.assert_close(magnitude[ridge], full[ridge])
    strong = ridge & (magnitude > 0.2)
    assert torch.all(edges[strong] == 1) and torch.all(edges[~ridge] == 0)


def test_edge_of_a_spiral_is_followed_to_its_end() -> None:
    # A dim spiral wall that is bright only towards its outer end: nearly all of its edge is weak.
    wall = np.kron(spiral(61, 77), np.ones((5, 5)))
    wall[:5] *= 1.0 + 3.0 * np.clip(1.0 - np.arange(wall.shape[1]) / 100.0, 0.0, 1.0)
    image = np.round(cv2.GaussianBlur(1000.0 * wall, (7, 7), 1.0))
    dense = torch.from_numpy(image)[None, None]
    low, high = 500.5, 8000.5
    _, edges = canny(dense, low, high, 1, (1.0, 1.0), eps=0.0)
    _, parts = canny(dense, low, high, 1, (1.0, 1.0), False, eps=0.0)
    assert 0 < (parts == 1).sum() < 0.01 * edges.sum()
    assert edges[0, 0, 140:160, 190:].sum() > 0  # the centre
    np.testing.assert_array_equal(edges[0, 0], opencv_edges(image, low, high))


def test_gradient_is_finite_where_the_image_is_flat() -> None:
    for eps in (0.0, 1e-6):
        x = torch.full((1, 1, 9, 9), 0.5, requires_grad=True)
        magnitude, edges = canny(x, eps=eps)
        magnitude.sum().backward()
        assert torch.isfinite(x.grad).all() and not edges.requires_grad


def bytes_of(image: Tensor) -> np.ndarray:
    """One photograph as a frame of bytes."""
    return torch.round(255.0 * image[0]).to(torch.uint8).permute(1, 2, 0).numpy()


@pytest.mark.parametrize("image", [bytes_of(photo(1, 3, 201, 217)), frame(40, 53), frame(9, 8)], ids=len)
@pytest.mark.parametrize("thresholds", [(60.0, 180.0), (20.5, 150.3), (0.0, 0.0)])
@pytest.mark.parametrize(
    ("size", "sigma"), [((5, 5), (1.0, 1.0)), ((3, 7), (0.8, 1.5)), ((1, 1), (1.0, 1.0))]
)
def test_edges_of_bytes_are_opencvs(
    image: np.ndarray, thresholds: tuple[float, float], size: tuple[int, int], sigma: tuple[float, float]
) -> None:
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    blurred = cv2.GaussianBlur(grey, size[::-1], sigma[1], sigmaY=sigma[0], borderType=cv2.BORDER_REFLECT_101)
    expected = cv2.Canny(blurred, thresholds[0], thresholds[1], L2gradient=True)
    dx, dy = (cv2.Sobel(blurred, cv2.CV_64F, i, 1 - i, borderType=cv2.BORDER_REPLICATE) for i in (1, 0))
    assert expected.any()
    for x in (*both_layouts(image), both_layouts(grey[..., None])[0]):
        magnitude, edges = canny(x, *thresholds, size, sigma)
        np.testing.assert_array_equal(as_frame(edges)[..., 0], expected)
        assert magnitude.dtype == torch.int16
        ridge = magnitude[0, 0].numpy()
        np.testing.assert_array_equal(ridge[ridge > 0], np.rint(np.hypot(dx, dy))[ridge > 0])
        assert np.all(ridge[expected > 0] > 0)


def test_weak_edges_of_bytes_are_half_of_white() -> None:
    x = torch.zeros(1, 1, 9, 12, dtype=torch.uint8)
    x[..., 4:] = 20
    x[..., 8:] = 100
    _, edges = canny(x, 50.0, 200.0, 1, (1.0, 1.0), hysteresis=False)
    assert edges[0, 0, 4].tolist() == [0, 0, 0, 128, 0, 0, 0, 255, 0, 0, 0, 0]


WRONG = [
    (lambda: canny(WORDS), TypeError, "input: expected a floating-point or uint8 tensor"),
    (lambda: canny(torch.zeros(1, 2, 8, 8)), ValueError, r"input: expected shape .* got \[1, 2, 8, 8\]"),
    (
        lambda: canny(torch.zeros(1, 1, 8, 8), 0.3, 0.2),
        ValueError,
        "low_threshold: expected .* got 0.3 and 0.2",
    ),
    (
        lambda: canny(torch.zeros(1, 1, 8, 8), kernel_size=4),
        ValueError,
        r"kernel_size: expected odd .* got \(4, 4\)",
    ),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
