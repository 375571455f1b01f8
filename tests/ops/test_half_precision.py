"""Losses and similarities of float16 and bfloat16, of images as large as those of training, are what float64
gives for the same numbers, rounded once. Features, tiles, boxes, colours, filters, geometry and metrics are
what float32 gives for them; positions, and what the dtype cannot have, are float32."""

import inspect
from collections.abc import Callable
from typing import Any

import pytest
import torch
from torch import Tensor

from chiasm import augmentation as A
from chiasm import color, feature, filters, geometry, losses, metrics, ops
from chiasm.geometry import conversions, depth, epipolar, homography, linalg
from chiasm.primitives.random.draws import uniform

SIZE = 300
#: Twice what rounding the result changes.
DTYPES = {torch.float16: 1e-3, torch.bfloat16: 8e-3}


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


PLANES = (rand(1, 1, SIZE, SIZE), rand(1, 1, SIZE, SIZE, seed=1))
BRIGHT = tuple(255.0 * plane for plane in PLANES)
#: Neighbours of float16: the squares of their differences are below its least number.
DARK = (PLANES[0] / 16.0, PLANES[0] / 16.0 + 2.0**-14)
VOLUMES = tuple(255.0 * rand(1, 1, 6, SIZE, SIZE, seed=seed) for seed in (2, 3))
#: Many of the numbers are near the least of float16, and some are below it.
HEATMAPS = tuple(2.0 * plane**4 / (SIZE * SIZE) for plane in PLANES)
LOGITS = 6.0 * rand(1, 3, SIZE, SIZE, seed=4) - 3.0
LABELS = torch.randint(0, 3, (1, SIZE, SIZE), generator=torch.Generator().manual_seed(5))
MARKS = losses.one_hot(LABELS, 3, dtype=torch.int64)

CASES: dict[str, tuple[Callable[..., Tensor], tuple[Tensor, ...]]] = {
    "binary_focal_loss_with_logits": (
        lambda p: losses.binary_focal_loss_with_logits(p, MARKS, reduction="mean"),
        (LOGITS,),
    ),
    "cauchy_loss": (losses.cauchy_loss, BRIGHT),
    "charbonnier_loss": (losses.charbonnier_loss, BRIGHT),
    "dice_loss": (lambda p: losses.dice_loss(p, LABELS), (LOGITS,)),
    "dice_loss macro": (lambda p: losses.dice_loss(p, LABELS, "macro"), (LOGITS,)),
    "focal_loss": (lambda p: losses.focal_loss(p, LABELS, 0.25, reduction="mean"), (LOGITS,)),
    "focal_loss none": (lambda p: losses.focal_loss(p, LABELS, 0.25), (LOGITS,)),
    "geman_mcclure_loss": (losses.geman_mcclure_loss, BRIGHT),
    "hausdorff_er_loss": (lambda p: losses.hausdorff_er_loss(p, LABELS[:, None]), (LOGITS.softmax(1),)),
    "hausdorff_er_loss map": (
        lambda p: losses.hausdorff_er_loss(p, LABELS[:, None], reduction="none"),
        (LOGITS.softmax(1),),
    ),
    "hausdorff_er_loss3d": (
        lambda p: losses.hausdorff_er_loss3d(p, LABELS[:, None, None].expand(-1, -1, 6, -1, -1), k=4),
        (VOLUMES[0].expand(-1, 3, -1, -1, -1) / 255.0,),
    ),
    "inverse_depth_smoothness_loss": (losses.inverse_depth_smoothness_loss, PLANES),
    "js_div_loss_2d": (losses.js_div_loss_2d, HEATMAPS),
    "kl_div_loss_2d": (losses.kl_div_loss_2d, (HEATMAPS[0] + 2.0**-20, HEATMAPS[1])),
    "lovasz_hinge_loss": (lambda p: losses.lovasz_hinge_loss(p[:, :1], LABELS), (LOGITS,)),
    "lovasz_softmax_loss": (lambda p: losses.lovasz_softmax_loss(p, LABELS), (LOGITS,)),
    "ms_ssim_loss": (lambda p, q: losses.ms_ssim_loss(p, q, data_range=255.0), BRIGHT),
    "ms_ssim_loss map": (lambda p, q: losses.ms_ssim_loss(p, q, reduction="none"), PLANES),
    "mutual_information_loss": (
        lambda p, q: losses.mutual_information_loss(p.flatten(1), q.flatten(1)),
        PLANES,
    ),
    "mutual_information_loss_2d": (losses.mutual_information_loss_2d, PLANES),
    "mutual_information_loss_3d": (losses.mutual_information_loss_3d, VOLUMES),
    "normalized_mutual_information_loss": (
        lambda p, q: losses.normalized_mutual_information_loss(p.flatten(1), q.flatten(1)),
        PLANES,
    ),
    "normalized_mutual_information_loss_2d": (losses.normalized_mutual_information_loss_2d, PLANES),
    "normalized_mutual_information_loss_3d": (losses.normalized_mutual_information_loss_3d, VOLUMES),
    "psnr_loss": (lambda p, q: losses.psnr_loss(p, q, 1.0), DARK),
    "ssim3d_loss": (lambda p, q: losses.ssim3d_loss(p, q, 5, 255.0), VOLUMES),
    "ssim_loss": (lambda p, q: losses.ssim_loss(p, q, 11, 255.0), BRIGHT),
    "total_variation": (losses.total_variation, (PLANES[0] / 2.0,)),
    # Two neighbours that are farther apart than float16 reaches.
    "total_variation mean": (
        lambda p: losses.total_variation(p, "mean"),
        (60000.0 * ((torch.arange(SIZE) == 7).double() - (torch.arange(SIZE) == 8).double()).expand(9, -1),),
    ),
    "tversky_loss": (lambda p: losses.tversky_loss(p, LABELS, 0.3, 0.7), (LOGITS,)),
    "tversky_loss micro": (lambda p: losses.tversky_loss(p, LABELS, 0.3, 0.7, average="micro"), (LOGITS,)),
    "welsch_loss": (losses.welsch_loss, PLANES),
    "metrics.psnr": (lambda p, q: metrics.psnr(p, q, 1.0), DARK),
    "metrics.ssim": (lambda p, q: metrics.ssim(p, q, 11, 255.0), BRIGHT),
    "metrics.ssim dark": (lambda p, q: metrics.ssim(p, q, 11), DARK),
    "metrics.ssim3d": (lambda p, q: metrics.ssim3d(p, q, 5, 255.0), VOLUMES),
}


