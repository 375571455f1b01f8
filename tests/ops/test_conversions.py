"""Angles, homogeneous coordinates, pixels, homographies and poses against their definitions in NumPy."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm.geometry import conversions as c

RANDOM = np.random.default_rng(0)


def tensor(*shape: int) -> Tensor:
    return torch.from_numpy(RANDOM.normal(size=shape))


def close(actual: Tensor, expected: object, tolerance: float = 1e-12) -> None:
    np.testing.assert_allclose(actual.detach().numpy(), expected, rtol=tolerance, atol=tolerance)


# --- angles -------------------------------------------------------------------------------------------------


def test_degrees_and_radians() -> None:
    x = 100.0 * tensor(2, 3)
    close(c.deg2rad(x), np.deg2rad(x))
    close(c.rad2deg(x), np.rad2deg(x))


def test_angle_to_rotation_matrix() -> None:
    """It rotates in the opposite direction of the usual matrix, for which y points up."""
    angle = 100.0 * tensor(2, 3)
    usual = (
        Rotation.from_rotvec(np.deg2rad(angle.numpy().reshape(-1, 1)) * [0.0, 0.0, 1.0])
        .as_matrix()[:, :2, :2]
        .reshape(2, 3, 2, 2)
    )
    close(c.angle_to_rotation_matrix(angle), usual.swapaxes(-1, -2))


def test_polar_coordinates() -> None:
    x, y = tensor(50), tensor(50)
    rho, phi = c.cart2pol(x, y)
    close(rho, np.hypot(x, y))
    close(phi, np.arctan2(y, x))
    for back, there in zip(c.pol2cart(rho, phi), (x, y), strict=True):
        close(back, there)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_polar_gradient_at_the_origin_is_zero(dtype: torch.dtype) -> None:
    x = torch.tensor([0.0, 1e-9, -1e-30], dtype=dtype, requires_grad=True)
    rho, phi = c.cart2pol(x, torch.zeros_like(x))
    (rho + phi).sum().backward()
    np.testing.assert_allclose(rho.detach(), [0.0, 1e-9, 1e-30], atol=1e-20)
    np.testing.assert_allclose(phi.detach(), [0.0, 0.0, math.pi], atol=1e-6)
    assert x.grad.tolist() == [0.0, 0.0, 0.0]


# --- homogeneous coordinates --------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(3,), (5, 2), (2, 4, 3), (2, 3, 4, 5)])
def test_homogeneous_points(shape: tuple[int, ...]) -> None:
    points = tensor(*shape)
    there = c.convert_points_to_homogeneous(points)
    close(there, np.concatenate([points, np.ones((*shape[:-1], 1))], -1))
    close(c.convert_points_from_homogeneous(there * 2.5), points)


def test_points_at_infinity_stay() -> None:
    points = torch.tensor([[2.0, 4.0, 0.0], [2.0, 4.0, 1e-9], [2.0, 4.0, -2.0]], requires_grad=True)
    result = c.convert_points_from_homogeneous(points)
    assert result.tolist() == [[2.0, 4.0], [2.0, 4.0], [-1.0, -2.0]]
    result.sum().backward()
    assert torch.isfinite(points.grad).all()


def test_affine_matrices() -> None:
    a, b = tensor(4, 2, 3), tensor(4, 3, 4)
    close(
        c.convert_affinematrix_to_homography(a), np.concatenate([a, np.tile([0.0, 0.0, 1.0], (4, 1, 1))], 1)
    )
    close(
        c.convert_affinematrix_to_homography3d(b),
        np.concatenate([b, np.tile([0.0, 0.0, 0.0, 1.0], (4, 1, 1))], 1),
    )


# --- pixels -------------------------------------------------------------------------------------------------


def pixel_matrix(sizes: tuple[int, ...], align_corners: bool = True) -> np.ndarray:
    """The matrix by the definition: the positions of the first and the last pixel of each axis (width
    first)."""
    made = np.eye(len(sizes) + 1)
    for axis, size in enumerate(sizes):
        edge = 1.0 if align_corners else 1.0 - 1.0 / size
        scale = 2.0 * edge / (size - 1)
        made[axis, axis], made[axis, -1] = scale, -edge
    return made


@pytest.mark.parametrize("align_corners", [True, False])
def test_normal_transform_pixel(align_corners: bool) -> None:
    made = c.normal_transform_pixel(7, 12, dtype=torch.float64, align_corners=align_corners)
    close(made, pixel_matrix((12, 7), align_corners)[None])
    assert c.normal_transform_pixel(7, 12).dtype == torch.float32


def test_normal_transform_pixel3d() -> None:
    close(c.normal_transform_pixel3d(5, 7, 12, dtype=torch.float64), pixel_matrix((12, 7, 5))[None])


def test_an_axis_of_one_pixel() -> None:
    """Its pixel is at 0 in both conventions."""
    for align_corners in (True, False):
        m = c.normal_transform_pixel(1, 1, align_corners=align_corners)[0]
        assert (m @ torch.tensor([0.0, 0.0, 1.0])).tolist() == [0.0, 0.0, 1.0]
    assert c.normalize_pixel_coordinates(torch.tensor([2.0, 0.0]), 1, 5).tolist() == [0.0, 0.0]
    assert c.denormalize_pixel_coordinates(torch.tensor([0.0, 0.0]), 1, 5).tolist() == [2.0, 0.0]


def test_pixel_coordinates() -> None:
    p, v = 50.0 * tensor(2, 6, 2), 50.0 * tensor(2, 6, 3)
    close(c.normalize_pixel_coordinates(p, 7, 12), p @ pixel_matrix((12, 7))[:2, :2] - 1.0)
    close(c.denormalize_pixel_coordinates(c.normalize_pixel_coordinates(p, 7, 12), 7, 12), p)
    zxy = pixel_matrix((5, 12, 7))
    close(c.normalize_pixel_coordinates3d(v, 5, 7, 12), v @ zxy[:3, :3] - 1.0)
    close(c.denormalize_pixel_coordinates3d(c.normalize_pixel_coordinates3d(v, 5, 7, 12), 5, 7, 12), v)


def test_corners_are_exactly_one() -> None:
    for width in range(2, 300):
        corners = c.normalize_pixel_coordinates(torch.tensor([[0.0, 0.0], [width - 1.0, 9.0]]), 10, width)
        assert corners.tolist() == [[-1.0, -1.0], [1.0, 1.0]]


def test_points_with_intrinsics() -> None:
    k = torch.tensor([[500.0, 0.0, 320.0], [0.0, 400.0, 240.0], [0.0, 0.0, 1.0]], dtype=torch.float64) * (
        1.0 + 0.1 * tensor(2, 3, 3).abs()
    )
    k[:, 2] = torch.tensor([0.0, 0.0, 1.0])
    points = 100.0 * tensor(2, 5, 2)
    rays = np.stack([np.linalg.solve(k[b].numpy(), np.c_[points[b], np.ones(5)].T).T for b in range(2)])
    close(c.normalize_points_with_intrinsics(points, k), rays[..., :2])
    close(c.denormalize_points_with_intrinsics(torch.from_numpy(rays[..., :2]), k), points)
    close(c.normalize_points_with_intrinsics(points[0], k[0]), rays[0, :, :2])
    close(c.normalize_points_with_intrinsics(points[:, 0], k), rays[:, 0, :2])


# --- homographies -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("align_corners", [True, False])
def test_homographies(align_corners: bool) -> None:
    m = tensor(3, 3, 3)
    source, target = pixel_matrix((12, 7), align_corners), pixel_matrix((9, 5), align_corners)
    made = c.normalize_homography(m, (7, 12), (5, 9), align_corners)
    close(made, target @ m.numpy() @ np.linalg.inv(source))
    close(c.denormalize_homography(made, (7, 12), (5, 9), align_corners), m)


def test_homographies3d() -> None:
    m = tensor(3, 4, 4)
    made = c.normalize_homography3d(m, (4, 7, 12), (6, 5, 9))
    close(made, pixel_matrix((9, 5, 6)) @ m.numpy() @ np.linalg.inv(pixel_matrix((12, 7, 4))))
    close(c.denormalize_homography3d(made, (4, 7, 12), (6, 5, 9)), m)


def test_what_takes_no_tensor_scripts() -> None:
    made = torch.jit.script(c.normal_transform_pixel)(7, 12, dtype=torch.float64, align_corners=False)
    torch.testing.assert_close(
        made, c.normal_transform_pixel(7, 12, dtype=torch.float64, align_corners=False)
    )
    torch.testing.assert_close(
        torch.jit.script(c.normal_transform_pixel3d)(5, 7, 12), c.normal_transform_pixel3d(5, 7, 12)
    )


def test_symbolic_sizes_stay_symbolic() -> None:
    """An op whose matrices depend on its image's size is exported for every size, one pixel included."""

    class Op(torch.nn.Module):
        def forward(self, image: Tensor, m: Tensor) -> Tensor:
            size = (image.size(0), image.size(1))
            return c.normalize_homography(m, size, size) + c.normal_transform_pixel(
                size[0], size[1], align_corners=False
            )

    dims = {
        "image": {0: torch.export.Dim("H", min=1, max=999), 1: torch.export.Dim("W", min=1, max=999)},
        "m": None,
    }
    exported = torch.export.export(
        Op(), (torch.zeros(7, 5), torch.ones(1, 3, 3)), dynamic_shapes=dims
    ).module()
    m = tensor(1, 3, 3).float()
    for shape in ((7, 5), (20, 3), (1, 1), (1, 30)):
        torch.testing.assert_close(exported(torch.zeros(shape), m), Op()(torch.zeros(shape), m))


