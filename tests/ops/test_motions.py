"""Quaternions, rotations, motions and poses as objects, compared with SciPy and NumPy."""

import numpy as np
import pytest
import torch
from scipy.linalg import expm
from scipy.spatial.transform import Rotation, Slerp

from chiasm.geometry.liegroup import Se2, Se3, So2, So3
from chiasm.geometry.pose import NamedPose
from chiasm.geometry.quaternion import Quaternion
from chiasm.geometry.vector import Vector2, Vector3


def numbers(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def as_scipy(q: Quaternion) -> Rotation:
    return Rotation.from_quat(q.data.numpy()[..., [1, 2, 3, 0]])


def test_quaternions() -> None:
    v, w = numbers(5, 3), numbers(5, 3, seed=1)
    q, p = Quaternion.from_axis_angle(v), Quaternion.from_axis_angle(w)
    a, b = Rotation.from_rotvec(v), Rotation.from_rotvec(w)
    np.testing.assert_allclose((q * p).matrix(), (a * b).as_matrix(), atol=1e-12)
    np.testing.assert_allclose((q / p).matrix(), (a * b.inv()).as_matrix(), atol=1e-12)
    np.testing.assert_allclose((q**0.3).matrix(), (a**0.3).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(Quaternion.from_matrix(q.matrix()).matrix(), a.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(q.polar_angle * 2, np.linalg.norm(v, axis=1), atol=1e-7)
    np.testing.assert_allclose((2.0 * q).norm(), np.full(5, 2.0))
    np.testing.assert_allclose((q + -p).squared_norm(), ((q - p).data ** 2).sum(1))
    for k in range(5):
        between = Slerp([0, 1], Rotation.concatenate([a[k], b[k]]))(0.3)
        np.testing.assert_allclose(q[k].slerp(p[k], 0.3).matrix(), between.as_matrix(), atol=1e-12)
    roll, pitch, yaw = q.to_euler()
    np.testing.assert_allclose(Quaternion.from_euler(roll, pitch, yaw).matrix(), q.matrix(), atol=1e-12)
    assert torch.stack(q.coeffs, -1).equal(q.q) and q.scalar.equal(q.w) and q.vec[:, 2].equal(q.z)
    torch.manual_seed(0)
    random = Quaternion.random(5000).matrix()
    assert abs(random.mean(0)).max() < 0.06  # every direction as often as its opposite


def test_rotations_of_space() -> None:
    v, w, points = numbers(5, 3), numbers(5, 3, seed=1), numbers(5, 3, seed=2)
    a, b = So3.exp(v), So3.exp(w)
    turn = Rotation.from_rotvec(v)
    np.testing.assert_allclose((a * b).matrix(), (turn * Rotation.from_rotvec(w)).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(a * points, turn.apply(points), atol=1e-12)
    np.testing.assert_allclose((a * Vector3(points)).data, turn.apply(points), atol=1e-12)
    np.testing.assert_allclose(a.inverse() * (a * points), points, atol=1e-12)
    np.testing.assert_allclose(a.log(), turn.as_rotvec(), atol=1e-12)
    np.testing.assert_allclose(a.adjoint(), turn.as_matrix(), atol=1e-12)
    plane = So2.exp(torch.tensor([0.3, -2.0], dtype=torch.float64))
    np.testing.assert_array_equal(plane.adjoint(), np.broadcast_to(np.eye(2), (2, 2, 2)))
    np.testing.assert_allclose(So3.vee(So3.hat(v)), v)
    angle = numbers(5)
    for axis, made in zip("xyz", (So3.rot_x, So3.rot_y, So3.rot_z)):
        expected = Rotation.from_euler(axis, angle.numpy()[:, None]).as_matrix()
        np.testing.assert_allclose(made(angle).matrix(), expected, atol=1e-12)
    assert So3.identity(2).matrix().equal(torch.eye(3).expand(2, 3, 3)) and So3.random(4).log().shape == (
        4,
        3,
    )


def test_rotations_of_the_plane() -> None:
    angle, points = numbers(5), numbers(5, 2, seed=1)
    a = So2.exp(angle)
    turn = np.stack(
        [np.stack([np.cos(angle), -np.sin(angle)], -1), np.stack([np.sin(angle), np.cos(angle)], -1)], -2
    )
    np.testing.assert_allclose(a.matrix(), turn, atol=1e-12)
    np.testing.assert_allclose(a * points, np.einsum("bij,bj->bi", turn, points), atol=1e-12)
    assert isinstance(a * Vector2(points), Vector2)
    np.testing.assert_allclose((a * So2.exp(angle)).matrix(), turn @ turn, atol=1e-12)
    np.testing.assert_allclose((a * a.inverse()).log(), np.zeros(5), atol=1e-12)
    np.testing.assert_allclose(So2.from_matrix(a.matrix())[1:3].log(), angle[1:3], atol=1e-12)
    np.testing.assert_allclose(So2.vee(So2.hat(angle)), angle)


@pytest.mark.parametrize(("group", "size"), [(Se2, 2), (Se3, 3)])
def test_motions(group: type, size: int) -> None:
    length = 3 if size == 2 else 6
    v, w, points = numbers(5, length), numbers(5, length, seed=1), numbers(5, size, seed=2)
    a, b = group.exp(v), group.exp(w)
    exact = np.stack([expm(m) for m in group.hat(v).numpy()])
    np.testing.assert_allclose(a.matrix(), exact, atol=1e-12)
    np.testing.assert_allclose((a * b).matrix(), exact @ b.matrix().numpy(), atol=1e-12)
    np.testing.assert_allclose(a.inverse().matrix(), np.linalg.inv(exact), atol=1e-12)
    moved = np.einsum("bij,bj->bi", exact[:, :size, :size], points) + exact[:, :size, size]
    np.testing.assert_allclose(a * points, moved, atol=1e-12)
    np.testing.assert_allclose(group.exp(a.log()).matrix(), exact, atol=1e-10)
    np.testing.assert_allclose(group.from_matrix(a.matrix())[2].matrix(), exact[2], atol=1e-12)
    np.testing.assert_allclose(group.vee(group.hat(v)), v)
    change = np.stack([expm(m) for m in group.hat((a.adjoint() @ w[..., None])[..., 0]).numpy()])
    np.testing.assert_allclose(exact @ b.matrix().numpy() @ np.linalg.inv(exact), change, atol=1e-10)
    assert a.t.equal(a.translation) and a.r.matrix().equal(a.rotation.matrix())
    assert group.identity(3).matrix().equal(torch.eye(size + 1).expand(3, size + 1, size + 1))
    assert group.random(3).matrix().shape == (3, size + 1, size + 1)


def test_axes_of_motions() -> None:
    x = torch.tensor([1.0, 2.0])
    assert Se3.trans_y(x).t.tolist() == [[0, 1, 0], [0, 2, 0]] and Se2.trans_x(x).t.tolist() == [
        [1, 0],
        [2, 0],
    ]
    np.testing.assert_allclose(Se3.rot_z(x).so3.log(), So3.rot_z(x).log())
    q = torch.cat([Quaternion.random(2).data, torch.rand(2, 3)], -1)
    made = Se3.from_qxyz(q)
    assert made.quaternion.data.equal(q[:, :4]) and made.translation.equal(q[:, 4:])


def test_a_motion_is_learned() -> None:
    shift = torch.nn.Parameter(torch.zeros(3))
    motion = Se3(Quaternion(torch.nn.Parameter(torch.tensor([1.0, 0.0, 0.0, 0.0]))), shift)
    assert len(list(motion.parameters())) == 2
    (motion * torch.ones(3)).sum().backward()
    assert shift.grad is not None and shift.grad.tolist() == [1, 1, 1]


def test_poses_between_frames() -> None:
    b_from_a = NamedPose(Se3.exp(numbers(6)), "a", "b")
    c_from_b = NamedPose.from_matrix(Se3.exp(numbers(6, seed=1)).matrix(), "b", "c")
    c_from_a = c_from_b * b_from_a
    assert (c_from_a.frame_src, c_from_a.frame_dst) == ("a", "c")
    point = numbers(3, seed=2)
    there = c_from_a.transform_points(point)
    np.testing.assert_allclose(there, c_from_b.transform_points(b_from_a.transform_points(point)), atol=1e-12)
    np.testing.assert_allclose(c_from_a.inverse().transform_points(there), point, atol=1e-12)
    turn = b_from_a.rotation
    for rotation in (turn, turn.matrix(), Quaternion.from_matrix(turn.matrix())):
        again = NamedPose.from_rt(rotation, b_from_a.translation)
        np.testing.assert_allclose(
            again.transform_points(point), b_from_a.transform_points(point), atol=1e-12
        )
        assert again.frame_src != again.frame_dst
    with pytest.raises(ValueError, match="expected a pose to frame 'a', got one to frame 'c'"):
        b_from_a * c_from_b
    with pytest.raises(ValueError, match="frame_dst: expected a name other than frame_src's, got 'a'"):
        NamedPose(Se3.identity(), "a", "a")


def test_what_is_refused() -> None:
    with pytest.raises(TypeError, match=r"z: expected a complex tensor, got torch\.float32"):
        So2(torch.ones(2))
    with pytest.raises(TypeError, match="q: expected a Quaternion, got Tensor"):
        So3(torch.ones(4))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match="rotation: expected a So3 or a Quaternion, got Tensor"):
        Se3(torch.ones(4), torch.ones(3))  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="data: expected"):
        Quaternion(torch.ones(3))
