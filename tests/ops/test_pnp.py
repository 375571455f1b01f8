"""Poses by least squares against OpenCV and scenes with known truth."""

import itertools

import cv2
import numpy as np
import pytest
import torch
from scenes import camera_matrix, points_in_front, pose, project

from chiasm.geometry.calibration import solve_pnp_dlt
from chiasm.geometry.pnp import refine_pnp


def scene(seed: int, noise: float = 1.0, count: int = 30, flat: bool = False) -> tuple[np.ndarray, ...]:
    """Points, the pixels at which a camera sees them, its matrix, R and t."""
    K, (R, t), X = camera_matrix(seed), pose(seed), points_in_front(count, seed)
    if flat:
        X[:, 2] = 6.0
    return X, project(K, R, t, X) + noise * np.random.default_rng(seed).normal(size=(count, 2)), K, R, t


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [torch.from_numpy(a)[None] for a in arrays]


def near(R: np.ndarray, t: np.ndarray, seed: int, angle: float, shift: float) -> torch.Tensor:
    turn, move = pose(seed + 50, angle, shift)
    return torch.from_numpy(np.hstack([turn @ R, t + move]))[None]


def by_opencv(X: np.ndarray, x: np.ndarray, K: np.ndarray) -> np.ndarray:
    found, rotation, t = cv2.solvePnP(X, x, K, None, flags=cv2.SOLVEPNP_ITERATIVE)
    assert found
    rotation, t = cv2.solvePnPRefineLM(
        X, x, K, None, rotation, t, (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-15)
    )
    return np.hstack([cv2.Rodrigues(rotation)[0], t])


@pytest.mark.parametrize("seed", range(4))
def test_equals_opencv_from_the_direct_linear_transform(seed: int) -> None:
    X, x, K, _, _ = scene(seed)
    inputs = tensors(X, x, K)
    start = solve_pnp_dlt(*inputs)
    refined = refine_pnp(*inputs, start)[0].numpy()
    np.testing.assert_allclose(refined, by_opencv(X, x, K), atol=1e-7)
    np.testing.assert_allclose(refined[:, :3] @ refined[:, :3].T, np.eye(3), atol=1e-12)
    single = refine_pnp(*[a.float() for a in inputs], start.float())[0]
    assert single.dtype == torch.float32
    np.testing.assert_allclose(single, refined, atol=2e-5)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("flat", [False, True])
def test_arrives_from_far(seed: int, flat: bool) -> None:
    X, x, K, R, t = scene(seed, 0.5, flat=flat)
    refined = refine_pnp(*tensors(X, x, K), near(R, t, seed, 0.5, 1.0), num_iters=20)[0].numpy()
    np.testing.assert_allclose(refined, by_opencv(X, x, K), atol=1e-6)


def test_exact_points_give_the_exact_pose() -> None:
    X, x, K, R, t = scene(5, 0.0, 4)
    refined = refine_pnp(*tensors(X, x, K), near(R, t, 5, 0.1, 0.2))[0].numpy()
    np.testing.assert_allclose(refined, np.hstack([R, t]), atol=1e-10)


def test_no_step_makes_it_worse() -> None:
    X, x, K, R, t = scene(6)
    inputs = tensors(X, x, K)
    start = near(R, t, 6, 1.5, 3.0)
    costs = []
    for steps in range(12):
        pose = refine_pnp(*inputs, start, num_iters=steps)[0].numpy()
        costs.append(((project(K, pose[:, :3], pose[:, 3:], X) - x) ** 2).sum())
    assert all(later <= earlier * (1 + 1e-9) for earlier, later in itertools.pairwise(costs))
    np.testing.assert_allclose(refine_pnp(*inputs, start, num_iters=0), start, atol=1e-12)


