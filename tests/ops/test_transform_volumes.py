"""Transforms of volumes against SciPy in float64, products in NumPy and grid_sample."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from sampled import by_scipy
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm.geometry.transform import (
    affine3d,
    center_crop3d,
    crop_and_resize3d,
    crop_by_boxes3d,
    crop_by_transform_mat3d,
    get_affine_matrix3d,
    get_perspective_transform3d,
    get_projective_transform,
    get_shear_matrix3d,
    homography_warp3d,
    rotate3d,
    warp_affine3d,
    warp_grid3d,
    warp_perspective3d,
)

D = torch.float64
SIZE = (9, 12, 15)
EXTENT = np.array([15, 12, 9])
X = torch.rand((2, 3, *SIZE), generator=torch.Generator().manual_seed(0), dtype=D)
MATRICES = torch.tensor(
    [
        [[1.1, 0.2, -0.1, 0.3], [-0.15, 0.9, 0.1, -0.2], [0.1, -0.05, 1.05, 0.4]],
        [[0.7, -0.5, 0.1, 4.3], [0.6, 0.8, -0.2, -2.2], [0.0, 0.3, 0.9, 0.7]],
    ],
    dtype=D,
)
HOMOGRAPHIES = torch.cat(
    [MATRICES, torch.tensor([[[0.01, -0.02, 0.015, 1.0]], [[-0.01, 0.005, 0.02, 1.1]]], dtype=D)], 1
)
PADDINGS = ["zeros", "border", "reflection"]
CORNERS = torch.tensor([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=D)


def full(matrix: Tensor) -> np.ndarray:
    return matrix.numpy() if len(matrix) == 4 else np.concatenate([matrix.numpy(), [[0, 0, 0, 1]]])


def voxels(size: tuple[int, int, int]) -> np.ndarray:
    """Voxels (x, y, z) of a volume, (D, H, W, 3)."""
    return np.stack(np.meshgrid(*[np.arange(s, dtype=float) for s in size], indexing="ij")[::-1], -1)


def mapped(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    p = np.concatenate([points, np.ones((*points.shape[:-1], 1))], -1) @ matrix.T
    return p[..., :3] / p[..., 3:]


def sampled(b: int, points: np.ndarray, padding: str) -> np.ndarray:
    return by_scipy(X[b].numpy(), [points[..., i] for i in (2, 1, 0)], padding)


@pytest.mark.parametrize("padding", PADDINGS)
def test_warps_equal_scipy(padding: str) -> None:
    size = (7, 10, 16)
    actual = warp_affine3d(X, MATRICES, size, "bilinear", padding)
    perspective = warp_perspective3d(X, HOMOGRAPHIES, size, "bilinear", padding, True)
    cropped = crop_by_transform_mat3d(X, HOMOGRAPHIES, size, "bilinear", padding)
    for b in range(2):
        source = mapped(np.linalg.inv(full(MATRICES[b])), voxels(size))
        np.testing.assert_allclose(actual[b], sampled(b, source, padding), atol=1e-11)
        source = mapped(np.linalg.inv(full(HOMOGRAPHIES[b])), voxels(size))
        np.testing.assert_allclose(perspective[b], sampled(b, source, padding), atol=1e-11)
        np.testing.assert_allclose(cropped[b], sampled(b, source, padding), atol=1e-11)
    own = warp_affine3d(X, MATRICES, SIZE, "bilinear", padding)
    torch.testing.assert_close(affine3d(X, MATRICES, "bilinear", padding, True), own, rtol=0, atol=0)


def by_grid_sample(source: np.ndarray, mode: str, padding: str) -> Tensor:
    """Positions (B, d, h, w, 3) in voxels, normalised by size - 1, and read as if -1 and 1 were the outer
    faces: Kornia's definition."""
    grid = torch.from_numpy(source * 2 / (EXTENT - 1) - 1)
    return F.grid_sample(X, grid, mode, padding, False)


