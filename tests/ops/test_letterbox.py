"""Frames as a network's input: against OpenCV's resize and border, and slices."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import pipelines
from chiasm.geometry.bbox import transform_bbox
from chiasm.pipelines import center_crop, crop_boxes, letterbox, letterbox_longest
from chiasm.pipelines.letterbox import _multiples

SIZES = [(72, 128), (108, 192), (481, 333), (3, 200), (64, 64), (1, 1), (640, 9)]
MEAN, STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


def photo(height: int, width: int, seed: int = 0) -> np.ndarray:
    """A smooth image, like a photograph."""
    noise = np.random.default_rng(seed).integers(0, 256, (height // 8 + 1, width // 8 + 1, 3), np.uint8)
    return cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC)


def resized(image: np.ndarray, width: int, height: int) -> np.ndarray:
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_LINEAR_EXACT)


def normalised(image: np.ndarray, mean=(0.0, 0.0, 0.0), std=(1.0, 1.0, 1.0)) -> np.ndarray:
    """A BGR image as normalised planes R, G, B."""
    rgb = image[..., ::-1].astype(np.float64) / 255
    return ((rgb - np.array(mean)) / np.array(std)).transpose(2, 0, 1)


def fitted(height: int, width: int, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Width and height of the resized image and its left top corner, as in the recipe for YOLO."""
    ratio = min(size[0] / height, size[1] / width)
    new_width, new_height = max(round(width * ratio), 1), max(round(height * ratio), 1)
    return (
        new_width,
        new_height,
        round((size[1] - new_width) / 2 - 0.1),
        round((size[0] - new_height) / 2 - 0.1),
    )


