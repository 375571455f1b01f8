"""Quaternions against SciPy's rotations and an eigendecomposition in float64."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation, Slerp
from torch import Tensor

from chiasm.geometry.quaternion import (
    Quaternion,
    average_quaternions,
    quaternion_conjugate,
    quaternion_inverse,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
)


def rotations(n: int, seed: int) -> Rotation:
    return Rotation.random(n, rng=seed)


def wxyz(rotation: Rotation) -> Tensor:
    return torch.from_numpy(np.roll(rotation.as_quat(), 1, -1))


def same(q: Tensor, rotation: Rotation, tolerance: float = 1e-12) -> None:
    """Assert that the rotations are equal; the quaternion's sign may differ."""
    expected = wxyz(rotation)
    sign = torch.sign((q * expected).sum(-1, keepdim=True))
    np.testing.assert_allclose(sign * q, expected, atol=tolerance)


def test_product() -> None:
    a, b = rotations(20, 0), rotations(20, 1)
    same(quaternion_multiply(wxyz(a), wxyz(b)), a * b)
    np.testing.assert_allclose(
        quaternion_multiply(2.0 * wxyz(a), 3.0 * wxyz(b)),
        6.0 * quaternion_multiply(wxyz(a), wxyz(b)),
        atol=1e-12,
    )


def test_inverse() -> None:
    q = 2.5 * wxyz(rotations(20, 0))
    one = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=torch.float64).expand(20, 4)
    np.testing.assert_allclose(quaternion_multiply(q, quaternion_inverse(q)), one, atol=1e-14)
    np.testing.assert_allclose(quaternion_conjugate(q), q * torch.tensor([1.0, -1.0, -1.0, -1.0]), atol=0)
    zero = torch.zeros(4, requires_grad=True)
    quaternion_inverse(zero).sum().backward()
    assert quaternion_inverse(zero).abs().sum() == 0 and torch.isfinite(zero.grad).all()


def test_rotate() -> None:
    rotation, points = rotations(20, 0), np.random.default_rng(0).normal(size=(20, 3))
    np.testing.assert_allclose(
        quaternion_rotate(wxyz(rotation), torch.from_numpy(points)), rotation.apply(points), atol=1e-14
    )
    one = quaternion_rotate(wxyz(rotation)[:1], torch.from_numpy(points))
    np.testing.assert_allclose(one, rotation[0].apply(points), atol=1e-14)


@pytest.mark.parametrize("t", [0.0, 0.25, 0.7, 1.0, 1.5])
def test_slerp(t: float) -> None:
    a, b = rotations(20, 0), rotations(20, 1)
    q1, q2 = wxyz(a), wxyz(b)
    expected = a * Rotation.from_rotvec(t * (a.inv() * b).as_rotvec())
    for made in (
        quaternion_slerp(q1, q2, t),
        quaternion_slerp(3.0 * q1, -0.5 * q2, torch.full((20,), t, dtype=torch.float64)),
    ):
        same(made, expected)
    if t <= 1.0:
        for k in range(3):
            same(quaternion_slerp(q1[k], q2[k], t), Slerp([0, 1], Rotation.concatenate([a[k], b[k]]))(t))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, math.pi - 1e-6, math.pi])
def test_slerp_has_finite_gradients(angle: float) -> None:
    for dtype in (torch.float32, torch.float64):
        q1 = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=dtype, requires_grad=True)
        q2 = torch.tensor(
            [math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0], dtype=dtype, requires_grad=True
        )
        t = torch.tensor(0.3, dtype=dtype, requires_grad=True)
        made = quaternion_slerp(q1, q2, t)
        made.sum().backward()
        assert all(torch.isfinite(x).all() for x in (made, q1.grad, q2.grad, t.grad))
        np.testing.assert_allclose(
            made.detach(), [math.cos(0.15 * angle), 0.0, math.sin(0.15 * angle), 0.0], atol=1e-6
        )


