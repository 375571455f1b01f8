"""Bilateral means of bytes, in both layouts: against the definition in float64, rounded, and against
OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from photos import photo
from test_bytes import as_frame, both_layouts, frame
from test_filters import NUMPY_MODE

from chiasm.filters import bilateral_blur, joint_bilateral_blur


def exact_mean(
    image: np.ndarray,
    guide: np.ndarray,
    size: tuple[int, int],
    color: float,
    space: tuple[float, float],
    border: str,
    distance: str,
) -> np.ndarray:
    """The definition in float64, a tap at a time."""
    ry, rx = size[0] // 2, size[1] // 2
    margins = ((ry, ry), (rx, rx), (0, 0))
    p, g = (np.pad(x.astype(np.float64), margins, NUMPY_MODE[border]) for x in (image, guide))
    height, width = image.shape[:2]
    total, weights = np.zeros(image.shape), np.zeros((height, width, 1))
    for i in range(size[0]):
        for j in range(size[1]):
            window = np.s_[i : i + height, j : j + width]
            apart = g[window] - guide
            squared = np.abs(apart).sum(-1) ** 2 if distance == "l1" else (apart**2).sum(-1)
            near = ((i - ry) / space[0]) ** 2 + ((j - rx) / space[1]) ** 2
            weight = np.exp(-0.5 * (squared / color**2 + near))[..., None]
            total, weights = total + weight * p[window], weights + weight
    return total / weights


@pytest.mark.parametrize("border", NUMPY_MODE)
@pytest.mark.parametrize("distance", ["l1", "l2"])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_bilateral_is_the_definition_rounded(channels: int, distance: str, border: str) -> None:
    for image in (frame(20, 31, channels), frame(12, 13, channels) // 8 + 60):
        for size, color, space in (((5, 5), 25.0, (1.5, 1.5)), ((3, 7), 90.0, (0.7, 2.0))):
            exact = exact_mean(image, image, size, color, space, border, distance)
            for x in both_layouts(image):
                result = as_frame(bilateral_blur(x, size, color, space, border, distance))
                assert np.abs(result - exact).max() < 0.51


def test_wide_windows_are_the_definition_rounded() -> None:
    image = np.rint(255.0 * photo(1, 3, 90, 100, torch.float64)[0].permute(1, 2, 0).numpy()).astype(np.uint8)
    exact = exact_mean(image, image, (63, 65), 40.0, (12.0, 15.0), "reflect", "l1")
    result = as_frame(bilateral_blur(both_layouts(image)[0], (63, 65), 40.0, (12.0, 15.0)))
    assert np.abs(result - exact).max() < 0.52


@pytest.mark.parametrize("channels", [1, 3])
def test_bilateral_is_a_level_from_opencvs(channels: int) -> None:
    """OpenCV omits the corners, which have no weight with a narrow Gaussian."""
    image = frame(60, 70, channels)
    image[:30] = image[:30] // 4 + 90
    for size, color, space in ((3, 40.0, 0.3), (5, 60.0, 0.5)):
        expected = cv2.bilateralFilter(image, size, color, space, borderType=cv2.BORDER_REFLECT_101)
        for x in both_layouts(image):
            result = as_frame(bilateral_blur(x, size, color, (space, space)))
            apart = np.abs(result - expected.reshape(result.shape).astype(int))
            assert apart.max() <= 1 and (channels == 1 or (apart > 0).mean() < 0.01)  # OpenCV truncates greys


def test_each_sample_has_its_sigmas() -> None:
    image = frame(20, 30)
    x = both_layouts(image)[0].expand(2, -1, -1, -1)
    sigmas = torch.tensor([[1.0, 1.0], [1.5, 0.7]])
    result = bilateral_blur(x, 5, torch.tensor([30.0, 80.0]), sigmas)
    assert torch.equal(result[:1], bilateral_blur(x[:1], 5, 30.0, (1.0, 1.0)))
    assert torch.equal(result[1:], bilateral_blur(x[:1], 5, torch.tensor(80.0), (1.5, 0.7)))


def test_joint_bilateral_is_the_definition_rounded() -> None:
    image, guide = frame(20, 31, 3), frame(20, 31, 2, seed=1)
    for distance in ("l1", "l2"):
        exact = exact_mean(image, guide, (3, 5), 70.0, (1.0, 1.7), "reflect", distance)
        for x, g in zip(both_layouts(image), both_layouts(guide), strict=True):
            result = joint_bilateral_blur(x, g, (3, 5), 70.0, (1.0, 1.7), "reflect", distance)
            assert np.abs(as_frame(result) - exact).max() < 0.51
            two = x.expand(2, -1, -1, -1)
            both = joint_bilateral_blur(two, g, (3, 5), 70.0, (1.0, 1.7), "reflect", distance)
            assert torch.equal(both[:1], result) and torch.equal(both[1:], result)


def test_no_width_of_colours_leaves_the_image() -> None:
    image = frame(12, 13)
    for x in both_layouts(image):
        np.testing.assert_array_equal(as_frame(bilateral_blur(x, 3, torch.zeros(1), (1.0, 1.0))), image)


X = both_layouts(frame(9, 8))[0]
WRONG = [
    (
        lambda: bilateral_blur(X.int(), 3, 9.0, (1.0, 1.0)),
        TypeError,
        "input: expected a floating-point or uint8",
    ),
    (
        lambda: joint_bilateral_blur(X, X.float(), 3, 9.0, (1.0, 1.0)),
        TypeError,
        "guidance: expected uint8 with",
    ),
    (
        lambda: joint_bilateral_blur(X.float(), X, 3, 9.0, (1.0, 1.0)),
        TypeError,
        "guidance: expected uint8 with",
    ),
    (lambda: bilateral_blur(X, 65, 9.0, (1.0, 1.0)), ValueError, "kernel_size: expected at most 4096 pixels"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
