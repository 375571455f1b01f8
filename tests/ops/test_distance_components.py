"""Connected components and distance transforms against SciPy and OpenCV, on photographs and on hard
shapes."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import photo
from shapes import hard_masks, spiral
from torch import Tensor

from chiasm.contrib import (
    connected_components,
    connected_components_union_find,
    connected_components_with_stats,
    distance_transform,
    distance_transform_edt,
)

X = torch.zeros(1, 3, 8, 8)
WORDS = torch.zeros(1, 3, 8, 8, dtype=torch.int16)
EIGHT = np.ones((3, 3))


def per_plane(x: Tensor, function: object) -> np.ndarray:
    planes = x.numpy().reshape(-1, *x.shape[2:])
    return np.stack([function(p) for p in planes]).reshape(x.shape)


def labels_by_first_pixel(plane: np.ndarray) -> np.ndarray:
    """SciPy's labels, each renamed to 1 + the index of the first pixel that has it."""
    labels, count = ndi.label(plane > 0, EIGHT)
    _, first = np.unique(labels, return_index=True)
    assert labels.min() == 0 and len(first) == count + 1
    first = first + 1
    first[0] = 0
    return first[labels]


# --- connected components -----------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(1, 1, 47, 53), (3, 1, 200, 131), (2, 7, 31, 40)])
@pytest.mark.parametrize("op", [connected_components, connected_components_union_find])
def test_components_of_photographs_equal_scipy(op: object, shape: tuple[int, ...]) -> None:
    x = photo(*shape)
    binary = (x > x.mean((2, 3), keepdim=True)).double()
    np.testing.assert_array_equal(op(binary), per_plane(binary, labels_by_first_pixel))


@pytest.mark.parametrize("shape", [(40, 40), (271, 483)])
@pytest.mark.parametrize("limit", [10, 100])
def test_components_of_hard_shapes_equal_scipy(shape: tuple[int, int], limit: int) -> None:
    masks = torch.from_numpy(np.stack(hard_masks(*shape))).float()[:, None]
    assert ndi.label(masks[0, 0], EIGHT)[1] == 1  # the spiral is one component
    # the 10 steps of exported gradients are enough
    np.testing.assert_array_equal(connected_components(masks, limit), per_plane(masks, labels_by_first_pixel))


def test_iterations_are_bounded() -> None:
    path = torch.from_numpy(spiral(40, 41)).float()[None, None]
    counts = [connected_components(path, n).unique().numel() - 1 for n in (0, 1, 2, 10)]
    assert counts[0] == path.sum() and counts[0] > counts[1] > counts[2] > counts[3] == 1


def by_opencv(plane: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """OpenCV's labels in the order of their first pixels, and the statistics in this order."""
    count, labels, stats, centroids = cv2.connectedComponentsWithStats((plane > 0).astype(np.uint8))
    found, first = np.unique(labels, return_index=True)
    shapes = found[np.argsort(first)]
    order = np.concatenate([[0], shapes[shapes > 0]])
    if (labels > 0).all():
        stats[0], centroids[0] = 0, 0  # OpenCV leaves a background without pixels undefined
    assert sorted(order) == list(range(count))
    return np.argsort(order)[labels], stats[order], centroids[order]


def with_stats() -> list[Tensor]:
    x = photo(2, 2, 61, 74)
    winding = (torch.rand(1, 1, 23, 130, generator=torch.Generator().manual_seed(3)) < 0.4).float()
    hard = torch.from_numpy(np.stack(hard_masks(40, 41))).float()[:, None]
    return [
        (x > x.mean((2, 3), keepdim=True)).float(),
        winding,
        hard,
        torch.zeros(1, 1, 9, 8),
        torch.ones(1, 1, 8, 9),
    ]


@pytest.mark.parametrize("image", with_stats())
@pytest.mark.parametrize("slots", [1, 7, 900])
def test_statistics_are_opencvs(image: Tensor, slots: int) -> None:
    labels, count, boxes, centroids = connected_components_with_stats(image, slots)
    for b, c in np.ndindex(*image.shape[:2]):
        named, stats, means = by_opencv(image[b, c].numpy())
        np.testing.assert_array_equal(labels[b, c], named)
        assert count[b, c] == len(stats)
        rows = min(slots, len(stats))
        np.testing.assert_array_equal(boxes[b, c, :rows], stats[:rows])
        np.testing.assert_array_equal(centroids[b, c, :rows], means[:rows])
        assert not boxes[b, c, rows:].any() and not centroids[b, c, rows:].any()


def test_statistics_of_bytes_and_masks() -> None:
    image = with_stats()[0]
    expected = connected_components_with_stats(image)
    frame = (200 * image).to(torch.uint8).permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2)
    scripted = torch.jit.script(connected_components_with_stats)
    for op in (connected_components_with_stats, scripted):
        for given in (frame, image > 0, image.double()):
            for made, wanted in zip(op(given), expected, strict=True):
                assert torch.equal(made, wanted) and made.dtype == wanted.dtype


# --- distances ----------------------------------------------------------------------------------------------