def test_slerp_scripts_with_numbers_and_tensors() -> None:
    scripted = torch.jit.script(quaternion_slerp)
    q1, q2 = wxyz(rotations(3, 0)), wxyz(rotations(3, 1))
    t = torch.full((3,), 0.3, dtype=torch.float64)
    torch.testing.assert_close(scripted(q1, q2, 0.3), scripted(q1, q2, t))


def test_each_pair_has_its_part() -> None:
    q1, q2, t = wxyz(rotations(4, 0)), wxyz(rotations(4, 1)), torch.rand(4, dtype=torch.float64)
    each = torch.stack([quaternion_slerp(q1[k], q2[k], float(t[k])) for k in range(4)])
    for call in (quaternion_slerp, torch.jit.script(quaternion_slerp)):
        np.testing.assert_allclose(call(q1, q2, t), each, atol=1e-15)
        np.testing.assert_allclose(call(q1, q2, t[:, None]), each, atol=1e-15)
    assert quaternion_slerp(q1[0], q2[0], t).shape == quaternion_slerp(q1, q2, t[:1, None]).shape == (4, 4)
    assert quaternion_slerp(q1[0], q2[0], t[:1]).shape == (4,)
    power = torch.stack([(Quaternion(q1[k]) ** float(t[k])).data for k in range(4)])
    for part in (t, t[:, None]):
        np.testing.assert_allclose((Quaternion(q1) ** part).data, power, atol=1e-15)
    for call in (lambda: quaternion_slerp(q1[:3], q2[:3], t[:, None]), lambda: Quaternion(q1[:3]) ** t):
        with pytest.raises(ValueError, match="t: expected leading dimensions that broadcast"):
            call()


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_powers(dtype: torch.dtype) -> None:
    """Whole powers are products; the others are exp(t log q), by NumPy."""
    axes = torch.tensor([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [-1.0, 1e-7, 0.0, 0.0], [0, 0, 0, 1.0]])
    data = torch.cat([torch.randn(20, 4, generator=torch.Generator().manual_seed(0)), axes]).to(dtype)
    assert (data[:, 0] < 0).sum() > 5
    q, tolerance = Quaternion(data), 1e-5 if dtype == torch.float32 else 1e-12
    np.testing.assert_allclose((q**0).data, torch.eye(4)[:1].expand(24, 4), atol=tolerance)
    np.testing.assert_allclose((q**1).data, data, atol=tolerance)
    np.testing.assert_allclose((q**3).data, (q * q * q).data, rtol=10 * tolerance, atol=tolerance)
    np.testing.assert_allclose((q**-1).data, q.inv().data, rtol=10 * tolerance, atol=tolerance)
    np.testing.assert_allclose(((q**0.5) ** 2).data, data, atol=tolerance)
    wide = data[:20].double().numpy()
    length, part = np.linalg.norm(wide, axis=1), np.linalg.norm(wide[:, 1:], axis=1)
    angle = 0.7 * np.arccos(wide[:, 0] / length)
    expected = np.concatenate([np.cos(angle)[:, None], (np.sin(angle) / part)[:, None] * wide[:, 1:]], 1)
    np.testing.assert_allclose((q[:20] ** 0.7).data, length[:, None] ** 0.7 * expected, atol=10 * tolerance)
    np.testing.assert_allclose((q[21] ** 0.5).data, [0, 1, 0, 0], atol=tolerance)
    assert (q[21] ** 3).data.equal(data[21])


def test_powers_and_angles_have_finite_gradients() -> None:
    for data in (torch.eye(4)[0], -torch.eye(4)[0], torch.tensor([-0.6, 0.0, 0.8, 0.0])):
        q = data.double().requires_grad_(True)
        (gradient,) = torch.autograd.grad((Quaternion(q) ** 0.3).data.sum(), q)
        assert gradient.isfinite().all()
        (gradient,) = torch.autograd.grad(Quaternion(q).polar_angle, q)
        assert gradient.isfinite().all()
    # Of lengths other than 1 too.
    q = torch.tensor([[-1.2, 0.3, 0.4, -0.2]], dtype=torch.float64, requires_grad=True)
    t = torch.tensor([0.3], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda q, t: (Quaternion(q) ** t).data, (q, t))
    assert torch.autograd.gradcheck(lambda q: Quaternion(q).polar_angle, (q,))
    assert Quaternion(torch.tensor([1.0, 1e-5, 0.0, 0.0])).polar_angle == pytest.approx(1e-5, rel=1e-6)


