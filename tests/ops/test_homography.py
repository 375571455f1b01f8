"""Homographies against OpenCV, and exact on four points."""

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.geometry.homography import find_homography_dlt


def truth(batch: int, dtype: torch.dtype) -> Tensor:
    m = torch.tensor([[1.1, 0.13, -33.0], [-0.08, 0.93, 27.0], [1.1e-4, -7e-5, 1.0]], dtype=torch.float64)
    bend = torch.tensor([[0.02, 0.0, 3.0], [0.0, -0.03, 0.0], [0.0, 1e-5, 0.0]], dtype=torch.float64)
    return torch.stack([m + b * bend for b in range(batch)]).to(dtype)


def apply(h: Tensor, p: Tensor) -> Tensor:
    q = torch.cat([p, torch.ones_like(p[..., :1])], -1).double() @ h.double().transpose(1, 2)
    return q[..., :2] / q[..., 2:]


def points(batch: int, count: int, seed: int = 0) -> Tensor:
    return (
        torch.rand(batch, count, 2, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        * 1000.0
    )


@pytest.mark.parametrize("seed", range(8))
def test_four_points_are_exact(seed: int) -> None:
    p = points(3, 4, seed)
    # Four points do not determine a homography if three are nearly collinear.
    corners = torch.tensor([[0.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0], [0.0, 1000.0]], dtype=torch.float64)
    p = corners + 0.3 * (p - 500.0)
    q = apply(truth(3, torch.float64), p)
    h = find_homography_dlt(p, q)
    for b in range(3):
        expected = cv2.getPerspectiveTransform(p[b].float().numpy(), q[b].float().numpy())
        np.testing.assert_allclose(h[b], expected, rtol=2e-3, atol=1e-4)
    assert (apply(h, p) - q).abs().max() < 1e-6
    single = find_homography_dlt(p.float(), q.float())
    assert single.dtype == torch.float32
    assert (apply(single, p) - q).abs().max() < 1e-2  # a hundredth of a pixel in 1000


@pytest.mark.parametrize("count", [5, 20, 300])
def test_noisy_points_equal_the_svd(count: int) -> None:
    p = points(3, count)
    q = (
        apply(truth(3, torch.float64), p)
        + torch.randn(3, count, 2, generator=torch.Generator().manual_seed(1)).double()
    )
    h = find_homography_dlt(p, q)
    for b in range(3):
        np.testing.assert_allclose(h[b], by_svd(p[b].numpy(), q[b].numpy()), rtol=1e-6, atol=1e-9)


def by_svd(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    def hartley(x: np.ndarray) -> np.ndarray:
        c = x.mean(0)
        s = np.sqrt(2) / np.linalg.norm(x - c, axis=1).mean()
        return np.array([[s, 0, -s * c[0]], [0, s, -s * c[1]], [0, 0, 1]])

    t1, t2 = hartley(p), hartley(q)
    ones = np.ones((len(p), 1))
    x, u = np.hstack([p, ones]) @ t1.T, np.hstack([q, ones]) @ t2.T
    zero = np.zeros_like(x)
    a = np.vstack([np.hstack([x, zero, -u[:, :1] * x]), np.hstack([zero, x, -u[:, 1:2] * x])])
    h = np.linalg.inv(t2) @ np.linalg.svd(a)[2][-1].reshape(3, 3) @ t1
    return h / h[2, 2]


def test_exact_points_equal_opencv() -> None:
    p = points(2, 30)
    q = apply(truth(2, torch.float64), p)
    for b in range(2):
        expected, _ = cv2.findHomography(p[b].numpy(), q[b].numpy())
        np.testing.assert_allclose(find_homography_dlt(p, q)[b], expected, rtol=1e-6, atol=1e-8)


def test_weight_zero_removes_a_point() -> None:
    p = points(2, 12)
    q = apply(truth(2, torch.float64), p)
    q[:, 3] += 200.0
    weights = torch.ones(2, 12, dtype=torch.float64)
    weights[:, 3] = 0.0
    assert (find_homography_dlt(p, q, weights) - truth(2, torch.float64)).abs().max() < 1e-6
    assert (find_homography_dlt(p, q) - truth(2, torch.float64)).abs().max() > 1e-3


def test_gradient_on_the_minimal_set() -> None:
    corners = torch.tensor([[0.0, 0.0], [1.0, 0.1], [1.1, 1.0], [-0.1, 0.9]], dtype=torch.float64)[None]
    p = corners.clone().requires_grad_(True)
    q = (corners * 2.0 + 0.1 * corners**2 + 0.3).requires_grad_(True)
    assert torch.autograd.gradcheck(find_homography_dlt, (p, q), atol=1e-4)
