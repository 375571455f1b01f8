"""Thin-plate splines against NumPy, SciPy's RBFInterpolator and grid_sample."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import photo
from scipy.interpolate import RBFInterpolator

from chiasm.geometry.transform import get_tps_transform, warp_image_tps, warp_points_tps

D = torch.float64
GENERATOR = torch.Generator().manual_seed(0)
SOURCE = torch.rand((3, 9, 2), generator=GENERATOR, dtype=D) * 2 - 1
TARGET = SOURCE + 0.1 * torch.randn((3, 9, 2), generator=GENERATOR, dtype=D)
POINTS = torch.rand((3, 30, 2), generator=GENERATOR, dtype=D) * 2 - 1


def by_numpy(points: np.ndarray, centers: np.ndarray, kernel: np.ndarray, affine: np.ndarray) -> np.ndarray:
    r = np.linalg.norm(points[:, None] - centers[None], axis=-1)
    return (
        affine[0] + points @ affine[1:] + np.where(r > 0, r * r * np.log(np.where(r > 0, r, 1)), 0) @ kernel
    )


def test_goes_through_its_points() -> None:
    kernel, affine = get_tps_transform(SOURCE, TARGET)
    torch.testing.assert_close(warp_points_tps(SOURCE, TARGET, kernel, affine), TARGET, rtol=0, atol=1e-9)
    for b in range(3):
        np.testing.assert_allclose(kernel[b].sum(0), 0, atol=1e-9)
        np.testing.assert_allclose(SOURCE[b].T @ kernel[b], 0, atol=1e-9)
        expected = by_numpy(POINTS[b].numpy(), TARGET[b].numpy(), kernel[b].numpy(), affine[b].numpy())
        np.testing.assert_allclose(warp_points_tps(POINTS, TARGET, kernel, affine)[b], expected, atol=1e-11)


def test_evaluation_equals_scipy() -> None:
    """SciPy's kernels are centred at the source points; its spline equals ours with these centres."""
    for b in range(3):
        spline = RBFInterpolator(SOURCE[b].numpy(), TARGET[b].numpy(), kernel="thin_plate_spline", degree=1)
        one, p = np.ones((9, 1)), SOURCE[b].numpy()
        r = np.linalg.norm(p[:, None] - p[None], axis=-1)
        u = np.where(r > 0, r * r * np.log(np.where(r > 0, r, 1)), 0)
        side = np.concatenate([one, p], 1)
        system = np.block([[u, side], [side.T, np.zeros((3, 3))]])
        weights = torch.from_numpy(
            np.linalg.solve(system, np.concatenate([TARGET[b].numpy(), np.zeros((3, 2))]))
        )[None]
        actual = warp_points_tps(POINTS[b : b + 1], SOURCE[b : b + 1], weights[:, :9], weights[:, 9:])
        np.testing.assert_allclose(actual[0], spline(POINTS[b].numpy()), atol=1e-9)


def test_float32_is_solved_in_float64() -> None:
    kernel, affine = get_tps_transform(SOURCE.float(), TARGET.float())
    assert kernel.dtype == torch.float32
    torch.testing.assert_close(
        warp_points_tps(SOURCE.float(), TARGET.float(), kernel, affine), TARGET.float(), rtol=0, atol=1e-4
    )


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("padding", ["zeros", "border", "reflection"])
def test_image_equals_grid_sample(padding: str, align: bool) -> None:
    x = photo(3, 2, 23, 31, D)
    kernel, affine = get_tps_transform(TARGET, SOURCE)
    grid = F.affine_grid(torch.eye(3, dtype=D)[None, :2].expand(3, 2, 3), [3, 1, 23, 31], align)
    led = np.stack(
        [
            by_numpy(grid[b].reshape(-1, 2).numpy(), SOURCE[b].numpy(), kernel[b].numpy(), affine[b].numpy())
            for b in range(3)
        ]
    )
    expected = F.grid_sample(x, torch.from_numpy(led).reshape(grid.shape), "bilinear", padding, align)
    torch.testing.assert_close(
        warp_image_tps(x, SOURCE, kernel, affine, align, padding), expected, rtol=0, atol=1e-9
    )


def test_gradient_is_finite_at_a_centre() -> None:
    kernel, affine = get_tps_transform(SOURCE, TARGET)
    points = TARGET.clone().requires_grad_(True)
    warp_points_tps(points, TARGET, kernel, affine).sum().backward()
    assert torch.isfinite(points.grad).all()
    start = SOURCE.clone().requires_grad_(True)
    sum(w.sum() for w in get_tps_transform(start, start.detach())).backward()
    assert torch.isfinite(start.grad).all()
