"""Lens distortion and pose against OpenCV."""

import cv2
import numpy as np
import pytest
import torch
from photos import photo
from scenes import LENS, SIZES, camera_matrix

from chiasm.geometry import calibration


def pixels(count: int = 60) -> np.ndarray:
    return np.random.default_rng(0).uniform([0, 0], [640, 480], (count, 2))


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [torch.from_numpy(a) for a in arrays]


@pytest.mark.parametrize("size", SIZES)
def test_distort_points_equal_opencv(size: int) -> None:
    K, new_K, p = camera_matrix(), camera_matrix(1), pixels()
    rays = np.linalg.solve(new_K, np.concatenate([p, np.ones((len(p), 1))], 1).T).T
    expected = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, LENS[:size])[0][:, 0]
    np.testing.assert_allclose(
        calibration.distort_points(*tensors(p, K, LENS[:size], new_K)), expected, rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("size", SIZES)
def test_undistort_points_equal_opencv(size: int) -> None:
    K, new_K, p = camera_matrix(), camera_matrix(1), pixels()
    exactly = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-14)
    expected = cv2.undistortPoints(p[:, None], K, LENS[:size], None, None, new_K, exactly)[:, 0]
    result = calibration.undistort_points(*tensors(p, K, LENS[:size], new_K))
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-8)
    np.testing.assert_allclose(
        calibration.distort_points(result, *tensors(K, LENS[:size], new_K)), p, rtol=0, atol=1e-8
    )
    single = calibration.undistort_points(*[t.float() for t in tensors(p, K, LENS[:size], new_K)])
    np.testing.assert_allclose(single, expected, rtol=0, atol=1e-3)


def test_fewer_steps_are_less_exact() -> None:
    K, p = tensors(camera_matrix(), pixels())
    errors = []
    for steps in (1, 2, 3, 5):
        back = calibration.distort_points(
            calibration.undistort_points(p, K, torch.from_numpy(LENS), None, steps), K, torch.from_numpy(LENS)
        )
        errors.append((back - p).abs().max().item())
    assert errors[0] > errors[1] > errors[2] > errors[3] and errors[1] < 2.0 and errors[3] < 1e-9


def test_gradient_through_the_steps() -> None:
    K, new_K, p = tensors(camera_matrix(), camera_matrix(1), pixels(4))
    inputs = [t.clone().requires_grad_(True) for t in (p, K, torch.from_numpy(LENS), new_K)]
    assert torch.autograd.gradcheck(
        lambda *a: calibration.undistort_points(*a, 8), inputs, atol=1e-5, rtol=1e-4
    )


def test_tilt_is_its_own_inverse() -> None:
    taux, tauy = tensors(np.array([[0.1], [-0.2], [0.0]]), np.array([[0.05], [0.3], [0.0]]))
    product = calibration.tilt_projection(taux, tauy) @ calibration.tilt_projection(taux, tauy, True)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-14)


@pytest.mark.parametrize("size", SIZES)
def test_undistort_image_equals_opencv(size: int) -> None:
    x = photo(2, 3, 61, 80, torch.float32)
    K = np.array([[70.0, 0, 40.2], [0, 66.0, 29.7], [0, 0, 1]])
    result = calibration.undistort_image(x, *[t.float().expand(2, *t.shape) for t in tensors(K, LENS[:size])])
    map_x, map_y = cv2.initUndistortRectifyMap(K, LENS[:size], None, K, (80, 61), cv2.CV_32FC1)
    for b in range(2):
        image = x[b].permute(1, 2, 0).numpy()
        ours = result[b].permute(1, 2, 0).numpy()
        np.testing.assert_allclose(ours, bilinear(image, map_x, map_y), atol=2e-4)
        # OpenCV rounds positions to 1/32
        np.testing.assert_allclose(ours, cv2.undistort(image, K, LENS[:size]), atol=0.05)


