"""Rotations against SciPy, including the singular points."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm.geometry import conversions
from chiasm.geometry.conversions import (
    axis_angle_to_quaternion,
    axis_angle_to_rotation_matrix,
    euler_from_quaternion,
    normalize_quaternion,
    quaternion_exp_to_log,
    quaternion_from_euler,
    quaternion_log_to_exp,
    quaternion_to_axis_angle,
    quaternion_to_rotation_matrix,
    rotation_matrix_to_axis_angle,
    rotation_matrix_to_quaternion,
    vector_to_skew_symmetric_matrix,
)

ANGLES = [0.0, 1e-12, 1e-6, 1e-3, 0.0199, 0.0201, 0.5, 2.0, 3.0, math.pi - 1e-3, math.pi - 1e-7]


def wxyz(rotation: Rotation) -> np.ndarray:
    xyzw = rotation.as_quat(canonical=True)
    return np.concatenate([xyzw[:, 3:], xyzw[:, :3]], 1)


def axes() -> Tensor:
    a = torch.randn(20, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    a = a / a.norm(dim=1, keepdim=True)
    return torch.cat([a, torch.eye(3, dtype=torch.float64), -torch.eye(3, dtype=torch.float64)])


@pytest.mark.parametrize("angle", ANGLES)
def test_equal_scipy(angle: float) -> None:
    v = axes() * angle
    rotation = Rotation.from_rotvec(v.numpy())
    quaternion = wxyz(rotation)
    matrix = rotation.as_matrix()
    np.testing.assert_allclose(axis_angle_to_quaternion(v), quaternion, atol=1e-12)
    np.testing.assert_allclose(axis_angle_to_rotation_matrix(v), matrix, atol=1e-12)
    np.testing.assert_allclose(quaternion_to_axis_angle(torch.from_numpy(quaternion)), v, atol=1e-12)
    np.testing.assert_allclose(
        quaternion_to_rotation_matrix(torch.from_numpy(quaternion)), matrix, atol=1e-12
    )
    np.testing.assert_allclose(rotation_matrix_to_quaternion(torch.from_numpy(matrix)), quaternion, atol=1e-9)
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
@pytest.mark.parametrize(
    "function",
    [axis_angle_to_quaternion, axis_angle_to_rotation_matrix],
    ids=lambda function: function.__name__,
)
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


def test_a_quaternion_of_zeros_is_no_turn() -> None:
    q = torch.tensor([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]], requires_grad=True)
    matrices = quaternion_to_rotation_matrix(q)
    assert torch.equal(matrices, torch.eye(3).expand(2, 3, 3))
    matrices.sum().backward()
    assert torch.equal(q.grad[0], torch.zeros(4)) and torch.isfinite(q.grad[1]).all()


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
    np.testing.assert_allclose(
        normalize_quaternion(q), q.numpy() / np.linalg.norm(q.numpy(), axis=-1, keepdims=True), atol=1e-12
    )
    assert normalize_quaternion(torch.zeros(4)).tolist() == [0.0] * 4


def test_exp_and_log_of_quaternions() -> None:
    """exp of half a rotation vector is the rotation's quaternion; the log distinguishes q and -q."""
    for angle in ANGLES:
        half = axes() * 0.5 * angle
        q = quaternion_log_to_exp(half)
        np.testing.assert_allclose(q, wxyz(Rotation.from_rotvec(2.0 * half.numpy())), atol=1e-12)
        np.testing.assert_allclose(quaternion_exp_to_log(q), half, atol=1e-12)
    long = axes() * 3.0  # beyond half a turn: w is negative
    np.testing.assert_allclose(quaternion_exp_to_log(quaternion_log_to_exp(long)), long, atol=1e-12)


