"""Camera models against OpenCV and finite differences."""

import cv2
import numpy as np
import pytest
import torch
from scenes import camera_matrix, points_in_front

from chiasm.geometry import camera

FISHEYE = [np.zeros(4), np.array([0.03, -0.01, 0.004, -0.001]), np.array([-0.05, 0.02, -0.003, 0.0005])]
#: From the principal point to 80 degrees off the axis.
RADII = [0.0, 1e-9, 1e-4, 9.9e-3, 1.01e-2, 0.3, 1.0, 5.6]


def params(k: np.ndarray) -> tuple[torch.Tensor, np.ndarray]:
    K = camera_matrix()
    return torch.tensor([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *k], dtype=torch.float64), K


def on_circles() -> np.ndarray:
    angle = np.linspace(0, 6, 7)
    return np.concatenate([r * np.stack([np.cos(angle), np.sin(angle)], 1) for r in RADII])


def test_project_points_equal_opencv() -> None:
    K, X = camera_matrix(), points_in_front(50)
    expected = cv2.projectPoints(X, np.zeros(3), np.zeros(3), K, None)[0][:, 0]
    np.testing.assert_allclose(
        camera.project_points(torch.from_numpy(X), torch.from_numpy(K)), expected, rtol=1e-12
    )


@pytest.mark.parametrize("normalize", [False, True])
def test_unproject_points_is_the_inverse(normalize: bool) -> None:
    K, X = torch.from_numpy(camera_matrix()), torch.from_numpy(points_in_front(50))
    depth = X.norm(dim=1, keepdim=True) if normalize else X[:, 2:]
    np.testing.assert_allclose(
        camera.unproject_points(camera.project_points(X, K), depth, K, normalize), X, rtol=1e-12
    )


def test_a_point_beside_the_camera_is_far_and_finite() -> None:
    K = torch.eye(3, requires_grad=True)
    pixel = camera.project_points(torch.tensor([[1.0, 0.0, 0.0], [1.0, 0.0, -1e-12], [0.0, 0.0, 0.0]]), K)
    pixel.sum().backward()
    assert pixel.isfinite().all() and K.grad.isfinite().all()
    assert pixel[0, 0] > 1e7 and pixel[1, 0] < -1e7


@pytest.mark.parametrize("k", FISHEYE, ids=["none", "mixed", "negative"])
def test_kannala_brandt_equals_opencv(k: np.ndarray) -> None:
    xy = on_circles()
    p, K = params(k)
    expected = cv2.fisheye.distortPoints(xy[:, None], K, k)[:, 0]
    pixels = camera.distort_points_kannala_brandt(torch.from_numpy(xy), p)
    # OpenCV omits the distortion within 1e-8
    np.testing.assert_allclose(pixels, expected, rtol=0, atol=1e-7)
    np.testing.assert_allclose(camera.undistort_points_kannala_brandt(pixels, p), xy, rtol=1e-9, atol=1e-11)
    near = np.linalg.norm(xy, axis=1) < 1.1
    by_opencv = cv2.fisheye.undistortPoints(pixels.numpy()[near][:, None], K, k)[:, 0]
    np.testing.assert_allclose(
        camera.undistort_points_kannala_brandt(pixels, p)[near], by_opencv, rtol=0, atol=1e-6
    )


@pytest.mark.parametrize("k", FISHEYE, ids=["none", "mixed", "negative"])
def test_derivatives_equal_autograd(k: np.ndarray) -> None:
    p, _ = params(k)
    for distort, derivative, q in (
        (camera.distort_points_kannala_brandt, camera.dx_distort_points_kannala_brandt, p),
        (camera.distort_points_affine, camera.dx_distort_points_affine, p[:4]),
    ):
        for xy in torch.from_numpy(on_circles()):
            jacobian = torch.autograd.functional.jacobian(lambda u, distort=distort, q=q: distort(u, q), xy)
            np.testing.assert_allclose(derivative(xy, q), jacobian, rtol=1e-7, atol=1e-8)
    X = torch.from_numpy(points_in_front(5))
    for point in X:
        np.testing.assert_allclose(
            camera.dx_project_points_z1(point),
            torch.autograd.functional.jacobian(camera.project_points_z1, point),
            rtol=1e-12,
        )