@pytest.mark.parametrize("size", [(64, 64), (96, 61)])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_letterbox_is_resize_and_border(height: int, width: int, size: tuple[int, int]) -> None:
    frames = np.stack([photo(height, width, seed) for seed in range(2)])
    new_width, new_height, left, top = fitted(height, width, size)
    below, beside = size[0] - new_height - top, size[1] - new_width - left
    actual, to_frame = letterbox(torch.from_numpy(frames), size)
    for image, frame in zip(actual, frames, strict=True):
        inner = resized(frame, new_width, new_height)
        expected = cv2.copyMakeBorder(
            inner, top, below, left, beside, cv2.BORDER_CONSTANT, value=(114, 114, 114)
        )
        np.testing.assert_allclose(image, normalised(expected), atol=1e-6)
    corners = torch.tensor([[[left, top, left + new_width, top + new_height]]], dtype=torch.float32)
    back = transform_bbox(to_frame[:1], corners)
    torch.testing.assert_close(back[0, 0], torch.tensor([0.0, 0.0, width, height]), rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize(("longest", "multiple"), [(96, 32), (50, 14), (7, 2)])
@pytest.mark.parametrize(("height", "width"), [*SIZES, (200, 1), (161, 128)])
def test_the_longest_side_and_multiples(height: int, width: int, longest: int, multiple: int) -> None:
    frame = photo(height, width)
    ratio = longest / max(height, width)
    new_height, new_width = (max(round(side * ratio), 1) for side in (height, width))
    below, beside = -new_height % multiple, -new_width % multiple
    actual, to_frame = letterbox_longest(torch.from_numpy(frame)[None], longest, multiple)
    top, left = below // 2, beside // 2
    expected = cv2.copyMakeBorder(
        resized(frame, new_width, new_height),
        *(top, below - top, left, beside - left),
        cv2.BORDER_CONSTANT,
        value=(114, 114, 114),
    )
    np.testing.assert_allclose(actual[0], normalised(expected), atol=1e-6)
    corners = torch.tensor([[[left, top, left + new_width, top + new_height]]], dtype=torch.float32)
    back = transform_bbox(to_frame, corners)
    torch.testing.assert_close(back[0, 0], torch.tensor([0.0, 0.0, width, height]), rtol=1e-6, atol=1e-4)


def test_sizes_for_the_longest_side() -> None:
    """All ties of rounding, and frames that are almost lines."""
    random = np.random.default_rng(0)
    several = [*random.integers(1, 40, (3000, 2)), *random.integers(1, 9000, (3000, 2))]
    for height, width in [*several, *((n, 1280) for n in range(1, 1281)), (1, 9000), (9000, 1)]:
        for longest, multiple in [(640, 32), (640, 2), (333, 14), (1, 2)]:
            exact = Fraction(int(height) * longest, int(max(height, width)))
            expected = -(-max(round(exact), 1) // multiple)
            assert _multiples(int(height), int(width), longest, multiple) == expected


@pytest.mark.parametrize(("height", "width"), [(720, 1280), (1080, 1920), (427, 640), (333, 500)])
def test_letterbox_is_within_a_level_of_inter_linear(height: int, width: int) -> None:
    """YOLO's authors resize by INTER_LINEAR, whose weights are rounded differently."""
    frame = photo(height, width)
    new_width, new_height, left, top = fitted(height, width, (640, 640))
    inner = cv2.resize(frame, (new_width, new_height), interpolation=cv2.INTER_LINEAR)
    actual = letterbox(torch.from_numpy(frame)[None])[0][
        0, :, top : top + new_height, left : left + new_width
    ]
    assert np.abs(actual.numpy() - normalised(inner)).max() < 1.001 / 255


@pytest.mark.parametrize(
    ("color", "code"), [("rgb", "RGB"), ("bgra", "BGRA"), ("rgba", "RGBA"), ("gray", "GRAY")]
)
def test_orders_of_channels(color: str, code: str) -> None:
    """The result equals OpenCV's conversion to BGR, followed by the op for BGR."""
    channels = 1 if color == "gray" else len(color)
    frame = np.random.default_rng(3).integers(0, 256, (48, 64, channels), np.uint8)
    bgr = torch.from_numpy(cv2.cvtColor(frame, getattr(cv2, f"COLOR_{code}2BGR")))
    own, box = torch.from_numpy(frame), torch.tensor([[3.0, 4.0, 30.0, 41.0]])
    for op in (letterbox, center_crop):
        for made, expected in zip(op(own[None], (32, 40), color=color), op(bgr[None], (32, 40))):
            assert made.equal(expected)
    assert crop_boxes(own, box, (9, 8), color=color).equal(crop_boxes(bgr, box, (9, 8)))
    with pytest.raises(ValueError, match=rf"frame: expected shape \(B, H, W, {channels}\)"):
        letterbox(own[None, ..., :-1], color=color)


@pytest.mark.parametrize("form", ["nv12", "nv21", "i420", "yuyv"])
def test_formats_of_cameras(form: str) -> None:
    """The result equals OpenCV's conversion, followed by a letterbox."""
    buffer = np.random.default_rng(3).integers(0, 256, (90, 80), np.uint8)  # 60 rows of luma, then chroma
    y, chroma = torch.from_numpy(buffer[:60]).reshape(1, 60, 80, 1), torch.from_numpy(buffer[60:])
    if form in ("nv12", "nv21"):
        parts = [y, chroma.reshape(1, 30, 40, 2)]
        bgr = cv2.cvtColor(buffer, getattr(cv2, f"COLOR_YUV2BGR_{form.upper()}"))
    elif form == "i420":
        u, v = chroma.flatten().reshape(2, 1, 30, 40, 1)
        parts, bgr = [y, u, v], cv2.cvtColor(buffer, cv2.COLOR_YUV2BGR_I420)
    else:
        parts = [torch.from_numpy(buffer).reshape(1, 90, 20, 4)]
        bgr = cv2.cvtColor(buffer.reshape(90, 40, 2), cv2.COLOR_YUV2BGR_YUYV)
    expected, to_frame = letterbox(torch.from_numpy(bgr)[None], (64, 48), 7, "top_left", MEAN, STD)
    actual = getattr(pipelines, f"letterbox_{form}")(*parts, (64, 48), 7, "top_left", MEAN, STD)
    assert torch.equal(actual[0], expected) and torch.equal(actual[1], to_frame)


def test_wrong_parts_of_a_camera_frame() -> None:
    y, uv = torch.zeros(1, 8, 8, 1, dtype=torch.uint8), torch.zeros(1, 4, 4, 2, dtype=torch.uint8)
    with pytest.raises(ValueError, match=r"uv: expected"):
        pipelines.letterbox_nv12(y, uv[..., :1])
    with pytest.raises(ValueError, match=r"y: expected"):
        pipelines.letterbox_nv12(y[0], uv)
    with pytest.raises(TypeError, match=r"uv: expected"):
        pipelines.letterbox_nv12(y, uv.float())
    with pytest.raises(ValueError, match="anchor"):
        pipelines.letterbox_nv12(y, uv, anchor="left")


def test_boxes_there_and_back() -> None:
    generator = torch.Generator().manual_seed(0)
    to_frame = letterbox(torch.zeros(1, 427, 640, 3, dtype=torch.uint8))[1]
    low = torch.rand(100, 2, generator=generator) * torch.tensor([600.0, 400.0])
    boxes = torch.cat([low, low + 1 + 20 * torch.rand(100, 2, generator=generator)], 1)[None]
    there = transform_bbox(torch.linalg.inv(to_frame), boxes)
    torch.testing.assert_close(transform_bbox(to_frame, there), boxes, rtol=0, atol=1e-3)


def test_letterbox_in_a_corner_with_numbers() -> None:
    frame = photo(50, 100)
    actual = letterbox(torch.from_numpy(frame)[None], (64, 64), 7, "top_left", MEAN, STD, "rgb")[0]
    expected = np.full((64, 64, 3), 7, np.uint8)
    expected[:32] = resized(frame, 64, 32)
    np.testing.assert_allclose(actual[0], normalised(expected[..., ::-1], MEAN, STD), atol=1e-5)


@pytest.mark.parametrize("size", [(24, 32), (33, 33), (60, 40)])
@pytest.mark.parametrize(("height", "width"), [(72, 128), (128, 73), (41, 41), (200, 31)])
def test_center_crop_is_resize_and_slice(height: int, width: int, size: tuple[int, int]) -> None:
    frame = photo(height, width)
    shorter = min(height, width)
    new_height, new_width = height * 40 // shorter, width * 40 // shorter
    canvas = np.zeros((size[0] + 2 * new_height, size[1] + 2 * new_width, 3), np.uint8)
    top, left = round((size[0] - new_height) / 2), round((size[1] - new_width) / 2)
    place = slice(new_height + top, 2 * new_height + top), slice(new_width + left, 2 * new_width + left)
    canvas[place] = resized(frame, new_width, new_height)
    expected = canvas[new_height : new_height + size[0], new_width : new_width + size[1]]
    actual = center_crop(torch.from_numpy(frame)[None], size, 40)[0]
    np.testing.assert_allclose(actual[0], normalised(expected, MEAN, STD), atol=1e-5)


def test_crops_are_resized_slices() -> None:
    frame = photo(60, 90)
    boxes = torch.tensor([[0.0, 0.0, 90.0, 60.0], [10.2, 5.6, 40.4, 50.5], [7.0, 7.0, 8.0, 8.0]])
    actual = crop_boxes(torch.from_numpy(frame), boxes, (20, 32))
    for image, box in zip(actual, boxes.round().int().tolist(), strict=True):
        expected = resized(frame[box[1] : box[3], box[0] : box[2]], 32, 20)
        np.testing.assert_allclose(image, normalised(expected, MEAN, STD), atol=1e-5)


def test_crops_beyond_the_frame_repeat_its_edge() -> None:
    frame = photo(20, 30)
    box = (-6, -4, 34, 25)
    bordered = cv2.copyMakeBorder(frame, 4, 5, 6, 4, cv2.BORDER_REPLICATE)
    actual = crop_boxes(torch.from_numpy(frame), torch.tensor([box], dtype=torch.float32), (29, 17))
    np.testing.assert_allclose(actual[0], normalised(resized(bordered, 17, 29), MEAN, STD), atol=1e-5)


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -float("inf"), 3e38, -1e10])
def test_crops_of_any_numbers(wrong: float) -> None:
    boxes = torch.full((5, 4), 3.0)
    boxes.fill_diagonal_(wrong)
    boxes[4] = wrong
    result = crop_boxes(torch.from_numpy(photo(20, 30)), boxes, (4, 5))
    assert result.isfinite().all()


