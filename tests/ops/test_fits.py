"""Lines and planes through points against NumPy's singular value decomposition in float64."""

import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.geometry.line import fit_line
from chiasm.geometry.plane import fit_plane


def points(extent: tuple[float, ...], count: int = 30, batch: int = 4) -> np.ndarray:
    """Spread along random axes by `extent`, away from the origin."""
    random = np.random.default_rng(0)
    turn = np.linalg.qr(random.normal(size=(batch, len(extent), len(extent))))[0]
    return random.normal(size=(batch, count, len(extent))) * extent @ turn + 10.0 * random.normal(
        size=(batch, 1, len(extent))
    )


def axes(p: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weighted mean, and the principal axes in rows, the longest first, each with its largest coordinate
    positive."""
    mean = (w[:, None] * p).sum(0) / w.sum()
    v = np.linalg.svd(np.sqrt(w)[:, None] * (p - mean), full_matrices=False)[2]
    largest = np.take_along_axis(v, np.abs(v).argmax(1)[:, None], 1)
    return mean, v * np.sign(largest)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize(
    "extent", [(3.0, 0.1), (3.0, 0.5, 0.2), (3.0, 2.8, 1.0), (3.0, 0.0, 0.0), (4.0, 1.0, 0.5, 0.2)]
)
def test_line(extent: tuple[float, ...], weighted: bool, dtype: torch.dtype) -> None:
    p = torch.from_numpy(points(extent)).to(dtype)
    w = torch.from_numpy(np.random.default_rng(1).uniform(0.1, 2.0, p.shape[:2])) if weighted else None
    origin, direction = fit_line(p, w)
    for k in range(len(p)):
        mean, v = axes(p[k].double().numpy(), w[k].numpy() if w is not None else np.ones(p.size(1)))
        np.testing.assert_allclose(origin[k], mean, rtol=1e-6 if dtype == torch.float32 else 1e-12)
        np.testing.assert_allclose(direction[k], v[0], atol=1e-6 if dtype == torch.float32 else 1e-9)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("extent", [(3.0, 0.1), (3.0, 2.0, 0.2), (3.0, 2.0, 0.0), (3.0, 1.0, 0.8)])
def test_plane(extent: tuple[float, ...], weighted: bool, dtype: torch.dtype) -> None:
    p = torch.from_numpy(points(extent)).to(dtype)
    w = torch.from_numpy(np.random.default_rng(1).uniform(0.1, 2.0, p.shape[:2])) if weighted else None
    normal, offset = fit_plane(p, w)
    for k in range(len(p)):
        mean, v = axes(p[k].double().numpy(), w[k].numpy() if w is not None else np.ones(p.size(1)))
        np.testing.assert_allclose(normal[k], v[-1], atol=1e-6 if dtype == torch.float32 else 1e-9)
        np.testing.assert_allclose(offset[k], -v[-1] @ mean, atol=1e-4 if dtype == torch.float32 else 1e-8)


@pytest.mark.parametrize("fit", [fit_line, fit_plane])
def test_the_fewest_points_lie_on_it(fit: object) -> None:
    p = torch.from_numpy(points((3.0, 2.0, 1.0), 2 if fit is fit_line else 3))
    first, second = fit(p)
    if fit is fit_line:
        off = torch.linalg.cross(p - first[:, None], second[:, None].expand_as(p))
    else:
        off = (p * first[:, None]).sum(-1) + second[:, None]
    assert off.abs().max() < 1e-9


@pytest.mark.parametrize("fit", [fit_line, fit_plane])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_without_a_best_one_it_is_finite(fit: object, dtype: torch.dtype) -> None:
    corners = torch.tensor([[-1.0, -1, -1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], dtype=dtype)
    circle = torch.tensor([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=dtype)
    p = torch.stack([corners, circle, torch.ones(4, 3, dtype=dtype)]).requires_grad_(True)
    first, second = fit(p)
    assert torch.isfinite(first).all() and torch.isfinite(second).all()
    unit = second if fit is fit_line else first
    np.testing.assert_allclose(unit.detach().norm(dim=-1), 1.0, atol=1e-6)
    (first.sum() + second.sum()).backward()
    assert torch.isfinite(p.grad).all()


@pytest.mark.parametrize("fit", [fit_line, fit_plane])
@pytest.mark.parametrize("extent", [(3.0, 0.5), (3.0, 1.0, 0.2)])
def test_gradients(fit: object, extent: tuple[float, ...]) -> None:
    p: Tensor = torch.from_numpy(points(extent, 6, 2)).requires_grad_(True)
    w = (
        torch.rand(2, 6, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
        .add(0.1)
        .requires_grad_(True)
    )
    assert torch.autograd.gradcheck(fit, (p, w), atol=1e-6)


WRONG = [
    (torch.zeros(5), None, ValueError, r"points: expected shape \(B, N, D\), got 1 dim"),
    (torch.zeros(1, 5, 1), None, ValueError, "points: expected two coordinates or more, got 1"),
    (torch.zeros(1, 5, 2).int(), None, TypeError, "points: expected a floating-point"),
    (
        torch.zeros(1, 5, 2),
        torch.zeros(5),
        ValueError,
        r"weights: expected shape \[1, 5\] for points \[1, 5, 2\], got \[5\]",
    ),
    (
        torch.zeros(1, 5, 2),
        torch.zeros(1, 4),
        ValueError,
        r"weights: expected shape \[1, 5\] for points \[1, 5, 2\], got \[1, 4\]",
    ),
]


@pytest.mark.parametrize("fit", [fit_line, fit_plane])
@pytest.mark.parametrize(("p", "w", "error", "message"), WRONG, ids=[w[3][:40] for w in WRONG])
def test_message(fit: object, p: Tensor, w: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fit(p, w)
