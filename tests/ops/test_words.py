"""Images of 16 bits, of depth cameras and scanners: interpolation and thresholds against OpenCV and SciPy."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
import torch
from scipy.ndimage import map_coordinates
from torch import Tensor

from chiasm.enhance import threshold
from chiasm.filters import in_range
from chiasm.geometry.calibration import undistort_image
from chiasm.geometry.transform import (
    center_crop,
    crop_by_transform_mat,
    remap,
    rescale,
    resize,
    resize_to_be_divisible,
    rotate,
    warp_affine,
    warp_perspective,
    warp_polar,
)

DTYPES = pytest.mark.parametrize("dtype", ["int16", "uint16"])
SIZE = (23, 31)


def noise(dtype: str, height: int = 37, width: int = 29) -> np.ndarray:
    """Two planes over the whole range of the type."""
    whole = np.random.default_rng(5).integers(0, 65536, (2, height, width))
    whole[:, :3], whole[:, -3:] = 65535, 0  # where rounding could leave the range
    return (whole - (32768 if dtype == "int16" else 0)).astype(dtype)


def smooth(dtype: str, height: int = 60, width: int = 70) -> np.ndarray:
    """A plane of which neighbours differ by up to 150 levels along each axis."""
    y, x = np.mgrid[:height, :width]
    return (90.0 * x + 120.0 * y * np.sin(x / 50.0) - (3000 if dtype == "int16" else 0)).astype(dtype)


def tensor(planes: np.ndarray) -> Tensor:
    return torch.from_numpy(planes)[None]


def off(made: Tensor, expected: Any) -> float:
    """The largest difference, of results that have kept the type."""
    assert made.dtype in (torch.int16, torch.uint16)
    return float(np.abs(made[0].numpy().astype(np.float64) - np.asarray(expected, np.float64)).max())


def at(planes: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Bilinear in float64, 0 outside."""
    wide = np.pad(planes, ((0, 0), (1, 1), (1, 1))).astype(np.float64)
    return np.stack([map_coordinates(plane, [y + 1, x + 1], order=1, cval=0.0) for plane in wide])


