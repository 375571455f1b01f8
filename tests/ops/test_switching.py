"""Conventions on which Kornia's users rely: layouts, dtypes and ranges."""

import importlib
import itertools
import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest
import scipy.cluster.vq
import scipy.spatial.distance
import torch
import torch.nn.functional as F
import torchvision.ops
from torch import Tensor

from chiasm import color, contrib, enhance, feature, filters, geometry, image, losses, metrics, morphology
from chiasm.geometry import depth, epipolar, homography, subpix, transform
from chiasm.geometry.camera import PinholeCamera, StereoCamera
from chiasm.geometry.conversions import axis_angle_to_quaternion, deg2rad, quaternion_log_to_exp, rad2deg
from chiasm.geometry.linalg import transform_points
from chiasm.geometry.line import fit_line
from chiasm.geometry.plane import fit_plane


@pytest.mark.parametrize("dtype", [torch.float16, torch.float32, torch.float64])
def test_points_keep_their_dtype(dtype: torch.dtype) -> None:
    matrix = torch.eye(4, dtype=torch.float64)[None]
    matrix[0, 0, 3] = 0.5
    moved = transform_points(matrix, torch.ones(1, 2, 3, dtype=dtype))
    assert moved.dtype == dtype
    assert moved[0, 0].tolist() == [1.5, 1.0, 1.0]


@pytest.mark.parametrize(
    ("dtype", "length"),
    [(torch.float16, 200.0), (torch.float16, 1e4), (torch.float32, 1e19), (torch.float32, 1e37)],
)
def test_long_vectors_do_not_overflow(dtype: torch.dtype, length: float) -> None:
    v = torch.tensor([length, 0.0, 0.0], dtype=dtype).requires_grad_()
    q = quaternion_log_to_exp(v)
    exact = v[0].item()
    expected = torch.tensor([math.cos(exact), math.sin(exact), 0.0, 0.0])
    tolerance = 2e-3 if dtype == torch.float16 else 1e-6
    torch.testing.assert_close(q.detach().float(), expected, rtol=0, atol=tolerance)
    q.sum().backward()
    assert v.grad is not None and bool(v.grad.isfinite().all())


def test_quaternions_of_any_length_equal_the_definition() -> None:
    length = torch.tensor([1e-9, 1e-3, 9.9e-3, 1.01e-2, 1.0, 49.9, 50.1, 1e4], dtype=torch.float64)
    axis = torch.tensor([2.0, -3.0, 6.0], dtype=torch.float64) / 7
    expected = torch.cat([length.cos()[:, None], length.sin()[:, None] * axis], 1)
    torch.testing.assert_close(quaternion_log_to_exp(length[:, None] * axis), expected, rtol=0, atol=1e-11)
    torch.testing.assert_close(
        axis_angle_to_quaternion(2 * length[:, None] * axis), expected, rtol=0, atol=1e-11
    )
    for scale in (1e-3, 1.0, 60.0):
        assert torch.autograd.gradcheck(quaternion_log_to_exp, (scale * axis).requires_grad_())


def test_disparities_with_the_channel_last() -> None:
    left = torch.tensor([[[100.0, 0.0, 32.0, 0.0], [0.0, 100.0, 24.0, 0.0], [0.0, 0.0, 1.0, 0.0]]])
    right = left.clone()
    right[0, 0, 3] = -50.0
    camera, disparity = StereoCamera(left, right), torch.rand(1, 1, 4, 5) + 5
    points = camera.reproject_disparity_to_3D(disparity.permute(0, 2, 3, 1))
    depth = 50.0 / disparity[:, 0]
    x = (torch.arange(5.0) - 32.0) * depth / 100.0
    torch.testing.assert_close(points[..., 2], depth)
    torch.testing.assert_close(points[..., 0], x)
    assert points.equal(camera(disparity))