def expected_average(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    v = np.linalg.eigh(np.einsum("n,ni,nj->ij", w, q, q))[1][:, -1]
    return v if v[0] >= 0 else -v


@pytest.mark.parametrize("spread", [0.0, 1e-6, 0.3, 5.0])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_average(spread: float, dtype: torch.dtype) -> None:
    random = np.random.default_rng(3)
    q = np.array([0.5, -0.1, 0.7, 0.2]) + spread * random.normal(size=(5, 12, 4))
    # Signs do not matter
    q = q / np.linalg.norm(q, axis=-1, keepdims=True) * random.choice([-1.0, 1.0], (5, 12, 1))
    w = random.uniform(0.1, 2.0, (5, 12))
    q = torch.from_numpy(q).to(dtype).double().numpy()
    tolerance = 1e-9 if dtype == torch.float64 else 1e-6
    for weights in (w, np.ones_like(w)):
        expected = [expected_average(*pair) for pair in zip(q, weights, strict=True)]
        made = average_quaternions(torch.from_numpy(q).to(dtype), torch.from_numpy(weights))
        np.testing.assert_allclose(made, expected, atol=tolerance)
    np.testing.assert_allclose(average_quaternions(torch.from_numpy(q).to(dtype)), expected, atol=tolerance)
    np.testing.assert_allclose(
        average_quaternions(torch.from_numpy(q[0]).to(dtype)), expected[0], atol=tolerance
    )


def test_average_without_a_mean_is_finite() -> None:
    """A rotation and its opposite: the two largest eigenvalues are equal."""
    for q in (torch.eye(4)[:2], torch.eye(4), torch.zeros(3, 4)):
        q = q.clone().requires_grad_(True)
        mean = average_quaternions(q)
        mean.sum().backward()
        assert torch.isfinite(mean).all() and torch.isfinite(q.grad).all()
        assert abs(float(mean.detach().norm()) - 1.0) < 1e-6


def test_gradients() -> None:
    q1, q2 = (wxyz(rotations(4, seed)).requires_grad_(True) for seed in (0, 1))
    points, t = (
        torch.rand(4, 3, dtype=torch.float64, requires_grad=True),
        torch.rand(4, dtype=torch.float64, requires_grad=True),
    )
    assert torch.autograd.gradcheck(quaternion_multiply, (q1, q2))
    assert torch.autograd.gradcheck(quaternion_inverse, (q1,))
    assert torch.autograd.gradcheck(quaternion_rotate, (q1, points))
    assert torch.autograd.gradcheck(quaternion_slerp, (q1, q2, t))
    w = torch.rand(2, 5, dtype=torch.float64, requires_grad=True)
    q = (torch.tensor([1.0, -0.5, 0.3, 0.8]) + 0.5 * torch.rand(2, 5, 4, dtype=torch.float64)).requires_grad_(
        True
    )
    assert torch.autograd.gradcheck(average_quaternions, (q, w), atol=1e-6)


WRONG = [
    (
        lambda: quaternion_multiply(torch.zeros(4), torch.zeros(3)),
        ValueError,
        r"q2: expected shape \(\*, 4\), got \[3\]",
    ),
    (
        lambda: quaternion_rotate(torch.zeros(4), torch.zeros(4)),
        ValueError,
        r"points: expected shape \(\*, 3\)",
    ),
    (
        lambda: quaternion_slerp(torch.zeros(4).int(), torch.zeros(4), 0.1),
        TypeError,
        "q1: expected a floating-point",
    ),
    (lambda: average_quaternions(torch.zeros(4)), ValueError, r"Q: expected shape \(\*, N, 4\), got \[4\]"),
    (
        lambda: average_quaternions(torch.zeros(2, 4), torch.zeros(1, 2)),
        ValueError,
        r"w: expected shape \(\*, N\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
