"""Key points: against the centres of Gaussians, and loops in NumPy written from the papers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.ndimage
import torch
from torch import Tensor

from chiasm import ops


def gaussians(centres: np.ndarray, sigma: float, height: int, width: int) -> Tensor:
    """Heat maps (1, K, H, W) with centres (K, 2)."""
    x, y = np.arange(width) - centres[:, :1], np.arange(height) - centres[:, 1:]
    along_x, along_y = np.exp(-(x**2) / (2 * sigma**2)), np.exp(-(y**2) / (2 * sigma**2))
    return torch.from_numpy(along_y[:, :, None] * along_x[:, None, :])[None]


def argmax(heatmap: np.ndarray) -> tuple[int, int]:
    """The column and the row of the largest value, the first of equals."""
    row, column = np.unravel_index(int(heatmap.argmax()), heatmap.shape)
    return int(column), int(row)


def quarter(heatmap: np.ndarray) -> list[float]:
    """Newell's shift, one axis after the other."""
    column, row = argmax(heatmap)
    point = [float(column), float(row)]
    if 0 < column < heatmap.shape[1] - 1:
        point[0] += 0.25 * np.sign(heatmap[row, column + 1] - heatmap[row, column - 1])
    if 0 < row < heatmap.shape[0] - 1:
        point[1] += 0.25 * np.sign(heatmap[row + 1, column] - heatmap[row - 1, column])
    return point


def dark(heatmap: np.ndarray, kernel_size: int) -> list[float]:
    """Zhang's equations 8 to 10, the Hessian solved by NumPy."""
    column, row = argmax(heatmap)
    radius = kernel_size // 2
    sigma = 0.15 * kernel_size + 0.35
    taps = np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma**2))
    smooth = heatmap
    for axis in (0, 1):
        smooth = scipy.ndimage.correlate1d(smooth, taps / taps.sum(), axis, mode="constant")
    smooth = (smooth - smooth.min()) / (smooth.max() - smooth.min()) * heatmap.max()
    p = np.log(np.maximum(smooth, 1e-10 * heatmap.max()))
    height, width = heatmap.shape
    if not (0 < column < width - 1 and 0 < row < height - 1):
        return [column, row]
    gradient_y, gradient_x = np.gradient(p)
    crossed = np.gradient(gradient_x, axis=0)[row, column]
    xx = p[row, column + 1] - 2 * p[row, column] + p[row, column - 1]
    yy = p[row + 1, column] - 2 * p[row, column] + p[row - 1, column]
    hessian = np.array([[xx, crossed], [crossed, yy]])
    if not (np.linalg.eigvalsh(hessian) < -1e-5).all():
        return [column, row]
    step = np.linalg.solve(hessian, [gradient_x[row, column], gradient_y[row, column]])
    return list(np.clip([column - step[0], row - step[1]], 0, [width - 1, height - 1]))


@pytest.mark.parametrize(("sigma", "kernel_size"), [(2.0, 11), (3.0, 17), (1.5, 11)])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_dark_finds_the_centre_of_a_gaussian(sigma: float, kernel_size: int, dtype: torch.dtype) -> None:
    centres = np.random.default_rng(0).uniform([16, 14], [48, 40], (50, 2))
    maps = gaussians(centres, sigma, 56, 64).to(dtype)
    points, _ = ops.decode_heatmaps(maps, "dark", kernel_size)
    np.testing.assert_allclose(points[0], centres, rtol=0, atol=1e-3)
    # The sub-pixel accuracy comes from the refinement
    assert np.abs(ops.decode_heatmaps(maps)[0][0] - centres).max() > 0.4


def noisy(seed: int, height: int, width: int) -> Tensor:
    random = np.random.default_rng(seed)
    centres = random.uniform(0, [width - 1, height - 1], (30, 2))
    return gaussians(centres, 2.0, height, width) + torch.from_numpy(
        0.05 * random.random((2, 30, height, width))
    )


@pytest.mark.parametrize(("height", "width"), [(24, 31), (3, 3), (2, 9), (1, 1)])
def test_refinements_are_the_papers(height: int, width: int) -> None:
    maps = noisy(3, height, width)
    plain = ops.decode_heatmaps(maps)
    quarters = ops.decode_heatmaps(maps, "quarter")[0]
    newton = ops.decode_heatmaps(maps, "dark", 7)[0]
    for b in range(2):
        for k in range(30):
            heatmap = maps[b, k].numpy()
            assert plain[0][b, k].tolist() == list(argmax(heatmap))
            assert plain[1][b, k] == heatmap.max()
            assert quarters[b, k].tolist() == quarter(heatmap)
            np.testing.assert_allclose(newton[b, k], dark(heatmap, 7), atol=1e-9)


def test_the_first_of_equals() -> None:
    maps = torch.zeros(1, 2, 4, 5)
    maps[0, 1, 1, 3] = maps[0, 1, 2, 1] = 1.0
    for refinement in ("none", "quarter"):
        points, scores = ops.decode_heatmaps(maps, refinement)
        assert points.tolist() == [[[0.0, 0.0], [3.0, 1.0]]] and scores.tolist() == [[0.0, 1.0]]