def grid(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the inverse of a matrix maps the pixels of the output."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    points = np.linalg.inv(matrix) @ np.stack([x.ravel(), y.ravel(), np.ones(x.size)])
    return (points[0] / points[2]).reshape(SIZE), (points[1] / points[2]).reshape(SIZE)


# --- sizes --------------------------------------------------------------------------------------------------


@DTYPES
@pytest.mark.parametrize("size", [(23, 31), (74, 58), (5, 200), (37, 29)])
def test_resize_is_opencvs_to_one_level(dtype: str, size: tuple[int, int]) -> None:
    planes = noise(dtype)
    expected = [cv2.resize(plane, size[::-1], interpolation=cv2.INTER_LINEAR) for plane in planes]
    assert off(resize(tensor(planes), size), expected) <= 1


@DTYPES
@pytest.mark.parametrize("corners", [True, False])
def test_resize_is_the_rounded_interpolation(dtype: str, corners: bool) -> None:
    planes = noise(dtype)
    x = torch.from_numpy(planes.astype(np.float64))[None]
    exact = torch.nn.functional.interpolate(x, SIZE, mode="bilinear", align_corners=corners)[0]
    # a half by rounding, and an eighth along each axis by weights in 1/2^18
    assert off(resize(tensor(planes), SIZE, align_corners=corners), exact) <= 0.75


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16"])
def test_a_factor_or_a_multiple_is_a_size(dtype: str) -> None:
    x = torch.from_numpy((noise("uint16") >> 8).astype(dtype))[None]
    assert rescale(x, (2.0, 0.5)).equal(resize(x, (74, 14)))
    assert resize_to_be_divisible(x, 8, "nearest").equal(resize(x, (40, 32), "nearest"))
    assert resize_to_be_divisible(x[0], 8, "nearest").equal(resize(x[0], (40, 32), "nearest"))


@DTYPES
@pytest.mark.parametrize("size", [(17, 13), (12, 9), (37, 10)])
def test_area_is_opencvs_to_one_level(dtype: str, size: tuple[int, int]) -> None:
    planes = noise(dtype)
    expected = [cv2.resize(plane, size[::-1], interpolation=cv2.INTER_AREA) for plane in planes]
    assert off(resize(tensor(planes), size, "area"), expected) <= 1


def test_area_is_the_mean_rounded_half_up() -> None:
    x = torch.tensor([[[[-3, -2, 5, 6], [-3, -2, 5, 6]]]], dtype=torch.int16)
    assert resize(x, (1, 2), "area")[0, 0].tolist() == [[-2, 6]]


@DTYPES
@pytest.mark.parametrize("name, code", [("bicubic", cv2.INTER_CUBIC), ("lanczos4", cv2.INTER_LANCZOS4)])
@pytest.mark.parametrize("size", [(23, 31), (74, 58), (37, 29), (1, 3)])
def test_wide_filters_are_opencvs_to_one_level(
    dtype: str, name: str, code: int, size: tuple[int, int]
) -> None:
    planes = noise(dtype)
    expected = [cv2.resize(plane, size[::-1], interpolation=code) for plane in planes]
    # Lanczos' weights are a quarter of a level less exact, and OpenCV's are float32.
    assert off(resize(tensor(planes), size, name), expected) <= (1 if name == "bicubic" else 2)


@DTYPES
@pytest.mark.parametrize("name", ["bilinear", "bicubic", "lanczos4", "area"])
def test_a_constant_keeps_its_level(dtype: str, name: str) -> None:
    level = np.iinfo(dtype).max - 7
    x = torch.full((1, 2, 11, 13), level, dtype=getattr(torch, dtype))
    assert (resize(x, (29, 7), name).to(torch.int32) == level).all()


def test_antialiased_filters_refuse_16_bits() -> None:
    with pytest.raises(TypeError, match="input: expected a floating-point or uint8 tensor"):
        resize(tensor(noise("uint16")), (4, 4), antialias=True)


#: How far OpenCV 5 may be: it rounds the positions of int16 to 1/32 pixel, which are then 1/64 off.
NEAR = {"uint16": 1, "int16": 1 + 2 * 150 / 64}

# --- warps --------------------------------------------------------------------------------------------------

TURN = np.array([[1.1, 0.2, -4.0], [-0.3, 0.9, 6.0], [0.0, 0.0, 1.0]])
TILT = np.array([[1.1, 0.2, -4.0], [-0.3, 0.9, 6.0], [0.001, -0.002, 1.0]])


@DTYPES
def test_warps_are_interpolation_in_float64_to_one_level(dtype: str) -> None:
    planes = noise(dtype)
    x = tensor(planes)
    affine = warp_affine(x, torch.from_numpy(TURN[None, :2]), SIZE)
    assert off(affine, at(planes, *grid(TURN))) <= 1.51
    tilted = warp_perspective(x, torch.from_numpy(TILT[None]), SIZE)
    assert off(tilted, at(planes, *grid(TILT))) <= 1.51
    cropped = crop_by_transform_mat(x, torch.from_numpy(TILT[None]), SIZE)
    assert torch.equal(cropped, tilted)


@DTYPES
def test_warps_of_smooth_images_are_opencvs(dtype: str) -> None:
    plane = smooth(dtype)
    x = tensor(plane[None])
    options = {"flags": cv2.INTER_LINEAR, "borderMode": cv2.BORDER_REPLICATE}
    expected = cv2.warpAffine(plane, TURN[:2], SIZE[::-1], **options)
    made = warp_affine(x, torch.from_numpy(TURN[None, :2]), SIZE, padding_mode="border")
    assert off(made, expected[None]) <= NEAR[dtype]
    expected = cv2.warpPerspective(plane, TILT, SIZE[::-1], **options)
    made = warp_perspective(x, torch.from_numpy(TILT[None]), SIZE, padding_mode="border")
    assert off(made, expected[None]) <= NEAR[dtype]


@DTYPES
def test_remap_is_opencvs(dtype: str) -> None:
    planes = noise(dtype)
    rng = np.random.default_rng(2)
    # Nearest pixels: no position is half-way between two.
    columns = (rng.integers(-3, 32, SIZE) + rng.uniform(-0.4, 0.4, SIZE)).astype(np.float32)
    rows = (rng.integers(-3, 40, SIZE) + rng.uniform(-0.4, 0.4, SIZE)).astype(np.float32)
    maps = torch.from_numpy(columns)[None], torch.from_numpy(rows)[None]
    near = remap(tensor(planes), *maps, "nearest", "border", align_corners=True)
    options = {"interpolation": cv2.INTER_NEAREST, "borderMode": cv2.BORDER_REPLICATE}
    assert off(near, [cv2.remap(p, columns, rows, **options) for p in planes]) == 0
    # In steps of 1/32, to which OpenCV 5 still rounds the positions of int16.
    columns, rows = np.round(columns * 32) / 32, np.round(rows * 32) / 32
    maps = torch.from_numpy(columns)[None], torch.from_numpy(rows)[None]
    made = remap(tensor(planes), *maps, align_corners=True)
    assert off(made, at(planes, columns.astype(np.float64), rows.astype(np.float64))) <= 0.5
    assert off(made, [cv2.remap(p, columns, rows, cv2.INTER_LINEAR) for p in planes]) <= 1


@DTYPES
def test_bicubic_saturates(dtype: str) -> None:
    planes = noise(dtype)
    limits = np.iinfo(dtype)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]].astype(np.float32) + 0.5
    maps = torch.from_numpy(x)[None], torch.from_numpy(y)[None]
    made = remap(tensor(planes), *maps, "bicubic", "border", align_corners=True)
    exact = torch.from_numpy(planes.astype(np.float64))[None]
    exact = remap(exact, *(m.double() for m in maps), "bicubic", "border", align_corners=True)[0]
    outside = (exact > limits.max) | (exact < limits.min)
    assert outside.any()
    expected = np.floor(exact.numpy() + 0.5).clip(limits.min, limits.max)
    assert off(made, expected) == 0
    floats = [cv2.remap(p.astype(np.float32), x, y, cv2.INTER_CUBIC) for p in planes]
    inner = np.s_[:, 1:-1, 1:-4]  # where OpenCV needs no border
    assert off(made[:, :, 1:-1, 1:-4], np.stack(floats).clip(limits.min, limits.max)[inner]) <= 1


