"""How frames fit, the filters, and the types and layouts of a network's input: against OpenCV, Pillow and
torchvision."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
import torchvision.transforms.functional as tv
from PIL import Image
from torch import Tensor

from chiasm.geometry.bbox import transform_bbox
from chiasm.pipelines import center_crop, crop_boxes, letterbox, pad_to_multiple

MEAN, STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Pillow's names of the filters with antialias.
FILTERS = {
    "bilinear": Image.Resampling.BILINEAR,
    "bicubic": Image.Resampling.BICUBIC,
    "lanczos": Image.Resampling.LANCZOS,
}
SIZES = [(480, 640), (427, 640), (333, 500), (120, 50), (1, 200), (31, 9), (1, 1)]


def noise(height: int, width: int, dtype: type = np.uint8, channels: int = 3) -> np.ndarray:
    top = np.iinfo(dtype).max
    return np.random.default_rng(0).integers(0, top, (height, width, channels), dtype, endpoint=True)


def place(height: int, width: int, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Left, top, width and height of the image in a letterbox, as YOLO's authors compute them."""
    ratio = min(size[0] / height, size[1] / width)
    inner = max(round(height * ratio), 1), max(round(width * ratio), 1)
    return (size[1] - inner[1]) // 2, (size[0] - inner[0]) // 2, inner[1], inner[0]


def framed(inner: np.ndarray, left: int, top: int, size: tuple[int, int], value: int) -> np.ndarray:
    canvas = np.full((*size, 3), value, inner.dtype)
    canvas[top : top + inner.shape[0], left : left + inner.shape[1]] = inner
    return canvas


def levels(result: tuple[Tensor, Tensor]) -> np.ndarray:
    return result[0][0].numpy().astype(np.int32)


def assert_near(actual: np.ndarray, expected: np.ndarray) -> None:
    apart = np.abs(actual.astype(np.int32) - expected)
    assert (apart <= 1).mean() >= 0.999
    assert apart.max() <= 2


