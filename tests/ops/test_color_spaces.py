"""Colour spaces against OpenCV (float32 and uint8), scikit-image and colorsys: a grid of all colours, and
photographs."""

import colorsys
import itertools
import math
from typing import Callable

import cv2
import numpy as np
import pytest
import skimage.color
import torch
from photos import hwc, photo
from torch import Tensor

from chiasm import color
from chiasm.primitives.core.target import exporting

LEVELS = np.linspace(0.0, 1.0, 17)
#: All combinations of 17 levels, including greys, primaries, black and white, as one image (1, 3, 289, 17).
GRID = (
    torch.from_numpy(np.array(list(itertools.product(LEVELS, LEVELS, LEVELS))))
    .reshape(1, 289, 17, 3)
    .permute(0, 3, 1, 2)
    .contiguous()
)
DEGREES = np.array([180 / math.pi, 1.0, 1.0], np.float32)
SCENES = [GRID, *(photo(3, 3, 37, 53, torch.float64)[b : b + 1] for b in range(3))]


def pixels(x: Tensor) -> np.ndarray:
    """(H, W, 3) of a batch of one."""
    return hwc(x)


# name, OpenCV's code, ours in OpenCV's units and order, tolerances of its three channels
FORWARD = [
    ("hsv", cv2.COLOR_RGB2HSV, lambda p: p * DEGREES, (3e-4, 5e-6, 1e-7)),
    ("hls", cv2.COLOR_RGB2HLS, lambda p: p * DEGREES, (3e-4, 1e-6, 5e-6)),
    ("xyz", cv2.COLOR_RGB2XYZ, lambda p: p, (1e-6, 1e-6, 1e-6)),
    # OpenCV's cube root and transfer function are splines
    ("lab", cv2.COLOR_RGB2Lab, lambda p: p, (5e-3, 1e-2, 1e-2)),
    ("luv", cv2.COLOR_RGB2Luv, lambda p: p, (5e-3, 1e-2, 2e-2)),
    ("ycbcr", cv2.COLOR_RGB2YCrCb, lambda p: p[..., [0, 2, 1]], (1e-6, 1e-6, 1e-6)),
    # OpenCV's factors have three digits
    ("yuv", cv2.COLOR_RGB2YUV, lambda p: p + np.array([0.0, 0.5, 0.5], np.float32), (1e-6, 2e-4, 3e-4)),
]


@pytest.mark.parametrize("scene", SCENES, ids=["grid", "astronaut", "chelsea", "coffee"])
@pytest.mark.parametrize(("name", "code", "convert", "tolerance"), FORWARD, ids=[f[0] for f in FORWARD])
def test_forward_equals_opencv(
    name: str, code: int, convert: Callable, tolerance: tuple[float, ...], scene: Tensor
) -> None:
    x = scene.float()
    actual = convert(pixels(getattr(color, f"rgb_to_{name}")(x)))
    difference = np.abs(actual - cv2.cvtColor(pixels(x), code))
    if name in ("hsv", "hls"):
        difference[..., 0] = np.minimum(difference[..., 0], 360.0 - difference[..., 0])
    if name == "lab" and scene is not GRID:
        # OpenCV interpolates Lab from a table of 33^3 colours, which contains the grid's
        tolerance = (
            0.2,
            0.3,
            0.3,
        )
    assert (difference.reshape(-1, 3).max(0) <= tolerance).all(), difference.reshape(-1, 3).max(0)


# name, OpenCV's code, ours in OpenCV's bytes; tolerances as documented
BYTES = [
    ("hsv", cv2.COLOR_RGB2HSV, lambda p: p * np.array([90 / math.pi, 255.0, 255.0])),
    ("hls", cv2.COLOR_RGB2HLS, lambda p: p * np.array([90 / math.pi, 255.0, 255.0])),
    ("xyz", cv2.COLOR_RGB2XYZ, lambda p: p * 255.0),
    ("lab", cv2.COLOR_RGB2Lab, lambda p: p * np.array([2.55, 1.0, 1.0]) + np.array([0.0, 128.0, 128.0])),
    (
        "luv",
        cv2.COLOR_RGB2Luv,
        lambda p: (p + np.array([0.0, 134.0, 140.0])) * np.array([2.55, 255 / 354, 255 / 262]),
    ),
    ("ycbcr", cv2.COLOR_RGB2YCrCb, lambda p: p[..., [0, 2, 1]] * 255.0 + np.array([0.0, 0.5, 0.5])),
    ("yuv", cv2.COLOR_RGB2YUV, lambda p: p * 255.0 + np.array([0.0, 128.0, 128.0])),
]


