"""Canny's edges against OpenCV's, given the same gradients."""

import cv2
import numpy as np
import pytest
import torch
from photos import photo
from shapes import spiral
from torch import Tensor

from chiasm.color import rgb_to_grayscale
from chiasm.filters import canny, gaussian_blur2d, sobel

BYTES = torch.zeros(1, 3, 8, 8, dtype=torch.uint8)


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
    # else the test above would say nothing about it
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
    # A dim spiral wall that grows bright towards its outer end only: nearly all of its edge is weak.
    wall = np.kron(spiral(61, 77), np.ones((5, 5)))
    wall[:5] *= 1.0 + 3.0 * np.clip(1.0 - np.arange(wall.shape[1]) / 100.0, 0.0, 1.0)
    image = np.round(cv2.GaussianBlur(1000.0 * wall, (7, 7), 1.0))
    dense = torch.from_numpy(image)[None, None]
    low, high = 500.5, 8000.5
    _, edges = canny(dense, low, high, 1, (1.0, 1.0), eps=0.0)
    _, parts = canny(dense, low, high, 1, (1.0, 1.0), False, eps=0.0)
    assert 0 < (parts == 1).sum() < 0.01 * edges.sum()
    assert edges[0, 0, 140:160, 190:].sum() > 0  # the middle
    np.testing.assert_array_equal(edges[0, 0], opencv_edges(image, low, high))


def test_gradient_is_finite_where_the_image_is_flat() -> None:
    for eps in (0.0, 1e-6):
        x = torch.full((1, 1, 9, 9), 0.5, requires_grad=True)
        magnitude, edges = canny(x, eps=eps)
        magnitude.sum().backward()
        assert torch.isfinite(x.grad).all() and not edges.requires_grad


WRONG = [
    (lambda: canny(BYTES), TypeError, "input: expected a floating-point"),
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
