"""Stereo pairs against OpenCV, scenes with known truth, and a photographed pair."""

import cv2
import motorcycle
import numpy as np
import pytest
import torch
from photos import load
from scenes import camera_matrix, points_in_front, pose, project

from chiasm.geometry.depth import depth_from_disparity
from chiasm.geometry.epipolar import motion_from_essential_choose_solution
from chiasm.geometry.ransac import ransac_essential
from chiasm.geometry.stereo import reproject_disparity_to_3d, stereo_rectify

NAMES = ("R1", "R2", "P1", "P2", "Q")
SHIFTS = {
    "left": (-0.6, 0.05, 0.1),
    "right": (0.6, -0.1, 0.02),
    "above": (0.1, -0.5, 0.02),
    "below": (0.05, 0.7, 0.1),
}
LENSES = (np.array([-0.12, 0.03, 1e-3, -5e-4, 0.0]), np.array([-0.08, 0.01, -1e-3, 5e-4, 0.0]))


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [torch.from_numpy(a)[None] for a in arrays]


def rig(seed: int, shift: str, angle: float = 0.15) -> tuple[np.ndarray, ...]:
    return (
        camera_matrix(seed),
        camera_matrix(seed + 5),
        pose(seed, angle)[0],
        np.array(SHIFTS[shift])[:, None],
    )


@pytest.mark.parametrize("lens", [False, True])
@pytest.mark.parametrize("zero_disparity", [True, False])
@pytest.mark.parametrize("shift", SHIFTS)
def test_equals_opencv(shift: str, zero_disparity: bool, lens: bool) -> None:
    for seed in range(2):
        K1, K2, R, t = rig(seed, shift)
        d1, d2 = LENSES if lens else (None, None)
        flags = cv2.CALIB_ZERO_DISPARITY if zero_disparity else 0
        expected = cv2.stereoRectify(K1, d1, K2, d2, (640, 480), R, t, flags=flags, alpha=-1)[:5]
        dist = tensors(d1, d2) if lens else [None, None]
        result = stereo_rectify(*tensors(K1, K2, R, t), 480, 640, *dist, zero_disparity)
        for name, a, b in zip(NAMES, result, expected, strict=True):
            # OpenCV computes principal points from corners, which it moves in float32 and undistorts in five
            # steps
            exact = name in ("R1", "R2")
            np.testing.assert_allclose(
                a[0],
                b,
                rtol=1e-9 if exact else 1e-6,
                atol=1e-12 if exact else 2e-3 if lens else 1e-4,
                err_msg=name,
            )


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("zero_disparity", [True, False])
def test_points_are_in_one_row_and_come_back(shift: str, zero_disparity: bool) -> None:
    K1, K2, R, t = rig(3, shift)
    R1, R2, P1, P2, Q = (
        m[0].numpy() for m in stereo_rectify(*tensors(K1, K2, R, t), 480, 640, zero_disparity=zero_disparity)
    )
    X = points_in_front(50)
    rectified = X @ R1.T
    x1, x2 = (project(P[:, :3], np.eye(3), np.linalg.inv(P[:, :3]) @ P[:, 3:], rectified) for P in (P1, P2))
    # each is the rotated view of its camera
    np.testing.assert_allclose(
        motorcycle.turned(project(K1, np.eye(3), np.zeros((3, 1)), X), K1, R1, P1[:, :3]), x1, atol=1e-9
    )
    np.testing.assert_allclose(motorcycle.turned(project(K2, R, t, X), K2, R2, P2[:, :3]), x2, atol=1e-9)
    along = 0 if shift in ("left", "right") else 1
    np.testing.assert_allclose(x1[:, 1 - along], x2[:, 1 - along], atol=1e-9)
    back = np.c_[x1, (x1 - x2)[:, along], np.ones(50)] @ Q.T
    np.testing.assert_allclose(back[:, :3] / back[:, 3:], rectified, atol=1e-9)


def test_a_rectified_pair_stays_as_it_is() -> None:
    K = camera_matrix()
    R1, R2, P1, P2, _ = stereo_rectify(*tensors(K, K, np.eye(3), np.array([[-0.3], [0.0], [0.0]])), 480, 640)
    for R in (R1, R2):
        np.testing.assert_allclose(R[0], np.eye(3), atol=1e-15)
    assert P1[0, 0, 0] == P1[0, 1, 1] == pytest.approx(K[1, 1])
    assert P2[0, 0, 3].item() == pytest.approx(-0.3 * K[1, 1])


def test_no_disparity_is_far_away() -> None:
    Q = stereo_rectify(*tensors(*rig(1, "left")), 5, 6)[4]
    disparity = torch.zeros(1, 1, 5, 6, dtype=torch.float64, requires_grad=True)
    points = reproject_disparity_to_3d(disparity, Q)
    (gradient,) = torch.autograd.grad(points.sum(), disparity)
    assert points.isfinite().all() and gradient.isfinite().all() and points[..., 2].min() > 1e9


# --- a photographed pair ------------------------------------------------------------------------------------


