"""Flips, crops, rescaling and pyramids against NumPy, torch, OpenCV and Pillow's conventions."""

import cv2
import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import chw, hwc, photo
from torch import Tensor

from chiasm.geometry.transform import (
    CenterCrop2D,
    build_laplacian_pyramid,
    build_pyramid,
    center_crop,
    crop_and_resize,
    crop_by_boxes,
    crop_by_indices,
    crop_by_transform_mat,
    hflip,
    pyrdown,
    pyrup,
    rescale,
    resize,
    resize_to_be_divisible,
    rot180,
    vflip,
)
from chiasm.primitives.core.window_sizes import as_ratio

D = torch.float64
X = photo(2, 3, 37, 53, D)
CV_BORDER = {
    "reflect": cv2.BORDER_REFLECT_101,
    "replicate": cv2.BORDER_REPLICATE,
    "constant": cv2.BORDER_CONSTANT,
}


def test_flips() -> None:
    array = X.numpy()
    np.testing.assert_array_equal(hflip(X), array[..., ::-1])
    np.testing.assert_array_equal(vflip(X), array[..., ::-1, :])
    np.testing.assert_array_equal(rot180(X), np.rot90(array, 2, (2, 3)))


@pytest.mark.parametrize(
    ("value", "ratio"),
    [
        (0.3, (3, 10)),
        (2.0, (2, 1)),
        (1 / 3, (1, 3)),
        (0.7071067811865476, None),
        (1e-3, (1, 1000)),
        (12.5, (25, 2)),
    ],
)
def test_ratios(value: float, ratio: tuple[int, int] | None) -> None:
    p, q = as_ratio(value)
    assert q <= 65536
    assert abs(p / q - value) < 1e-9
    assert ratio in (None, (p, q))


def test_rescale() -> None:
    torch.testing.assert_close(
        rescale(X, (0.5, 1.7), "bicubic"), F.interpolate(X, (18, 90), mode="bicubic"), rtol=0, atol=1e-11
    )
    torch.testing.assert_close(
        rescale(X, 0.3, antialias=True), resize(X, (11, 15), antialias=True), rtol=0, atol=0
    )
    assert rescale(X, 2).equal(resize(X, (74, 106))) and torch.jit.script(rescale)(X, 2.0).equal(
        rescale(X, 2)
    )


@pytest.mark.parametrize("factor", [1, 2, 3, 4, 5, 8, 14])
def test_sizes_are_rounded_half_to_even(factor: int) -> None:
    for size in range((factor + 1) // 2 + 1, 5 * factor + 3):
        actual = resize_to_be_divisible(torch.zeros(1, 1, size, 4 * factor), factor)
        assert actual.shape[2:] == (round(size / factor) * factor, 4 * factor)


def by_opencv(x: Tensor, border: str) -> Tensor:
    taps = np.array([1, 4, 6, 4, 1]) / 16
    blurred = [
        chw(cv2.sepFilter2D(hwc(x, b), cv2.CV_64F, taps, taps, borderType=CV_BORDER[border]))
        for b in range(len(x))
    ]
    return torch.from_numpy(np.stack(blurred))


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("border", ["reflect", "replicate", "constant"])
def test_pyramid_steps_are_blur_and_interpolation(border: str, align: bool) -> None:
    interpolated = F.interpolate(by_opencv(X, border), (18, 26), mode="bilinear", align_corners=align)
    torch.testing.assert_close(pyrdown(X, border, align), interpolated, rtol=0, atol=1e-12)
    interpolated = F.interpolate(by_opencv(X, border), (24, 35), mode="bilinear", align_corners=align)
    torch.testing.assert_close(pyrdown(X, border, align, 1.5), interpolated, rtol=0, atol=1e-12)
    enlarged = F.interpolate(X, (74, 106), mode="bilinear", align_corners=align)
    torch.testing.assert_close(pyrup(X, border, align), by_opencv(enlarged, border), rtol=0, atol=1e-12)


def test_pyrdown_is_opencvs_but_for_half_a_pixel() -> None:
    """The blurs do not change a linear ramp, so the values show the positions of pixels."""
    plane = torch.arange(40.0).expand(1, 1, 32, 40)
    np.testing.assert_allclose(
        pyrdown(plane)[0, 0, 5, 2:-2], cv2.pyrDown(hwc(plane))[5, 2:-2] + 0.5, atol=1e-5
    )


def test_pyramids() -> None:
    levels = build_pyramid(X, 3)
    torch.testing.assert_close(levels[2], pyrdown(pyrdown(X)), rtol=0, atol=0)
    assert torch.equal(levels[0], X)
    details = build_laplacian_pyramid(X, 4)
    image = details[3]
    for detail in details[2::-1]:
        image = by_opencv(F.interpolate(image, detail.shape[2:], mode="bilinear"), "reflect") + detail
    torch.testing.assert_close(image, X, rtol=0, atol=1e-12)
    assert details[0].mean().abs() < 1e-3


@pytest.mark.parametrize(("size", "align"), [((21, 13), True), ((5, 53), False), ((45, 61), True)])
def test_center_crop_takes_whole_pixels(size: tuple[int, int], align: bool) -> None:
    padded = F.pad(X, [4, 4, 4, 4])
    top, left = 4 + (37 - size[0]) // 2, 4 + (53 - size[1]) // 2
    expected = padded[:, :, top : top + size[0], left : left + size[1]]
    torch.testing.assert_close(center_crop(X, size, align_corners=align), expected, rtol=0, atol=0)


def test_center_crop_between_pixels() -> None:
    expected = (X[:, :, 10:26, 20:33] + X[:, :, 11:27, 20:33]) / 2
    torch.testing.assert_close(center_crop(X, (16, 13)), expected, rtol=0, atol=1e-12)


def pixels_of(dtype: torch.dtype) -> Tensor:
    """Integers that reach both ends of their type."""
    info = torch.iinfo(dtype)
    return ((X - X.min()) / (X.max() - X.min()) * (info.max - info.min) + info.min).round().to(dtype)


def framed(x: Tensor) -> Tensor:
    """The same images, stored pixel by pixel."""
    return x.to(torch.int32).permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2).to(x.dtype)