@DTYPES
def test_a_colour_beyond_the_border(dtype: str) -> None:
    limits = np.iinfo(dtype)
    x = tensor(noise(dtype))
    shift = torch.tensor([[[1.0, 0.0, 5.0], [0.0, 1.0, 0.0]]])
    made = warp_affine(x, shift, (37, 29), padding_mode="fill", fill_value=torch.tensor([1e6, -1e6]))
    assert made[0, 0, :, :5].unique().tolist() == [limits.max]
    assert made[0, 1, :, :5].unique().tolist() == [limits.min]
    assert torch.equal(made[..., 5:], x[..., :-5])


@DTYPES
def test_turns_and_identities_keep_pixels(dtype: str) -> None:
    x = tensor(noise(dtype, 24, 24))
    assert off(rotate(x, torch.tensor(90.0)), np.rot90(x[0].numpy(), axes=(1, 2))) == 0
    lens = torch.zeros(1, 4, dtype=torch.float64)
    camera = torch.tensor([[[20.0, 0, 12], [0, 20, 12], [0, 0, 1]]], dtype=torch.float64)
    assert off(undistort_image(x, camera, lens), x[0].numpy()) == 0


@DTYPES
def test_crops_between_pixels_are_means(dtype: str) -> None:
    planes = noise(dtype, 24, 24)
    means = (planes[:, :, :-1].astype(np.float64) + planes[:, :, 1:]) / 2
    made = center_crop(tensor(planes), (24, 3), padding_mode="border")
    assert off(made, np.floor(means[:, :, 10:13] + 0.5)) == 0


@DTYPES
def test_polar_coordinates_are_opencvs(dtype: str) -> None:
    plane = smooth(dtype)
    flags = cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS
    expected = cv2.warpPolar(plane, (20, 40), (30.0, 28.0), 22.0, flags)
    made = warp_polar(
        tensor(plane[None]), (40, 20), torch.tensor([[30.0, 28.0]]), torch.tensor([22.0]), "linear"
    )
    assert off(made, expected[None]) <= NEAR[dtype]


# --- thresholds ---------------------------------------------------------------------------------------------


@DTYPES
@pytest.mark.parametrize("kind", ["binary", "binary_inv", "trunc", "tozero", "tozero_inv"])
@pytest.mark.parametrize("limit", [-40000.0, -1.5, 0.0, 1234.0, 20000.7, 32767.0, 65535.0, 1e5])
def test_threshold_is_opencvs(dtype: str, kind: str, limit: float) -> None:
    planes = noise(dtype)
    if kind == "trunc" and limit < np.iinfo(dtype).min:
        assert threshold(tensor(planes), limit, 0.0, kind).unique().tolist() == [np.iinfo(dtype).min]
        return  # OpenCV gives 0, as if the type were unsigned
    code = getattr(cv2, f"THRESH_{kind.upper()}")
    for maxval in (30000.0, 1e6, 100.6):
        expected = [cv2.threshold(plane, limit, maxval, code)[1] for plane in planes]
        assert off(threshold(tensor(planes), limit, maxval, kind), expected) == 0
        many = threshold(tensor(planes), torch.tensor([limit]), torch.tensor([maxval]), kind)
        assert off(many, expected) == 0


@DTYPES
def test_in_range_is_opencvs(dtype: str) -> None:
    planes = noise(dtype)
    low, high = (-9000, 1000), (20000, 30000)
    image = planes.transpose(1, 2, 0).copy()
    expected = cv2.inRange(image, low, high)
    assert 0 < expected.mean() < 255
    x = tensor(planes)
    mask = in_range(x, [float(n) for n in low], [float(n) for n in high], True)
    assert mask.dtype == torch.uint8
    np.testing.assert_array_equal(mask[0, 0].numpy(), expected)
    kept = in_range(x, torch.tensor(low), torch.tensor(high))
    assert off(kept, np.where(expected, planes, 0)) == 0


# --- TorchScript --------------------------------------------------------------------------------------------


def test_they_script() -> None:
    x = tensor(noise("uint16"))
    scripted = torch.jit.script(resize)
    assert torch.equal(scripted(x, (9, 11)), resize(x, (9, 11)))
    turn = torch.from_numpy(TURN[None, :2])
    assert torch.equal(torch.jit.script(warp_affine)(x, turn, SIZE), warp_affine(x, turn, SIZE))
    assert torch.equal(torch.jit.script(threshold)(x, 900.0, 65535.0), threshold(x, 900.0, 65535.0))
    bounds = torch.tensor([900.0, 100.0]), torch.tensor([30000.0, 60000.0])
    assert torch.equal(torch.jit.script(in_range)(x, *bounds), in_range(x, *bounds))
