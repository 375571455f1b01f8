"""K-means against scikit-learn, and random textures against their recursion, point by point."""

import numpy as np
import pytest
import torch
from sklearn.cluster import KMeans as SklearnKMeans
from torch import Tensor
from torch.autograd import gradcheck

from chiasm.contrib import diamond_square, kmeans

X = torch.zeros(7, 3)


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


# --- clusters -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("iterations", [1, 3, 100])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize(("count", "clusters", "axes"), [(50, 3, 1), (301, 7, 2), (1000, 12, 5)])
def test_means_equal_sklearn(
    count: int, clusters: int, axes: int, dtype: torch.dtype, iterations: int
) -> None:
    x = (rand(count, axes) * 4.0 + 1000.0).to(dtype)
    start = x[:clusters]
    centers, labels = kmeans(x, start, iterations)
    assert centers.dtype == dtype and labels.dtype == torch.int64
    expected = SklearnKMeans(
        clusters, init=start.double().numpy(), n_init=1, max_iter=iterations, tol=0, algorithm="lloyd"
    ).fit(x.double().numpy())
    np.testing.assert_array_equal(labels, expected.labels_)
    np.testing.assert_allclose(
        centers, expected.cluster_centers_, rtol=1e-12 if dtype == torch.float64 else 1e-7
    )


def test_no_iteration_assigns_only() -> None:
    x, start = rand(40, 3), rand(5, 3, seed=1)
    centers, labels = kmeans(x, start, 0)
    torch.testing.assert_close(centers, start, rtol=1e-14, atol=0.0)
    assert torch.equal(labels, torch.cdist(x, start).argmin(1))


def test_a_centre_without_points_stays() -> None:
    x = torch.tensor([[0.0], [1.0], [4.0]])
    centers, labels = kmeans(x, torch.tensor([[0.0], [100.0], [5.0], [5.0]]), 3)
    assert centers.flatten().tolist() == [0.5, 100.0, 4.0, 5.0]  # the first of the two at 5 has the point
    assert labels.tolist() == [0, 0, 2]


def test_no_points_move_no_centre() -> None:
    start = rand(5, 3)
    for call in (kmeans, torch.jit.script(kmeans)):
        centers, labels = call(rand(0, 3), start, 3)
        assert torch.equal(centers, start) and labels.shape == (0,)


def test_gradient_is_of_the_means() -> None:
    x = torch.cat([rand(9, 2), rand(6, 2, seed=1) + 5.0]).requires_grad_(True)
    start = x.detach()[[0, 10]]
    assert gradcheck(lambda v: kmeans(v, start, 4)[0], x)
    (grad,) = torch.autograd.grad(kmeans(x, start, 4)[0][0].sum(), x)
    torch.testing.assert_close(
        grad,
        torch.tensor([1 / 9, 0.0]).double().repeat_interleave(torch.tensor([9, 6]))[:, None].expand(15, 2),
    )


# --- textures -----------------------------------------------------------------------------------------------