def test_every_loss_is_here() -> None:
    functions = {name for name in losses.__all__ if inspect.isfunction(getattr(losses, name))}
    assert functions - {"one_hot"} == {name.partition(" ")[0] for name in CASES if "." not in name}


@pytest.mark.parametrize(("dtype", "tolerance"), DTYPES.items(), ids=str)
@pytest.mark.parametrize(("loss", "given"), CASES.values(), ids=CASES)
def test_half_precision_is_float64_rounded(
    loss: Callable[..., Tensor], given: tuple[Tensor, ...], dtype: torch.dtype, tolerance: float
) -> None:
    narrow = [value.to(dtype).requires_grad_() for value in given]
    exact = loss(*[value.detach().double() for value in narrow])
    actual = loss(*narrow)
    assert actual.dtype == dtype
    torch.testing.assert_close(actual.double(), exact, rtol=tolerance, atol=1e-6)
    actual.float().mean().backward()
    for value in narrow:
        assert torch.isfinite(value.grad).all()


#: Their differences are exact.
LEVELS = tuple(plane.round() for plane in BRIGHT)
SMALL = rand(2, 1, 40, 44, seed=6)
PATCHES = rand(9, 1, 16, 16, seed=7) / 128.0
FRAMES = 300.0 * (rand(2, 7, 2, 3, seed=8) - 0.5) * (torch.arange(7) % 3 > 0)[:, None, None]
BOXES = torch.stack([400.0 * rand(9, seed=s) + 50.0 * (s < 11) + 100.0 * (s > 10) for s in range(9, 14)], -1)
TURNS = torch.linalg.matrix_exp(torch.tensor([0.3, 0.306, 2.0])[:, None, None].double() * torch.tensor(
    [[0.0, -0.6, 0.8], [0.6, 0.0, 0.0], [-0.8, 0.0, 0.0]], dtype=torch.float64
))  # fmt: skip
WIDE = torch.nn.functional.pad(rand(1, 1, 20, 20, seed=15), [700, 60, 5, 6])
CAMERA = torch.tensor([[[500.0, 0.0, 150.0], [0.0, 480.0, 140.0], [0.0, 0.0, 1.0]]])
SLOPE = (torch.arange(60.0)[:, None] + torch.arange(70.0))[None, None]
PIXELS = 300.0 * rand(1, 40, 2, seed=18)
PERSPECTIVE = torch.tensor([[[1.1, 0.1, -9.0], [-0.1, 0.9, 7.0], [1e-4, 2e-4, 1.0]]])
ESSENTIAL = torch.tensor([[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]])
COLOURS = rand(1, 3, 20, 20, seed=19) * rand(1, 1, 20, 20, seed=20)
UNITS = torch.nn.functional.normalize(
    torch.cat([torch.eye(4), -torch.eye(4), torch.zeros(1, 4), rand(9, 4, seed=23) - 0.5]), dim=-1
)

