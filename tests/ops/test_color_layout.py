"""Channel order, alpha, bytes and sepia against OpenCV, Pillow and NumPy."""

from typing import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import chw, hwc, photo
from PIL import Image

from chiasm import color


def as_bytes(x: torch.Tensor) -> torch.Tensor:
    return torch.round(x * 255).to(torch.uint8)


@pytest.mark.parametrize("size", [(37, 53), (64, 31), (1, 7)])
@pytest.mark.parametrize(("name", "channels", "code"), [
    ("bgr_to_rgb", 3, cv2.COLOR_BGR2RGB),
    ("rgb_to_bgr", 3, cv2.COLOR_RGB2BGR),
    ("rgba_to_rgb", 4, cv2.COLOR_RGBA2RGB),
    ("rgba_to_bgr", 4, cv2.COLOR_RGBA2BGR),
    ("grayscale_to_rgb", 1, cv2.COLOR_GRAY2RGB),
    ("bgr_to_grayscale", 3, cv2.COLOR_BGR2GRAY),
])  # fmt: skip
def test_equals_opencv(name: str, channels: int, code: int, size: tuple[int, int]) -> None:
    x = photo(3, channels, *size)
    actual = getattr(color, name)(x)
    for b in range(3):
        np.testing.assert_allclose(actual[b], chw(cv2.cvtColor(hwc(x, b), code)), atol=1e-6)


@pytest.mark.parametrize(
    "name", ["bgr_to_rgb", "rgb_to_bgr", "rgba_to_rgb", "rgba_to_bgr", "grayscale_to_rgb"]
)
def test_bytes_stay_bytes(name: str) -> None:
    channels = 1 if name.startswith("gray") else 4 if name.startswith("rgba") else 3
    x = photo(2, channels, 5, 7)
    assert torch.equal(getattr(color, name)(as_bytes(x)), as_bytes(getattr(color, name)(x)))


@pytest.mark.parametrize(("name", "order"), [("rgb_to_rgba", [0, 1, 2]), ("bgr_to_rgba", [2, 1, 0])])
def test_alpha_is_appended(name: str, order: list[int]) -> None:
    x = photo(2, 4, 11, 13)
    rgb, alpha = x[:, :3], x[:, 3:]
    actual = getattr(color, name)(rgb, alpha)
    np.testing.assert_array_equal(actual, np.concatenate([x.numpy()[:, order], alpha], 1))
    constant = getattr(color, name)(as_bytes(rgb), 200.0)
    np.testing.assert_array_equal(constant[:, 3], np.full((2, 11, 13), 200, np.uint8))


def test_blend_equals_pillow() -> None:
    x = photo(2, 4, 37, 53)
    background = np.array([30, 200, 90], np.uint8)
    actual = color.rgba_to_rgb(as_bytes(x).double() / 255, torch.from_numpy(background).double() / 255)
    for b in range(2):
        over = Image.fromarray(hwc(as_bytes(x), b), "RGBA")
        below = Image.new("RGBA", over.size, (*background.tolist(), 255))
        expected = np.asarray(Image.alpha_composite(below, over))[..., :3].astype(np.float64)
        assert np.abs(hwc(actual, b) * 255 - expected).max() <= 0.51
    numbers = tuple((background / 255.0).tolist())
    for given in (
        numbers,
        torch.tensor(numbers).view(3, 1, 1),
        torch.tensor(numbers).view(3, 1, 1).expand(2, 3, 37, 53),
    ):
        made = color.rgba_to_rgb(as_bytes(x).double() / 255, given)
        torch.testing.assert_close(made, actual, rtol=0, atol=1e-7)
        assert torch.jit.script(color.RgbaToRgb(given))(as_bytes(x).double() / 255).equal(made)


def test_bytes_equal_numpy_and_opencv() -> None:
    x = photo(2, 3, 37, 53) * 4 - 2
    assert x.min() < 0 and x.max() > 1
    actual = color.rgb_to_rgb255(x)
    assert actual.dtype == torch.uint8
    np.testing.assert_array_equal(actual, np.clip(np.rint(x.numpy() * np.float32(255)), 0, 255))
    for b in range(2):
        np.testing.assert_array_equal(
            hwc(actual, b), cv2.addWeighted(hwc(x, b), 255.0, hwc(x, b), 0.0, 0.0, dtype=cv2.CV_8U)
        )