def smooth(height: int, width: int) -> np.ndarray:
    small = noise(height // 8 + 1, width // 8 + 1)
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_antialias_is_pillows(height: int, width: int, name: str) -> None:
    """To the bit if Pillow resizes the rows and then the columns. In one call it may take the columns first;
    bytes between the two saturate, which shows in noise."""
    size, method = (96, 128), FILTERS[name]
    left, top, new_width, new_height = place(height, width, size)
    options = {"color": "rgb", "interpolation": name, "antialias": True, "dtype": "uint8", "layout": "NHWC"}

    frame = noise(height, width)
    batch = torch.from_numpy(frame)[None]
    for fit, inner in (("pad", (new_width, new_height)), ("stretch", size[::-1])):
        rows = Image.fromarray(frame).resize((inner[0], height), method)
        expected = np.asarray(rows.resize(inner, method))
        if fit == "pad":
            expected = framed(expected, left, top, size, 114)
        np.testing.assert_array_equal(levels(letterbox(batch, size, fit=fit, **options)), expected)

    frame = smooth(height, width)
    inner = np.asarray(Image.fromarray(frame).resize((new_width, new_height), method))
    actual = levels(letterbox(torch.from_numpy(frame)[None], size, **options))
    assert_near(actual, framed(inner, left, top, size, 114))


@pytest.mark.parametrize(("height", "width"), [(480, 640), (427, 640), (333, 500), (700, 201)])
def test_area_is_opencvs(height: int, width: int) -> None:
    frame, size = noise(height, width), (96, 128)
    left, top, new_width, new_height = place(height, width, size)
    inner = cv2.resize(frame, (new_width, new_height), interpolation=cv2.INTER_AREA)
    options = {"color": "rgb", "interpolation": "area", "dtype": "uint8", "layout": "NHWC"}
    batch = torch.from_numpy(frame)[None]
    assert_near(levels(letterbox(batch, size, **options)), framed(inner, left, top, size, 114))
    stretched = cv2.resize(frame, size[::-1], interpolation=cv2.INTER_AREA)
    assert_near(levels(letterbox(batch, size, fit="stretch", **options)), stretched)


@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic", "lanczos", "area"])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_white_of_16_bits_stays_white(height: int, width: int, interpolation: str) -> None:
    frame = torch.full((1, height, width, 3), 65535, dtype=torch.uint16)
    for antialias in {"area": [False], "bilinear": [False, True]}.get(interpolation, [True]):
        image = letterbox(frame, (64, 96), fit="stretch", interpolation=interpolation, antialias=antialias)[0]
        torch.testing.assert_close(image, torch.ones(1, 3, 64, 96), rtol=0.0, atol=1e-7)


def test_area_of_16_bits_is_the_rounded_mean() -> None:
    frame = noise(96, 320, np.uint16)
    means = frame.reshape(32, 3, 64, 5, 3).astype(np.int64).sum((1, 3))
    expected = (2 * means + 15) // 30 / np.float32(65535)
    batch = torch.from_numpy(frame)[None]
    actual = letterbox(batch, (32, 64), fit="stretch", color="rgb", interpolation="area")[0]
    np.testing.assert_allclose(actual[0].permute(1, 2, 0), expected, rtol=1e-6)


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_stretch_is_a_resize(height: int, width: int) -> None:
    frame = noise(height, width)
    image, to_frame = letterbox(torch.from_numpy(frame)[None], (64, 96), fit="stretch", color="rgb")
    expected = cv2.resize(frame, (96, 64), interpolation=cv2.INTER_LINEAR_EXACT) / 255
    np.testing.assert_allclose(image[0].permute(1, 2, 0), expected, atol=1e-6)
    whole = transform_bbox(to_frame, torch.tensor([[[0.0, 0.0, 96.0, 64.0]]]))
    np.testing.assert_allclose(whole[0, 0], [0, 0, width, height], rtol=1e-6)


@pytest.mark.parametrize(("height", "width"), [(480, 640), (640, 427), (333, 500), (257, 256), (120, 50)])
def test_center_crop_is_imagenets_recipe(height: int, width: int) -> None:
    """torchvision's Resize and CenterCrop of an image of Pillow, ToTensor, Normalize."""
    frame = noise(height, width)
    picture = tv.center_crop(tv.resize(Image.fromarray(frame), [96], antialias=True), [80, 80])
    expected = tv.normalize(tv.to_tensor(picture), list(MEAN), list(STD)).numpy()
    batch = torch.from_numpy(frame)[None]
    actual = center_crop(batch, (80, 80), 96, color="rgb", antialias=True)[0][0].numpy()
    deviations = np.array(STD)[:, None, None]
    assert (np.abs(actual - expected) * deviations * 255 <= 1.001).mean() >= 0.999


@pytest.mark.parametrize("anchor", ["center", "top_left"])
@pytest.mark.parametrize(("height", "width"), [(427, 640), (64, 32), (65, 31), (1, 1)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_pad_to_multiple_is_a_border(height: int, width: int, anchor: str, dtype: type) -> None:
    frame = noise(height, width, dtype)
    below, beside = -height % 32, -width % 32
    top, left = (below // 2, beside // 2) if anchor == "center" else (0, 0)
    grey = 7 if dtype is np.uint8 else 7 * 257
    edges = top, below - top, left, beside - left
    expected = cv2.copyMakeBorder(frame, *edges, cv2.BORDER_CONSTANT, value=(grey,) * 3)
    expected = cv2.cvtColor(expected, cv2.COLOR_BGR2RGB) / np.float32(np.iinfo(dtype).max)
    image, to_frame = pad_to_multiple(torch.from_numpy(frame)[None], 32, 7, anchor, layout="NHWC")
    np.testing.assert_allclose(image[0], expected, atol=1e-6)
    corner = transform_bbox(to_frame, torch.tensor([[[left, top, left + width, top + height]]]).float())
    assert corner.tolist() == [[[0.0, 0.0, width, height]]]


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_frames_of_16_bits(height: int, width: int) -> None:
    frame, size = noise(height, width, np.uint16), (96, 128)
    left, top, new_width, new_height = place(height, width, size)
    inner = cv2.resize(frame, (new_width, new_height), interpolation=cv2.INTER_LINEAR)
    expected = framed(inner, left, top, size, 114 * 257)[..., ::-1]
    image = letterbox(torch.from_numpy(frame)[None], size, layout="NHWC")[0][0].numpy()
    assert np.abs(np.rint(image * 65535) - expected).max() <= 1
    grey = letterbox(torch.from_numpy(frame[..., :1].copy())[None], size, color="gray")[0][0].numpy()
    assert np.abs(np.rint(grey * 65535) - expected[..., 2]).max() <= 1


def test_16_bits_with_antialias_are_pillows_floats_rounded() -> None:
    frame, size = noise(211, 300, np.uint16), (50, 64)
    planes = [Image.fromarray(plane.astype(np.float32)) for plane in np.moveaxis(frame, 2, 0)]
    expected = np.stack([np.asarray(p.resize(size[::-1], FILTERS["lanczos"])) for p in planes])
    expected = np.rint(expected.clip(0, 65535))
    options = {"color": "rgb", "fit": "stretch", "interpolation": "lanczos", "antialias": True}
    made = letterbox(torch.from_numpy(frame)[None], size, **options)[0][0].numpy()
    assert np.abs(np.rint(made * 65535) - expected).max() <= 2


@pytest.mark.parametrize("layout", ["NCHW", "NHWC"])
@pytest.mark.parametrize("dtype", ["float32", "float16", "uint8"])
def test_types_and_layouts(dtype: str, layout: str) -> None:
    """The steps of OpenCV; float16 rounds the normalised numbers, as NumPy does."""
    frame, mean, std = noise(72, 128), MEAN, STD
    if dtype == "uint8":
        mean, std = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    inner = cv2.resize(frame, (64, 36), interpolation=cv2.INTER_LINEAR_EXACT)
    expected = framed(inner, 0, 6, (48, 64), 114)[..., ::-1]
    if dtype != "uint8":
        expected = ((expected / 255 - np.array(mean)) / np.array(std)).astype(dtype)
    if layout == "NCHW":
        expected = expected.transpose(2, 0, 1)
    image = letterbox(
        torch.from_numpy(frame)[None], (48, 64), 114, "center", mean, std, dtype=dtype, layout=layout
    )
    assert image[0].dtype == getattr(torch, dtype) and image[0].is_contiguous()
    near = {"uint8": 0, "float32": 1e-5, "float16": 2e-3}[dtype]
    np.testing.assert_allclose(image[0][0].numpy(), expected, atol=near)


def test_crops_of_bytes() -> None:
    frame = noise(60, 90)
    made = crop_boxes(
        torch.from_numpy(frame),
        torch.tensor([[10.0, 5.0, 40.0, 50.0]]),
        (20, 32),
        (0.0, 0.0, 0.0),
        (1.0, 1.0, 1.0),
        dtype="uint8",
        layout="NHWC",
    )
    expected = cv2.resize(frame[5:50, 10:40], (32, 20), interpolation=cv2.INTER_LINEAR_EXACT)
    np.testing.assert_array_equal(made[0], expected[..., ::-1])


@pytest.mark.parametrize(
    "call",
    [
        lambda frame: letterbox(frame, fit="stretch"),
        lambda frame: letterbox(frame, antialias=True),
        lambda frame: letterbox(frame, (320, 640), anchor="top_left", interpolation="area"),
        lambda frame: center_crop(frame, antialias=True),
        lambda frame: pad_to_multiple(frame, 64),
    ],
)
def test_boxes_there_and_back(call: Callable[[Tensor], tuple[Tensor, Tensor]]) -> None:
    to_frame = call(torch.zeros(1, 427, 640, 3, dtype=torch.uint8))[1]
    low = torch.rand(100, 2, generator=torch.Generator().manual_seed(0)) * torch.tensor([600.0, 400.0])
    boxes = torch.cat([low, low + 20.0], 1)[None]
    there = transform_bbox(torch.linalg.inv(to_frame), boxes)
    torch.testing.assert_close(transform_bbox(to_frame, there), boxes, rtol=0, atol=1e-3)


FRAME = torch.zeros(1, 4, 6, 3, dtype=torch.uint8)
WORDS = FRAME.to(torch.uint16)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: letterbox(FRAME.int()),
            TypeError,
            "frame: expected dtype torch.uint8 or torch.uint16, got torch.int32",
        ),
        (
            lambda: crop_boxes(WORDS[0], torch.zeros(1, 4)),
            TypeError,
            "frame: expected dtype torch.uint8, got torch.uint16",
        ),
        (lambda: letterbox(FRAME, fit="crop"), ValueError, "fit: expected one of .*, got 'crop'"),
        (
            lambda: letterbox(FRAME, interpolation="bicubic"),
            ValueError,
            "antialias: expected True for interpolation 'bicubic', got False",
        ),
        (
            lambda: center_crop(FRAME, interpolation="area", antialias=True),
            ValueError,
            "antialias: expected False for interpolation 'area', got True",
        ),
        (lambda: letterbox(FRAME, dtype="int8"), ValueError, "dtype: expected one of"),
        (lambda: letterbox(FRAME, layout="HWC"), ValueError, "layout: expected one of"),
        (lambda: letterbox(WORDS, dtype="uint8"), ValueError, "dtype: expected 'float32' or 'float16'"),
        (lambda: center_crop(FRAME, dtype="uint8"), ValueError, "mean: expected zeros for dtype 'uint8'"),
        (
            lambda: letterbox(FRAME, std=(1.0, 2.0, 1.0), dtype="uint8"),
            ValueError,
            "std: expected ones for dtype 'uint8'",
        ),
        (lambda: pad_to_multiple(FRAME, 0), ValueError, "multiple: expected a positive whole number, got 0"),
        (lambda: pad_to_multiple(FRAME, anchor="left"), ValueError, "anchor: expected one of"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
