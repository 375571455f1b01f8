"""The classes of geometry: modules that hold a transform or cameras, against OpenCV and the functions that
they use."""

import cv2
import numpy as np
import pytest
import torch
from photos import chw, hwc, photo
from scenes import pose
from torch import Tensor, nn

from chiasm.geometry import transform
from chiasm.geometry.camera import PinholeCamera, StereoCamera
from chiasm.geometry.conversions import normalize_homography
from chiasm.geometry.depth import DepthWarper, depth_warp
from chiasm.geometry.transform import Affine, HomographyWarper

D = torch.float64
X = photo(3, 3, 25, 31, D)
ONE = {"angle": torch.tensor([20.0], dtype=D), "scale_factor": torch.tensor([1.3], dtype=D)}
ONE |= {"shear": torch.tensor([[0.1, -0.2]], dtype=D), "translation": torch.tensor([[3.5, -2.0]], dtype=D)}


def test_a_chain_of_kornias_names_scripts() -> None:
    names = [
        ("Hflip",),
        ("Vflip",),
        ("Rot180",),
        ("Rotate", ONE["angle"]),
        ("Scale", ONE["scale_factor"]),
        ("Shear", ONE["shear"]),
    ]
    names += [
        ("Translate", ONE["translation"]),
        ("PyrDown",),
        ("PyrUp",),
        ("Rescale", 0.8),
        ("Resize", (20, 24)),
        ("CenterCrop", (16, 18)),
    ]
    chain = nn.Sequential(*[getattr(transform, name)(*setting) for name, *setting in names])
    expected = X
    for function, *setting in (
        ("hflip",),
        ("vflip",),
        ("rot180",),
        *((f, ONE[k].expand(3, *ONE[k].shape[1:])) for f, k in HELD),
    ):
        corners = {"align_corners": True} if function == "shear" else {}  # like Kornia's class
        expected = getattr(transform, function)(expected, *setting, **corners)
    expected = transform.pyrup(transform.pyrdown(expected))
    expected = transform.center_crop(
        transform.resize(transform.rescale(expected, 0.8, align_corners=True), (20, 24)), (16, 18)
    )
    assert expected.shape == (3, 3, 16, 18) and expected.std() > 0.1
    torch.testing.assert_close(chain(X), expected, rtol=0, atol=1e-12)
    torch.testing.assert_close(torch.jit.script(chain)(X), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("size", [(16, 18), (25, 30), (8, 31), 5])
def test_middles_at_whole_pixels_are_slices(size: int | tuple[int, int]) -> None:
    height, width = (size, size) if isinstance(size, int) else size
    top, left = (25 - height) // 2, (31 - width) // 2
    expected = X[:, :, top : top + height, left : left + width]
    for mode in ("slice", "resample"):
        crop = transform.CenterCrop2D(size, cropping_mode=mode)
        torch.testing.assert_close(crop(X), expected, rtol=0, atol=1e-12)
        torch.testing.assert_close(torch.jit.script(crop)(X), expected, rtol=0, atol=1e-12)


def test_middles_of_smaller_images() -> None:
    resized = nn.functional.interpolate(X, (40, 44), mode="bilinear")
    torch.testing.assert_close(transform.CenterCrop2D((40, 44))(X), resized, rtol=0, atol=1e-12)
    padded = nn.functional.pad(X, (6, 7, 7, 8))
    warped = transform.CenterCrop2D((40, 44), cropping_mode="resample")(X)
    torch.testing.assert_close(warped, padded, rtol=0, atol=1e-12)
    with pytest.raises(ValueError, match="cropping_mode: expected one of"):
        transform.CenterCrop2D(4, cropping_mode="warp")
    with pytest.raises(ValueError, match="resample: expected one of"):
        transform.CenterCrop2D(4, resample="lanczos")


HELD = [("rotate", "angle"), ("scale", "scale_factor"), ("shear", "shear"), ("translate", "translation")]


@pytest.mark.parametrize(("function", "name"), HELD)
def test_a_held_parameter_is_learned_and_any_other_tensor_moves_along(function: str, name: str) -> None:
    made = getattr(transform, function.capitalize())
    module = made(nn.Parameter(ONE[name].clone()))
    module(X).square().sum().backward()
    assert [n for n, _ in module.named_parameters()] == [name] and getattr(module, name).grad.abs().min() > 0
    fixed = made(ONE[name]).float()
    assert (
        getattr(fixed, name).dtype == torch.float32
        and not fixed.state_dict()
        and not list(fixed.parameters())
    )


@pytest.mark.parametrize("name", ["warp_affine", "warp_perspective", "homography_warp"])
def test_one_matrix_serves_a_batch(name: str) -> None:
    M = torch.tensor([[[0.9, 0.1, 0.2], [-0.1, 1.1, 0.1], [0.0, 0.0, 1.0]]], dtype=D)[
        :, : 2 if name == "warp_affine" else 3
    ]
    function = getattr(transform, name)
    assert torch.equal(function(X, M, (20, 22)), function(X, M.expand(3, -1, -1), (20, 22)))


@pytest.mark.parametrize("center", [None, torch.tensor([[4.0, 9.0]])])
def test_affine_equals_opencv(center: Tensor | None) -> None:
    module = Affine(
        torch.tensor([20.0, -5.0, 0.0]),
        ONE["translation"],
        torch.tensor([[1.2, 0.8]]),
        torch.tensor([[0.1, -0.2]]),
        center,
    )
    found = torch.jit.script(module)(X)
    torch.testing.assert_close(found, module(X), rtol=0, atol=1e-12)
    c = np.array([[1, 0, 15.0], [0, 1, 12.0], [0, 0, 1]])
    if center is not None:
        c[:2, 2] = center[0].numpy()
    shear = np.array([[1, 0, 0], [np.tan(0.2), 1, 0], [0, 0, 1]]) @ np.array(
        [[1, -np.tan(0.1), 0], [0, 1, 0], [0, 0, 1]]
    )
    for b, degrees in enumerate((20.0, -5.0, 0.0)):
        turn = np.eye(3)
        turn[:2] = cv2.getRotationMatrix2D((0, 0), degrees, 1)
        matrix = c @ turn @ np.diag([1.2, 0.8, 1]) @ shear @ np.linalg.inv(c)
        matrix[:2, 2] += ONE["translation"][0].numpy()
        np.testing.assert_allclose(
            found[b],
            chw(cv2.warpAffine(hwc(X.float(), b), matrix[:2], (31, 25), flags=cv2.INTER_LINEAR)),
            atol=1e-4,
        )


def test_affine_is_its_parts() -> None:
    batch = {k: v.expand(3, *v.shape[1:]) for k, v in ONE.items()}
    torch.testing.assert_close(
        Affine(ONE["angle"])(X), transform.rotate(X, batch["angle"]), rtol=0, atol=1e-12
    )
    torch.testing.assert_close(
        Affine(translation=ONE["translation"])(X),
        transform.translate(X, batch["translation"]),
        rtol=0,
        atol=1e-12,
    )
    factor = batch["scale_factor"][:, None].expand(3, 2)
    torch.testing.assert_close(Affine(scale_factor=factor)(X), transform.scale(X, factor), rtol=0, atol=1e-12)
    assert torch.equal(Affine()(X), X)
    module = Affine(nn.Parameter(torch.tensor([10.0], dtype=D)))
    assert torch.autograd.gradcheck(
        lambda angle: torch.func.functional_call(module, {"angle": angle}, X[:1]),
        ONE["angle"].clone().requires_grad_(),
        fast_mode=True,
    )


# From a source to an output, in pixels
H = torch.tensor([[[1.1, 0.1, -2.0], [0.05, 0.9, 1.5], [1e-3, 2e-3, 1.0]]], dtype=D)


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("normal", [True, False])
def test_homography_warper_equals_opencv(normal: bool, align: bool) -> None:
    back = torch.linalg.inv(H)
    if normal:
        back = normalize_homography(back, (20, 22), (25, 31), align)
    warper = HomographyWarper(20, 22, normalized_coordinates=normal, align_corners=align)
    scripted = torch.jit.script(warper)
    found = warper(X, back)
    for b in range(3):
        np.testing.assert_allclose(
            found[b],
            chw(cv2.warpPerspective(hwc(X.float(), b), H[0].numpy(), (22, 20), flags=cv2.INTER_LINEAR)),
            atol=1e-4,
        )
    scripted.precompute_warp_grid(back)
    warper.precompute_warp_grid(back)
    for other in (scripted(X, back), scripted(X), warper(X), torch.jit.script(warper)(X)):
        torch.testing.assert_close(other, found, rtol=0, atol=1e-9)
    assert warper.float().warped_grid.dtype == torch.float32 and not warper.state_dict()


K = np.array([[40.0, 0, 14.5], [0, 38.0, 12.2], [0, 0, 1]])


def cameras(count: int, first: int = 1) -> tuple[PinholeCamera, list[np.ndarray]]:
    """Cameras near the origin, and their extrinsics."""
    extrinsics = []
    for seed in range(first, first + count):
        E = np.eye(4)
        E[:3, :3], E[:3, 3:] = pose(seed, 0.1, 0.3)
        extrinsics.append(E)
    size = torch.full((count,), 25.0, dtype=D), torch.full((count,), 31.0, dtype=D)
    return (
        PinholeCamera(torch.from_numpy(K).repeat(count, 1, 1), torch.from_numpy(np.stack(extrinsics)), *size),
        extrinsics,
    )


def test_camera_equals_opencv() -> None:
    camera, extrinsics = cameras(3)
    points = torch.rand(3, 7, 3, dtype=D, generator=torch.Generator().manual_seed(1)) + torch.tensor(
        [-0.5, -0.5, 3.0]
    )
    seen, scripted = camera(points), torch.jit.script(camera)
    for b, E in enumerate(extrinsics):
        expected = cv2.projectPoints(points[b].numpy(), cv2.Rodrigues(E[:3, :3])[0], E[:3, 3], K, None)[0][
            :, 0
        ]
        np.testing.assert_allclose(seen[b], expected, rtol=1e-12)
    depth = (camera.rt_matrix @ nn.functional.pad(points, [0, 1], value=1.0).mT).mT[..., 2:]
    for c in (camera, scripted):
        torch.testing.assert_close(c.project(points), seen)
        torch.testing.assert_close(c.unproject(seen, depth), points)
        torch.testing.assert_close(c.project(points[:, 0]), seen[:, 0])
        torch.testing.assert_close(c.intrinsics_inverse(), torch.from_numpy(np.linalg.inv(K)).expand(3, 3, 3))
    torch.testing.assert_close(camera(points[:1].expand(3, 7, 3)), camera(points[:1]))
    half = camera.scale(torch.tensor([0.5], dtype=D))
    torch.testing.assert_close(half(points), 0.5 * seen)
    assert half.height.tolist() == [12.5] * 3 and half.width.tolist() == [15.5] * 3


def test_camera_has_its_numbers() -> None:
    camera = PinholeCamera.from_parameters(40, 38.0, 14.5, 12.2, 25, 31, 0.1, 0.2, 0.3, 2, dtype=D)
    assert camera.batch_size == 2 and camera.camera_matrix.shape == (2, 3, 3)
    np.testing.assert_array_equal(camera.camera_matrix[1], K)
    assert [v.tolist() for v in (camera.fx, camera.fy, camera.cx, camera.cy)] == [
        [40.0] * 2,
        [38.0] * 2,
        [14.5] * 2,
        [12.2] * 2,
    ]
    assert camera.translation_vector[1, :, 0].tolist() == [0.1, 0.2, 0.3] and torch.equal(
        camera.rotation_matrix[0], torch.eye(3, dtype=D)
    )
    assert camera.float()(torch.rand(2, 4, 3)).dtype == torch.float32
    pose = PinholeCamera(
        camera.intrinsics, nn.Parameter(camera.extrinsics.clone()), camera.height, camera.width
    )
    pose(torch.rand(2, 4, 3)).sum().backward()
    assert pose.extrinsics.grad[:, :3].abs().min() > 0


def test_cameras_of_scaled_images_keep_their_form() -> None:
    factor = torch.tensor([0.5, 2.0], dtype=D)
    for size in (3, 4):
        whole = torch.eye(size, dtype=D).repeat(2, 1, 1)
        whole[:, :2, :3] = torch.tensor([[40.0, 0.3, 14.5], [0.0, 38.0, 12.2]], dtype=D)
        heights = torch.tensor([24.0, 25.0], dtype=D), torch.tensor([30.0, 31.0], dtype=D)
        camera = PinholeCamera(whole.clone(), torch.eye(4, dtype=D).repeat(2, 1, 1), *heights)
        made = camera.scale(factor)
        np.testing.assert_allclose(made.intrinsics[:, :2], whole[:, :2] * factor[:, None, None])
        assert made.intrinsics[:, 2:].equal(whole[:, 2:]) and camera.intrinsics.equal(whole)
        assert made.height.tolist() == [12.0, 50.0] and made.width.tolist() == [15.0, 62.0]
        assert camera.scale_(factor) is camera and camera.intrinsics.equal(made.intrinsics)
        assert camera.height.equal(made.height) and camera.width.equal(made.width)


def test_stereo_camera_equals_opencv() -> None:
    R, t = pose(4, 0.1)
    t = np.array([[-0.7], [0.02], [0.05]])
    _, _, P1, P2, Q, _, _ = cv2.stereoRectify(K, None, K, None, (31, 25), R, t, flags=0, alpha=-1)
    P1[1, 1] = P2[1, 1] = 1.1 * P1[1, 1]  # OpenCV's rectified pixels are square, others need not be
    camera = StereoCamera(*(torch.from_numpy(P).expand(2, 3, 4) for P in (P1, P2)))
    points = np.random.default_rng(0).uniform([-1, -1, 3], [1, 1, 6], (25, 31, 3))
    seen = [np.c_[points.reshape(-1, 3), np.ones(25 * 31)] @ P.T for P in (P1, P2)]
    left, right = ((s[:, :2] / s[:, 2:]).reshape(25, 31, 2) for s in seen)
    assert camera.batch_size == 2 and camera.tx.tolist() == pytest.approx([np.linalg.norm(t)] * 2)
    np.testing.assert_allclose(left[..., 1], right[..., 1])
    q = camera.Q[0].numpy() @ np.stack(
        [left[..., 0], left[..., 1], (left - right)[..., 0], np.ones((25, 31))]
    ).reshape(4, -1)
    np.testing.assert_allclose((q[:3] / q[3]).T.reshape(25, 31, 3), points)
    Q[1] *= 1.0 / 1.1
    np.testing.assert_allclose(camera.Q[1], Q, atol=1e-12)
    disparity = torch.rand(2, 1, 25, 31, dtype=D, generator=torch.Generator().manual_seed(0)) + 3.0
    for b, found in enumerate(torch.jit.script(camera)(disparity)):
        np.testing.assert_allclose(
            found, cv2.reprojectImageTo3D(disparity[b, 0].numpy().astype(np.float32), Q), rtol=1e-4
        )
    learned = StereoCamera(camera.rectified_left_camera, nn.Parameter(camera.rectified_right_camera.clone()))
    learned(disparity).sum().backward()
    assert learned.rectified_right_camera.grad[:, 0, 2:].abs().min() > 0


def by_opencv(picture: np.ndarray, points: np.ndarray, E: np.ndarray, border: int) -> np.ndarray:
    """The picture (C, H, W), sampled where a camera at E sees the world points (H, W, 3)."""
    uv = (
        cv2.projectPoints(points.reshape(-1, 3), cv2.Rodrigues(E[:3, :3])[0], E[:3, 3], K, None)[0]
        .reshape(*points.shape[:2], 2)
        .astype(np.float32)
    )
    return np.stack(
        [
            cv2.remap(p.astype(np.float32), uv[..., 0], uv[..., 1], cv2.INTER_LINEAR, borderMode=border)
            for p in picture
        ]
    )


@pytest.mark.parametrize("padding", ["zeros", "border"])
def test_depth_warper_of_three_views_equals_opencv(padding: str) -> None:
    (dst, extrinsics), (src, [E]) = cameras(3), cameras(1, 9)
    z = 3.0 + 0.2 * torch.sin(torch.arange(25 * 31, dtype=D) / 40).reshape(1, 1, 25, 31)
    warper = DepthWarper(dst, 25, 31, padding_mode=padding).compute_projection_matrix(src)
    found = torch.jit.script(warper)(z, X)
    torch.testing.assert_close(found, warper(z, X), rtol=0, atol=1e-12)
    v, u = np.mgrid[:25, :31]
    rays = (
        np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], -1)
        * z[0, 0, :, :, None].numpy()
    )
    points = (rays - E[:3, 3]) @ E[:3, :3]
    border = cv2.BORDER_CONSTANT if padding == "zeros" else cv2.BORDER_REPLICATE
    for b in range(3):
        # Positions rounded to 1/32
        np.testing.assert_allclose(
            found[b], by_opencv(X[b].numpy(), points, extrinsics[b], border), atol=0.02
        )
    one = depth_warp(
        dst.intrinsics[1:2],
        dst.extrinsics[1:2],
        src.intrinsics,
        src.extrinsics,
        z,
        X[1:2],
        True,
        "bilinear",
        padding,
    )
    torch.testing.assert_close(found[1:2], one, rtol=0, atol=1e-12)