@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("mode", ["bilinear", "nearest"])
def test_without_corners_equals_grid_sample(mode: str, padding: str) -> None:
    size = (7, 10, 16)
    target = np.array([16, 10, 7])
    shrunk = (voxels(size) + 0.5) * (target - 1) / target
    affine = np.stack([mapped(np.linalg.inv(full(m)), shrunk) for m in MATRICES])
    expected = by_grid_sample(affine, mode, padding)
    torch.testing.assert_close(
        warp_affine3d(X, MATRICES, size, mode, padding, False), expected, rtol=0, atol=1e-9
    )
    perspective = np.stack([mapped(np.linalg.inv(full(m)), voxels(size)) for m in HOMOGRAPHIES])
    grid = torch.from_numpy((perspective * 2 + 1) / EXTENT - 1)  # the same voxels; +-1 are the outer faces
    expected = F.grid_sample(X, grid, mode, padding, False)
    torch.testing.assert_close(
        warp_perspective3d(X, HOMOGRAPHIES, size, mode, padding, False), expected, rtol=0, atol=1e-9
    )


@pytest.mark.parametrize("align", [True, False])
def test_the_identity_leaves_a_volume(align: bool) -> None:
    same, size = torch.eye(4, dtype=D)[None], (X.size(2), X.size(3), X.size(4))
    for warp in (warp_perspective3d, homography_warp3d):
        torch.testing.assert_close(warp(X[:1], same, size, align_corners=align), X[:1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("align", [True, False])
def test_homography_warp_equals_grid_sample(align: bool) -> None:
    h = torch.eye(4, dtype=D) + 0.1 * (HOMOGRAPHIES - torch.eye(4, dtype=D))
    grid = F.affine_grid(torch.eye(4, dtype=D)[None, :3].expand(2, 3, 4), [2, 1, 7, 10, 16], align)
    warped = warp_grid3d(grid, h)
    for b in range(2):
        np.testing.assert_allclose(warped[b], mapped(h[b].numpy(), grid[b].numpy()), atol=1e-12)
    expected = F.grid_sample(X, warped, "bilinear", "border", align)
    torch.testing.assert_close(
        homography_warp3d(X, h, (7, 10, 16), "bilinear", "border", align), expected, rtol=0, atol=1e-9
    )
    voxel = homography_warp3d(X, torch.linalg.inv(HOMOGRAPHIES), (7, 10, 16), normalized_coordinates=False)
    torch.testing.assert_close(
        voxel, warp_perspective3d(X, HOMOGRAPHIES, (7, 10, 16), align_corners=True), rtol=0, atol=1e-9
    )


def about(matrix: np.ndarray, center: Tensor) -> np.ndarray:
    out = np.eye(4)
    out[:3, :3] = matrix
    out[:3, 3] = center.numpy() - matrix @ center.numpy()
    return out


ANGLES = torch.tensor([[20.0, -10.0, 35.0], [-70.0, 100.0, 5.0]], dtype=D)
CENTER = torch.tensor([[3.0, 4.5, 2.0], [100.0, 200.0, 50.0]], dtype=D)
SCALE = torch.tensor([[1.5, 0.7, 1.1], [0.9, 1.3, 2.0]], dtype=D)
SHEARS = [torch.tensor([0.1 * (i + 1), -0.15 * i], dtype=D) for i in range(6)]


def rotation(b: int, sign: float = 1.0) -> np.ndarray:
    return Rotation.from_rotvec(sign * ANGLES[b].numpy(), degrees=True).as_matrix() @ np.diag(
        SCALE[b].numpy()
    )


def shearing(b: int) -> np.ndarray:
    xy, xz, yx, yz, zx, zy = [-np.tan(float(s[b])) for s in SHEARS]
    x = np.array([[1, 0, 0], [xy, 1, 0], [xz, 0, 1]])
    y = np.array([[1, yx, 0], [0, 1, 0], [0, yz, 1]])
    return x @ y @ np.array([[1, 0, zx], [0, 1, zy], [0, 0, 1]])


def test_matrices() -> None:
    move = torch.tensor([[1.0, -2.0, 3.0], [7.0, 0.5, -4.0]], dtype=D)
    projective = get_projective_transform(CENTER, ANGLES, SCALE)
    shear = get_shear_matrix3d(CENTER, *SHEARS)
    affine = get_affine_matrix3d(move, CENTER, SCALE, ANGLES, *SHEARS)
    plain = get_affine_matrix3d(move, CENTER, SCALE, ANGLES)
    for b in range(2):
        np.testing.assert_allclose(projective[b], about(rotation(b), CENTER[b])[:3], atol=1e-9)
        np.testing.assert_allclose(shear[b], about(shearing(b), CENTER[b]), atol=1e-9)
        moved = np.eye(4)
        moved[:3, 3] = move[b]
        np.testing.assert_allclose(plain[b], moved @ about(rotation(b, -1), CENTER[b]), atol=1e-9)
        np.testing.assert_allclose(
            affine[b], moved @ about(rotation(b, -1), CENTER[b]) @ about(shearing(b), CENTER[b]), atol=1e-8
        )


def test_rotate_is_about_the_middle() -> None:
    yaw, pitch, roll = ANGLES.unbind(-1)
    middle = torch.tensor([[7.0, 5.5, 4.0]] * 2, dtype=D)
    matrix = np.stack(
        [
            about(Rotation.from_rotvec(a.numpy(), degrees=True).as_matrix(), m)
            for a, m in zip(ANGLES, middle, strict=True)
        ]
    )
    expected = np.stack(
        [sampled(b, mapped(np.linalg.inv(matrix[b]), voxels(SIZE)), "zeros") for b in range(2)]
    )
    np.testing.assert_allclose(rotate3d(X, yaw, pitch, roll, align_corners=True), expected, atol=1e-9)
    np.testing.assert_allclose(rotate3d(X, yaw, pitch, roll, middle, align_corners=True), expected, atol=1e-9)


@pytest.mark.parametrize("shape", [(), (1,)])
def test_one_angle_for_all(shape: tuple[int, ...]) -> None:
    one, each = torch.full(shape, 20.0, dtype=D), torch.full((2,), 20.0, dtype=D)
    roll = ANGLES[:, 2]
    for angles, wanted in [((one, one, one), (each, each, each)), ((one, roll, one), (each, roll, each))]:
        expected = rotate3d(X, *wanted, CENTER)
        torch.testing.assert_close(rotate3d(X, *angles, CENTER), expected, rtol=0, atol=0)
        torch.testing.assert_close(rotate3d(X, *angles), rotate3d(X, *wanted))


@pytest.mark.parametrize("shape", [(), (1,)])
def test_one_shear_angle_for_all(shape: tuple[int, ...]) -> None:
    one, each = torch.full(shape, 0.3, dtype=D), torch.full((2,), 0.3, dtype=D)
    for k in range(6):
        angles, wanted = [*SHEARS[:k], one, *SHEARS[k + 1 :]], [*SHEARS[:k], each, *SHEARS[k + 1 :]]
        expected = get_shear_matrix3d(CENTER, *wanted)
        torch.testing.assert_close(get_shear_matrix3d(CENTER, *angles), expected, rtol=0, atol=0)
        expected = get_affine_matrix3d(CENTER, CENTER, SCALE, ANGLES, *wanted)
        actual = get_affine_matrix3d(CENTER, CENTER, SCALE, ANGLES, *angles)
        torch.testing.assert_close(actual, expected, rtol=0, atol=0)
    torch.testing.assert_close(get_shear_matrix3d(CENTER, one), get_shear_matrix3d(CENTER, each))


def test_perspective_transform_goes_through_five_corners() -> None:
    generator = torch.Generator().manual_seed(1)
    source = CORNERS * 10 + torch.rand((2, 8, 3), generator=generator, dtype=D)
    target = CORNERS * 7 + torch.rand((2, 8, 3), generator=generator, dtype=D)
    matrix = get_perspective_transform3d(source, target)
    five = [0, 1, 2, 5, 7]
    for b in range(2):
        np.testing.assert_allclose(
            mapped(matrix[b].numpy(), source[b, five].numpy()), target[b, five], atol=1e-9
        )
        assert matrix[b, 3, 3] == 1
    image = torch.from_numpy(mapped(full(MATRICES[0]), source.numpy()))
    np.testing.assert_allclose(get_perspective_transform3d(source, image)[0], full(MATRICES[0]), atol=1e-9)


def test_crops() -> None:
    torch.testing.assert_close(center_crop3d(X, (5, 4, 9)), X[:, :, 2:7, 4:8, 3:12], rtol=0, atol=0)
    halfway = (X[:, :, 2:6, 4:8, 3:12] + X[:, :, 3:7, 4:8, 3:12]) / 2
    torch.testing.assert_close(center_crop3d(X, (4, 4, 9)), halfway, rtol=0, atol=1e-12)
    low, extent = torch.tensor([2.0, 3.0, 1.0], dtype=D), torch.tensor([8.0, 6.0, 4.0], dtype=D)
    box = (low + CORNERS * extent).expand(2, 8, 3)
    torch.testing.assert_close(
        crop_and_resize3d(X, box, (5, 7, 9), align_corners=True), X[:, :, 1:6, 3:10, 2:11], rtol=0, atol=1e-9
    )
    every_other = X[:, :, 1:6:2, 3:10:2, 2:11:2]
    torch.testing.assert_close(
        crop_and_resize3d(X, box, (3, 4, 5), align_corners=True), every_other, rtol=0, atol=1e-9
    )
    corner = (CORNERS * extent).expand(2, 8, 3)
    actual = crop_by_boxes3d(X, box, corner, align_corners=True)
    torch.testing.assert_close(actual, X[:, :, 1:6, 3:10, 2:11], rtol=0, atol=1e-9)
    torch.testing.assert_close(
        crop_by_boxes3d(X, box, corner, align_corners=True, size=(5, 7, 9)), actual, rtol=0, atol=0
    )


@pytest.mark.parametrize("axis", [2, 3, 4])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_single_voxel_counts_from_its_centre(axis: int, dtype: torch.dtype) -> None:
    x = X.select(axis, 3)[..., None].movedim(-1, axis).to(dtype)
    size = (x.size(2), x.size(3), x.size(4))
    zero, eye = torch.zeros(1, dtype=dtype), torch.eye(4, dtype=dtype).expand(2, 4, 4)
    box = (CORNERS * torch.tensor([s - 1 or 1 for s in size[::-1]])).expand(2, 8, 3)
    mirror = eye.clone()
    mirror[:, 4 - axis, 4 - axis] = -1.0
    for made in (
        affine3d(x, eye[:, :3]),
        affine3d(x, mirror[:, :3]),
        rotate3d(x, zero, zero, zero),
        warp_affine3d(x, eye[:, :3], size, align_corners=False),
        crop_by_boxes3d(x, box, box, size=size),
    ):
        torch.testing.assert_close(made, x, rtol=0, atol=1e-5 if dtype == torch.float32 else 1e-9)
    # A rotation about this axis is the one of the middle slice of equal ones.
    turn = torch.full((1,), 30.0, dtype=dtype)
    angles = [turn if 4 - axis == k else zero for k in range(3)]
    many = x.expand([7 if k == axis else -1 for k in range(5)])
    torch.testing.assert_close(rotate3d(x, *angles), rotate3d(many, *angles).narrow(axis, 3, 1))


@pytest.mark.parametrize("size", [(1, 7, 9), (5, 1, 9), (5, 7, 1)])
def test_a_crop_of_one_voxel_is_refused(size: tuple[int, int, int]) -> None:
    with pytest.raises(ValueError, match="size: expected numbers above 1, got"):
        crop_and_resize3d(X, CORNERS.expand(2, 8, 3), size)