@pytest.mark.parametrize("size", SIZES)
def test_undistorted_bytes(size: int) -> None:
    x = (photo(2, 3, 61, 80, torch.float32) * 255).round().to(torch.uint8)
    K = np.array([[70.0, 0, 40.2], [0, 66.0, 29.7], [0, 0, 1]])
    camera, lens = (t.expand(2, *t.shape) for t in tensors(K, LENS[:size]))
    result = calibration.undistort_image(x, camera, lens)
    frame = x.permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2)
    assert result.dtype == torch.uint8 and result.equal(calibration.undistort_image(frame, camera, lens))
    for b in range(2):
        image, ours = (t[b].permute(1, 2, 0).numpy().astype(int) for t in (x, result))
        apart = abs(ours - cv2.undistort(image.astype(np.uint8), K, LENS[:size]))
        assert (apart > 1).mean() < 0.01  # OpenCV 5 does not round positions


def bilinear(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Bilinear sampling in float64, with zeros outside."""
    padded = np.pad(image.astype(np.float64), ((2, 2), (2, 2), (0, 0)))
    x = np.clip(x.astype(np.float64) + 2, 0, padded.shape[1] - 1.001)
    y = np.clip(y.astype(np.float64) + 2, 0, padded.shape[0] - 1.001)
    j, i = x.astype(int), y.astype(int)
    fx, fy = (x - j)[..., None], (y - i)[..., None]
    upper, lower = (
        padded[i, j] * (1 - fx) + padded[i, j + 1] * fx,
        padded[i + 1, j] * (1 - fx) + padded[i + 1, j + 1] * fx,
    )
    return upper * (1 - fy) + lower * fy


def test_leading_dimensions() -> None:
    x = photo(6, 2, 11, 12, torch.float64)
    K, dist = tensors(np.array([[12.0, 0, 6.2], [0, 13.0, 5.7], [0, 0, 1]]), LENS[:5])
    flat = calibration.undistort_image(x, K.expand(6, 3, 3), dist.expand(6, 5))
    split = calibration.undistort_image(
        x.reshape(2, 3, 2, 11, 12), K.expand(2, 3, 3, 3), dist.expand(2, 3, 5)
    )
    assert split.reshape(x.shape).equal(flat)
    assert calibration.undistort_image(x[0], K, dist).equal(flat[0])


K3, P2 = torch.eye(3), torch.zeros(4, 2)
WRONG = [
    (
        lambda: calibration.distort_points(P2[0], K3, torch.zeros(4)),
        ValueError,
        r"points: expected shape \(\*, N, 2\)",
    ),
    (
        lambda: calibration.distort_points(P2, K3, torch.zeros(6)),
        ValueError,
        r"dist: expected shape .* got \[6\]",
    ),
    (
        lambda: calibration.distort_points(P2, K3[:2], torch.zeros(4)),
        ValueError,
        r"K: expected shape \(\*, 3, 3\), got \[2, 3\]",
    ),
    (
        lambda: calibration.undistort_points(P2, K3, torch.zeros(4), K3[0]),
        ValueError,
        "new_K: expected shape",
    ),
    (
        lambda: calibration.undistort_points(P2, K3, torch.zeros(4), None, 0),
        ValueError,
        "num_iters: expected at least 1",
    ),
    (
        lambda: calibration.tilt_projection(torch.zeros(2), torch.zeros(2)),
        ValueError,
        r"taux: expected shape \(\*, 1\)",
    ),
    (
        lambda: calibration.undistort_image(torch.zeros(2, 3, 4, 4), K3, torch.zeros(4)),
        ValueError,
        "K: expected the leading",
    ),
    (
        lambda: calibration.undistort_image(
            torch.zeros(2, 3, 1, 4, 4), torch.eye(3).expand(3, 2, 3, 3), torch.zeros(1, 1, 4)
        ),
        ValueError,
        "K: expected one for each of 6 images",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:30] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
