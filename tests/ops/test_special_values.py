"""NaN, infinity and values out of range in positions, indices and loops that depend on data."""

import math
import sys
from functools import partial

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from chiasm import color, contrib, enhance, filters, geometry, image, losses, morphology
from chiasm.geometry import ransac
from chiasm.geometry.transform import crop_by_indices, remap, warp_affine, warp_perspective
from chiasm.primitives.core.target import exporting
from chiasm.primitives.geometry.angles import angle_of
from chiasm.primitives.numbers.ranking import stable_topk
from chiasm.primitives.numbers.reductions import greatest, least
from chiasm.primitives.numbers.rounding import to_index
from chiasm.primitives.resampling.taps import bilinear_taps, cubic_taps, nearest_taps
from chiasm.primitives.resampling.volumes import resample_volume

SPECIAL = [math.nan, math.inf, -math.inf, 3e9, -3e9, 1e38, -1e38, torch.finfo(torch.float32).max, 0.0, 1e-40]
MODES = ["bilinear", "nearest", "bicubic"]
PADDINGS = ["zeros", "border", "reflection", "fill"]


@pytest.mark.parametrize("size", [1, 2, 7, 32768])
def test_an_index_is_in_range_whatever_the_number(size):
    x = torch.tensor([*SPECIAL, -0.5, 0.5, size - 0.5, size + 0.5])
    index = to_index(x, size)
    expected = [0 if math.isnan(v) else int(min(max(v, 0), size - 1)) for v in x.tolist()]
    assert index.dtype == torch.int64 and index.tolist() == expected


@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("mode", MODES)
def test_a_position_that_is_nan_reads_nothing(mode, padding):
    torch.manual_seed(0)
    picture = torch.rand(2, 3, 6, 8) + 1.0
    x, y = torch.full((2, 4, 5), 3.0), torch.full((2, 4, 5), 2.0)
    x[0, 1, 2], y[1, 3, 0] = math.nan, math.nan
    colour = torch.tensor([0.25, 0.5, 0.75]) if padding == "fill" else None
    out = warp(picture, x, y, mode, padding, colour)
    inside = picture[:, :, 2:3, 3:4].expand(2, 3, 4, 5).clone()
    nothing = torch.zeros(3) if colour is None else colour
    inside[0, :, 1, 2], inside[1, :, 3, 0] = nothing, nothing
    torch.testing.assert_close(out, inside)


def warp(picture, x, y, mode, padding, colour):
    from chiasm.primitives.resampling.warping import resample_image

    return resample_image(picture, x, y, mode, padding, True, colour)


@pytest.mark.parametrize("align_corners", [False, True])
@pytest.mark.parametrize("padding", ["zeros", "border", "reflection"])
def test_taps_lie_inside_the_image_wherever_the_position_is(padding, align_corners):
    x = torch.tensor(SPECIAL)[None, None]
    for y in x[0, 0]:
        taps = [bilinear_taps(x, y.expand_as(x), 5, 7), nearest_taps(x, y.expand_as(x), 5, 7)]
        for index, weight in [*taps, cubic_taps(x, y.expand_as(x), 5, 7, padding, align_corners)]:
            for i, w in zip(index, weight, strict=True):
                assert int(i.min()) >= 0 and int(i.max()) < 35
                assert bool(w.isfinite().all())


@pytest.mark.parametrize("value", SPECIAL)
@pytest.mark.parametrize("padding", ["zeros", "border", "reflection"])
@pytest.mark.parametrize("mode", MODES)
def test_warps_by_any_matrix_and_map_end_well(mode, padding, value):
    picture = torch.rand(1, 2, 9, 11)
    bound = 2.0 if mode == "bicubic" else 1.001  # a cubic overshoots
    for out in [
        warp_affine(picture, torch.full((1, 2, 3), value), (6, 7), mode, padding),
        warp_perspective(picture, torch.full((1, 3, 3), value), (6, 7), mode, padding),
        remap(picture, torch.full((1, 4, 5), value), torch.full((1, 4, 5), value), mode, padding),
    ]:
        assert bool((out.abs() < bound).all())