def test_classes_take_keywords_and_defaults_of_their_own() -> None:
    image = torch.rand(2, 3, 8, 9)
    assert enhance.AdjustContrast(contrast_factor=0.5)(image).equal(enhance.adjust_contrast(image, 0.5))
    assert enhance.AdjustHue(hue_factor=0.1)(image).equal(enhance.adjust_hue(image, 0.1))
    normalize = enhance.Normalize((0.1, 0.2, 0.3), (1.0, 2.0, 4.0))
    expected = (image - torch.tensor([0.1, 0.2, 0.3])[:, None, None]) / torch.tensor([1.0, 2.0, 4.0])[
        :, None, None
    ]
    torch.testing.assert_close(torch.jit.script(normalize)(image), expected)
    wide = F.interpolate(image, scale_factor=2.0, mode="bilinear", align_corners=True)
    torch.testing.assert_close(transform.Rescale(2.0)(image), wide)
    patches = contrib.extract_tensor_patches(image, 4, 2, 1)
    joined = contrib.CombineTensorPatches((8, 9), 4, 2, 1, True)(
        contrib.extract_tensor_patches(image, 4, 2, 1, True)
    )
    assert patches.shape[1] == 16 and joined.shape == image.shape


def test_kornias_spellings_are_the_same_classes() -> None:
    for package, names in {
        filters: {
            "BlurPool2D": "BlurPool2d",
            "MaxBlurPool2D": "MaxBlurPool2d",
            "MotionBlur3D": "MotionBlur3d",
        },
        enhance: {"JPEGCodecDifferentiable": "JpegCodecDifferentiable"},
        color: {"ApplyColorMap": "ApplyColormap"},
    }.items():
        for name, own in names.items():
            assert getattr(package, name) is getattr(package, own) and name in dir(package)


def test_enumerations_are_the_strings() -> None:
    image = torch.rand(1, 3, 8, 8)
    assert color.rgb_to_raw(image, color.CFA.GB).equal(color.rgb_to_raw(image, "gb"))
    assert torch.jit.script(color.RgbToRaw(color.CFA.GB))(image).equal(color.rgb_to_raw(image, "gb"))
    grey = image[:, :1]
    for kind in enhance.ThresholdType:
        assert enhance.threshold(grey, 0.5, 1.0, kind).equal(enhance.threshold(grey, 0.5, 1.0, kind.value))
    for name in color.ColorMapType:
        assert color.apply_colormap(grey, name).equal(color.apply_colormap(grey, name.value))
    a, b = torch.rand(2, 64), torch.rand(2, 64)
    for kernel in losses.MIKernel:
        loss = losses.MILossFromRef(a, kernel_function=kernel)
        assert torch.jit.script(loss)(b).equal(
            losses.mutual_information_loss(b, a, kernel_function=kernel.value)
        )
    mask = torch.rand(2, 64) > 0.3
    expected = losses.normalized_mutual_information_loss(b, a, mask, mask)
    assert losses.NMILossFromRef(a, mask)(b, mask).equal(expected)


def test_whitening_that_is_fitted() -> None:
    generator = torch.Generator().manual_seed(
        0
    )  # a mixture that is nearly singular is whitened to less than 1
    mixture = torch.rand(3, 3, generator=generator, dtype=torch.float64)
    x = torch.randn(60, 2, 3, generator=generator, dtype=torch.float64) @ mixture
    white = enhance.ZCAWhitening(compute_inv=True).fit(x)
    torch.testing.assert_close(white(x), enhance.zca_whiten(x))
    covariance = np.cov(white(x).flatten(1).numpy().T)
    np.testing.assert_allclose(covariance, np.eye(6), atol=1e-3)
    torch.testing.assert_close(white.inverse_transform(white(x)), x)
    with pytest.raises(RuntimeError, match="nothing is fitted yet"):
        enhance.ZCAWhitening()(x)


def test_a_fitted_whitening_is_saved_and_moves() -> None:
    x = torch.randn(20, 4, generator=torch.Generator().manual_seed(0))
    white = enhance.ZCAWhitening(compute_inv=True).fit(x)
    state = white.state_dict()
    assert set(state) == {"mean_vector", "transform_matrix", "transform_inv"}  # Kornia's names
    pipeline, empty = (torch.nn.Sequential(w) for w in (white, enhance.ZCAWhitening(compute_inv=True)))
    assert not empty[0].fitted and not empty.state_dict()
    empty.load_state_dict(pipeline.state_dict())
    assert empty[0].fitted and torch.equal(empty(x), white(x))
    assert torch.equal(empty[0].inverse_transform(x), white.inverse_transform(x))
    assert white.double().transform_matrix.dtype == torch.float64
    assert white.to("meta")(x.to("meta")).device.type == "meta"
    # Kornia's state has an empty inverse where none is fitted.
    plain = enhance.ZCAWhitening()
    plain.load_state_dict(state | {"transform_inv": torch.empty(0)})
    assert torch.equal(plain(x), empty(x))
    with pytest.raises(RuntimeError, match="no inverse is fitted"):
        plain.inverse_transform(x)


