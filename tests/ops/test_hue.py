"""Hue and saturation against OpenCV and colorsys."""

import colorsys
import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import chw, hwc, photo
from torch import Tensor

from chiasm import enhance
from chiasm.color import rgb_to_hsv


def by_opencv(x: Tensor, sample: int, turn: float, factor: float) -> np.ndarray:
    hsv = cv2.cvtColor(hwc(x, sample), cv2.COLOR_RGB2HSV)
    hsv[..., 0] = (hsv[..., 0] + math.degrees(turn)) % 360
    hsv[..., 1] = np.clip(hsv[..., 1] * factor, 0, 1)
    return chw(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB))


@pytest.mark.parametrize("size", [(37, 53), (64, 31)])
@pytest.mark.parametrize("turn", [-3.0, -0.7, 0.0, 0.5, 7.0])
def test_hue_equals_opencv(size: tuple[int, int], turn: float) -> None:
    x = photo(3, 3, *size)
    actual = enhance.adjust_hue(x, turn)
    each = enhance.adjust_hue(x, torch.tensor([0.3, turn, 0.1]))
    for b in range(3):
        np.testing.assert_allclose(actual[b], by_opencv(x, b, turn, 1.0), atol=1e-5)
    torch.testing.assert_close(each[1], actual[1])


@pytest.mark.parametrize("factor", [0.0, 0.6, 1.0, 2.5])
def test_saturation_equals_opencv(factor: float) -> None:
    x = photo(2, 3, 37, 53)
    actual = enhance.adjust_saturation(x, factor)
    for b in range(2):
        np.testing.assert_allclose(actual[b], by_opencv(x, b, 0.0, factor), atol=1e-5)
    torch.testing.assert_close(enhance.adjust_saturation(x, torch.tensor([1.0, factor]))[1], actual[1])
    torch.testing.assert_close(enhance.adjust_saturation(x[0], torch.tensor(factor)), actual[0])


def test_colorsys_on_ties_and_primaries() -> None:
    levels = [0.0, 0.25, 0.5, 1.0]
    colours = [(r, g, b) for r in levels for g in levels for b in levels]
    actual = enhance.adjust_hue(
        torch.tensor(colours, dtype=torch.float64)[:, :, None, None], 2 * math.pi / 5
    )[..., 0, 0]
    for colour, turned in zip(colours, actual.tolist(), strict=True):
        h, s, v = colorsys.rgb_to_hsv(*colour)
        assert turned == pytest.approx(colorsys.hsv_to_rgb((h + 0.2) % 1, s, v), abs=1e-7), colour


def test_raw_forms() -> None:
    hsv = rgb_to_hsv(photo(2, 3, 9, 11, torch.float64))
    turned = enhance.adjust_hue_raw(hsv, torch.tensor([5.0, -5.0], dtype=torch.float64)).numpy()
    for b, turn in enumerate((5.0, -5.0)):
        np.testing.assert_allclose(turned[b, 0], (hsv[b, 0].numpy() + turn) % (2 * math.pi), atol=1e-12)
        np.testing.assert_array_equal(turned[b, 1:], hsv[b, 1:])
    stronger = enhance.adjust_saturation_raw(hsv, 3.0).numpy()
    np.testing.assert_allclose(stronger[:, 1], np.clip(3.0 * hsv[:, 1].numpy(), 0, 1), atol=1e-12)
    np.testing.assert_array_equal(stronger[:, [0, 2]], hsv[:, [0, 2]])


def test_gradient_is_finite_on_grey() -> None:
    x = torch.tensor([0.0, 0.5, 1.0]).expand(3, 3)[None, :, None].clone().requires_grad_(True)
    factor = torch.tensor([1.5], requires_grad=True)
    (enhance.adjust_saturation(x, factor) + enhance.adjust_hue(x, factor)).square().sum().backward()
    assert torch.isfinite(x.grad).all()
    assert torch.isfinite(factor.grad).all()


X = torch.zeros(2, 3, 8, 8)
WRONG = [
    (
        lambda: enhance.adjust_hue(X[:, :2], 0.1),
        ValueError,
        r"image: expected shape \(\*, 3, H, W\), got \[2, 2, 8, 8\]",
    ),
    (lambda: enhance.adjust_hue(X, torch.ones(3)), ValueError, r"factor: expected a number, .* got \[3\]"),
    (lambda: enhance.adjust_saturation(X.int(), 0.1), TypeError, "image: expected a floating-point tensor"),
    (lambda: enhance.adjust_hue_raw(X[0, 0], 0.1), ValueError, "image: expected shape"),
    (lambda: enhance.adjust_saturation_raw(X, torch.ones(2, 1)), ValueError, "factor: expected a number"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
