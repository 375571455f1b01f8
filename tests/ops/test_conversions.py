"""Rotations against SciPy, with the singular points."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm.geometry.conversions import (
    axis_angle_to_quaternion,
    axis_angle_to_rotation_matrix,
    normalize_quaternion,
    quaternion_to_axis_angle,
    quaternion_to_rotation_matrix,
    rotation_matrix_to_axis_angle,
    rotation_matrix_to_quaternion,
)

ANGLES = [0.0, 1e-12, 1e-6, 1e-3, 0.0199, 0.0201, 0.5, 2.0, 3.0, math.pi - 1e-3, math.pi - 1e-7]


def axes() -> Tensor:
    a = torch.randn(20, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    a = a / a.norm(dim=1, keepdim=True)
    return torch.cat([a, torch.eye(3, dtype=torch.float64), -torch.eye(3, dtype=torch.float64)])


@pytest.mark.parametrize("angle", ANGLES)
def test_equal_scipy(angle: float) -> None:
    v = axes() * angle
    rotation = Rotation.from_rotvec(v.numpy())
    xyzw = rotation.as_quat(canonical=True)
    wxyz = np.concatenate([xyzw[:, 3:], xyzw[:, :3]], 1)
    matrix = rotation.as_matrix()
    np.testing.assert_allclose(axis_angle_to_quaternion(v), wxyz, atol=1e-12)
    np.testing.assert_allclose(axis_angle_to_rotation_matrix(v), matrix, atol=1e-12)
    np.testing.assert_allclose(quaternion_to_axis_angle(torch.from_numpy(wxyz)), v, atol=1e-12)
    np.testing.assert_allclose(quaternion_to_rotation_matrix(torch.from_numpy(wxyz)), matrix, atol=1e-12)
    np.testing.assert_allclose(rotation_matrix_to_quaternion(torch.from_numpy(matrix)), wxyz, atol=1e-9)
    np.testing.assert_allclose(rotation_matrix_to_axis_angle(torch.from_numpy(matrix)), v, atol=1e-8)


def test_half_a_turn() -> None:
    """At pi both axes name the same rotation: compare matrices."""
    v = axes() * math.pi
    matrix = torch.from_numpy(Rotation.from_rotvec(v.numpy()).as_matrix())
    back = rotation_matrix_to_axis_angle(matrix)
    assert torch.allclose(back.norm(dim=1), torch.full((len(v),), math.pi, dtype=torch.float64), atol=1e-7)
    torch.testing.assert_close(axis_angle_to_rotation_matrix(back), matrix, rtol=0, atol=1e-7)


def test_negated_quaternion_is_the_same_rotation() -> None:
    q = axis_angle_to_quaternion(axes() * 1.3)
    torch.testing.assert_close(quaternion_to_axis_angle(-q), axes() * 1.3)
    torch.testing.assert_close(quaternion_to_rotation_matrix(-3.0 * q), quaternion_to_rotation_matrix(q))


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("function", [axis_angle_to_quaternion, axis_angle_to_rotation_matrix], ids=lambda function: function.__name__)
def test_gradients_from_vectors(function: object, angle: float) -> None:
    v = (axes()[:3] * angle).requires_grad_(True)
    assert torch.autograd.gradcheck(function, (v,), atol=1e-6)


@pytest.mark.parametrize("angle", [a for a in ANGLES if a < math.pi - 1e-6])
def test_round_trip_gradient_is_the_identity(angle: float) -> None:
    v = axes()[0] * angle
    for there, back in (
        (axis_angle_to_quaternion, quaternion_to_axis_angle),
        (axis_angle_to_rotation_matrix, rotation_matrix_to_axis_angle),
    ):
        jacobian = torch.autograd.functional.jacobian(lambda u, there=there, back=back: back(there(u)), v)
        np.testing.assert_allclose(jacobian, np.eye(3), atol=1e-6)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_gradients_are_finite_at_the_singular_points(dtype: torch.dtype) -> None:
    half = axes().to(dtype) * math.pi
    starts = [
        (quaternion_to_axis_angle, axis_angle_to_quaternion(torch.cat([half, 0 * half]))),
        (rotation_matrix_to_quaternion, axis_angle_to_rotation_matrix(torch.cat([half, 0 * half]))),
        (rotation_matrix_to_axis_angle, axis_angle_to_rotation_matrix(torch.cat([half, 0 * half]))),
        (normalize_quaternion, torch.zeros(2, 4, dtype=dtype)),
        (quaternion_to_axis_angle, torch.tensor([[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]], dtype=dtype)),
    ]
    for function, start in starts:
        x = start.detach().clone().requires_grad_(True)
        y = function(x)
        y.sum().backward()
        assert torch.isfinite(y).all() and torch.isfinite(x.grad).all(), function.__name__


def test_normalize_quaternion() -> None:
    q = torch.randn(5, 2, 4, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    np.testing.assert_allclose(normalize_quaternion(q), q.numpy() / np.linalg.norm(q.numpy(), axis=-1, keepdims=True), atol=1e-12)
    assert normalize_quaternion(torch.zeros(4)).tolist() == [0.0] * 4