FRAME = torch.zeros(1, 4, 6, 3, dtype=torch.uint8)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: letterbox(FRAME.float()), TypeError, "frame: expected dtype torch.uint8"),
        (lambda: letterbox(FRAME[0]), ValueError, r"frame: expected shape \(B, H, W, 3\)"),
        (lambda: letterbox(FRAME, (0, 4)), ValueError, "size: expected positive"),
        (lambda: letterbox(FRAME, value=256), ValueError, "value: expected a whole number from 0 to 255"),
        (lambda: letterbox(FRAME, anchor="right"), ValueError, "anchor: expected one of"),
        (lambda: letterbox(FRAME, std=(1.0, 0.0, 1.0)), ValueError, "std: expected numbers above 0"),
        (lambda: letterbox(FRAME, color="grey"), ValueError, "color: expected one of"),
        (lambda: center_crop(FRAME, shortest=0), ValueError, "shortest: expected a positive"),
        (lambda: crop_boxes(FRAME, torch.zeros(1, 4)), ValueError, r"frame: expected .*\(H, W, 3\)"),
        (lambda: crop_boxes(FRAME[0], torch.zeros(4)), ValueError, "boxes: expected"),
        (lambda: crop_boxes(FRAME[0], torch.zeros(1, 4).int()), TypeError, "boxes: expected"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