def test_undistortion_is_differentiable_at_the_centre_and_far() -> None:
    p, _ = params(FISHEYE[1])
    pixels = camera.distort_points_kannala_brandt(torch.from_numpy(on_circles()[::3]), p)
    a, b = pixels.clone().requires_grad_(True), p.clone().requires_grad_(True)
    assert torch.autograd.gradcheck(camera.undistort_points_kannala_brandt, (a, b), atol=1e-6)
    c = torch.from_numpy(on_circles()[::3]).requires_grad_(True)
    assert torch.autograd.gradcheck(camera.distort_points_kannala_brandt, (c, b), atol=1e-5)


def test_single_precision() -> None:
    p, _ = params(FISHEYE[1])
    xy = torch.from_numpy(on_circles())
    pixels = camera.distort_points_kannala_brandt(xy.float(), p.float())
    np.testing.assert_allclose(pixels, camera.distort_points_kannala_brandt(xy, p), atol=2e-4)
    np.testing.assert_allclose(
        camera.undistort_points_kannala_brandt(pixels, p.float())[:49], xy[:49], rtol=1e-4, atol=2e-6
    )


def test_affine_and_orthographic() -> None:
    xy, p = torch.tensor([[0.5, -0.25]]), torch.tensor([400.0, 300.0, 320.0, 240.0])
    pixel = camera.distort_points_affine(xy, p)
    assert pixel.tolist() == [[520.0, 165.0]]
    assert camera.undistort_points_affine(pixel, p).equal(xy)
    X = camera.unproject_points_orthographic(xy, torch.tensor([3.0]))
    assert X.tolist() == [[0.5, -0.25, 3.0]] and camera.project_points_orthographic(X).equal(xy)
    assert camera.dx_project_points_orthographic(X).tolist() == [[1.0]]
    assert camera.unproject_points_z1(xy, torch.tensor([[2.0]])).tolist() == [[1.0, -0.5, 2.0]]
    assert camera.project_points_z1(camera.unproject_points_z1(xy)).equal(xy)


def test_frames_to_pixels_and_back() -> None:
    K = torch.eye(4, dtype=torch.float64)
    K[:3, :3] = torch.from_numpy(camera_matrix())
    depth = 1.0 + torch.rand(2, 1, 4, 5, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    row, column = torch.meshgrid(torch.arange(4.0), torch.arange(5.0), indexing="ij")
    grid = torch.stack([column, row, torch.ones(4, 5)], -1).double()[None]
    X = camera.pixel2cam(depth, K.inverse()[None].repeat(2, 1, 1), grid)
    np.testing.assert_allclose(
        X[1, 2, 3], np.linalg.inv(K[:3, :3].numpy()) @ [3, 2, 1] * depth[1, 0, 2, 3].item(), rtol=1e-12
    )
    np.testing.assert_allclose(
        camera.cam2pixel(X, K[None].repeat(2, 1, 1)), grid[..., :2].expand(2, 4, 5, 2), atol=1e-9
    )


WRONG = [
    (
        lambda: camera.project_points(torch.zeros(2), torch.eye(3)),
        ValueError,
        r"point_3d: expected shape \(\*, 3\), got \[2\]",
    ),
    (
        lambda: camera.project_points(torch.zeros(3), torch.eye(4)),
        ValueError,
        r"camera_matrix: expected shape \(\*, 3, 3\), got \[4, 4\]",
    ),
    (
        lambda: camera.project_points(torch.zeros(3).int(), torch.eye(3)),
        TypeError,
        "point_3d: expected a floating-point",
    ),
    (
        lambda: camera.unproject_points(torch.zeros(2), torch.zeros(2), torch.eye(3)),
        ValueError,
        r"depth: expected shape \(\*, 1\)",
    ),
    (
        lambda: camera.unproject_points_z1(torch.zeros(3, 2), torch.zeros(3, 2)),
        ValueError,
        r"extension: expected shape \(\*\) or \(\*, 1\)",
    ),
    (
        lambda: camera.cam2pixel(torch.zeros(4, 5, 3), torch.eye(4)[None]),
        ValueError,
        r"cam_coords_src: expected shape \(B, H, W, 3\)",
    ),
    (
        lambda: camera.pixel2cam(torch.zeros(1, 2, 4, 5), torch.eye(4)[None], torch.zeros(1, 4, 5, 3)),
        ValueError,
        r"depth: expected shape \(B, 1, H, W\)",
    ),
    (
        lambda: camera.distort_points_kannala_brandt(torch.zeros(2), torch.zeros(4)),
        ValueError,
        r"params: expected shape \(\*, 8\)",
    ),
    (
        lambda: camera.undistort_points_kannala_brandt(torch.zeros(2), torch.zeros(8), 0),
        ValueError,
        "num_iters: expected at least 1, got 0",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:30] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