def test_every_byte_returns() -> None:
    levels = torch.arange(256, dtype=torch.uint8).expand(1, 3, 1, 256)
    unit = color.rgb255_to_rgb(levels)
    assert unit.dtype == torch.float32
    np.testing.assert_array_equal(unit, levels.numpy() / np.float32(255))
    assert torch.equal(color.rgb_to_rgb255(unit), levels)
    assert color.rgb255_to_rgb(levels.double()).dtype == torch.float64


def test_normals() -> None:
    generator = np.random.default_rng(0)
    normals = generator.standard_normal((2, 3, 19, 23))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    coded = color.normals_to_rgb255(torch.from_numpy(normals))
    np.testing.assert_array_equal(coded, np.rint((normals + 1) * 127.5).astype(np.uint8))
    back = color.rgb255_to_normals(coded)
    expected = coded.numpy() / 127.5 - 1
    np.testing.assert_allclose(back, expected / np.linalg.norm(expected, axis=1, keepdims=True), atol=1e-6)
    assert np.abs(back.numpy() - normals).max() < 0.01


def test_normal_of_no_length() -> None:
    x = torch.full((1, 3, 1, 1), 127.5, dtype=torch.float64, requires_grad=True)
    normal = color.rgb255_to_normals(x)
    normal.sum().backward()
    assert (normal == 0).all() and (x.grad == 0).all()


@pytest.mark.parametrize("size", [(37, 53), (64, 31)])
def test_sepia_equals_opencv(size: tuple[int, int]) -> None:
    matrix = np.array([[0.393, 0.769, 0.189], [0.349, 0.686, 0.168], [0.272, 0.534, 0.131]], np.float32)
    x = photo(3, 3, *size)
    for b in range(3):
        toned = cv2.transform(hwc(x, b), matrix)
        np.testing.assert_allclose(color.sepia(x, rescale=False)[b], chw(toned), atol=1e-6)
        np.testing.assert_allclose(color.sepia(x)[b], chw(toned / (toned.max() + 1e-6)), atol=1e-6)
        np.testing.assert_allclose(color.sepia(x, eps=0.5)[b], chw(toned / (toned.max() + 0.5)), atol=1e-6)


X = torch.zeros(1, 3, 4, 4)
WRONG = [
    (
        lambda: color.rgb_to_bgr(X[:, :1]),
        ValueError,
        r"image: expected shape \(\*, 3, H, W\), got \[1, 1, 4, 4\]",
    ),
    (
        lambda: color.grayscale_to_rgb(X),
        ValueError,
        r"image: expected shape \(\*, 1, H, W\), got \[1, 3, 4, 4\]",
    ),
    (lambda: color.rgba_to_rgb(X), ValueError, r"image: expected shape \(\*, 4, H, W\), got \[1, 3, 4, 4\]"),
    (lambda: color.rgba_to_bgr(X), ValueError, r"image: expected shape \(\*, 4, H, W\)"),
    (
        lambda: color.rgba_to_rgb(X[:, [0, 0, 0, 0]], torch.ones(4)),
        ValueError,
        r"background_color: expected shape \(\*, 3, H, W\), got \[4, 1, 1\]",
    ),
    (
        lambda: color.rgba_to_rgb(X[:, [0, 0, 0, 0]], (1.0, 1.0)),
        ValueError,
        "background_color: expected 3 numbers, got 2",
    ),
    (
        lambda: color.rgba_to_rgb(X[:, [0, 0, 0, 0]].byte(), torch.ones(3)),
        TypeError,
        "image: expected a floating-point",
    ),
    (lambda: color.rgb_to_rgba(X[:, :2], 1.0), ValueError, "image: expected shape"),
    (
        lambda: color.bgr_to_rgba(X, X),
        ValueError,
        r"alpha_val: expected shape \(\*, 1, H, W\), got \[1, 3, 4, 4\]",
    ),
    (lambda: color.rgb_to_rgba(X, X[:, :1, :3]), ValueError, r"alpha_val: expected .* got \[1, 1, 3, 4\]"),
    (lambda: color.rgb_to_rgb255(X.int()), TypeError, "image: expected a floating-point"),
    (lambda: color.rgb_to_rgb255(X[0, 0]), ValueError, "image: expected shape"),
    (lambda: color.normals_to_rgb255(X.int()), TypeError, "image: expected a floating-point"),
    (lambda: color.rgb255_to_rgb(X[:, :2]), ValueError, "image: expected shape"),
    (lambda: color.rgb255_to_normals(X[:, :2]), ValueError, "image: expected shape"),
    (lambda: color.sepia(X[:, :2]), ValueError, "input: expected shape"),
    (lambda: color.sepia(X.int()), TypeError, "input: expected a floating-point"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=range(len(WRONG)))
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