def test_weights_of_zero_leave_points_out() -> None:
    X, x, K, R, t = scene(7)
    weights = torch.ones(1, 30, dtype=torch.float64)
    weights[:, ::3] = 0.0
    wrong = x.copy()
    wrong[::3] += 50.0
    kept = weights[0].numpy() > 0
    refined = refine_pnp(*tensors(X, wrong, K), near(R, t, 7, 0.1, 0.2), weights)[0].numpy()
    np.testing.assert_allclose(refined, by_opencv(X[kept], x[kept], K), atol=1e-7)


@pytest.mark.parametrize(("noise", "tolerance"), [(0.0, 1e-6), (1.0, 1e-3), (5.0, 2e-2)])
def test_gradient_is_nearly_the_minimums_with_large_distances_left(noise: float, tolerance: float) -> None:
    X, x, K, R, t = scene(8, noise, 12)
    inputs = tensors(X, x, K)
    start = near(R, t, 8, 0.05, 0.1)
    generator = torch.Generator().manual_seed(0)
    weights = torch.randn(3, 4, generator=generator, dtype=torch.float64)

    def value(*moved: torch.Tensor) -> torch.Tensor:
        return (refine_pnp(*moved, start, num_iters=20) * weights).sum()

    active = [a.clone().requires_grad_(True) for a in inputs]
    gradients = torch.autograd.grad(value(*active), active)
    slopes, differences = [], []
    for _ in range(8):
        way = [torch.randn(a.shape, generator=generator, dtype=torch.float64) for a in inputs]
        slopes.append(sum((g * w).sum() for g, w in zip(gradients, way, strict=True)))
        ends = [value(*(a + h * w for a, w in zip(inputs, way, strict=True))) for h in (1e-6, -1e-6)]
        differences.append((ends[0] - ends[1]) / 2e-6)
    slopes, differences = torch.stack(slopes), torch.stack(differences)
    assert (slopes - differences).norm() < tolerance * differences.norm()


def test_a_batch_is_its_entries() -> None:
    scenes = [scene(seed) for seed in range(3)]
    inputs = [torch.cat(parts) for parts in zip(*(tensors(*s[:3]) for s in scenes), strict=True)]
    start = torch.cat([near(s[3], s[4], k, 0.2, 0.3) for k, s in enumerate(scenes)])
    together = refine_pnp(*inputs, start)
    for b in range(3):
        torch.testing.assert_close(
            refine_pnp(*[a[b : b + 1] for a in inputs], start[b : b + 1])[0], together[b], rtol=0, atol=1e-12
        )


X8, P8, K3, POSE = (
    torch.zeros(2, 8, 3),
    torch.zeros(2, 8, 2),
    torch.eye(3).expand(2, 3, 3),
    torch.eye(4)[None, :3].expand(2, 3, 4),
)
MESSAGES = [
    (
        lambda: refine_pnp(X8[:, :2], P8[:, :2], K3, POSE),
        ValueError,
        "world_points: expected at least 3 points, got 2",
    ),
    (
        lambda: refine_pnp(X8, P8[:, :5], K3, POSE),
        ValueError,
        "img_points: expected as many points as world_points, 8, got 5",
    ),
    (lambda: refine_pnp(X8, P8, K3, K3), ValueError, r"pose: expected shape \(\*, 3, 4\), got \[2, 3, 3\]"),
    (lambda: refine_pnp(X8, P8, K3, POSE[0]), ValueError, r"pose: expected shape \(B, 3, 4\)"),
    (
        lambda: refine_pnp(X8, P8, K3, POSE, X8),
        ValueError,
        r"weights: expected shape \(B, N\), got \[2, 8, 3\]",
    ),
    (
        lambda: refine_pnp(X8, P8, K3, POSE, num_iters=-1),
        ValueError,
        "num_iters: expected at least 0, got -1",
    ),
    (
        lambda: refine_pnp(X8.long(), P8, K3, POSE),
        TypeError,
        "world_points: expected a floating-point tensor",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), MESSAGES, ids=[m[2][:30] for m in MESSAGES])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
