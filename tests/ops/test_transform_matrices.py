"""Matrices of plane transforms against OpenCV and products in NumPy."""

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.geometry.transform import (
    get_affine_matrix2d,
    get_perspective_transform,
    get_rotation_matrix2d,
    get_shear_matrix2d,
    invert_affine_transform,
    projection_from_Rt,
)

BATCH = 5


def uniform(*shape: int, low: float = 0.0, high: float = 1.0, seed: int = 0) -> Tensor:
    generator = torch.Generator().manual_seed(seed + sum(shape))
    return torch.rand(shape, generator=generator, dtype=torch.float64) * (high - low) + low


CENTER = uniform(BATCH, 2, low=-20, high=900).float().double()  # OpenCV takes float32
ANGLE = uniform(BATCH, low=-200, high=200)
SCALE = uniform(BATCH, 2, low=0.3, high=3)


def translation(x: float, y: float) -> np.ndarray:
    return np.array([[1, 0, x], [0, 1, y], [0, 0, 1]])


def about(matrix: np.ndarray, center: Tensor) -> np.ndarray:
    x, y = center.tolist()
    full = np.eye(3)
    full[:2, :2] = matrix
    return translation(x, y) @ full @ translation(-x, -y)


def rotation(degrees: float, scale: Tensor) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return np.array([[c, s], [-s, c]]) @ np.diag(scale.numpy())


def shearing(sx: float, sy: float) -> np.ndarray:
    return np.array([[1, 0], [-np.tan(sy), 1]]) @ np.array([[1, -np.tan(sx)], [0, 1]])


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_rotation_equals_opencv(dtype: torch.dtype) -> None:
    """In float32, too, every entry is as accurate as float32 allows."""
    scale = SCALE[:, :1].expand(-1, 2)
    center, angle = CENTER.to(dtype), ANGLE.to(dtype)
    actual = get_rotation_matrix2d(center, angle, scale.to(dtype))
    for b in range(BATCH):
        expected = cv2.getRotationMatrix2D(center[b].tolist(), float(angle[b]), float(scale.to(dtype)[b, 0]))
        np.testing.assert_allclose(
            actual[b], expected, rtol=1e-7 if dtype == torch.float32 else 1e-12, atol=1e-10
        )


def test_unequal_scales_come_first() -> None:
    actual = get_rotation_matrix2d(CENTER, ANGLE, SCALE)
    for b in range(BATCH):
        np.testing.assert_allclose(
            actual[b], about(rotation(float(ANGLE[b]), SCALE[b]), CENTER[b])[:2], atol=1e-9
        )


def test_shear_is_about_its_centre() -> None:
    sx, sy = uniform(BATCH, low=-1, high=1, seed=1), uniform(BATCH, low=-1, high=1, seed=2)
    actual = get_shear_matrix2d(CENTER, sx, sy)
    for b in range(BATCH):
        np.testing.assert_allclose(
            actual[b], about(shearing(float(sx[b]), float(sy[b])), CENTER[b]), atol=1e-9
        )
    zero = torch.zeros_like(sx)
    torch.testing.assert_close(get_shear_matrix2d(CENTER, sx), get_shear_matrix2d(CENTER, sx, zero))
    torch.testing.assert_close(get_shear_matrix2d(CENTER, None, sy), get_shear_matrix2d(CENTER, zero, sy))


@pytest.mark.parametrize("shape", [(), (1,)])
def test_one_shear_angle_for_all(shape: tuple[int, ...]) -> None:
    one, each = torch.full(shape, 0.3, dtype=torch.float64), torch.full((BATCH,), 0.3, dtype=torch.float64)
    sy = uniform(BATCH, low=-1, high=1, seed=2)
    move = uniform(BATCH, 2, low=-50, high=50, seed=3)
    for angles, wanted in [((one,), (each,)), ((one, sy), (each, sy)), ((None, one), (None, each))]:
        expected = get_shear_matrix2d(CENTER, *wanted)
        torch.testing.assert_close(get_shear_matrix2d(CENTER, *angles), expected, rtol=0, atol=0)
        torch.testing.assert_close(
            get_affine_matrix2d(move, CENTER, SCALE, ANGLE, *angles),
            get_affine_matrix2d(move, CENTER, SCALE, ANGLE, *wanted),
            rtol=0,
            atol=0,
        )
    torch.testing.assert_close(
        get_shear_matrix2d(CENTER[:1], one, sy), get_shear_matrix2d(CENTER[:1].expand(BATCH, 2), each, sy)
    )


@pytest.mark.parametrize("sheared", [False, True])
def test_affine_matrix_is_the_product(sheared: bool) -> None:
    sx, sy = (
        (uniform(BATCH, low=-1, high=1, seed=1), uniform(BATCH, low=-1, high=1, seed=2))
        if sheared
        else (None, None)
    )
    move = uniform(BATCH, 2, low=-50, high=50, seed=3)
    actual = get_affine_matrix2d(move, CENTER, SCALE, ANGLE, sx, sy)
    for b in range(BATCH):
        expected = translation(*move[b].tolist()) @ about(rotation(-float(ANGLE[b]), SCALE[b]), CENTER[b])
        if sheared:
            expected = expected @ about(shearing(float(sx[b]), float(sy[b])), CENTER[b])
        np.testing.assert_allclose(actual[b], expected, atol=1e-8)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_perspective_equals_opencv(dtype: torch.dtype) -> None:
    square = torch.tensor([[0.0, 0.0], [400.0, 0.0], [400.0, 300.0], [0.0, 300.0]], dtype=torch.float64)
    source = (square + uniform(BATCH, 4, 2, low=-90, high=90)).to(dtype)
    target = (square * 1.7 + uniform(BATCH, 4, 2, low=-90, high=90, seed=4)).to(dtype)
    actual = get_perspective_transform(source, target)
    assert actual.dtype == dtype
    for b in range(BATCH):
        expected = cv2.getPerspectiveTransform(source[b].float().numpy(), target[b].float().numpy())
        np.testing.assert_allclose(actual[b], expected, rtol=1e-3, atol=1e-4)
        points = np.concatenate([source[b].numpy(), np.ones((4, 1))], 1) @ actual[b].double().numpy().T
        np.testing.assert_allclose(
            points[:, :2] / points[:, 2:], target[b], atol=2e-3 if dtype == torch.float32 else 1e-9
        )


def test_inverse_equals_opencv() -> None:
    matrix = uniform(BATCH, 2, 3, low=-3, high=3)
    matrix[:, :, 2] *= 100
    for b, actual in enumerate(invert_affine_transform(matrix)):
        np.testing.assert_allclose(actual, cv2.invertAffineTransform(matrix[b].numpy()), atol=1e-9)


def test_projection() -> None:
    r, t = uniform(2, 4, 3, 3), uniform(2, 4, 3, 1)
    np.testing.assert_array_equal(projection_from_Rt(r, t), np.concatenate([r, t], -1))