def binaries() -> Tensor:
    """Photographs thresholded at a level, dots, and a spiral: (5, 2, 61, 74); every plane has clear and set
    pixels."""
    x = photo(2, 2, 61, 74)
    generator = torch.Generator().manual_seed(0)
    dots = (
        torch.rand(2, 2, 61, 74, generator=generator) < torch.tensor([0.002, 0.1]).reshape(2, 1, 1, 1)
    ).float()
    path = torch.from_numpy(spiral(61, 74)).float().expand(1, 2, 61, 74)
    return torch.cat([(x > x.mean((2, 3), keepdim=True)).float(), dots, path])


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_edt_equals_scipy_and_opencv(dtype: torch.dtype, inverted: bool) -> None:
    x = binaries().to(dtype)
    x = 1.0 - x if inverted else x
    actual = distance_transform_edt(x)
    np.testing.assert_allclose(
        actual, per_plane(x, ndi.distance_transform_edt), rtol=1e-6 if dtype == torch.float32 else 1e-15
    )
    opencv = per_plane(
        x, lambda p: cv2.distanceTransform(p.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    )
    np.testing.assert_allclose(actual, opencv, rtol=1e-5)


@pytest.mark.parametrize(
    "op", [connected_components, connected_components_union_find, distance_transform_edt]
)
def test_bytes_are_set_above_zero(op: Callable[[Tensor], Tensor]) -> None:
    image = binaries()
    levels = (image > 0) * torch.randint(1, 256, image.shape)
    frame = levels.to(torch.uint8).permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2)
    expected = op((image > 0).float())
    for given in (levels.to(torch.uint8), frame):
        assert op(given).equal(expected) and op(given).dtype == expected.dtype


def test_edt_of_one_clear_pixel() -> None:
    x = torch.ones(1, 2, 100, 40, dtype=torch.float64)
    x[0, 0, 97, 2] = 0.0
    actual = distance_transform_edt(x)
    rows, columns = np.mgrid[:100, :40]
    np.testing.assert_allclose(actual[0, 0], np.hypot(rows - 97, columns - 2), rtol=1e-15)
    assert torch.isinf(actual[0, 1]).all()


def growth_by_definition(x: np.ndarray, size: int, h: float) -> np.ndarray:
    """The paper's iteration, in float64."""
    r = size // 2
    rows, columns = np.mgrid[-r : r + 1, -r : r + 1]
    kernel = np.exp(-np.hypot(rows, columns) / h)
    shape, out = x.astype(np.float64), np.zeros(x.shape)
    for k in range(-(-max(x.shape) // r)):
        # SciPy drops weights below 1e-16
        near = cv2.filter2D(shape, cv2.CV_64F, kernel, borderType=cv2.BORDER_REPLICATE)
        with np.errstate(divide="ignore"):
            beyond = np.where(near > 0, -h * np.log(near), 0.0)
        found = beyond > 0
        out += np.where(found, k * r + beyond, 0.0)
        shape = np.where(found, 1.0, shape)
    return out


@pytest.mark.parametrize("size", [3, 5, 7])
@pytest.mark.parametrize("h", [0.1, 0.35])
def test_convolutional_distance_by_definition(size: int, h: float) -> None:
    x = binaries().double()
    actual = distance_transform(x, size, h)
    np.testing.assert_allclose(actual, per_plane(x, lambda p: growth_by_definition(p, size, h)), atol=1e-9)


@pytest.mark.parametrize(("size", "h"), [(3, 0.35), (5, 0.15)])
def test_convolutional_distance_of_volumes_by_definition(size: int, h: float) -> None:
    x = (torch.rand(2, 1, 7, 9, 12, generator=torch.Generator().manual_seed(4)) < 0.02).double()
    x[1, 0] = 0.0
    actual, r = distance_transform(x, size, h), size // 2
    offset = np.mgrid[-r : r + 1, -r : r + 1, -r : r + 1]
    kernel = np.exp(-np.sqrt((offset**2).sum(0)) / h)
    shape, expected = x[0, 0].numpy().copy(), np.zeros(x.shape[2:])
    for k in range(28):
        near = ndi.correlate(shape, kernel, mode="nearest")
        with np.errstate(divide="ignore"):
            beyond = np.where(near > 0, -h * np.log(near), 0.0)
        expected += np.where(beyond > 0, k * r + beyond, 0.0)
        shape = np.where(beyond > 0, 1.0, shape)
    np.testing.assert_allclose(actual[0, 0], expected, atol=1e-9)
    assert (actual[1] == 0).all() and expected.max() > 3
    exact = ndi.distance_transform_edt(1 - x[0, 0].numpy())
    near_by = (exact > 0) & (exact <= 1)
    assert np.abs(expected - exact)[near_by].max() < 0.35


def test_convolutional_distance_is_near_the_euclidean() -> None:
    x = torch.zeros(1, 1, 31, 31, dtype=torch.float64)
    x[0, 0, 15, 9] = 1.0
    exact = distance_transform_edt(1.0 - x)
    ring = exact[0, 0] <= 7
    # a 15 x 15 kernel contains the pixels within 7, so it has their distances; a sharp kernel hardly blends
    # them
    assert (distance_transform(x, 15, 0.05) - exact)[0, 0][ring].abs().max() < 1e-9
    assert (distance_transform(x, 3, 0.35) - exact)[0, 0].abs().max() < 0.3 * exact.max()


def test_no_shape_is_nowhere_near() -> None:
    assert distance_transform(X).abs().max() == 0


WRONG = [
    (lambda: connected_components(WORDS), TypeError, "image: expected a floating-point or uint8"),
    (lambda: connected_components(X[0, 0, 0]), ValueError, "image: expected shape"),
    (lambda: connected_components(X, -1), ValueError, "num_iterations: expected at least 0, got -1"),
    (lambda: connected_components_union_find(WORDS), TypeError, "image: expected a floating-point or uint8"),
    (lambda: distance_transform_edt(WORDS), TypeError, "image: expected a floating-point or uint8"),
    (lambda: distance_transform(X[0]), ValueError, "image: expected shape"),
    (lambda: distance_transform(X, 4), ValueError, "kernel_size: expected an odd size of at least 3, got 4"),
    (lambda: distance_transform(X, 3, 0.0), ValueError, "h: expected a positive number, got 0.0"),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
