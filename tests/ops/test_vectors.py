"""Vectors, lines and planes as objects, compared with NumPy."""

import numpy as np
import pytest
import torch

from chiasm.geometry.line import ParametrizedLine
from chiasm.geometry.plane import Hyperplane
from chiasm.geometry.vector import Scalar, Vector2, Vector3


def points(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def test_arithmetic_of_vectors() -> None:
    a, b = points(5, 3), points(5, 3, seed=1)
    v, w = Vector3(a), Vector3(b)
    np.testing.assert_allclose((v + w).data, a + b)
    np.testing.assert_allclose((2.0 - v).data, 2.0 - a)
    np.testing.assert_allclose((v / w).data, a / b)
    length = v.dot(w)
    np.testing.assert_allclose(length.data, np.einsum("ij,ij->i", a, b))
    for scaled in (v * length, length * v):
        assert isinstance(scaled, Vector3)
        np.testing.assert_allclose(scaled.data, a * length.data[:, None])
    np.testing.assert_allclose(v.squared_norm().data, np.linalg.norm(a, axis=1) ** 2)
    np.testing.assert_allclose(v.normalized().data, a / np.linalg.norm(a, axis=1, keepdims=True))
    assert torch.linalg.norm(v, dim=-1).equal(torch.linalg.norm(a, dim=-1))
    assert torch.hypot(v, w).equal(torch.hypot(a, b))  # pyright: ignore[reportArgumentType]


def test_parts_of_vectors() -> None:
    v = Vector3(points(5, 3))
    for index in (0, slice(1, 3), v.x > 0, torch.tensor([2, 1])):
        assert isinstance(v[index], Vector3) and v[index].data.equal(v.data[index])
    assert v[..., 1].equal(v.y) and v[:, 2].equal(v.z) and v[0][1].equal(v.y[0])
    assert Vector2.random((4, 2)).shape == (4, 2, 2)
    assert Vector2.from_coords(torch.zeros(3), torch.ones(3)).y.tolist() == [1, 1, 1]
    assert Vector3.from_coords(1.0, 2.0, 3.0, dtype=torch.float64).dtype == torch.float64
    with pytest.raises(ValueError, match="vector: expected"):
        Vector2(torch.zeros(3, 3))


def test_planes_through_points() -> None:
    p = points(3, 7, 3)
    plane = Hyperplane.through(p[0], p[1], p[2])
    normal = np.cross(p[2] - p[0], p[1] - p[0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(plane.normal.data, normal, atol=1e-12)
    q = points(7, 3, seed=2)
    height = ((q - p[0]).numpy() * normal).sum(1)
    np.testing.assert_allclose(plane.signed_distance(q).data, height, atol=1e-12)
    np.testing.assert_allclose(plane.abs_distance(Vector3(q)).data, abs(height), atol=1e-12)
    np.testing.assert_allclose(plane.projection(q).data, q - height[:, None] * normal, atol=1e-12)
    on_a_line = Hyperplane.through(p[0], p[0] + q, p[0] - 2.0 * q)
    for point in (p[0], p[0] + q, p[0] - 2.0 * q):
        assert on_a_line.abs_distance(point).data.max() < 1e-12
    np.testing.assert_allclose(on_a_line.normal.squared_norm().data, np.ones(7))


def test_lines_and_where_they_meet_planes() -> None:
    a, b, q = points(7, 3), points(7, 3, seed=1), points(7, 3, seed=2)
    line = ParametrizedLine.through(a, b)
    along = (b - a).numpy() / np.linalg.norm(b - a, axis=1, keepdims=True)
    np.testing.assert_allclose(line.direction, along, atol=1e-12)
    t = ((q - a).numpy() * along).sum(1)
    foot = a.numpy() + t[:, None] * along
    np.testing.assert_allclose(line.projection(q), foot, atol=1e-12)
    np.testing.assert_allclose(line.distance(q), np.linalg.norm(q - foot, axis=1), atol=1e-12)
    np.testing.assert_allclose(line.squared_distance(q), np.linalg.norm(q - foot, axis=1) ** 2, atol=1e-12)
    for step in (torch.from_numpy(t), torch.from_numpy(t)[:, None], Scalar(torch.from_numpy(t))):
        np.testing.assert_allclose(line.point_at(step), foot, atol=1e-12)
    plane = Hyperplane.from_vector(Vector3(q).normalized(), points(7, 3, seed=3))
    where, point = line.intersect(plane)
    assert plane.abs_distance(point).data.max() < 1e-9
    np.testing.assert_allclose(line.point_at(where), point, atol=1e-12)
    origin, direction = line
    assert origin is line[0] and direction is line[1] and line.dim() == 3
    with pytest.raises(ValueError, match="p1: expected a point other than p0"):
        ParametrizedLine.through(a, a)


def test_gradients_of_planes() -> None:
    """Of edges that are orthogonal and equally long, on a line, and of equal points."""
    corners = torch.tensor([
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [3.0, 6.0, 9.0]],
        [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]],
    ], dtype=torch.float64, requires_grad=True)  # fmt: skip
    plane = Hyperplane.through(*corners.unbind(1))
    np.testing.assert_allclose(plane.normal.squared_norm().data.detach(), np.ones(3))
    away = plane.abs_distance(corners.movedim(1, 0)).data
    np.testing.assert_allclose(away.detach(), np.zeros((3, 3)), atol=1e-14)
    (plane.normal.data.sum() + plane.offset.data.sum()).backward()
    assert corners.grad.isfinite().all()
    square = corners.detach()[0].clone().requires_grad_(True)
    assert torch.autograd.gradcheck(lambda p: Hyperplane.through(*p.unbind())._normal, (square,))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_planes_of_half_precision(dtype: torch.dtype) -> None:
    p = (300.0 * points(3, 5, 3)).to(dtype)
    plane, expected = Hyperplane.through(*p), Hyperplane.through(*p.float())
    for part, wanted in ((plane.normal, expected.normal), (plane.offset, expected.offset)):
        assert part.data.dtype == dtype and part.data.equal(wanted.data.to(dtype))


def test_gradients_of_a_line_beside_a_parallel_one() -> None:
    plane = Hyperplane(torch.eye(3)[2], torch.tensor(-4.0))
    direction = torch.tensor([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]], requires_grad=True)
    t, p = ParametrizedLine(torch.zeros(2, 3), direction).intersect(plane)
    assert t.tolist() == [5.0, torch.inf] and p[0].tolist() == [0.0, 3.0, 4.0] and p[1, 0] == torch.inf
    (t[0] + p[0].sum()).backward()
    # t = 4 / z, and the point (x t, y t, 4)
    np.testing.assert_allclose(direction.grad, [[5, 5, -4 / 0.64 - 0.6 * 4 / 0.64], [0, 0, 0]], atol=1e-5)