def test_what_is_flat_is_not_refined() -> None:
    ridge = gaussians(np.array([[10.3, 10.0]]), 2.0, 21, 21)[:, :, 10:11].expand(-1, -1, 21, -1)
    for maps in (torch.full((1, 1, 9, 9), 0.5), torch.zeros(1, 1, 9, 9), ridge * 0 - 3.0):
        points, _ = ops.decode_heatmaps(maps, "dark")
        assert points.tolist() == [[[0.0, 0.0]]]
    # All rows except the borders have the same values, so a step across the rows would be noise
    maps = ridge.clone()
    maps[0, 0, 10] *= 1 + 1e-12
    points, _ = ops.decode_heatmaps(maps, "dark", 3)
    assert points.tolist() == [[[10.0, 10.0]]]


def test_nan_is_found_and_not_refined() -> None:
    maps = noisy(0, 12, 12)[:1, :1].clone()
    maps[0, 0, 5, 7] = float("nan")
    for refinement in ("none", "quarter", "dark"):
        points, scores = ops.decode_heatmaps(maps, refinement)
        assert torch.isnan(scores).all() and torch.isfinite(points).all()
        assert (points - torch.tensor([7.0, 5.0])).abs().max() <= 0.25


def test_half_precision_is_computed_in_float32() -> None:
    maps = noisy(1, 20, 20).half()
    points, scores = ops.decode_heatmaps(maps, "dark")
    assert points.dtype == torch.float32 and scores.dtype == torch.float16
    torch.testing.assert_close(points, ops.decode_heatmaps(maps.float(), "dark")[0])


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_positions_that_half_precision_lacks(dtype: torch.dtype) -> None:
    """bfloat16 has no 383, float16 no 2047.5."""
    maps = torch.zeros(1, 1, 384, 288, dtype=dtype)
    maps[0, 0, 383, 287] = 1
    for refinement in ("none", "quarter", "dark"):
        assert ops.decode_heatmaps(maps, refinement)[0].tolist() == [[[287.0, 383.0]]]
    places = torch.zeros(1, 1, 4096, dtype=dtype)
    places[0, 0, 4095] = 1
    assert ops.decode_simcc(places, places[..., 4000:])[0].tolist() == [[[2047.5, 47.5]]]


def test_an_empty_batch_and_no_keypoints() -> None:
    points, scores = ops.decode_heatmaps(torch.zeros(0, 3, 8, 8), "quarter")
    assert points.shape == (0, 3, 2) and scores.shape == (0, 3)
    for refinement in ("none", "quarter", "dark"):
        points, scores = ops.decode_heatmaps(torch.zeros(2, 0, 8, 8), refinement)
        assert points.shape == (2, 0, 2) and scores.shape == (2, 0)
    points, scores = ops.decode_simcc(torch.zeros(2, 0, 8), torch.zeros(2, 0, 4))
    assert points.shape == (2, 0, 2) and scores.shape == (2, 0)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 3.0])
def test_simcc(ratio: float) -> None:
    random = np.random.default_rng(0)
    # Few levels, which give ties
    x, y = random.integers(0, 9, (2, 17, 60)) / 8, random.integers(0, 9, (2, 17, 80)) / 8
    points, scores = ops.decode_simcc(torch.from_numpy(x), torch.from_numpy(y), ratio)
    np.testing.assert_allclose(points, np.stack([x.argmax(2), y.argmax(2)], 2) / ratio, rtol=1e-15)
    assert np.array_equal(scores, np.minimum(x.max(2), y.max(2)))


X = torch.rand(1, 2, 5, 6)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.decode_heatmaps(X[0]), ValueError, r"heatmaps: expected shape \(B, K, H, W\)"),
        (lambda: ops.decode_heatmaps(X.int()), TypeError, "heatmaps: expected a floating-point"),
        (lambda: ops.decode_heatmaps(X[..., :0]), ValueError, "heatmaps: expected a pixel at least"),
        (lambda: ops.decode_heatmaps(X, "half"), ValueError, "refinement: expected one of"),
        (lambda: ops.decode_heatmaps(X, "dark", 4), ValueError, "kernel_size: expected a positive odd"),
        (lambda: ops.decode_simcc(X[0], X[0, :1]), ValueError, r"simcc_y: expected shape \(B, K, Hy\)"),
        (lambda: ops.decode_simcc(X, X[0]), ValueError, "simcc_x: expected shape"),
        (lambda: ops.decode_simcc(X[0], X[0].int()), TypeError, "simcc_y: expected a floating-point"),
        (lambda: ops.decode_simcc(X[0], X[0][..., :0]), ValueError, "simcc_y: expected a place at least"),
        (lambda: ops.decode_simcc(X[0], X[0], 0.0), ValueError, "split_ratio: expected a positive"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