PIXELS = pytest.mark.parametrize("dtype", [torch.uint8, torch.int16, torch.uint16])


@PIXELS
def test_centre_crops_of_integers(dtype: torch.dtype) -> None:
    x = pixels_of(dtype)
    wide = x.numpy().astype(np.int64)
    for of in (x, framed(x)):
        crop = center_crop(of, (21, 13))
        assert crop.dtype == dtype
        np.testing.assert_array_equal(crop.numpy(), wide[:, :, 8:29, 20:33])
        around = center_crop(of, (45, 61), padding_mode="border").numpy()
        np.testing.assert_array_equal(around, np.pad(wide, [(0, 0), (0, 0), (4, 4), (4, 4)], "edge"))
        between = wide[:, :, 10:26, 20:33] + wide[:, :, 11:27, 20:33]
        np.testing.assert_array_equal(center_crop(of, (16, 13)).numpy(), (between + 1) // 2)
        cubic = center_crop(x.to(D), (16, 12), "bicubic")
        info = torch.iinfo(dtype)
        expected = torch.floor(cubic + 0.5).clamp(info.min, info.max).numpy()
        np.testing.assert_array_equal(center_crop(of, (16, 12), "bicubic").numpy(), expected)
    with pytest.raises(TypeError, match="input_tensor: expected a floating-point, uint8, int16 or uint16"):
        center_crop(x.to(torch.int64), (3, 3))


QUADRILATERALS = torch.tensor(
    [
        [[3.0, 2.0], [40.0, 5.0], [44.0, 30.0], [1.0, 33.0]],
        [[10.0, 8.0], [30.0, 8.0], [30.0, 20.0], [10.0, 20.0]],
    ]
)


def test_crop_and_resize_equals_opencv() -> None:
    x = X.float()
    target = np.array([[0, 0], [24, 0], [24, 15], [0, 15]], np.float32)
    for align in (True, False):
        actual = crop_and_resize(x, QUADRILATERALS, (16, 25), align_corners=align)
        for b in range(2):
            matrix = cv2.getPerspectiveTransform(QUADRILATERALS[b].numpy(), target)
            np.testing.assert_allclose(
                actual[b],
                chw(cv2.warpPerspective(hwc(x, b), matrix, (25, 16), flags=cv2.INTER_LINEAR)),
                atol=1e-4,
            )
            same = crop_by_transform_mat(x, torch.from_numpy(matrix)[None], (16, 25))[b]
            torch.testing.assert_close(actual[b], same, rtol=0, atol=1e-4)


@pytest.mark.parametrize("size", [(1, 25), (16, 1), (0, 2)])
def test_a_crop_of_one_pixel_is_refused(size: tuple[int, int]) -> None:
    for call in (crop_and_resize, torch.jit.script(crop_and_resize)):
        with pytest.raises(Exception, match="size: expected numbers above 1, got"):
            call(X, QUADRILATERALS, size)


def test_crops_of_bytes_equal_opencv() -> None:
    x = pixels_of(torch.uint8)
    target = np.array([[0, 0], [24, 0], [24, 15], [0, 15]], np.float32)
    boxes = torch.from_numpy(target).expand(2, 4, 2)
    actual = crop_and_resize(x, QUADRILATERALS, (16, 25))
    assert actual.dtype == torch.uint8
    assert torch.equal(crop_and_resize(framed(x), QUADRILATERALS, (16, 25)), actual)
    assert torch.equal(crop_by_boxes(x, QUADRILATERALS, boxes), actual)
    for b in range(2):
        matrix = cv2.getPerspectiveTransform(QUADRILATERALS[b].numpy(), target)
        expected = chw(cv2.warpPerspective(hwc(x, b), matrix, (25, 16), flags=cv2.INTER_LINEAR))
        apart = np.abs(actual[b].numpy().astype(int) - expected.astype(int))
        assert apart.max() <= 4 and (apart > 1).mean() < 0.05


def test_crop_by_boxes() -> None:
    box = QUADRILATERALS[1:].expand(2, 4, 2)
    corner = torch.tensor([[0.0, 0.0], [20.0, 0.0], [20.0, 12.0], [0.0, 12.0]]).expand(2, 4, 2)
    actual = crop_by_boxes(X, box, corner)
    torch.testing.assert_close(actual, X[:, :, 8:21, 10:31], rtol=0, atol=1e-9)
    torch.testing.assert_close(crop_by_boxes(X, box, corner + 3), X[:, :, 5:18, 7:28], rtol=0, atol=1e-9)
    torch.testing.assert_close(crop_by_boxes(X, box, corner, size=(13, 21)), actual, rtol=0, atol=0)
    with pytest.raises(ValueError, match="dst_box: expected rectangles of one size"):
        crop_by_boxes(X, box, QUADRILATERALS)


BOXES = torch.tensor([[[2, 1], [26, 1], [26, 14], [2, 14]], [[0, 3], [10, 3], [10, 36], [0, 36]]])


@pytest.mark.parametrize("align", [None, True])
@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic"])
def test_crop_by_indices_resizes_the_crop_alone(interpolation: str, align: bool | None) -> None:
    actual = crop_by_indices(X, BOXES, (16, 20), interpolation, align)
    for b, crop in enumerate([X[:1, :, 1:15, 2:27], X[1:, :, 3:37, 0:11]]):
        expected = F.interpolate(crop, (16, 20), mode=interpolation, align_corners=align)
        torch.testing.assert_close(actual[b : b + 1], expected, rtol=0, atol=1e-11)


def test_crop_by_indices_without_resizing() -> None:
    same = BOXES[:1].expand(2, 4, 2)
    assert torch.equal(crop_by_indices(X, same), X[:, :, 1:15, 2:27])
    assert torch.equal(crop_by_indices(X, same + 0.7), X[:, :, 1:15, 2:27])
    padded = crop_by_indices(X, BOXES, (16, 20), shape_compensation="pad")
    assert torch.equal(padded[0], F.pad(X[0, :, 1:15, 2:22], [0, 0, 0, 2]))
    assert torch.equal(padded[1], F.pad(X[1, :, 3:19, 0:11], [0, 9]))
    nearest = crop_by_indices(X, BOXES, (7, 5), "nearest")
    assert torch.equal(
        nearest[0], X[0][:, [1 + i * 14 // 7 for i in range(7)]][..., [2 + j * 25 // 5 for j in range(5)]]
    )
    with pytest.raises(ValueError, match="src_box: expected boxes of one size"):
        crop_by_indices(X, BOXES)


@PIXELS
def test_crop_by_indices_of_integers(dtype: torch.dtype) -> None:
    x, info = pixels_of(dtype), torch.iinfo(dtype)
    wide = x.numpy().astype(np.int64)
    for of in (x, framed(x)):
        whole = crop_by_indices(of, BOXES[:1].expand(2, 4, 2))
        assert whole.dtype == dtype
        np.testing.assert_array_equal(whole.numpy(), wide[:, :, 1:15, 2:27])
        pad = crop_by_indices(of, BOXES, (16, 20), shape_compensation="pad").numpy()
        np.testing.assert_array_equal(pad[1], np.pad(wide[1, :, 3:19, 0:11], [(0, 0), (0, 0), (0, 9)]))
        nearest = crop_by_indices(of, BOXES, (7, 5), "nearest").numpy()
        np.testing.assert_array_equal(nearest[0], wide[0][:, 1:15:2, 2:27:5])
        for interpolation, steps in (("bilinear", 2048), ("bicubic", 32)):
            actual = crop_by_indices(of, BOXES, (16, 20), interpolation).numpy()
            exact = crop_by_indices(x.to(D), BOXES, (16, 20), interpolation)
            exact = exact.clamp(info.min, info.max).numpy()
            # half a step along each axis, where bicubic is up to 1.5 times as steep
            assert np.abs(actual - exact).max() <= 1.5 * 2 * (info.max - info.min) / (2 * steps) + 0.5


@PIXELS
def test_centre_crop_module_of_integers(dtype: torch.dtype) -> None:
    x = pixels_of(dtype)
    np.testing.assert_array_equal(CenterCrop2D((21, 13))(x).numpy(), x.numpy()[:, :, 8:29, 20:33])