@pytest.mark.parametrize("scene", SCENES, ids=["grid", "astronaut", "chelsea", "coffee"])
@pytest.mark.parametrize(("name", "code", "convert"), BYTES, ids=[b[0] for b in BYTES])
def test_forward_equals_opencv_bytes(name: str, code: int, convert: Callable, scene: Tensor) -> None:
    levels = np.rint(pixels(scene) * 255).astype(np.uint8)
    x = torch.from_numpy(levels).permute(2, 0, 1)[None].float() / 255
    ours = np.clip(np.rint(convert(pixels(getattr(color, f"rgb_to_{name}")(x)))), 0, 255)
    difference = np.abs(ours - cv2.cvtColor(levels, code).astype(np.float64))
    if name in ("hsv", "hls"):
        difference[..., 0] = np.minimum(difference[..., 0], 180.0 - difference[..., 0])
    # OpenCV interpolates Lab from a table of 33^3 colours: some a differ by two levels
    assert (difference > 1).mean() <= (5e-4 if name == "lab" else 0.0)
    assert difference.max() <= (2 if name == "lab" else 1)


INVERSE = [
    ("hsv", cv2.COLOR_HSV2RGB, np.array([2 * math.pi, 1.0, 1.0]), lambda p: p * DEGREES),
    ("hls", cv2.COLOR_HLS2RGB, np.array([2 * math.pi, 1.0, 1.0]), lambda p: p * DEGREES),
    ("xyz", cv2.COLOR_XYZ2RGB, np.ones(3), lambda p: p),
    ("ycbcr", cv2.COLOR_YCrCb2RGB, np.ones(3), lambda p: p[..., [0, 2, 1]]),
]


@pytest.mark.parametrize(("name", "code", "span", "convert"), INVERSE, ids=[i[0] for i in INVERSE])
def test_inverse_equals_opencv(name: str, code: int, span: np.ndarray, convert: Callable) -> None:
    x = (GRID * torch.from_numpy(span)[:, None, None]).float()
    expected = cv2.cvtColor(np.ascontiguousarray(convert(pixels(x))), code)
    np.testing.assert_allclose(pixels(getattr(color, f"{name}_to_rgb")(x)), expected, atol=1e-5)


def test_lab_inverse_equals_opencv() -> None:
    lab = color.rgb_to_lab(GRID.float())
    np.testing.assert_allclose(
        pixels(color.lab_to_rgb(lab)), cv2.cvtColor(pixels(lab), cv2.COLOR_Lab2RGB), atol=1e-4
    )


def test_luv_inverse_equals_opencv() -> None:
    luv = color.rgb_to_luv(GRID.float())
    light = pixels(GRID).max(-1) > 0.2  # OpenCV's splines are inaccurate for dark colours
    expected = cv2.cvtColor(pixels(luv), cv2.COLOR_Luv2RGB)
    np.testing.assert_allclose(pixels(color.luv_to_rgb(luv))[light], expected[light], atol=1e-2)


def test_lab_outside_srgb_is_clipped_on_request() -> None:
    lab = GRID * 2 - 1
    lab = (
        lab * torch.tensor([50.0, 120.0, 120.0])[:, None, None]
        + torch.tensor([50.0, 0.0, 0.0])[:, None, None]
    )
    free = color.lab_to_rgb(lab, clip=False)
    assert free.max() > 1.1 and free.min() < -0.1
    torch.testing.assert_close(color.lab_to_rgb(lab), free.clamp(0, 1))
    expected = skimage.color.lab2rgb(pixels(lab))  # it sets negative Z to 0
    z = (pixels(lab)[..., 0] + 16) / 116 - pixels(lab)[..., 2] / 200
    np.testing.assert_allclose(pixels(color.lab_to_rgb(lab))[z > 0.14], expected[z > 0.14], atol=2e-3)


# name, function of scikit-image, tolerance (its white has five digits, its matrix of YUV six)
SKIMAGE = [
    ("lab", skimage.color.rgb2lab, 6e-3),
    ("luv", skimage.color.rgb2luv, 1e-2),
    ("yuv", skimage.color.rgb2yuv, 3e-5),
]


@pytest.mark.parametrize("scene", SCENES, ids=["grid", "astronaut", "chelsea", "coffee"])
@pytest.mark.parametrize(("name", "function", "tolerance"), SKIMAGE, ids=[s[0] for s in SKIMAGE])
def test_equals_skimage(name: str, function: Callable, tolerance: float, scene: Tensor) -> None:
    np.testing.assert_allclose(
        pixels(getattr(color, f"rgb_to_{name}")(scene)), function(pixels(scene)), atol=tolerance
    )


@pytest.mark.parametrize("scene", SCENES, ids=["grid", "astronaut", "chelsea", "coffee"])
def test_linear_light_equals_skimage(scene: Tensor) -> None:
    linear = color.rgb_to_linear_rgb(scene)
    # scikit-image's rgb2xyz linearises and multiplies by the same matrix
    np.testing.assert_allclose(
        pixels(color.rgb_to_xyz(linear)), skimage.color.rgb2xyz(pixels(scene)), atol=1e-7
    )
    np.testing.assert_allclose(pixels(color.linear_rgb_to_rgb(linear)), pixels(scene), atol=1e-7)


