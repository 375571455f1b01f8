"""An error names the wrong argument, the expected and the actual value."""

from typing import Callable

import pytest
import torch

from chiasm import (
    augmentation,
    color,
    contrib,
    enhance,
    feature,
    filters,
    image,
    losses,
    metrics,
    morphology,
    ops,
    pipelines,
)
from chiasm.geometry import conversions, epipolar, homography, subpix, transform
from chiasm.primitives.core.target import exporting
from chiasm.primitives.filters.correlation import centred
from chiasm.primitives.filters.padding import padded

X = torch.zeros(1, 3, 8, 8)
BYTES = torch.zeros(1, 3, 8, 8, dtype=torch.uint8)
EYE = torch.eye(3)[None]
FRAME = torch.zeros(8, 8, 3, dtype=torch.uint8)
BOXES = torch.zeros(1, 4)


def warped_by_two_grids() -> torch.Tensor:
    warper = transform.HomographyWarper(4, 4)
    warper.precompute_warp_grid(EYE.expand(2, -1, -1))
    return warper(X)


WRONG = [
    (
        lambda: color.rgb_to_grayscale(X[:, :2]),
        ValueError,
        r"image: expected shape \(\*, 3, H, W\), got \[1, 2, 8, 8\]",
    ),
    (
        lambda: color.rgb_to_grayscale(BYTES.int()),
        TypeError,
        "image: expected a floating-point or uint8 tensor, got dtype",
    ),
    (
        lambda: color.rgb_to_grayscale(X, torch.ones(4)),
        ValueError,
        r"rgb_weights: expected shape \(3,\), got \[4\]",
    ),
    (lambda: color.rgb_to_hsv(X[0, 0]), ValueError, "image: expected shape"),
    (lambda: color.bgr_to_rgb(X[:, :1]), ValueError, "image: expected shape"),
    (
        lambda: enhance.normalize(BYTES.int(), EYE[0, 0], EYE[0, 0]),
        TypeError,
        "data: expected a floating-point",
    ),
    (lambda: enhance.normalize(X, EYE, EYE[0, 0]), ValueError, "mean: expected"),
    (lambda: enhance.normalize(X, EYE[0, 0], EYE), ValueError, "std: expected"),
    (
        lambda: filters.gaussian_blur2d(X[0], 3, (1.0, 1.0)),
        ValueError,
        r"input: expected shape \(B, C, H, W\), got 3 dim",
    ),
    (
        lambda: filters.gaussian_blur2d(X, 3, torch.ones(3)),
        ValueError,
        r"sigma: expected shape \(B, 2\), got \[3\]",
    ),
    (lambda: filters.get_gaussian_kernel1d(4, 1.0), ValueError, "kernel_size: expected .* got 4"),
    (lambda: filters.sobel(BYTES.int()), TypeError, "input: expected a floating-point or uint8"),
    (lambda: filters.bilateral_blur(X, 3, 0.1, torch.ones(1, 3)), ValueError, "sigma_space: expected shape"),
    (
        lambda: morphology.dilation(X, torch.ones(3)),
        ValueError,
        r"kernel: expected shape \(kh, kw\), got \[3\]",
    ),
    (
        lambda: morphology.dilation(X, torch.ones(3, 3), torch.ones(3, 2)),
        ValueError,
        "structuring_element: expected",
    ),
    (lambda: transform.resize(X, 4, "nearest", antialias=True), ValueError, "antialias: expected False"),
    (
        lambda: transform.warp_perspective(X, EYE[0], (4, 4)),
        ValueError,
        r"M: expected shape \(B, 3, 3\), got \[3, 3\]",
    ),
    (lambda: transform.warp_perspective(X, EYE.int(), (4, 4)), TypeError, "M: expected a floating-point"),
    (
        lambda: transform.warp_perspective(X, EYE, (4, 4), "bilinear", "fill", True, torch.ones(1, 3)),
        ValueError,
        "fill_value: expected shape",
    ),
    (
        lambda: transform.warp_affine(X, EYE, (4, 4)),
        ValueError,
        r"M: expected shape \(B, 2, 3\), got \[1, 3, 3\]",
    ),
    (lambda: transform.warp_affine(X[0], EYE[:, :2], (4, 4)), ValueError, "src: expected shape"),
    (lambda: transform.affine(X, EYE), ValueError, r"matrix: expected shape \(B, 2, 3\)"),
    (lambda: transform.rotate(X, X), ValueError, r"angle: expected shape \(B,\)"),
    (lambda: transform.rotate(X, EYE[0, 0], EYE), ValueError, "center: expected shape"),
    (lambda: transform.scale(X, EYE[0]), ValueError, r"scale_factor: expected shape \(\*, 2\)"),
    (lambda: transform.translate(X, EYE[0, 0]), ValueError, "translation: expected shape"),
    (lambda: transform.shear(X, EYE[0, 0]), ValueError, "shear: expected shape"),
    (lambda: transform.remap(X, EYE[0], EYE), ValueError, r"map_x: expected shape \(B, h, w\)"),
    (lambda: transform.remap(X, EYE, EYE.int()), TypeError, "map_y: expected a floating-point"),
    (
        lambda: transform.homography_warp(X, EYE[:, :2], (4, 4)),
        ValueError,
        r"src_homo_dst: expected shape \(B, 3, 3\)",
    ),
    (lambda: transform.warp_grid(X, EYE), ValueError, r"grid: expected shape \(\*, 2\)"),
    (lambda: transform.elastic_transform2d(X, X), ValueError, r"noise: expected shape \(B, 2, H, W\)"),
    (lambda: transform.get_rotation_matrix2d(EYE, EYE, EYE), ValueError, "center: expected shape"),
    (
        lambda: transform.get_perspective_transform(EYE, EYE),
        ValueError,
        r"points_src: expected shape \(B, 4, 2\)",
    ),
    (lambda: transform.invert_affine_transform(EYE), ValueError, "matrix: expected shape"),
    (lambda: transform.projection_from_Rt(EYE, EYE), ValueError, r"tvec: expected shape \(\*, 3, 1\)"),
    (lambda: transform.transpose(X[0, 0, 0]), ValueError, r"input: expected shape \(\*, H, W\)"),
    (lambda: transform.hflip(X[0, 0, 0]), ValueError, r"input: expected shape \(\*, H, W\)"),
    (lambda: transform.crop_and_resize(X, EYE, (4, 4)), ValueError, r"boxes: expected shape \(B, 4, 2\)"),
    (lambda: transform.crop_by_boxes(X, EYE, EYE), ValueError, r"src_box: expected shape \(B, 4, 2\)"),
    (lambda: transform.crop_by_indices(X, EYE), ValueError, r"src_box: expected shape \(B, 4, 2\)"),
    (
        lambda: transform.crop_by_indices(X, X[:, 0, :4, :2], (4, 4), antialias=True),
        ValueError,
        "antialias: expected False",
    ),
    (
        lambda: transform.warp_affine3d(X, EYE, (2, 2, 2)),
        ValueError,
        r"src: expected shape \(B, C, D, H, W\)",
    ),
    (lambda: transform.warp_affine3d(X[None], EYE, (2, 2, 2)), ValueError, r"M: expected shape \(B, 3, 4\)"),
    (lambda: transform.warp_grid3d(X, EYE), ValueError, r"grid: expected shape \(\*, 3\)"),
    (lambda: transform.get_perspective_transform3d(EYE, EYE), ValueError, r"src: expected shape \(B, 8, 3\)"),
    (lambda: transform.get_tps_transform(EYE, EYE), ValueError, r"points_src: expected shape \(B, N, 2\)"),
    (
        lambda: transform.get_tps_transform(EYE[:, :2, :2], EYE[:, :2, :2]),
        ValueError,
        "points_src: expected at least 3 points, got 2",
    ),
    (
        lambda: transform.warp_points_tps(EYE[..., :2], EYE[..., :2], EYE[..., :2], EYE),
        ValueError,
        r"affine_weights: expected shape \(B, 3, 2\)",
    ),
    (lambda: homography.find_homography_dlt(X[0], X[0, :, :, :2]), ValueError, "points1: expected shape"),
    (
        lambda: homography.find_homography_dlt(X[0, :, :, :2], X[0, :, :4, :2]),
        ValueError,
        "points2: expected as many",
    ),
    (
        lambda: homography.find_homography_dlt(X[0, :, :3, :2], X[0, :, :3, :2]),
        ValueError,
        "points1: expected at least 4",
    ),
    (
        lambda: homography.find_homography_dlt(X[0, :, :, :2], X[0, :, :, :2], X),
        ValueError,
        "weights: expected shape",
    ),
    (
        lambda: conversions.axis_angle_to_quaternion(torch.zeros(4)),
        ValueError,
        r"axis_angle: expected shape \(\*, 3\)",
    ),
    (
        lambda: conversions.quaternion_to_axis_angle(torch.zeros(3)),
        ValueError,
        r"quaternion: expected shape \(\*, 4\)",
    ),
    (
        lambda: conversions.rotation_matrix_to_quaternion(torch.zeros(3, 4)),
        ValueError,
        "rotation_matrix: expected shape",
    ),
    (
        lambda: conversions.normalize_quaternion(torch.zeros(4).int()),
        TypeError,
        "quaternion: expected a floating-point",
    ),
    (lambda: subpix.nms3d(X, 3), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (lambda: subpix.spatial_softmax2d(BYTES), TypeError, "input: expected a floating-point"),
    (
        lambda: subpix.spatial_soft_argmax2d(X, torch.ones(3)),
        ValueError,
        r"temperature: expected one positive number, got shape \[3\]",
    ),
    (lambda: subpix.spatial_expectation2d(X[0]), ValueError, "input: expected shape"),
    (
        lambda: subpix.render_gaussian2d(EYE, EYE[..., :2], (4, 4)),
        ValueError,
        r"mean: expected shape \(\*, 2\)",
    ),
    (
        lambda: subpix.conv_soft_argmax2d(X, (3, 11), padding=(1, 1)),
        ValueError,
        r"kernel_size: expected no more than the padded input's \[1, 10, 10\]",
    ),
    (lambda: subpix.conv_soft_argmax3d(X), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (lambda: subpix.conv_quad_interp3d(X), ValueError, r"input: expected shape \(B, C, D, H, W\)"),
    (
        lambda: subpix.conv_quad_interp3d(X[None], precomputed_nms_mask=X[None]),
        TypeError,
        "precomputed_nms_mask: expected dtype torch.bool",
    ),
    (
        lambda: subpix.iterative_quad_interp3d(X[None], precomputed_nms_mask=X > 0),
        ValueError,
        "precomputed_nms_mask: expected input's shape",
    ),
    (lambda: feature.harris_response(X, sigmas=torch.ones(1, 1)), ValueError, "sigmas: expected shape"),
    (lambda: feature.harris_keypoints(X, 4), ValueError, r"input: expected shape \(B, 1, H, W\)"),
    (
        lambda: enhance.sharpness(X, torch.ones(1, 1, 8, 1)),
        ValueError,
        r"factor: expected a number, or a tensor .* broadcasts against \[1, 3, 6, 6\], got \[1, 1, 8, 1\]",
    ),
    (
        lambda: enhance.adjust_saturation(X, torch.ones(1, 3, 1, 1)),
        ValueError,
        r"factor: expected one for the three channels, got shape \[1, 3, 1, 1\]",
    ),
    (
        lambda: filters.get_gabor_kernel2d(3, torch.ones(2), 0.0, torch.ones(3)),
        ValueError,
        r"lambd: expected a shape that broadcasts with sigma's \[2, 1\], got \[3, 1\]",
    ),
    (
        lambda: filters.get_motion_kernel3d(3, EYE[0], torch.ones(2)),
        ValueError,
        r"direction: expected leading dimensions that broadcast with angle's \[3, 3\], got \[2, 1\]",
    ),
    (
        lambda: filters.gaussian(3, torch.ones(1, 2)),
        ValueError,
        r"sigma: expected shape \(B,\) or \(B, 1\), got \[1, 2\]",
    ),
    (
        lambda: conversions.pol2cart(torch.ones(2), torch.ones(3)),
        ValueError,
        r"phi: expected a shape that broadcasts with rho's \[2\], got \[3\]",
    ),
    (
        lambda: epipolar.sampson_epipolar_distance(X[0, ..., :2], X[0, ..., :2], X[0, :2, :3, :3]),
        ValueError,
        r"Fm: expected leading dimensions that broadcast with pts1's \[3, 8, 2\], got \[2, 3, 3\]",
    ),
    (
        lambda: epipolar.triangulate_points(
            EYE.new_zeros(3, 4), X[:, 0, :3, :4], EYE[0, :, :2], EYE[0, :, :2]
        ),
        ValueError,
        r"points2: expected with P2 the dimensions of points1 with P1, \[3\], got \[1, 3\]",
    ),
    (
        lambda: epipolar.motion_from_essential_choose_solution(
            EYE[0], EYE[0], EYE[0], EYE[..., :2], EYE[..., :2]
        ),
        ValueError,
        r"x1: expected leading dimensions that expand to E_mat's \[3, 3\], got \[1, 3, 2\]",
    ),
    (lambda: metrics.ssim(X, X[0], 5), ValueError, "img2: expected shape"),
    (
        lambda: transform.Affine(angle=torch.zeros(3))(X.expand(2, -1, -1, -1)),
        ValueError,
        r"angle: expected one, or one for each sample of input \[2, .*\], got \[3\]",
    ),
    (warped_by_two_grids, ValueError, "patch_src: expected an image for each of precompute_warp_grid's 2"),
    (
        lambda: pipelines.preprocess(FRAME.float()),
        TypeError,
        "frame: expected dtype torch.uint8, got torch.float32",
    ),
    (
        lambda: pipelines.edges(FRAME[..., :2]),
        ValueError,
        r"frame: expected shape \(H, W, 3\), got \[8, 8, 2\]",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_script_raises_the_same_message() -> None:
    with pytest.raises(torch.jit.Error, match="input: expected a floating-point or uint8 tensor"):
        torch.jit.script(filters.sobel)(BYTES.int())


def test_script_names_shapes_that_do_not_broadcast() -> None:
    with pytest.raises(torch.jit.Error, match="phi: expected a shape that broadcasts with rho's"):
        torch.jit.script(conversions.pol2cart)(torch.ones(2), torch.ones(3))


def test_unknown_target() -> None:
    with pytest.raises(ValueError, match="target: expected one of"), exporting("webgpu"):
        pass


@pytest.mark.parametrize(
    ("border", "window", "size", "least"),
    [("reflect", 5, 2, 3), ("reflect", 4, 2, 3), ("circular", 7, 2, 3)],
)
def test_images_too_small_for_their_border(border: str, window: int, size: int, least: int) -> None:
    kernel = torch.ones(window, window)
    scripted = torch.jit.script(filters.filter2d)
    for axis, name in ((2, "rows"), (3, "columns")):
        small = torch.zeros(1, 1, 9, 9).narrow(axis, 0, size)
        message = (
            f"input: expected at least {least} {name} for the border '{border}' and a window of {window},"
            f" got {size}"
        )
        with pytest.raises(ValueError, match=message):
            filters.filter2d(small, kernel, border)
        with pytest.raises(torch.jit.Error, match=message):
            scripted(small, kernel, border)
        for target in ("native", "cuda", "onnx", "vjp"):
            with exporting(target), pytest.raises(ValueError, match=message):
                padded(small, centred(window), centred(window), border)
        enough = torch.zeros(1, 1, 9, 9).narrow(axis, 0, least)
        assert filters.filter2d(enough, kernel, border).shape == enough.shape


def test_volumes_too_small_for_their_border() -> None:
    volume, kernel = torch.zeros(1, 1, 2, 9, 9), torch.ones(5, 5, 5)
    with pytest.raises(
        ValueError, match=r"input: expected at least 3 slices for the border 'reflect'.*got 2"
    ):
        filters.filter3d(volume, kernel, "reflect")
    assert filters.filter3d(volume, kernel, "constant").shape == volume.shape


def test_windows_inside_of_a_smaller_image() -> None:
    with pytest.raises(ValueError, match=r"input: expected at least 5 columns for a window inside it, got 4"):
        filters.filter2d(torch.zeros(1, 1, 9, 4), torch.ones(5, 5), padding="valid")
    with pytest.raises(ValueError, match=r"input: expected at least 7 rows for a window inside it, got 4"):
        filters.filter2d_separable(torch.zeros(1, 1, 4, 9), torch.ones(5), torch.ones(7), padding="valid")
    with pytest.raises(ValueError, match=r"input: expected at least 16 rows for a window inside it, got 15"):
        feature.dense_sift(torch.zeros(1, 1, 15, 20))


@pytest.mark.parametrize(("border", "lowest"), [("reflect", 3), ("circular", 3), ("replicate", 1)])
def test_the_check_of_a_border_leaves_symbols_alone(border: str, lowest: int) -> None:
    sides = {i: torch.export.Dim(s, min=lowest, max=4096) for i, s in ((2, "H"), (3, "W"))}
    program = torch.export.export(
        filters.BoxBlur((5, 5), border), (torch.zeros(2, 3, 24, 31),), dynamic_shapes={"input": sides}
    )
    assert {(int(r.lower), int(r.upper)) for r in program.range_constraints.values()} == {(lowest, 4096)}
    assert not [n for n in program.graph.nodes if "assert" in str(n.target)]


@pytest.mark.parametrize(
    ("error", "message", "call"),
    [
        (
            ValueError,
            r"frame: expected at least one pixel, got \[1, 0, 8, 3\]",
            lambda: pipelines.letterbox(FRAME[None, :0]),
        ),
        (
            ValueError,
            r"kernel: expected at least one pixel, got \[0, 3\]",
            lambda: morphology.dilation(X, torch.ones(0, 3)),
        ),
        (
            ValueError,
            r"tensor: expected at least one image, got \[0, 3, 8, 8\]",
            lambda: image.make_grid(X[:0]),
        ),
        *[
            (
                ValueError,
                r"input: expected an image for 2 boxes, got \[0, 3, 8, 8\]",
                lambda f=f: f(X[:0], torch.zeros(2, 5), 1),
            )
            for f in (ops.roi_align, ops.roi_pool, ops.ps_roi_align, ops.ps_roi_pool)
        ],
        (
            ValueError,
            r"input: expected sizes of at least 1, got \[1, 3, 0, 8\]",
            lambda: ops.roi_pool(X[:, :, :0], torch.zeros(2, 5), 1),
        ),
    ],
)
def test_empty_tensors_and_short_settings(error: type[Exception], message: str, call: Callable) -> None:
    with pytest.raises(error, match=f"^{message}"):
        call()


SEED = torch.zeros(1, dtype=torch.int64)
RANGE = "expected 2 numbers, got"


@pytest.mark.parametrize(
    ("error", "message", "call"),
    [
        (ValueError, f"degrees: {RANGE} 1", lambda: augmentation.random_affine(X, SEED, (3.0,))),
        (ValueError, f"scale: {RANGE} 0", lambda: augmentation.random_affine(X, SEED, (0.0, 1.0), scale=())),
        (
            TypeError,
            f"scale_y: {RANGE} dict",
            lambda: augmentation.random_affine(X, SEED, (0.0, 1.0), scale_y={}),
        ),
        (ValueError, f"degrees: {RANGE} 1", lambda: augmentation.random_rotation(X, SEED, (3.0,))),
        (TypeError, f"brightness: {RANGE} float", lambda: augmentation.random_brightness(X, SEED, 3.0)),
        (TypeError, f"brightness: {RANGE} str", lambda: augmentation.random_brightness(X, SEED, "ab")),
        (ValueError, f"brightness: {RANGE} 1", lambda: augmentation.random_brightness(X, SEED, (1.0,))),
        (
            ValueError,
            "padding: expected 4 numbers, got 2",
            lambda: augmentation.random_crop(X, SEED, (2, 2), (1, 1)),
        ),
        (
            TypeError,
            "structuring_element: expected a tensor, got list",
            lambda: morphology.dilation(X, EYE[0], structuring_element=[1.0]),
        ),
        (ValueError, "origin: expected 2 numbers, got 1", lambda: morphology.dilation(X, EYE[0], origin=[1])),
        (TypeError, "kernel: expected a tensor, got int", lambda: morphology.reconstruction(X, X, kernel=3)),
        (
            TypeError,
            "rgb_weights: expected a tensor, got tuple",
            lambda: color.rgb_to_grayscale(X, (1.0, 1.0, 1.0)),
        ),
        (
            TypeError,
            "weights: expected a tensor, got float",
            lambda: epipolar.normalize_points(torch.zeros(1, 4, 2), weights=1.0),
        ),
        (
            ValueError,
            "dsize_dst: expected 2 numbers, got 1",
            lambda: conversions.normalize_homography(EYE, (3, 3), (3,)),
        ),
        (
            TypeError,
            "stride: expected 3 numbers, got int",
            lambda: subpix.conv_soft_argmax3d(X[None], (3, 3, 3), 1),
        ),
        (
            TypeError,
            "alpha: expected 2 numbers, got float",
            lambda: transform.elastic_transform2d(X, torch.zeros(1, 2, 8, 8), alpha=1.0),
        ),
        (ValueError, f"times: {RANGE} 1", lambda: augmentation.random_rotation90(X, SEED, (1,))),
        (TypeError, f"grid: {RANGE} int", lambda: augmentation.random_jigsaw(X, SEED, 2)),
        (ValueError, f"bits: {RANGE} 1", lambda: augmentation.random_posterize(X, SEED, (3,))),
        (TypeError, f"drop_width: {RANGE} int", lambda: augmentation.random_rain(X, SEED, drop_width=1)),
        (
            TypeError,
            f"degrees: {RANGE} float",
            lambda: augmentation.random_rotation3d(X[None], SEED, [1.0, 1.0, 1.0]),
        ),
        (TypeError, f"K: {RANGE} float", lambda: losses.ms_ssim_loss(X, X, [0.5], K=0.01)),
        (
            TypeError,
            f"normalize_range: {RANGE} float",
            lambda: contrib.diamond_square(X, normalize_range=1.0),
        ),
        (
            ValueError,
            r"kernel: expected at least one number, got \[0, 3\]",
            lambda: filters.filter2d(X, torch.zeros(0, 3)),
        ),
        (
            ValueError,
            r"kernel_y: expected at least one number, got \[0\]",
            lambda: filters.filter2d_separable(X, torch.ones(3), torch.ones(0)),
        ),
        (
            TypeError,
            f"size: {RANGE} int",
            lambda: ops.decode_detr(torch.zeros(1, 2, 3), torch.zeros(1, 2, 4), 8, 1),
        ),
    ],
)
def test_what_is_no_pair_is_named(error: type[Exception], message: str, call: Callable) -> None:
    with pytest.raises(error, match=f"^{message}"):
        call()
