"""Pipelines against the same chain in OpenCV."""

import cv2
import numpy as np
import pytest
import torch
from photos import frame

from chiasm.pipelines import edges, preprocess

SIZES = [(224, 224), (399, 599), (101, 230), (65, 47)]


@pytest.mark.parametrize("size", SIZES)
def test_preprocess_equals_opencv(size: tuple[int, int]) -> None:
    x = frame(*size)
    small = cv2.resize(x.numpy().astype(np.float32), (224, 224), interpolation=cv2.INTER_LINEAR)
    rgb = small[..., ::-1] / 255.0
    expected = (rgb - np.array([0.485, 0.456, 0.406])) / np.array([0.229, 0.224, 0.225])
    actual = preprocess(x)
    assert actual.shape == (1, 3, 224, 224) and actual.dtype == torch.float32
    np.testing.assert_allclose(actual[0], expected.transpose(2, 0, 1), atol=2e-4)
    other = preprocess(x, mean=(0.0, 0.1, 0.2), std=(1.0, 0.5, 2.0))
    np.testing.assert_allclose(other[0, 1], (rgb[..., 1] - 0.1) / 0.5, atol=2e-4)


@pytest.mark.parametrize("size", SIZES)
def test_edges_equal_opencv(size: tuple[int, int]) -> None:
    x = frame(*size)
    grey = cv2.cvtColor(x.numpy().astype(np.float32), cv2.COLOR_BGR2GRAY)
    blurred = cv2.GaussianBlur(grey, (5, 5), 1.0, borderType=cv2.BORDER_REFLECT_101)
    gx, gy = (cv2.Sobel(blurred, cv2.CV_32F, i, 1 - i, borderType=cv2.BORDER_REPLICATE) for i in (1, 0))
    expected = np.clip(np.rint(np.hypot(gx, gy)), 0, 255)
    actual = edges(x).numpy()
    assert actual.dtype == np.uint8 and expected.max() > 10
    # The last bit may differ if the magnitude is within rounding of a half.
    difference = np.abs(actual.astype(np.float64) - expected)
    assert difference.max() <= 1 and difference.mean() < 1e-3


def test_edges_saturate() -> None:
    x = torch.zeros(20, 20, 3, dtype=torch.uint8)
    x[:, 10:] = 255
    assert edges(x).max() == 255