#: An op, its arguments, and for each floating-point output whether it has their dtype; else it is float32.
OTHERS: dict[str, tuple[Callable[..., object], tuple[Tensor, ...], list[bool]]] = {
    "affine_shape": (feature.affine_shape, (PATCHES,), [True]),
    "dense_sift": (feature.dense_sift, (SMALL / 128.0,), [True]),
    "dominant_orientation": (feature.dominant_orientation, (PATCHES,), [True]),
    "gftt_response": (feature.gftt_response, (8.0 * SMALL,), [True]),
    "harris_response": (feature.harris_response, (8.0 * SMALL,), [True]),
    "hessian_response": (feature.hessian_response, (8.0 * SMALL,), [True]),
    "make_upright": (feature.make_upright, (FRAMES,), [True]),
    "sift_describe": (feature.sift_describe, (PATCHES,), [True]),
    "detect_keypoints": (lambda x: feature.detect_keypoints(x, 20), (WIDE,), [False, True]),
    "detect_keypoints double": (
        lambda x: feature.detect_keypoints(x, 20, "dog", mr_size=1.0, double_image=True),
        (WIDE,),
        [False, True],
    ),
    "harris_keypoints": (lambda x: feature.harris_keypoints(x, 20), (WIDE,), [False, True]),
    "index_proposal": (lambda x: feature.index_proposal(x, 8), (WIDE,), [False, True]),
    "multi_scale_index_proposal": (
        lambda x: feature.multi_scale_index_proposal(x, [8, 16]),
        (WIDE,),
        [False, True],
    ),
    "decode_db": (lambda x: ops.decode_db(x, box_threshold=0.1), (WIDE,), [False, True]),
    "merge": (lambda x: ops.merge(x, (44, 44), 30), (rand(2, 25, 1, 33, 33, seed=16),), [True]),
    "rotated_iou": (ops.rotated_iou, (BOXES, BOXES + 20.0), [False]),
    "aepe": (metrics.aepe, (600.0 * (rand(50, 2) - 0.5), 600.0 * (rand(50, 2, seed=1) - 0.5)), [True]),
    "aepe sum": (
        lambda a, b: metrics.aepe(a, b, "sum"),
        tuple(torch.nn.functional.pad(x[..., None], [0, 1]) for x in LEVELS),
        [False],
    ),
    "angle_error_mat": (lambda r: metrics.angle_error_mat(r[1:], r[:-1]), (TURNS,), [True]),
    "angle_error_vec": (
        lambda a: metrics.angle_error_vec(a, a.flip(-1)),
        (torch.tensor([[6e4, 1e3, 0.0], [1e-4, 3e-5, 0.0], [0.0, 0.0, 0.0]]),),
        [True],
    ),
    "mean_absolute_disparity_error sum": (
        lambda a, b: metrics.mean_absolute_disparity_error(a, b, reduction="sum"),
        LEVELS,
        [False],
    ),
    "root_mean_squared_disparity_error sum": (
        lambda a, b: metrics.root_mean_squared_disparity_error(a, b, reduction="sum"),
        LEVELS,
        [False],
    ),
    "mean_bad_pixel_error sum": (
        lambda a, b: metrics.mean_bad_pixel_error(a, b, reduction="sum"),
        LEVELS,
        [False],
    ),
    "kitti_d1_error sum": (lambda a, b: metrics.kitti_d1_error(a, b, reduction="sum"), LEVELS, [False]),
    "depth_to_normals": (depth.depth_to_normals, (100.0 + 0.05 * SLOPE, CAMERA), [True]),
    "depth_to_normals unit": (
        lambda z, k: depth.depth_to_normals(z, k, True),
        (100.0 + 0.05 * SLOPE, CAMERA),
        [True],
    ),
    "fundamental_from_essential": (epipolar.fundamental_from_essential, (ESSENTIAL, CAMERA, CAMERA), [True]),
    "get_closest_point_on_epipolar_line": (
        epipolar.get_closest_point_on_epipolar_line,
        (PIXELS, PIXELS + 20.0, torch.tensor([[[0.0, -1e-3, 0.3], [1e-3, 0.0, 0.2], [-0.3, 0.1, 1.0]]])),
        [True],
    ),
    "lab_to_rgb": (lambda x: color.lab_to_rgb(x, False), (color.rgb_to_lab(COLOURS),), [True]),
    "line_segment_transfer_error_one_way": (
        homography.line_segment_transfer_error_one_way,
        (PIXELS.reshape(1, -1, 2, 2), PIXELS.reshape(1, -1, 2, 2) + 20.0, PERSPECTIVE),
        [True],
    ),
    "luv_to_rgb": (color.luv_to_rgb, (color.rgb_to_luv(COLOURS),), [True]),
    "motion_from_essential_choose_solution": (
        epipolar.motion_from_essential_choose_solution,
        (ESSENTIAL, CAMERA, CAMERA, PIXELS, PIXELS - torch.tensor([9.0, 0.0])),
        [True, True, True],
    ),
    "non_local_means": (lambda x: filters.non_local_means(x, 3, 5, 0.3), (SMALL,), [True]),
    "normalize_points": (epipolar.normalize_points, (PIXELS,), [True, True]),
    "normalize_points weights": (
        lambda x, w: epipolar.normalize_points(x, weights=w),
        (PIXELS, rand(1, 40, seed=22)),
        [True, True],
    ),
    "normalize_quaternion": (
        conversions.normalize_quaternion,
        (torch.tensor([[0.0, 0.0, 0.0, 0.0], [300.0, 200.0, -100.0, 50.0], [1e-5, 3e-5, 0.0, 0.0]]),),
        [True],
    ),
    "oneway_transfer_error": (
        lambda a, b, h: homography.oneway_transfer_error(a, b, h, False),
        (PIXELS, PIXELS + 300.0, PERSPECTIVE),
        [True],
    ),
    "point_line_distance": (
        linalg.point_line_distance,
        (PIXELS[0], torch.tensor([[300.0, 200.0, -900.0]] * 39 + [[0.0, 0.0, 0.0]])),
        [True],
    ),
    "project_points": (
        geometry.camera.project_points,
        (
            torch.cat([PIXELS[0] / 300.0, 1.0 + rand(40, 1, seed=21)], -1) * (torch.arange(40) > 0)[:, None],
            CAMERA,
        ),
        [True],
    ),
    "quaternion_exp_to_log": (conversions.quaternion_exp_to_log, (UNITS,), [True]),
    "quaternion_to_axis_angle": (conversions.quaternion_to_axis_angle, (UNITS,), [True]),
    "rgb_to_lab": (color.rgb_to_lab, (COLOURS,), [True]),
    "rgb_to_luv": (color.rgb_to_luv, (COLOURS,), [True]),
    "roberts": (filters.roberts, BRIGHT[:1], [True]),
    "roberts plain": (lambda x: filters.roberts(x, False), BRIGHT[:1], [True]),
    "sampson_homography_distance": (
        lambda a, b, h: homography.sampson_homography_distance(a, b, h, False),
        (PIXELS, PIXELS + 300.0, PERSPECTIVE),
        [True],
    ),
    "symmetric_transfer_error": (
        lambda a, b, h: homography.symmetric_transfer_error(a, b, h, False),
        (PIXELS, PIXELS + 300.0, PERSPECTIVE),
        [True],
    ),
    "translation_ate": (metrics.translation_ate, (600.0 * rand(50, 3), 1e-4 * rand(50, 3, seed=1)), [True]),
}


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize(("op", "given", "narrow"), OTHERS.values(), ids=OTHERS)
def test_half_precision_is_float32_rounded(
    op: Callable[..., object], given: tuple[Tensor, ...], narrow: list[bool], dtype: torch.dtype
) -> None:
    halves = [value.to(dtype) for value in given]
    actual, exact = op(*halves), op(*[value.float() for value in halves])
    parts = [p for p in (actual if isinstance(actual, tuple) else [actual]) if p.is_floating_point()]
    expected = [p for p in (exact if isinstance(exact, tuple) else [exact]) if p.is_floating_point()]
    for part, wanted, is_narrow in zip(parts, expected, narrow, strict=True):
        assert part.dtype == (dtype if is_narrow else torch.float32)
        assert wanted.isfinite().all() and wanted.any()
        torch.testing.assert_close(part, wanted.to(part.dtype), rtol=torch.finfo(part.dtype).eps, atol=0)