@pytest.mark.parametrize("mode", ["bilinear", "nearest", "bicubic"])
@pytest.mark.parametrize("padding", ["zeros", "border", "reflection"])
def test_what_is_behind_is_black(mode: str, padding: str) -> None:
    source = PinholeCamera.from_parameters(40, 38.0, 14.5, 12.2, 25, 31)
    behind = PinholeCamera.from_parameters(40, 38.0, 14.5, 12.2, 25, 31, tz=-100.0)
    z = torch.ones(1, 1, 25, 31, requires_grad=True)
    image = X[:1].float().requires_grad_()  # "nearest" has no derivative with respect to depth
    out = DepthWarper(behind, 25, 31, mode, padding).compute_projection_matrix(source)(z, image)
    out.sum().backward()
    assert (
        out.abs().max() == 0
        and image.grad.isfinite().all()
        and (mode == "nearest" or z.grad.isfinite().all())
    )


CAMERA = PinholeCamera.from_parameters(1.0, 1.0, 0.0, 0.0, 4, 5)
WARPER = HomographyWarper(4, 5)
E4, SIZE = torch.eye(4)[None], torch.ones(1)
WRONG = [
    (lambda: WARPER(X), ValueError, "src_homo_dst: expected a homography"),
    (lambda: HomographyWarper(4, 5, "linear"), ValueError, "mode: expected one of"),
    (lambda: WARPER.precompute_warp_grid(E4), ValueError, r"src_homo_dst: expected shape \(B, 3, 3\)"),
    (lambda: Affine(torch.zeros(2, 2)), ValueError, r"angle: expected shape \(B,\)"),
    (lambda: Affine(shear=torch.zeros(2)), ValueError, r"shear: expected shape \(B, 2\)"),
    (lambda: Affine()(X.int()), TypeError, "input: expected a floating-point"),
    (
        lambda: PinholeCamera(E4[0], E4, SIZE, SIZE),
        ValueError,
        r"intrinsics: expected shape \(B, 3, 3\) or \(B, 4, 4\)",
    ),
    (
        lambda: PinholeCamera(E4, E4[:, :3], SIZE, SIZE),
        ValueError,
        r"extrinsics: expected shape \(\*, 4, 4\)",
    ),
    (
        lambda: PinholeCamera(E4, E4.expand(2, 4, 4), SIZE, SIZE),
        ValueError,
        "extrinsics: expected a batch of 1",
    ),
    (lambda: StereoCamera(E4, E4), ValueError, r"rectified_left_camera: expected shape \(\*, 3, 4\)"),
    (
        lambda: StereoCamera(E4[:, :3], E4[:, :3].expand(2, 3, 4)),
        ValueError,
        r"rectified_right_camera: expected the left one's shape \[1, 3, 4\]",
    ),
    (lambda: DepthWarper(CAMERA, 4, 5)(X[:, :1], X), ValueError, "pinhole_src: expected a camera"),
    (
        lambda: DepthWarper(CAMERA, 4, 5).compute_projection_matrix(CAMERA)(X[:, :1], X),
        ValueError,
        r"depth_src: expected shape \(B, 1, 4, 5\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:24] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
