"""Depth maps against NumPy and OpenCV, on a plane seen from two positions."""

import cv2
import numpy as np
import pytest
import torch
from scenes import pose

from chiasm.geometry import depth

HEIGHT, WIDTH = 24, 31
K = np.array([[33.0, 0, 15.4], [0, 30.0, 11.2], [0, 0, 1]])
GRID = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), -1).astype(np.float64)
RAYS = np.concatenate([(GRID - K[:2, 2]) / K[[0, 1], [0, 1]], np.ones((HEIGHT, WIDTH, 1))], -1)


def plane_depth(normal: np.ndarray, offset: float) -> np.ndarray:
    return offset / (RAYS @ normal)


def batch(array: np.ndarray, count: int = 1) -> torch.Tensor:
    return torch.from_numpy(array).expand(count, *array.shape)


def test_depth_from_disparity() -> None:
    d = torch.tensor([[2.0, 8.0]], dtype=torch.float64)
    np.testing.assert_allclose(depth.depth_from_disparity(d, 0.1, 400.0), [[20.0, 5.0]])
    np.testing.assert_allclose(
        depth.depth_from_disparity(d, torch.tensor([0.1]).double(), torch.tensor(400.0).double()),
        [[20.0, 5.0]],
    )
    assert depth.depth_from_disparity(torch.zeros(1), 0.1, 400.0).isfinite().all()


def test_a_plane() -> None:
    normal, offset = np.array([0.2, -0.1, 0.97]), 3.0
    truth = plane_depth(normal, offset)
    found = depth.depth_from_plane_equation(
        batch(normal), batch(np.array([offset])), batch(GRID.reshape(-1, 2)), batch(K)
    )
    np.testing.assert_allclose(found[0].reshape(HEIGHT, WIDTH), truth, rtol=1e-12)
    points = depth.depth_to_3d(batch(truth)[None], batch(K))[0]
    np.testing.assert_allclose(points.permute(1, 2, 0), RAYS * truth[..., None], rtol=1e-12)
    np.testing.assert_allclose(
        depth.depth_to_3d_v2(torch.from_numpy(truth), torch.from_numpy(K)), points.permute(1, 2, 0)
    )
    grid = depth.unproject_meshgrid(HEIGHT, WIDTH, torch.from_numpy(K))
    np.testing.assert_allclose(grid, RAYS, rtol=1e-12)
    np.testing.assert_allclose(
        depth.depth_to_3d_v2(torch.from_numpy(truth), torch.from_numpy(K), False, grid),
        points.permute(1, 2, 0),
    )
    unit = depth.depth_to_3d(batch(truth)[None], batch(K), True)[0].norm(dim=0)
    np.testing.assert_allclose(unit, truth, rtol=1e-12)


def test_parallel_rays_are_far_and_finite() -> None:
    found = depth.depth_from_plane_equation(
        torch.tensor([[1.0, 0.0, 0.0]]),
        torch.ones(1, 1),
        torch.tensor([[[0.0, 1.0], [-1e-12, 0.0]]]),
        torch.eye(3)[None],
    )
    assert found[0, 0] > 1e7 and found[0, 1] < -1e7 and found.isfinite().all()


def test_normals() -> None:
    """A bumpy surface against OpenCV's Sobel; a plane nearly has its own normal (Sobel's smoothing is exact
    for planes in space only at unit slope)."""
    z = 3.0 + 0.3 * np.sin(0.4 * GRID[..., 0]) + 0.2 * np.cos(0.3 * GRID[..., 1])
    points = RAYS * z[..., None]
    du, dv = (cv2.Sobel(points, cv2.CV_64F, dx, 1 - dx, borderType=cv2.BORDER_REPLICATE) / 8 for dx in (1, 0))
    expected = np.cross(du, dv)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    found = depth.depth_to_normals(batch(z)[None], batch(K))[0].permute(1, 2, 0)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    normal = np.array([0.2, -0.1, 0.97]) / np.linalg.norm([0.2, -0.1, 0.97])
    flat = depth.depth_to_normals(batch(plane_depth(normal, 3.0))[None], batch(K))[0].permute(1, 2, 0)
    np.testing.assert_allclose(
        flat[1:-1, 1:-1], np.broadcast_to(normal, (HEIGHT - 2, WIDTH - 2, 3)), atol=0.01
    )


def test_normals_where_there_are_none() -> None:
    z = torch.zeros(1, 1, 9, 9, dtype=torch.float64, requires_grad=True)
    normals = depth.depth_to_normals(z, batch(K))
    normals.sum().backward()
    assert normals.abs().max() == 0 and z.grad.isfinite().all()


def views() -> tuple[np.ndarray, ...]:
    """Extrinsics of two views, the source's depth of a plane, and the destination's smooth picture."""
    extrinsics = []
    for seed in (1, 2):
        E = np.eye(4)
        E[:3, :3], E[:3, 3:] = pose(seed, 0.1, 0.3)
        extrinsics.append(E)
    picture = np.stack(
        [np.sin(0.3 * GRID[..., 0]) + 0.1 * GRID[..., 1], np.cos(0.2 * GRID[..., 1] + 0.1 * GRID[..., 0])]
    )
    return extrinsics[0], extrinsics[1], plane_depth(np.array([0.1, 0.2, 0.97]), 3.0), picture