@pytest.mark.parametrize("track", [ops.sort_track, ops.byte_track])
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_tracks_of_half_precision_are_float32(track: Callable[..., Any], dtype: torch.dtype) -> None:
    """The area of this box is 360000, and float16 ends at 65504."""
    tracks = [torch.zeros(1, 2, 7, dtype=dtype), torch.zeros(1, 2, 7, 7, dtype=dtype)]
    counters, last = torch.zeros(1, 2, 4, dtype=torch.int64), torch.zeros(1, dtype=torch.int64)
    found, score = torch.tensor([[True]]), torch.tensor([[0.875]], dtype=dtype)
    for x in (100.0, 104.0, 108.0):
        box = torch.tensor([[[x, 100.0, x + 600.0, 700.0]]], dtype=dtype)
        scores = [score] if track is ops.byte_track else []
        *tracks, counters, last, boxes, _, shown = track(*tracks, counters, last, box, *scores, found)
        assert all(part.dtype == torch.float32 and part.isfinite().all() for part in (*tracks, boxes))
        torch.testing.assert_close(boxes[:, :1], box.float(), rtol=0, atol=0.1)
    assert shown.tolist() == [[True, False]] and counters[0, 0].tolist() == [1, 2, 3, 0]


def test_the_mean_of_many_halves() -> None:
    """A sum in float16 stays at 2048 if 1 is added."""
    for value in (1.0, torch.tensor(1.0, dtype=torch.float16), torch.tensor(1.0, dtype=torch.bfloat16)):
        meter = metrics.AverageMeter()
        for _ in range(5000):
            meter.update(value)
        assert meter.avg == 1.0 and meter.count == 5000