# --- poses --------------------------------------------------------------------------------------------------


def poses(n: int = 6) -> tuple[Tensor, Tensor, np.ndarray]:
    """R, t and the same as 4x4."""
    rotation, t = Rotation.random(n, rng=1).as_matrix(), RANDOM.normal(size=(n, 3, 1))
    matrix = np.tile(np.eye(4), (n, 1, 1))
    matrix[:, :3, :3], matrix[:, :3, 3:] = rotation, t
    return torch.from_numpy(rotation), torch.from_numpy(t), matrix


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    return np.roll(Rotation.from_matrix(rotation).as_quat(canonical=True), 1, -1)


def test_matrix4x4() -> None:
    R, t, matrix = poses()
    close(c.Rt_to_matrix4x4(R, t), matrix)
    for part, expected in zip(c.matrix4x4_to_Rt(torch.from_numpy(matrix)), (R, t), strict=True):
        close(part, expected)


def test_camera_axes() -> None:
    """The same world point results from either camera's axes."""
    R, t, matrix = poses()
    turn = np.diag([1.0, -1.0, -1.0, 1.0])
    for function, of_pose in (
        (c.camtoworld_graphics_to_vision_4x4, c.camtoworld_graphics_to_vision_Rt),
        (c.camtoworld_vision_to_graphics_4x4, c.camtoworld_vision_to_graphics_Rt),
    ):
        close(function(torch.from_numpy(matrix)), matrix @ turn)
        close(c.Rt_to_matrix4x4(*of_pose(R, t)), matrix @ turn)