def test_the_disparities_are_of_the_left_image() -> None:
    left, right = motorcycle.matches(3000)
    colours = []
    for name, x in (("motorcycle_left.png", left), ("motorcycle_right.png", right)):
        colours.append(
            cv2.remap(load(name).astype(np.float32), x[None].astype(np.float32), None, cv2.INTER_LINEAR)[0]
        )
    assert np.median(np.abs(colours[0] - colours[1])) < 8


def test_depths_of_the_motorcycle() -> None:
    d = np.nan_to_num(motorcycle.disparity(), nan=0.0, posinf=0.0)
    K1, K2, t = motorcycle.LEFT, motorcycle.RIGHT, np.array([[-motorcycle.BASELINE], [0.0], [0.0]])
    _, _, P1, P2, Q = stereo_rectify(*tensors(K1, K2, np.eye(3), t), *d.shape, zero_disparity=False)
    # already rectified: only the principal points move, by their offset from the images' centres
    moved = (K1 - P1[0, :, :3].numpy())[0, 2], (K2 - P2[0, :, :3].numpy())[0, 2]
    disparity = torch.from_numpy(d)[None, None]
    valid = d > 0
    points = reproject_disparity_to_3d(disparity - (moved[0] - moved[1]), Q)[0].numpy()
    depth = depth_from_disparity(disparity + motorcycle.OFFSET, motorcycle.BASELINE, K1[0, 0])[0, 0].numpy()
    np.testing.assert_allclose(points[valid][:, 2], depth[valid], rtol=1e-6)
    assert depth[valid].min() > 1500 and depth[valid].max() < 20000  # millimetres


def test_the_motorcycle_by_turned_cameras_from_matches_to_points() -> None:
    """From matches, a third of them wrong, to an essential matrix, a rectified pair and points, up to the
    unknown scale."""
    left, right = motorcycle.matches(500, 3)
    turn1, turn2 = pose(1, 0.05)[0], pose(2, 0.06)[0]
    x1, x2 = (
        motorcycle.turned(left, motorcycle.LEFT, turn1, motorcycle.LEFT),
        motorcycle.turned(right, motorcycle.RIGHT, turn2, motorcycle.RIGHT),
    )
    x2[::3] = np.roll(x2[::3], 7, 0)
    right_ones = np.arange(500) % 3 > 0
    K1, K2 = tensors(motorcycle.LEFT, motorcycle.RIGHT)
    p1, p2 = tensors(x1, x2)
    numbers = torch.rand(1, 200, 5, generator=torch.Generator().manual_seed(0))
    E, mask = ransac_essential(p1, p2, K1, K2, numbers)
    R, t, _, _ = motion_from_essential_choose_solution(E, K1, K2, p1, p2, mask)
    R1, R2, P1, P2, Q = (
        m[0].numpy()
        for m in stereo_rectify(K1, K2, R, t * motorcycle.BASELINE, *motorcycle.disparity().shape)
    )
    u1 = motorcycle.turned(x1[right_ones], motorcycle.LEFT, R1, P1[:, :3])
    u2 = motorcycle.turned(x2[right_ones], motorcycle.RIGHT, R2, P2[:, :3])
    assert np.abs(u1[:, 1] - u2[:, 1]).max() < 0.1
    back = np.c_[u1, (u1 - u2)[:, 0], np.ones(len(u1))] @ Q.T
    depth = (back[:, :3] / back[:, 3:] @ R1 @ turn1)[:, 2]
    true = motorcycle.BASELINE * motorcycle.LEFT[0, 0] / ((left - right)[right_ones, 0] + motorcycle.OFFSET)
    np.testing.assert_allclose(depth, true, rtol=0.01)


K3, ZERO = torch.eye(3)[None], torch.zeros(1, 3, 1)
MESSAGES = [
    (lambda: stereo_rectify(K3[0], K3, K3, ZERO, 4, 5), ValueError, r"K1: expected shape \(B, 3, 3\)"),
    (lambda: stereo_rectify(K3, K3, K3, ZERO[..., 0], 4, 5), ValueError, r"t: expected shape \(B, 3, 1\)"),
    (lambda: stereo_rectify(K3, K3, K3.long(), ZERO, 4, 5), TypeError, "R: expected a floating-point tensor"),
    (lambda: stereo_rectify(K3, K3, K3, ZERO, 4, 5, torch.zeros(1, 6)), ValueError, "dist: expected shape"),
    (
        lambda: reproject_disparity_to_3d(torch.zeros(1, 2, 4, 5), torch.eye(4)[None]),
        ValueError,
        r"disparity: expected shape \(B, 1, H, W\)",
    ),
    (
        lambda: reproject_disparity_to_3d(torch.zeros(1, 1, 4, 5), torch.eye(4)),
        ValueError,
        r"Q: expected shape \(B, 4, 4\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), MESSAGES, ids=[m[2][:30] for m in MESSAGES])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_no_cameras_are_rectified() -> None:
    none = torch.zeros(0, 3, 3)
    shapes = [r.shape for r in stereo_rectify(none, none, none, none[..., :1], 10, 12)]
    assert shapes == [(0, 3, 3), (0, 3, 3), (0, 3, 4), (0, 3, 4), (0, 4, 4)]