def test_whether_a_volume_is_changed_does_not_hang_on_its_dtype() -> None:
    seed, still = torch.arange(8), [(0.0, 0.0)] * 3
    volume = rand(1, 1, 3, 4, 5).to(torch.bfloat16)
    for i, u in enumerate(uniform(seed, 1)[:, 0].tolist()):
        for p, changed in ((u + 1e-5, True), (u - 1e-5, False)):
            out = A.random_motion_blur3d(volume, seed[i : i + 1], (3, 3), still, (0.0, 0.0), p=p)
            assert out.equal(volume) != changed and out.dtype == torch.bfloat16


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("align_corners", [True, False])
def test_positions_by_depth_of_half_precision(align_corners: bool, dtype: torch.dtype) -> None:
    """In half precision, columns beyond 256 or 2048 would be off by whole pixels."""
    image = torch.cat([PLANES[0]] * 8, -1).to(dtype)
    k = torch.tensor([[[512.0, 0.0, 1200.0], [0.0, 512.0, 150.0], [0.0, 0.0, 1.0]]], dtype=dtype)
    motion = torch.eye(4, dtype=dtype)[None].clone()
    motion[0, 0, 3] = 0.0625
    z = (4.0 + 4.0 * PLANES[1][:, :, :, :1].expand(-1, -1, -1, image.size(3))).to(dtype)

    def warped(image: Tensor, z: Tensor, motion: Tensor, k: Tensor) -> list[Tensor]:
        eye = torch.eye(4, dtype=motion.dtype)[None]
        return [
            depth.warp_frame_depth(image, z, motion, k),
            depth.warp_frame_depth(image, z, motion, k, True),
            depth.depth_warp(k, motion, k, eye, z, image, align_corners),
        ]

    given = (image, z, motion, k)
    for actual, expected in zip(warped(*given), warped(*[x.float() for x in given]), strict=True):
        assert actual.dtype == dtype and expected.any()
        torch.testing.assert_close(actual.float(), expected, rtol=0, atol=4 * torch.finfo(dtype).eps)
    for actual, expected in zip(warped(image, *[x.float() for x in given[1:]]), warped(*given), strict=True):
        assert actual.equal(expected)
