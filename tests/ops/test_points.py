"""geometry.linalg against NumPy and OpenCV."""

from typing import Callable

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm.geometry.linalg import (
    batched_dot_product,
    batched_squared_norm,
    compose_transformations,
    euclidean_distance,
    inverse_transformation,
    point_line_distance,
    relative_transformation,
    transform_points,
)


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def poses(count: int, seed: int) -> Tensor:
    m = torch.eye(4, dtype=torch.float64).repeat(count, 1, 1)
    m[:, :3, :3] = torch.from_numpy(Rotation.random(count, random_state=seed).as_matrix())
    m[:, :3, 3] = rand(count, 3, seed=seed)
    return m


def test_products_and_norms() -> None:
    x, y = rand(2, 5, 3), rand(1, 5, 3, seed=1)
    np.testing.assert_allclose(batched_dot_product(x, y), (x.numpy() * y.numpy()).sum(-1))
    np.testing.assert_allclose(
        batched_squared_norm(x, True), np.linalg.norm(x.numpy(), axis=-1, keepdims=True) ** 2
    )
    np.testing.assert_allclose(euclidean_distance(x, y), np.linalg.norm(x.numpy() - y.numpy(), axis=-1))
    assert euclidean_distance(x, y, True).shape == (2, 5, 1)


def test_distance_of_a_point_to_itself() -> None:
    x = rand(4, 3).requires_grad_(True)
    near = x.detach() + torch.tensor([[0.0], [1e-9], [1e-3], [1.0]])
    distance = euclidean_distance(x, near)
    np.testing.assert_allclose(
        distance.detach(), np.array([0.0, 1e-9, 1e-3, 1.0]) * np.sqrt(3), rtol=1e-6, atol=1e-20
    )
    distance.sum().backward()
    np.testing.assert_allclose(x.grad.norm(dim=1), [0.0, 0.0, 1.0, 1.0], atol=1e-9)


def test_point_line_distance() -> None:
    """The distance to the foot of the perpendicular."""
    point, line = rand(6, 2), rand(6, 3, seed=1)
    p, l = point.numpy(), line.numpy()
    direction = np.stack([-l[:, 1], l[:, 0]], 1) / np.linalg.norm(l[:, :2], axis=1, keepdims=True)
    start = -l[:, 2:] * l[:, :2] / (l[:, :2] ** 2).sum(1, keepdims=True)
    foot = start + direction * ((p - start) * direction).sum(1, keepdims=True)
    np.testing.assert_allclose(point_line_distance(point, line), np.linalg.norm(p - foot, axis=1), rtol=1e-10)
    w = torch.tensor([[2.0], [-1.0], [0.5], [3.0], [1.0], [-4.0]], dtype=torch.float64)
    torch.testing.assert_close(
        point_line_distance(torch.cat([point * w, w], 1), line), point_line_distance(point, line)
    )


def test_point_line_distance_without_a_direction() -> None:
    line = torch.tensor([[0.0, 0.0, 1.0]], requires_grad=True)
    distance = point_line_distance(torch.ones(1, 2), line)
    distance.backward()
    assert distance.isfinite().all() and line.grad.isfinite().all()


@pytest.mark.parametrize(
    ("transformation", "points", "result"),
    [
        ((1, 4, 4), (5, 6, 3), (5, 6, 3)),
        ((5, 4, 4), (1, 6, 3), (5, 6, 3)),
        ((4, 4), (5, 6, 3), (5, 6, 3)),
        ((2, 4, 4), (2, 5, 6, 3), (2, 5, 6, 3)),
        ((2, 5, 4, 4), (2, 5, 6, 3), (2, 5, 6, 3)),
        ((2, 4, 4), (2, 3), (2, 3)),
        ((3, 3), (2,), (2,)),
    ],
)
def test_transform_points_broadcasts(
    transformation: tuple[int, ...], points: tuple[int, ...], result: tuple[int, ...]
) -> None:
    m, p = (
        rand(*transformation) + 4.0 * torch.eye(transformation[-1], dtype=torch.float64),
        rand(*points, seed=1),
    )
    moved = transform_points(m, p)
    full = m.reshape(
        transformation[:-2] + (1,) * (len(points) + 1 - len(transformation)) + transformation[-2:]
    ).expand(result[:-1] + transformation[-2:])
    q = np.einsum(
        "...ij,...j->...i", full.numpy(), np.concatenate([p.numpy(), np.ones((*points[:-1], 1))], -1)
    )
    assert moved.shape == result
    np.testing.assert_allclose(moved, q[..., :-1] / q[..., -1:], rtol=1e-10)


def test_points_at_infinity_are_not_divided() -> None:
    m = torch.tensor([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]], requires_grad=True)
    moved = transform_points(m, torch.tensor([[[0.0, 2.0], [2.0, 2.0]]]))
    assert moved.tolist() == [[[0.0, 2.0], [1.0, 1.0]]]
    moved.sum().backward()
    assert m.grad.isfinite().all()


def test_rigid_transformations() -> None:
    a, b = poses(5, 1), poses(5, 2)
    np.testing.assert_allclose(compose_transformations(a, b), a.numpy() @ b.numpy(), atol=1e-12)
    np.testing.assert_allclose(inverse_transformation(a), np.linalg.inv(a.numpy()), atol=1e-12)
    np.testing.assert_allclose(
        relative_transformation(a, b), np.linalg.inv(a.numpy()) @ b.numpy(), atol=1e-12
    )
    np.testing.assert_allclose(compose_transformations(a[:1], b), a[:1].numpy() @ b.numpy(), atol=1e-12)
    assert inverse_transformation(a[0]).shape == (4, 4)


EYE, X = torch.eye(4)[None], torch.zeros(2, 5, 3)

WRONG = [
    (
        lambda: batched_dot_product(X, X[..., :2]),
        ValueError,
        r"y: expected shape \(\*, 3\) like x, got \[2, 5, 2\]",
    ),
    (lambda: batched_dot_product(X, X.int()), TypeError, "y: expected a floating-point"),
    (lambda: batched_squared_norm(torch.zeros([])), ValueError, r"x: expected shape \(\*, D\), got \[\]"),
    (lambda: euclidean_distance(X.int(), X), TypeError, "x: expected a floating-point"),
    (
        lambda: point_line_distance(EYE, X),
        ValueError,
        r"point: expected shape \(\*, 2\) or \(\*, 3\), got \[1, 4, 4\]",
    ),
    (lambda: point_line_distance(X, EYE), ValueError, r"line: expected shape \(\*, 3\), got \[1, 4, 4\]"),
    (
        lambda: transform_points(EYE[..., :3], X),
        ValueError,
        r"trans_01: expected shape \(B, 4, 4\) for points in 3 dimensions, got \[1, 4, 3\]",
    ),
    (
        lambda: transform_points(EYE[None, None], X),
        ValueError,
        r"points_1: expected the batch dimensions of trans_01 \[1, 1, 1, 4, 4\]",
    ),
    (lambda: transform_points(EYE, X.int()), TypeError, "points_1: expected a floating-point"),
    (
        lambda: compose_transformations(EYE, EYE[..., :3]),
        ValueError,
        r"trans_12: expected shape \(\*, 4, 4\), got \[1, 4, 3\]",
    ),
    (lambda: inverse_transformation(EYE.int()), TypeError, "trans_12: expected a floating-point"),
    (lambda: relative_transformation(X, EYE), ValueError, "trans_01: expected shape"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
