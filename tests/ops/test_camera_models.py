"""Camera models as objects, against OpenCV."""

import copy
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from scenes import camera_matrix, points_in_front
from torch import Tensor

from chiasm.geometry import camera
from chiasm.geometry.camera import CameraModel, CameraModelType
from chiasm.geometry.vector import Vector2, Vector3
from chiasm.image import ImageSize

SIZE = ImageSize(480, 640)
LENS = np.array([0.12, -0.05, 0.003, -0.002, 0.01, 0.02, -0.01, 0.004])
FISHEYE = np.array([0.03, -0.01, 0.004, -0.001])
MORE = {
    CameraModelType.PINHOLE: [],
    CameraModelType.BROWN_CONRADY: LENS,
    CameraModelType.KANNALA_BRANDT_K3: FISHEYE,
    CameraModelType.ORTHOGRAPHIC: [],
}
every_model = pytest.mark.parametrize("kind", MORE)


def params(kind: CameraModelType, zoom: float = 1.0) -> Tensor:
    K = camera_matrix() * [[zoom], [zoom], [1.0]]
    return torch.tensor([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *MORE[kind]], dtype=torch.float64)


def seen(kind: CameraModelType, X: np.ndarray, zoom: float = 1.0) -> np.ndarray:
    K, zero = camera_matrix() * [[zoom], [zoom], [1.0]], np.zeros(3)
    if kind == CameraModelType.ORTHOGRAPHIC:
        return X[:, :2] * K.diagonal()[:2] + K[:2, 2]
    if kind == CameraModelType.KANNALA_BRANDT_K3:
        return cv2.fisheye.projectPoints(X[None], zero, zero, K, FISHEYE)[0][0]
    lens: Any = LENS if kind == CameraModelType.BROWN_CONRADY else None
    return cv2.projectPoints(X, zero, zero, K, lens)[0][:, 0]


@every_model
def test_pixels_are_opencvs_and_come_back(kind: CameraModelType) -> None:
    X = points_in_front(40)
    model = CameraModel(SIZE, kind, params(kind))
    points = torch.from_numpy(X)
    pixels = model.project(points)
    np.testing.assert_allclose(pixels, seen(kind, X), rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(model.unproject(pixels, points[:, 2]), X, rtol=1e-7, atol=1e-7)
    objects = model.project(Vector3(points))
    assert isinstance(objects, Vector2) and objects.data.equal(pixels)
    back = model.unproject(objects, points[:, 2])
    assert isinstance(back, Vector3) and back.data.equal(model.unproject(pixels, points[:, 2]))
    torch.testing.assert_close(model.project(points[3]), pixels[3])
    torch.testing.assert_close(model.project(points.reshape(2, 4, 5, 3)), pixels.reshape(2, 4, 5, 2))


@every_model
def test_each_camera_of_a_batch_sees_its_own_points(kind: CameraModelType) -> None:
    X = np.stack([points_in_front(6), points_in_front(6) + [0.1, 0.2, 0.3]])
    model = CameraModel(SIZE, kind, torch.stack([params(kind), params(kind, 0.5)]))
    expected = np.stack([seen(kind, X[0]), seen(kind, X[1], 0.5)])
    points = torch.from_numpy(X)
    np.testing.assert_allclose(model.project(points), expected, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(model.project(points[:, 0]), expected[:, 0], rtol=1e-9, atol=1e-8)
    back = model.unproject(model.project(points), points[..., 2])
    np.testing.assert_allclose(back, X, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(model.matrix()[1], camera_matrix() * [[0.5], [0.5], [1.0]])
    assert model.K().equal(model.matrix()) and model.fx.shape == (2,)


def test_what_a_camera_holds() -> None:
    model = CameraModel((480, 640), CameraModelType.PINHOLE, torch.tensor([328.0, 300.0, 320.0, 240.0]))
    assert (model.height, model.width, model.image_size) == (480, 640, SIZE)
    assert [float(n) for n in (model.fx, model.fy, model.cx, model.cy)] == [328, 300, 320, 240]
    scaled = model.scale(0.5)
    assert scaled.image_size == (240, 320) and scaled.params.tolist() == [164, 150, 160, 120]
    assert repr(model).startswith("CameraModel(ImageSize(height=480, width=640), PinholeModel, tensor")
    assert copy.deepcopy(model).params.equal(model.params)


def test_what_is_refused() -> None:
    one = torch.ones(4)
    with pytest.raises(
        ValueError, match=r"params: expected shape \(12,\) or \(B, 12\) for BrownConradyModel"
    ):
        CameraModel(SIZE, CameraModelType.BROWN_CONRADY, one)
    with pytest.raises(ValueError, match=r"params: expected shape .* got \[1, 1, 4\]"):
        camera.PinholeModel(SIZE, one[None, None])
    with pytest.raises(TypeError, match="params: expected a floating-point tensor"):
        camera.Orthographic(SIZE, one.long())
    unknown: Any = "pinhole"
    with pytest.raises(ValueError, match="model_type: expected one of CameraModelType, got 'pinhole'"):
        CameraModel(SIZE, unknown, one)
    with pytest.raises(ValueError, match=r"points: expected shape \(2, \*, 3\) for 2 cameras"):
        camera.PinholeModel(SIZE, torch.ones(2, 4)).project(torch.ones(3, 3))