@pytest.mark.parametrize(
    "box",
    [
        (-5, 2, 3, 4),
        (3, -2, 40, 4),
        (30, 30, 50, 60),
        (-9, -9, -3, -2),
        (5, 5, 2, 1),
        (-(2**62), -(2**62), 2**62, 2**62),
    ],
)
@pytest.mark.parametrize("dtype", [torch.int64, torch.float64])
def test_a_box_beyond_the_image_is_cut_at_its_border(box, dtype):
    picture = torch.rand(1, 2, 10, 12)
    x0, y0, x1, y1 = box
    corners = torch.tensor([[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], dtype=dtype)
    left, top = int(np.clip(x0, 0, 11)), int(np.clip(y0, 0, 9))
    right, bottom = max(left, int(np.clip(x1, 0, 11))), max(top, int(np.clip(y1, 0, 9)))
    cut = picture[:, :, top : bottom + 1, left : right + 1]
    out = crop_by_indices(picture, corners, (7, 5), align_corners=True)
    torch.testing.assert_close(out, F.interpolate(cut, (7, 5), mode="bilinear", align_corners=True))


def test_boxes_of_nan_give_pixels_of_the_image():
    picture = torch.rand(1, 1, 6, 6)
    out = crop_by_indices(picture, torch.full((1, 4, 2), math.nan), (3, 3))
    torch.testing.assert_close(out, picture[:, :, :1, :1].expand(1, 1, 3, 3))


def test_the_distance_transform_ends_whatever_the_values():
    torch.manual_seed(0)
    for picture in [
        torch.randn(1, 1, 32, 32),
        torch.full((1, 1, 9, 9), math.nan),
        torch.randn(1, 1, 20, 20) * 1e30,
        torch.rand(1, 1, 16, 16) - 0.9,
    ]:
        assert contrib.distance_transform(picture).shape == picture.shape


@pytest.mark.parametrize("kernel_size, h", [(3, 0.35), (3, 0.01), (7, 0.2)])
def test_the_distance_transforms_bound_changes_nothing_of_a_shape(kernel_size, h, monkeypatch):
    """For a shape in one corner, and for greys, the result with the bound equals that without, even for a
    kernel whose diagonal underflows."""
    torch.manual_seed(0)
    corner = torch.zeros(1, 1, 23, 31)
    corner[0, 0, 0, 0] = 1.0
    pictures = [corner, corner * 1e-30, (torch.rand(1, 1, 17, 40) - 0.97).clamp(min=0.0)]
    bounded = [contrib.distance_transform(p, kernel_size, h) for p in pictures]
    module = sys.modules["chiasm.primitives.features.distances"]
    free = module._grown
    monkeypatch.setattr(module, "_grown", lambda state, limit, *fixed: free(state, 100_000, *fixed))
    for picture, result in zip(pictures, bounded, strict=True):
        assert torch.equal(result, contrib.distance_transform(picture, kernel_size, h))
    assert float(bounded[0][0, 0, -1, -1]) > 25


def test_a_reconstruction_without_the_kernels_centre_ends():
    seed = torch.zeros(1, 1, 8, 8)
    seed[..., ::2] = 1.0
    kernel = torch.tensor([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    assert morphology.reconstruction(seed, torch.ones(1, 1, 8, 8), kernel=kernel).shape == seed.shape


def test_a_reconstruction_follows_a_path_as_long_as_the_image_has_pixels():
    mask = torch.zeros(1, 1, 15, 15)
    mask[..., ::2, :] = 1.0
    mask[0, 0, 1::4, -1] = 1.0
    mask[0, 0, 3::4, 0] = 1.0
    seed = torch.zeros_like(mask)
    seed[0, 0, 0, 0] = 1.0
    assert torch.equal(morphology.reconstruction(seed, mask), mask)


@pytest.mark.parametrize("value", SPECIAL)
def test_images_of_any_value_count_somewhere(value):
    torch.manual_seed(0)
    picture = torch.rand(1, 1, 16, 16)
    picture[0, 0, 3, 4] = value
    for slow in [False, True]:
        filters.otsu_threshold(picture, 16, slow_and_differentiable=slow)
        enhance.equalize_clahe(picture, 2.0, (2, 2), slow_and_differentiable=slow)
    assert int(enhance.count_histogram(picture, 8).sum()) in (255, 256)
    assert color.apply_colormap(picture, "jet").shape == (1, 3, 16, 16)
    losses.mutual_information_loss(picture, picture)
    assert int(image.tensor_to_frames(picture).flatten()[3 * 16 + 4]) == (255 if value > 1 else 0)


@pytest.mark.parametrize("value", SPECIAL)
def test_random_numbers_of_any_value_draw_points(value):
    torch.manual_seed(0)
    points = torch.rand(1, 12, 2) * 50
    found = ransac.ransac_homography(points, points + 3.0, torch.full((1, 20, 4), value))
    assert all(isinstance(t, torch.Tensor) for t in found)


def test_points_that_are_nan_are_drawn_nowhere():
    blank = torch.zeros(1, 1, 6, 6)
    line = image.draw_line(
        blank,
        torch.tensor([[[math.nan, math.nan]]]),
        torch.tensor([[[math.nan, math.nan]]]),
        torch.tensor([1.0]),
    )
    assert torch.equal(line, blank)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_angles_in_onnx_are_those_of_atan2(dtype):
    values = [0.0, -0.0, 1.0, -1.0, 0.3, -2.5, 1e-30, 1e30, -1e30, math.inf, -math.inf, math.nan]
    y, x = (
        t.flatten()
        for t in torch.meshgrid(
            torch.tensor(values, dtype=dtype), torch.tensor(values, dtype=dtype), indexing="ij"
        )
    )
    with exporting("onnx"):
        angle = angle_of(y, x)
    torch.testing.assert_close(angle, torch.atan2(y + 0.0, x + 0.0), equal_nan=True)  # -0 + 0 is 0


FAR = 50000.0


@pytest.mark.parametrize(
    "taps", [bilinear_taps, nearest_taps, partial(cubic_taps, padding_mode="border", align_corners=True)]
)
def test_pixels_of_large_images_have_their_numbers(taps):
    x, y = torch.full((1, 1, 1), FAR - 3.0).double(), torch.full((1, 1, 1), FAR - 4.0).double()
    index, weight = taps(x, y, 50000, 50000)
    read = [int(i) for i, w in zip(index, weight, strict=True) if float(w) != 0]
    assert read == [49996 * 50000 + 49997]


def test_pixels_of_small_images_have_numbers_of_32_bits():
    x = torch.zeros(1, 1, 1)
    assert {i.dtype for i in bilinear_taps(x, x, 40000, 50000)[0]} == {torch.int32}


@pytest.mark.parametrize("mode", ["bilinear", "nearest"])
def test_voxels_of_large_volumes_are_read(mode):
    volume = torch.full((1,), 7.0).expand(1, 1, 1300, 1300, 1300)  # without memory
    place = torch.full((1, 1, 1, 1), 1298.25)
    read = resample_volume(volume, place, place, place, mode, "zeros", True)
    assert read.tolist() == [[[[[7.0]]]]]


def test_extremes_and_ranks_in_onnx_keep_nan():
    x = torch.tensor([[1.0, math.nan, 3.0], [2.0, 5.0, 4.0], [math.inf, 1.0, math.nan]])
    with exporting("onnx"):
        low, high = least(x, [1]), greatest(x, [1])
        values, index = stable_topk(x[:2], 2)
    assert low.isnan().flatten().tolist() == [True, False, True] and high.isnan().flatten().tolist() == [
        True,
        False,
        True,
    ]
    assert float(low[1]) == 2.0 and float(high[1]) == 5.0
    assert (
        index.tolist() == [[1, 2], [1, 2]] and math.isnan(values[0, 0]) and values[1].tolist() == [5.0, 4.0]
    )


@pytest.mark.parametrize("label", [-5, 10**9, -(2**62), 2**62])
def test_labels_out_of_range_belong_to_no_class(label):
    from chiasm import metrics

    labels = torch.tensor([[0, 1, label, 2]])
    assert losses.one_hot(labels, 3).sum(1).tolist() == [[1.0, 1.0, 0.0, 1.0]]
    assert int(metrics.confusion_matrix(labels, labels, 3).sum()) == 3
    assert metrics.accuracy(torch.eye(3), torch.tensor([0, label, 2]), (1,)).tolist() == pytest.approx(
        [200 / 3]
    )


@pytest.mark.parametrize("value", [math.nan, math.inf, 0.0, 1e38])
def test_degenerate_points_give_some_homography(value):
    points = torch.full((1, 8, 2), value)
    assert geometry.homography.find_homography_dlt(points, points).shape == (1, 3, 3)