def test_equals_colorsys() -> None:
    x = GRID[..., ::5, :]
    hls, back = color.rgb_to_hls(x), color.hls_to_rgb(x * torch.tensor([2 * math.pi, 1, 1])[:, None, None])
    hsv_back = color.hsv_to_rgb(x * torch.tensor([2 * math.pi, 1, 1])[:, None, None])
    for i, colour in enumerate(x[0].flatten(1).T.tolist()):
        h, lightness, s = colorsys.rgb_to_hls(*colour)
        if s == 0:
            h = 0.0
        assert hls[0].flatten(1)[:, i].tolist() == pytest.approx((2 * math.pi * h, lightness, s), abs=1e-6), (
            colour
        )
        assert back[0].flatten(1)[:, i].tolist() == pytest.approx(colorsys.hls_to_rgb(*colour), abs=1e-6), (
            colour
        )
        assert hsv_back[0].flatten(1)[:, i].tolist() == pytest.approx(
            colorsys.hsv_to_rgb(*colour), abs=1e-6
        ), colour


def test_hue_of_any_number_of_turns() -> None:
    x = GRID * torch.tensor([2 * math.pi, 1, 1])[:, None, None]
    turned = x + torch.tensor([-4 * math.pi, 0, 0])[:, None, None]
    torch.testing.assert_close(color.hsv_to_rgb(turned), color.hsv_to_rgb(x), atol=1e-6, rtol=0)
    torch.testing.assert_close(color.hls_to_rgb(turned), color.hls_to_rgb(x), atol=1e-6, rtol=0)


SPACES = ["hls", "hsl", "hsv", "lab", "linear_rgb", "luv", "xyz", "ycbcr", "yuv"]


@pytest.mark.parametrize("name", SPACES)
def test_round_trip(name: str) -> None:
    there, back = getattr(color, f"rgb_to_{name}"), getattr(color, f"{name}_to_rgb")
    for dtype, tolerance in (
        (torch.float64, 1e-7),
        (torch.float32, 3e-5),
        (torch.float16, 0.1),
        (torch.bfloat16, 0.5),
    ):
        if name == "ycbcr":  # OpenCV's constants
            tolerance = max(tolerance, 1e-3)
        x = GRID.to(dtype)
        result = back(there(x))
        assert result.dtype == dtype
        torch.testing.assert_close(result, x, atol=tolerance, rtol=0)


@pytest.mark.parametrize("name", SPACES)
@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_gradients_are_finite_on_all_colours(name: str, dtype: torch.dtype) -> None:
    x = GRID.to(dtype).requires_grad_(True)
    forward = getattr(color, f"rgb_to_{name}")(x)
    assert torch.isfinite(torch.autograd.grad(forward.sum(), x)[0]).all()
    y = forward.detach().requires_grad_(True)
    assert torch.isfinite(torch.autograd.grad(getattr(color, f"{name}_to_rgb")(y).sum(), y)[0]).all()


def test_lab_and_luv_of_greys_have_no_chroma() -> None:
    grey = torch.linspace(0, 1, 101, dtype=torch.float64).expand(1, 3, 1, 101)
    assert color.rgb_to_lab(grey)[:, 1:].abs().max() < 1e-12
    assert color.rgb_to_luv(grey)[:, 1:].abs().max() < 1e-9  # eps


@pytest.mark.parametrize(
    "name", [*(f"rgb_to_{s}" for s in SPACES), "xyz_to_rgb", "yuv_to_rgb", "rgb_to_y", "bgr_to_grayscale"]
)
def test_form_for_onnx_equals_eager_in_float32(name: str) -> None:
    """The convolution is for float32 only, which the tests of every op, in float64, do not cover."""
    function, x = getattr(color, name), photo(2, 3, 19, 22)
    with exporting("onnx"):
        torch.testing.assert_close(function(x), function(x.double()).float(), atol=1e-4, rtol=1e-5)
        assert function(x[0]).shape == function(x)[0].shape


@pytest.mark.parametrize(
    "name",
    [f"rgb_to_{s}" for s in SPACES] + [f"{s}_to_rgb" for s in SPACES] + ["rgb_to_y", "bgr_to_grayscale"],
)
def test_any_leading_shape(name: str) -> None:
    function, x = getattr(color, name), photo(2, 3, 5, 7, torch.float64)
    torch.testing.assert_close(function(x[0]), function(x)[0])
    torch.testing.assert_close(function(x[None]), function(x)[None])


@pytest.mark.parametrize(
    "name",
    [f"rgb_to_{s}" for s in SPACES] + [f"{s}_to_rgb" for s in SPACES] + ["rgb_to_y", "bgr_to_grayscale"],
)
@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (torch.zeros(2, 4, 4), ValueError, r"image: expected shape \(\*, 3, H, W\), got \[2, 4, 4\]"),
        (torch.zeros(3, 4), ValueError, "image: expected shape"),
        (
            torch.zeros(1, 3, 4, 4, dtype=torch.int32),
            TypeError,
            "image: expected a floating-point.* tensor, got dtype torch.int32",
        ),
    ],
)
def test_message(name: str, value: Tensor, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        getattr(color, name)(value)