def test_inverse_poses() -> None:
    R, t, matrix = poses()
    for function in (c.camtoworld_to_worldtocam_Rt, c.worldtocam_to_camtoworld_Rt):
        close(c.Rt_to_matrix4x4(*function(R, t)), np.linalg.inv(matrix))
        close(c.Rt_to_matrix4x4(*function(R, t, check_rotation=True)), np.linalg.inv(matrix))
        with pytest.raises(ValueError, match="R: expected rotation matrices"):
            function(-R, t, check_rotation=True)


def test_arkit_and_colmap() -> None:
    R, t, matrix = poses()
    expected = np.linalg.inv(matrix @ np.diag([1.0, -1.0, -1.0, 1.0]))
    q, moved = c.ARKitQTVecs_to_ColmapQTVecs(torch.from_numpy(quaternion_of(R.numpy())), t)
    close(q, quaternion_of(expected[:, :3, :3]), 1e-9)
    close(moved, expected[:, :3, 3:])
    q, back = c.ColmapQTVecs_to_ARKitQTVecs(q, moved)
    close(q, quaternion_of(R.numpy()), 1e-9)
    close(back, t)


# --- errors -------------------------------------------------------------------------------------------------

WRONG = [
    (lambda: c.deg2rad(torch.zeros(3).bool()), TypeError, "tensor: expected real numbers"),
    (lambda: c.cart2pol(torch.zeros(3), torch.zeros(3).int()), TypeError, "y: expected a floating-point"),
    (
        lambda: c.convert_points_from_homogeneous(torch.zeros(3, 1)),
        ValueError,
        r"points: expected shape \(\*, D \+ 1\), got \[3, 1\]",
    ),
    (
        lambda: c.convert_affinematrix_to_homography(torch.zeros(2, 3)),
        ValueError,
        r"A: expected shape \(B, 2, 3\), got 2 dim",
    ),
    (
        lambda: c.convert_affinematrix_to_homography3d(torch.zeros(1, 2, 3)),
        ValueError,
        r"A: expected shape \(\*, 3, 4\), got \[1, 2, 3\]",
    ),
    (lambda: c.normal_transform_pixel(0, 3), ValueError, r"sizes: expected positive numbers, got \[3, 0\]"),
    (
        lambda: c.normalize_pixel_coordinates(torch.zeros(3), 4, 4),
        ValueError,
        r"pixel_coordinates: expected shape \(\*, 2\)",
    ),
    (
        lambda: c.normalize_points_with_intrinsics(torch.zeros(2), torch.zeros(2, 2)),
        ValueError,
        "camera_matrix: expected shape",
    ),
    (
        lambda: c.normalize_homography(torch.zeros(3, 3), (4, 4), (4, 4)),
        ValueError,
        r"dst_pix_trans_src_pix: expected shape \(B, 3, 3\)",
    ),
    (
        lambda: c.normalize_homography3d(torch.zeros(1, 3, 3), (4, 4, 4), (4, 4, 4)),
        ValueError,
        "dst_pix_trans_src_pix: expected shape",
    ),
    (
        lambda: c.Rt_to_matrix4x4(torch.eye(3), torch.zeros(3)),
        ValueError,
        r"t: expected shape \(\*, 3, 1\), got \[3\]",
    ),
    (lambda: c.matrix4x4_to_Rt(torch.eye(3)), ValueError, "extrinsics: expected shape"),
    (lambda: c.euler_from_quaternion(*[torch.zeros(1).int()] * 4), TypeError, "w: expected a floating-point"),
    (lambda: c.quaternion_exp_to_log(torch.zeros(3)), ValueError, r"quaternion: expected shape \(\*, 4\)"),
    (lambda: c.vector_to_skew_symmetric_matrix(torch.zeros(4)), ValueError, r"vec: expected shape \(\*, 3\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