def test_clusters_that_are_fitted() -> None:
    generator = torch.Generator().manual_seed(0)
    x = torch.randn(90, 2, generator=generator) + torch.tensor([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]]).repeat(
        30, 1
    )
    first = x[:3].clone()
    model = contrib.KMeans(3, first, tolerance=1e-9, max_iterations=50)
    model.fit(x)
    expected = scipy.cluster.vq.kmeans2(x.double().numpy(), first.double().numpy(), 50, minit="matrix")
    np.testing.assert_allclose(model.cluster_centers, expected[0], rtol=1e-5)
    assert model.cluster_assignments.tolist() == expected[1].tolist() == model.predict(x).tolist()
    drawn = contrib.KMeans(3, None, seed=4)
    drawn.fit(x)
    assert drawn.cluster_centers.shape == (3, 2)
    torch.manual_seed(4)
    other = contrib.KMeans(3)  # draws from PyTorch's generator
    other.fit(x)
    assert torch.equal(other.cluster_centers, drawn.cluster_centers)


def lloyd(x: np.ndarray, centers: np.ndarray, tolerance: float) -> tuple[np.ndarray, int]:
    """The centres where Kornia's rule stops, and the number of iterations."""
    for count in itertools.count(1):
        nearest = np.abs(x[:, None] - centers).argmin(1)
        moved = np.array([x[nearest == k].mean() for k in range(len(centers))])
        total, centers = np.abs(moved - centers).sum(), moved
        if total**2 <= tolerance:
            return centers, count
    raise AssertionError


def test_clusters_stop_where_the_sum_of_movements_is_small(monkeypatch: pytest.MonkeyPatch) -> None:
    module = importlib.import_module("chiasm.contrib.kmeans")
    nearest, left = module._nearest, iter(range(1000))
    # a fit that does not stop fails, instead of running for ever
    monkeypatch.setattr(module, "_nearest", lambda *given: (next(left), nearest(*given))[1])
    x = np.arange(40.0) ** 1.5
    counts = set()
    for tolerance in (0.0, 50.0, 200.0, 400.0, 1000.0, 2500.0):
        expected, count = lloyd(x, x[:4], tolerance)
        counts.add(count)
        model = contrib.KMeans(4, torch.from_numpy(x[:4, None]), tolerance)
        model.fit(torch.from_numpy(x[:, None]))
        np.testing.assert_allclose(model.cluster_centers[:, 0], expected, rtol=1e-12)
    assert len(counts) == 6
    model = contrib.KMeans(2, tolerance=0.0)
    model.fit(torch.tensor([[0.0], [float("nan")], [1.0]]))
    assert model.cluster_centers.isnan().any()


def test_a_cluster_without_points_gets_one() -> None:
    x = torch.tensor([[0.0], [1.0], [8.0], [10.0]])
    found = set()
    for seed in range(20):
        model = contrib.KMeans(2, torch.tensor([[5.0], [1000.0]]), max_iterations=1, seed=seed)
        model.fit(x)
        assert model.cluster_centers[0].item() == 4.75
        found.add(model.cluster_centers[1].item())
    assert found == {0.0, 1.0, 8.0, 10.0}


def test_fitted_clusters_are_saved_and_move() -> None:
    x = torch.rand(30, 2, generator=torch.Generator().manual_seed(0))
    model, empty = contrib.KMeans(3, seed=1), contrib.KMeans(3)
    model.fit(x)
    empty.load_state_dict(model.state_dict())
    assert torch.equal(empty.cluster_centers, model.cluster_centers)
    assert torch.equal(empty.predict(x), model.cluster_assignments)
    assert empty.predict(x.to("meta")).device.type == "meta"
    assert model.to("meta").cluster_centers.device.type == "meta"
    assert model.cluster_assignments.device.type == "meta"


