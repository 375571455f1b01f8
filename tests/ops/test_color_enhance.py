"""Colour and intensity against OpenCV, colorsys and NumPy."""

import colorsys
import math

import cv2
import numpy as np
import pytest
import torch
from photos import chw, hwc, photo

from chiasm.color import RgbToGrayscale, RgbToHsv, bgr_to_rgb, rgb_to_grayscale, rgb_to_hsv
from chiasm.enhance import Normalize, normalize


@pytest.mark.parametrize("size", [(37, 53), (64, 31), (1, 7)])
def test_gray_equals_opencv(size: tuple[int, int]) -> None:
    x = photo(3, 3, *size)
    for b in range(3):
        np.testing.assert_allclose(
            rgb_to_grayscale(x)[b, 0], cv2.cvtColor(hwc(x, b), cv2.COLOR_RGB2GRAY), atol=1e-6
        )


def test_gray_with_weights() -> None:
    x = photo(2, 3, 11, 13, torch.float64)
    w = torch.tensor([0.1, 0.2, 0.7], dtype=torch.float64)
    np.testing.assert_allclose(rgb_to_grayscale(x, w), np.einsum("bchw,c->bhw", x, w)[:, None], atol=1e-12)
    np.testing.assert_array_equal(RgbToGrayscale(w)(x), rgb_to_grayscale(x, w))


@pytest.mark.parametrize("size", [(37, 53), (64, 31)])
def test_hsv_equals_opencv(size: tuple[int, int]) -> None:
    x = photo(3, 3, *size)
    for b in range(3):
        expected = chw(cv2.cvtColor(hwc(x, b), cv2.COLOR_RGB2HSV))
        actual = rgb_to_hsv(x)[b].numpy()
        turn = np.abs(actual[0] - np.radians(expected[0]))
        assert np.minimum(turn, 2 * math.pi - turn).max() < 1e-4
        np.testing.assert_allclose(actual[1:], expected[1:], atol=1e-5)


def test_hsv_equals_colorsys_on_ties_and_primaries() -> None:
    levels = [0.0, 0.25, 0.5, 1.0]
    colours = [(r, g, b) for r in levels for g in levels for b in levels]
    actual = rgb_to_hsv(torch.tensor(colours, dtype=torch.float64)[:, :, None, None])[..., 0, 0]
    for colour, (h, s, v) in zip(colours, actual.tolist(), strict=True):
        eh, es, ev = colorsys.rgb_to_hsv(*colour)
        assert (h, s, v) == pytest.approx((2 * math.pi * eh, es, ev), abs=1e-7), colour
        assert 0.0 <= h < 2 * math.pi


def test_hsv_gradient_is_finite_on_grey_and_black() -> None:
    x = torch.tensor([0.0, 0.5]).expand(3, 2).T.reshape(2, 3, 1, 1).clone().requires_grad_(True)
    rgb_to_hsv(x).sum().backward()
    assert torch.isfinite(x.grad).all()


def test_any_leading_shape() -> None:
    x = photo(2, 3, 5, 7)
    assert torch.equal(RgbToHsv()(x[0]), rgb_to_hsv(x)[0])
    assert torch.equal(rgb_to_grayscale(x[None])[0], rgb_to_grayscale(x))


def test_bgr_to_rgb_reverses() -> None:
    x = photo(2, 3, 5, 7)
    assert torch.equal(bgr_to_rgb(x), x.flip(1))
    assert torch.equal(bgr_to_rgb((x * 255).to(torch.uint8)), (x * 255).to(torch.uint8).flip(1))


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_normalize(channels: int) -> None:
    x = photo(2, channels, 7, 9, torch.float64)
    mean = torch.linspace(0.1, 0.8, 2 * channels, dtype=torch.float64).reshape(2, channels)
    std = torch.linspace(0.5, 0.9, 2 * channels, dtype=torch.float64).reshape(2, channels)
    expected = (x.numpy() - mean.numpy()[:, :, None, None]) / std.numpy()[:, :, None, None]
    np.testing.assert_allclose(normalize(x, mean, std), expected, atol=1e-12)
    np.testing.assert_allclose(Normalize(mean[0], std[0])(x)[0], expected[0], atol=1e-12)
    np.testing.assert_allclose(normalize(x, mean[0, 0], std[0, :1])[0, 0], expected[0, 0], atol=1e-12)