@pytest.mark.parametrize("w", [1.0, -1.0])
def test_log_at_the_poles_is_zero_with_a_finite_gradient(w: float) -> None:
    for dtype in (torch.float32, torch.float64):
        q = torch.tensor([w, 0.0, 0.0, 0.0], dtype=dtype, requires_grad=True)
        quaternion_exp_to_log(q).sum().backward()
        assert quaternion_exp_to_log(q).tolist() == [0.0] * 3
        assert torch.isfinite(q.grad).all()


def test_skew_symmetric_matrix_is_the_cross_product() -> None:
    v, u = axes()[:8].reshape(2, 4, 3), axes()[8:16].reshape(2, 4, 3)
    product = (vector_to_skew_symmetric_matrix(v) @ u[..., None])[..., 0]
    np.testing.assert_allclose(product, np.cross(v.numpy(), u.numpy()), atol=1e-14)


def test_euler_equals_scipy() -> None:
    angles = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)) * [3.1, 1.55, 3.1]
    rotation = Rotation.from_euler("xyz", angles)
    q = quaternion_from_euler(*torch.from_numpy(angles).unbind(-1))
    sign = np.sign(q[0].numpy())[:, None]
    np.testing.assert_allclose(torch.stack(q, -1) * sign, wxyz(rotation), atol=1e-14)
    back = euler_from_quaternion(*torch.from_numpy(wxyz(rotation)).unbind(-1))
    np.testing.assert_allclose(torch.stack(back, -1), angles, atol=1e-12)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2, math.pi / 2 - 1e-7, math.pi / 2 - 1e-4])
def test_euler_in_gimbal_lock_is_the_same_rotation(pitch: float, dtype: torch.dtype) -> None:
    roll, yaw = (
        a.flatten() for a in torch.meshgrid(torch.linspace(-3, 3, 7), torch.linspace(-3, 3, 5), indexing="ij")
    )
    rotation = Rotation.from_euler(
        "xyz", torch.stack([roll, torch.full_like(roll, pitch), yaw], -1).double().numpy()
    )
    q = [part.to(dtype).requires_grad_(True) for part in torch.from_numpy(wxyz(rotation)).unbind(-1)]
    angles = torch.stack(euler_from_quaternion(*q), -1)
    error = (Rotation.from_euler("xyz", angles.detach().double().numpy()).inv() * rotation).magnitude().max()
    # float32: the sine of the pitch is known to 1e-7, the pitch only to its root
    assert error < (2e-3 if dtype == torch.float32 else 1e-7)
    angles.sum().backward()
    assert all(torch.isfinite(part.grad).all() for part in q)


def test_euler_in_gimbal_lock_has_no_roll() -> None:
    q = quaternion_from_euler(torch.tensor(0.3), torch.tensor(math.pi / 2), torch.tensor(0.5))
    roll, pitch, yaw = euler_from_quaternion(*q)
    assert roll == 0.0
    np.testing.assert_allclose([pitch, yaw], [math.pi / 2, 0.2], atol=1e-6)


def test_what_is_no_rotation_is_refused_on_demand() -> None:
    eye = torch.eye(3).repeat(2, 1, 1)
    for function in (rotation_matrix_to_axis_angle, rotation_matrix_to_quaternion):
        assert torch.isfinite(function(eye, check_rotation=True)).all()
        for wrong in (2.0 * eye, -eye, eye + math.nan):
            with pytest.raises(ValueError, match="rotation_matrix: expected rotation matrices"):
                function(wrong, check_rotation=True)
        with pytest.raises(torch.jit.Error, match="expected rotation matrices"):
            torch.jit.script(function)(2.0 * eye, check_rotation=True)


def test_old_names() -> None:
    assert conversions.angle_axis_to_quaternion is axis_angle_to_quaternion
    assert conversions.angle_axis_to_rotation_matrix is axis_angle_to_rotation_matrix
    assert conversions.quaternion_to_angle_axis is quaternion_to_axis_angle
    assert conversions.rotation_matrix_to_angle_axis is rotation_matrix_to_axis_angle