def read_there(picture: np.ndarray, motion: np.ndarray, points: np.ndarray) -> np.ndarray:
    rotation, _ = cv2.Rodrigues(motion[:3, :3])
    uv = (
        cv2.projectPoints(points.reshape(-1, 3), rotation, motion[:3, 3], K, None)[0]
        .reshape(HEIGHT, WIDTH, 2)
        .astype(np.float32)
    )
    return np.stack(
        [cv2.remap(p.astype(np.float32), uv[..., 0], uv[..., 1], cv2.INTER_LINEAR) for p in picture]
    )


def test_depth_warp_reads_where_opencv_projects() -> None:
    dst, src, z, picture = views()
    expected = read_there(picture, dst @ np.linalg.inv(src), RAYS * z[..., None])
    arguments = [batch(a) for a in (K, dst, K, src)]
    found = depth.depth_warp(*arguments, batch(z)[None], batch(picture))[0]
    np.testing.assert_allclose(found, expected, atol=0.02)  # OpenCV rounds positions to 1/32
    assert (found[0] != 0).double().mean() > 0.5
    K4 = np.eye(4)
    K4[:3, :3] = K
    assert depth.depth_warp(batch(K4), arguments[1], batch(K4), arguments[3], batch(z)[None], batch(picture))[
        0
    ].equal(found)
    behind = np.eye(4)
    behind[2, 3] = -100.0
    assert (
        depth.depth_warp(batch(K), batch(behind), batch(K), batch(np.eye(4)), batch(z)[None], batch(picture))
        .abs()
        .max()
        == 0
    )


def test_positions_are_as_exact_as_the_geometry() -> None:
    """A ramp of one level a pixel, far from the camera's axis: its levels are positions."""
    width = 4000
    camera = torch.tensor([[[1000.0, 0.0, 2000.0], [0.0, 1000.0, 1.0], [0.0, 0.0, 1.0]]], dtype=torch.float64)
    motion = torch.eye(4, dtype=torch.float64)[None].clone()
    motion[0, 0, 3] = 0.0123
    z = torch.full((1, 1, 2, width), 3.7, dtype=torch.float64)
    ramp = torch.arange(width, dtype=torch.float64).expand(1, 1, 2, width)
    found, exact = (
        depth.depth_warp(camera, motion, camera, torch.eye(4, dtype=torch.float64)[None], z, image)
        for image in (ramp.float(), ramp)
    )
    torch.testing.assert_close(found[..., 5:-5].double(), exact[..., 5:-5], atol=5e-4, rtol=0)


@pytest.mark.parametrize("unit", [False, True])
def test_warp_frame_depth_reads_where_opencv_projects(unit: bool) -> None:
    motion, _, z, picture = views()
    points = RAYS * z[..., None] / (np.linalg.norm(RAYS, axis=-1, keepdims=True) if unit else 1.0)
    found = depth.warp_frame_depth(batch(picture), batch(z)[None], batch(motion), batch(K), unit)[0]
    np.testing.assert_allclose(found, read_there(picture, motion, points), atol=0.02)


def test_warp_by_a_plane_is_a_homography() -> None:
    """With the destination's depth of a plane, the warp equals cv2.warpPerspective by the plane's
    homography."""
    motion, _, _, picture = views()
    normal, offset = np.array([0.1, 0.2, 0.97]), 3.0
    H = K @ (motion[:3, :3] + motion[:3, 3:] @ normal[None] / offset) @ np.linalg.inv(K)
    found = depth.warp_frame_depth(
        batch(picture), batch(plane_depth(normal, offset))[None], batch(motion), batch(K)
    )[0]
    for plane, ours in zip(picture, found, strict=True):
        expected = cv2.warpPerspective(
            plane.astype(np.float32), H, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        np.testing.assert_allclose(ours, expected, atol=0.02)


D, M4, X = torch.ones(1, 1, 4, 5), torch.eye(4)[None], torch.ones(1, 3, 4, 5)
K3 = torch.eye(3)[None]
WRONG = [
    (
        lambda: depth.depth_from_disparity(D.int(), 1.0, 1.0),
        TypeError,
        "disparity: expected a floating-point",
    ),
    (lambda: depth.depth_to_3d(D[0], K3), ValueError, r"depth: expected shape \(B, C, H, W\)"),
    (
        lambda: depth.depth_to_3d(X, K3),
        ValueError,
        r"depth: expected shape \(B, 1, H, W\), got \[1, 3, 4, 5\]",
    ),
    (lambda: depth.depth_to_3d(D, K3[0]), ValueError, r"camera_matrix: expected shape \(B, 3, 3\)"),
    (lambda: depth.depth_to_3d_v2(D, M4), ValueError, r"camera_matrix: expected shape \(\*, 3, 3\)"),
    (
        lambda: depth.depth_from_plane_equation(D, D, D, K3),
        ValueError,
        r"plane_normals: expected shape \(B, 3\)",
    ),
    (
        lambda: depth.depth_warp(K3[:, :2], M4, K3, M4, D, X),
        ValueError,
        r"intrinsics_dst: expected shape \(\*, 3, 3\) or",
    ),
    (
        lambda: depth.depth_warp(K3, K3, K3, M4, D, X),
        ValueError,
        r"extrinsics_dst: expected shape \(\*, 4, 4\)",
    ),
    (lambda: depth.warp_frame_depth(X, D, K3, K3), ValueError, r"src_trans_dst: expected shape \(\*, 4, 4\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:30] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