def refined(noise: np.ndarray, roughness: float, scale: float) -> np.ndarray:
    """The recursion, one point at a time, from the known points."""
    height, width = noise.shape
    cell = 1
    while cell < max(height, width) - 1:
        cell *= 2
    known = {(y, x): scale * noise[y, x] for y in range(0, height, cell) for x in range(0, width, cell)}

    def fill(points: list[tuple[int, int]], offsets: list[tuple[int, int]]) -> None:
        values = {}
        for y, x in points:
            beside = [
                known[y + dy, x + dx] for dy, dx in offsets if 0 <= y + dy < height and 0 <= x + dx < width
            ]
            values[y, x] = np.mean(beside) + scale * noise[y, x]
        known.update(values)

    while cell > 1:
        h = cell // 2
        fill(
            [(y, x) for y in range(h, height, cell) for x in range(h, width, cell)],
            [(-h, -h), (-h, h), (h, -h), (h, h)],
        )
        sides = [(y, x) for y in range(0, height, h) for x in range(0, width, h) if (y // h + x // h) % 2]
        fill(sides, [(-h, 0), (h, 0), (0, -h), (0, h)])
        cell, scale = h, scale * roughness
    return np.array([[known[y, x] for x in range(width)] for y in range(height)])


@pytest.mark.parametrize("roughness", [0.0, 0.5, 0.9])
@pytest.mark.parametrize(
    "shape", [(1, 1, 1, 1), (1, 1, 2, 2), (2, 1, 1, 7), (3, 1, 33, 33), (1, 3, 17, 40), (2, 5, 35, 9)]
)
def test_texture_equals_the_recursion(shape: tuple[int, ...], roughness: float) -> None:
    noise = 2.0 * rand(*shape) - 1.0
    actual = diamond_square(noise, roughness, 0.7)
    for b in range(shape[0]):
        for c in range(shape[1]):
            np.testing.assert_allclose(actual[b, c], refined(noise[b, c].numpy(), roughness, 0.7), atol=1e-14)


def test_each_sample_has_its_own_roughness() -> None:
    noise, roughness, scale = (
        rand(3, 2, 12, 19),
        torch.tensor([0.2, 0.5, 0.8]).double(),
        torch.tensor([1.0, 2.0, 0.1]).double(),
    )
    actual = diamond_square(noise, roughness, scale)
    for b in range(3):
        torch.testing.assert_close(
            actual[b : b + 1],
            diamond_square(noise[b : b + 1], roughness[b].item(), scale[b]),
            rtol=1e-14,
            atol=1e-14,
        )


def test_texture_in_a_range() -> None:
    actual = diamond_square(rand(2, 3, 20, 31), normalize_range=(-2.0, 3.0))
    torch.testing.assert_close(actual.amin((2, 3)), torch.full((2, 3), -2.0).double())
    torch.testing.assert_close(actual.amax((2, 3)), torch.full((2, 3), 3.0).double(), rtol=1e-4, atol=0.0)


def test_texture_has_gradients() -> None:
    noise = (2.0 * rand(2, 1, 6, 5) - 1.0).requires_grad_(True)
    roughness = torch.tensor([0.0, 0.6], dtype=torch.float64, requires_grad=True)
    scale = torch.tensor(1.3, dtype=torch.float64, requires_grad=True)
    assert gradcheck(diamond_square, (noise, roughness, scale))


def test_rough_textures_are_rougher() -> None:
    noise = 2.0 * rand(1, 1, 129, 129) - 1.0
    steps = [diamond_square(noise, r).diff(dim=3).abs().mean().item() for r in (0.3, 0.5, 0.7)]
    assert 2.0 * steps[0] < 1.5 * steps[1] < steps[2]


WRONG = [
    (lambda: kmeans(X[0], X, 1), ValueError, r"x: expected shape \(N, D\)"),
    (lambda: kmeans(X.int(), X, 1), TypeError, "x: expected a floating-point"),
    (lambda: kmeans(X, X.int(), 1), TypeError, "centers: expected a floating-point"),
    (
        lambda: kmeans(X, X[:, :2], 1),
        ValueError,
        r"centers: expected shape \(K, D\) for x \[7, 3\], got \[7, 2\]",
    ),
    (lambda: kmeans(X, X[:0], 1), ValueError, "centers: expected shape"),
    (lambda: kmeans(X, X, -1), ValueError, "num_iterations: expected zero or more, got -1"),
    (lambda: diamond_square(X), ValueError, r"random: expected shape \(B, C, H, W\)"),
    (lambda: diamond_square(X[None, None].int()), TypeError, "random: expected a floating-point"),
    (
        lambda: diamond_square(X[None, None], X[:2, 0]),
        ValueError,
        r"roughness: expected a number, or a scalar tensor, \(1,\) or \(B,\), got \[2\]",
    ),
    (lambda: diamond_square(X[None, None], 0.5, X[:1]), ValueError, "random_scale: expected a number"),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