@pytest.mark.parametrize(("settings", "message"), [
    ({"tolerance": None}, "tolerance: expected a number, or max_iterations above 0, got None"),
    ({"tolerance": float("nan")}, "tolerance: expected zero or more, got nan"),
    ({"cluster_centers": torch.ones(2)}, r"cluster_centers: expected shape \(num_clusters, D\)"),
    ({"cluster_centers": torch.ones(3, 1)}, r"cluster_centers: expected 2 of them, got \[3, 1\]"),
])  # fmt: skip
def test_settings_of_clusters(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        contrib.KMeans(2, **settings)


def test_matches_alone() -> None:
    generator = torch.Generator().manual_seed(0)
    a, b = torch.rand(9, 4, generator=generator), torch.rand(7, 4, generator=generator)
    far = scipy.spatial.distance.cdist(a, b)
    pairs = [[i, j] for i, j in enumerate(far.argmin(1)) if far[:, j].argmin() == i]
    distances, indices = feature.DescriptorMatcher("mnn")(a, b)
    assert indices.tolist() == pairs
    np.testing.assert_allclose(distances[:, 0], [far[i, j] for i, j in pairs], rtol=1e-5)


def test_modules_of_patches_and_frames() -> None:
    image, lafs = torch.rand(2, 1, 40, 44), torch.eye(2, 3).expand(2, 3, 2, 3) * 6
    lafs = lafs + torch.tensor([[0.0, 0.0, 20.0], [0.0, 0.0, 21.0]])
    assert feature.LAFOrienter(24)(lafs, image).equal(feature.orient_laf(lafs, image, 24))
    shape = feature.LAFAffineShapeEstimator(24, preserve_orientation=False)
    assert shape(lafs, image).equal(feature.adapt_laf_shape(lafs, image, 24))
    turned = feature.LAFAffineShapeEstimator(24)(feature.rotate_laf(lafs, torch.full((2, 3, 1), 30.0)), image)
    torch.testing.assert_close(feature.get_laf_orientation(turned), torch.full((2, 3, 1), 30.0))
    describe = feature.LAFDescriptor(patch_descriptor_module=feature.SIFTDescriptor(24), patch_size=24)
    for module in (feature.LAFOrienter(24), feature.LAFAffineShapeEstimator(24), describe):
        given = (image, lafs) if module is describe else (lafs, image)
        torch.testing.assert_close(torch.jit.script(module)(*given), module(*given))
    sigmas = torch.tensor([1.0, 2.0])
    assert feature.CornerHarris(0.04)(image, sigmas).equal(
        feature.harris_response(image, 0.04, sigmas=sigmas)
    )
    assert feature.BlobHessian()(image, sigmas).equal(feature.hessian_response(image, sigmas=sigmas))
    peaks = subpix.NonMaximaSuppression2d((3, 3))
    assert torch.jit.script(peaks)(image, True).equal(subpix.nms2d(image, (3, 3), True))


def channels(x: Tensor) -> int:
    return 1 if x.dim() == 2 else x.size(-3)


UNBATCHED = {
    "resize": lambda x: transform.resize(x, (4, 5)),
    "rescale": lambda x: transform.rescale(x, 0.5),
    "rotate": lambda x: transform.rotate(x, torch.tensor(30.0)),
    "translate": lambda x: transform.translate(x, torch.tensor([1.0, 2.0])),
    "scale": lambda x: transform.scale(x, torch.tensor(1.5)),
    "shear": lambda x: transform.shear(x, torch.tensor([0.1, 0.0])),
    "affine": lambda x: transform.affine(x, torch.eye(2, 3)[None]),
    "sharpness": lambda x: enhance.sharpness(x, 0.5),
    "equalize": enhance.equalize,
    "normalize_min_max": enhance.normalize_min_max,
    "connected_components": lambda x: contrib.connected_components(x - 0.5),
    "in_range": lambda x: filters.in_range(x, [0.2] * channels(x), [0.7] * channels(x)),
}


@pytest.mark.parametrize("call", UNBATCHED.values(), ids=UNBATCHED)
def test_images_without_a_batch(call: Callable[[Tensor], Tensor]) -> None:
    image = torch.rand(3, 8, 9)
    assert call(image).equal(call(image[None])[0])
    assert call(image[1]).equal(call(image[1:2][None])[0, 0])


def test_one_image_by_many_matrices() -> None:
    image, angles = torch.rand(1, 3, 8, 9), torch.tensor([0.0, 30.0, -50.0])
    many = transform.rotate(image, angles)
    assert many.equal(transform.rotate(image.expand(3, -1, -1, -1), angles))
    matrix = torch.eye(3).repeat(3, 1, 1)
    matrix[:, 0, 2] = torch.tensor([0.0, 1.0, 2.0])
    for warp in (transform.warp_perspective, transform.homography_warp, transform.crop_by_transform_mat):
        assert warp(image, matrix, (8, 9)).equal(warp(image.expand(3, -1, -1, -1), matrix, (8, 9)))
        with pytest.raises(ValueError, match="expected one, or one for each image"):
            warp(image.expand(2, -1, -1, -1), matrix, (8, 9))


def test_shapes_that_broadcast() -> None:
    image = torch.rand(2, 3, 8, 9)
    bound = torch.tensor([0.1, 0.2, 0.3])
    wanted = filters.in_range(image, bound, bound + 0.5)
    for low in (bound[:, None, None], bound[None, :, None, None].expand(2, -1, -1, -1)):
        assert filters.in_range(image, low, low + 0.5).equal(wanted)
    pred, weight = torch.randn(2, 3, 8, 9), torch.tensor([1.0, 2.0, 4.0])
    torch.testing.assert_close(
        losses.binary_focal_loss_with_logits(pred, image, None, 0.0, pos_weight=weight[:, None, None]),
        F.binary_cross_entropy_with_logits(pred, image, reduction="none", pos_weight=weight[:, None, None]),
    )
    mask = torch.rand(8, 9) > 0.3
    loss = losses.mutual_information_loss_2d
    assert loss(image, pred, mask).equal(loss(image, pred, mask.expand(2, 3, 8, 9)))
    lafs = torch.eye(2, 3).expand(2, 5, 2, 3)
    turned = feature.rotate_laf(lafs, torch.full((2, 5, 1), 20.0))
    assert feature.rotate_laf(lafs, torch.tensor(20.0)).equal(turned)
    with pytest.raises(ValueError, match=r"sigma: expected shape \(4, 2\) or \(1, 2\), got \[2, 2\]"):
        filters.gaussian_blur2d(torch.rand(4, 1, 8, 8), 3, torch.ones(2, 2))
    assert losses.total_variation(torch.tensor([[0, 1], [0, 3]])).item() == 6.0


def test_boxes_by_centre_and_size() -> None:
    centres = torch.rand(5, 4) * 10 + 1
    corners = torchvision.ops.box_convert(centres, "cxcywh", "xyxy")
    expected = torchvision.ops.box_iou(corners, corners)
    torch.testing.assert_close(metrics.mean_iou_bbox(centres, centres, "cxcywh"), expected)


def test_keywords_of_kernels_engines_and_cameras() -> None:
    sized = {
        filters.get_gaussian_kernel1d: (5, 1.0),
        filters.get_gaussian_erf_kernel1d: (5, 1.0),
        filters.get_gaussian_discrete_kernel1d: (5, 1.0),
        filters.gaussian: (5, 1.0),
        filters.get_gaussian_kernel2d: (5, (1.0, 2.0)),
        filters.get_gaussian_kernel3d: (5, (1.0, 2.0, 3.0)),
    }
    for kernel, given in sized.items():
        found = kernel(*given, device=torch.device("meta"), dtype=torch.float64)
        assert found.device.type == "meta" and found.dtype == torch.float64
    image, element = torch.rand(1, 1, 9, 9), torch.ones(3, 3)
    for name in ("dilation", "erosion", "opening", "closing", "gradient", "top_hat", "bottom_hat"):
        op = getattr(morphology, name)
        assert op(image, element, engine="unfold").equal(op(image, element))
        with pytest.raises(ValueError, match="engine: expected one of"):
            op(image, element, engine="fast")
    camera = PinholeCamera.from_parameters(10.0, 11.0, 4.0, 3.0, 6, 8, 1.0, 2.0, 3.0)
    assert [camera.tx.item(), camera.ty.item(), camera.tz.item()] == [1.0, 2.0, 3.0]
    other = camera.clone()
    other.extrinsics[:, 0, 3] = 7.0
    assert camera.tx.item() == 1.0 and camera.device() == torch.device("cpu")


def test_segments_without_a_batch() -> None:
    corner = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    segments = torch.stack([corner, corner.roll(1, 0)], 1)
    H = homography.find_homography_lines_dlt(segments, 2.0 * segments)
    torch.testing.assert_close(H, torch.diag(torch.tensor([2.0, 2.0, 1.0]))[None])


def test_whole_numbers_of_degrees() -> None:
    degrees = torch.tensor([0, 45, 180, -90])
    np.testing.assert_allclose(deg2rad(degrees), np.deg2rad(degrees.numpy()), rtol=1e-6)
    np.testing.assert_allclose(rad2deg(degrees), np.rad2deg(degrees.numpy()), rtol=1e-6)
    with pytest.raises(TypeError, match=r"tensor: expected real numbers, got torch\.bool"):
        deg2rad(torch.tensor([True]))


def test_a_plane_of_pixels_is_drawn_on() -> None:
    drawn = image.draw_point2d(torch.zeros(3, 4), torch.tensor([[2, 1], [0, 2]]), torch.tensor([7.0]))
    expected = np.zeros((3, 4))
    expected[[1, 2], [2, 0]] = 7
    np.testing.assert_array_equal(drawn, expected)


@pytest.mark.parametrize("weighted", [False, True])
def test_one_set_of_points_is_fitted(weighted: bool) -> None:
    generator = torch.Generator().manual_seed(3)
    points = torch.randn(20, 3, generator=generator, dtype=torch.float64) * torch.tensor([3.0, 1.0, 0.1])
    weights = torch.rand(20, generator=generator, dtype=torch.float64) if weighted else None
    w = np.ones(20) if weights is None else weights.numpy()
    mean = (w[:, None] * points.numpy()).sum(0) / w.sum()
    centred = points.numpy() - mean
    vectors = np.linalg.eigh((w[:, None] * centred).T @ centred)[1]
    origin, direction = fit_line(points, weights)
    np.testing.assert_allclose(origin, mean, atol=1e-12)
    assert direction.shape == (3,) and abs(direction.numpy() @ vectors[:, 2]) == pytest.approx(1)
    normal, offset = fit_plane(points, weights)
    assert normal.shape == (3,) and abs(normal.numpy() @ vectors[:, 0]) == pytest.approx(1)
    assert offset.item() == pytest.approx(-normal.numpy() @ mean, abs=1e-12)


def test_one_angle_for_all_rotations() -> None:
    center, scale = torch.tensor([[3.0, 2.0], [1.0, 5.0]]), torch.ones(2, 2)
    turned = transform.get_rotation_matrix2d(center, torch.tensor(30.0), scale)
    for b in range(2):
        expected = cv2.getRotationMatrix2D(tuple(center[b].tolist()), 30.0, 1.0)
        np.testing.assert_allclose(turned[b], expected, atol=1e-6)


def test_names_of_geometry_without_their_module() -> None:
    assert geometry.resize is transform.resize and geometry.Resize is transform.Resize
    assert geometry.PinholeCamera is PinholeCamera and geometry.fit_line is fit_line
    assert transform.ImageRegistrator is geometry.ImageRegistrator is geometry.registration.ImageRegistrator
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        getattr(geometry, "no_such_name")  # noqa: B009 (a type checker knows that it is missing)


def test_scenes_are_seen_by_their_cameras() -> None:
    torch.manual_seed(0)
    scene = epipolar.generate_scene(4, 50)
    X, P = scene["points3d"].numpy(), scene["P"].numpy()
    for v in range(4):
        rotation, shift = scene["R"][v].numpy(), scene["t"][v].numpy()
        assert (X[0] @ rotation.T + shift[:, 0])[:, 2].min() > 0.99
        np.testing.assert_allclose(P[v], scene["K"][0].numpy() @ np.hstack([rotation, shift]), atol=1e-4)
        turn = cv2.Rodrigues(rotation)[0]
        seen = cv2.projectPoints(X[0], turn, shift, scene["K"][0].numpy(), None)[0]
        np.testing.assert_allclose(scene["points2d"][v], seen[:, 0], rtol=1e-3, atol=1e-2)
    K = epipolar.random_intrinsics(torch.tensor(2.0, dtype=torch.float64), torch.tensor(3.0))
    assert K.shape == (1, 3, 3) and K.dtype == torch.float64 and 2 <= K[0, 0, 0] < 3
    with pytest.raises(ValueError, match="num_views, num_points: expected positive numbers, got 0 and 5"):
        epipolar.generate_scene(0, 5)


@pytest.mark.parametrize("double", [False, True])
def test_a_scale_space(double: bool) -> None:
    plane = torch.zeros(1, 1, 81, 97, dtype=torch.float64)
    plane[0, 0, 40, 48] = 1.0
    pyramid = transform.ScalePyramid(2, 1.6, 30, double)
    levels, sigmas, sizes = pyramid(plane)
    first = [81, 97] if not double else [162, 194]
    assert [list(x.shape[3:]) for x in levels] == [[n >> k for n in first] for k in range(len(levels))]
    assert len(levels) == 2 + double
    wide = cv2.resize(plane[0, 0].numpy(), None, fx=2, fy=2) if double else plane[0, 0].numpy()
    has = 1.0 if double else 0.5
    for k in range(5 - 2 * double):  # the blurs add up to one; a doubled image's positions differ
        assert sigmas[0][0, k].item() == pytest.approx(1.6 * 2 ** (k / 2))
        total = math.sqrt(sigmas[0][0, k].item() ** 2 - has**2)
        blurred = cv2.GaussianBlur(wide, (0, 0), total)
        assert levels[0][0, 0, k].max().item() == pytest.approx(blurred.max(), rel=0.1 if double else 2e-3)
    assert [s[0, 0].item() for s in sizes] == [(0.5 if double else 1.0) * 2**k for k in range(len(sizes))]
    tiny = transform.ScalePyramid()(torch.rand(1, 1, 7, 6))[0]
    assert len(tiny) == 1 and tiny[0].isfinite().all()
    for made, expected in zip(torch.jit.script(pyramid)(plane)[0], levels):
        torch.testing.assert_close(made, expected)


def test_planes_of_a_cost_volume() -> None:
    left = PinholeCamera.from_parameters(20.0, 20.0, 8.0, 6.0, 12, 16)
    right = PinholeCamera.from_parameters(20.0, 20.0, 8.0, 6.0, 12, 16, tx=-0.25)
    warper = depth.DepthWarper(right, 12, 16)
    with pytest.raises(ValueError, match="pinhole_src: expected a camera"):
        warper.compute_subpixel_step()
    step = warper.compute_projection_matrix(left).compute_subpixel_step()
    # disparity = focal length * base * inverse depth: half a pixel each
    assert step.item() == pytest.approx(0.5 / (20.0 * 0.25), rel=1e-4)
    left.tx = 2.0
    assert left.tx.item() == left.extrinsics[0, 0, 3].item() == 2.0


def test_images_of_different_sizes_are_registered() -> None:
    image, smaller = torch.rand(1, 1, 32, 40), torch.rand(1, 1, 16, 20)
    found = transform.ImageRegistrator(pyramid_levels=2, num_iterations=3, allow_shape_mismatch=True)
    expected = transform.ImageRegistrator(pyramid_levels=2, num_iterations=3)
    resized = F.interpolate(image, (16, 20), mode="bilinear", align_corners=False)
    torch.testing.assert_close(found.register(image, smaller), expected.register(resized, smaller))
    with pytest.raises(ValueError, match="dst_img: expected src_img's shape"):
        expected.register(image, smaller)
