"""Text boxes: against OpenCV's contours and rectangles, and loops over pixels."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import ops
from chiasm.primitives.geometry.rectangles import smallest_rectangle_direction


def edges(points: np.ndarray) -> list[float]:
    """The areas of the bounding rectangles along each edge of the hull of (P, 2)."""
    hull = cv2.convexHull(points.astype(np.int32))[:, 0].astype(np.float64)
    areas = []
    for edge in np.roll(hull, -1, 0) - hull:
        if edge.any():
            unit = edge / np.linalg.norm(edge)
            along, across = hull @ unit, hull @ np.array([-unit[1], unit[0]])
            areas.append(np.ptp(along) * np.ptp(across))
    return sorted(areas) or [0.0]


@pytest.mark.parametrize("count", [1, 2, 3, 4, 10, 200])
@pytest.mark.parametrize("span", [3, 40, 30000])
def test_the_rectangle_of_least_area(count: int, span: int) -> None:
    points = np.random.default_rng(count).integers(-span, span, (60, count, 2)).astype(np.float64)
    if count == 200:  # many edges
        points = np.round(points / np.linalg.norm(points + 0.1, axis=2, keepdims=True) * span)
    direction = smallest_rectangle_direction(*torch.from_numpy(points).unbind(2)).numpy()
    assert (direction[:, 0] > 0).all() and (direction[:, 1] >= 0).all()
    assert np.array_equal(direction, direction.round())
    for each, (a, b) in zip(points, direction, strict=True):
        along, across = each @ np.array([a, b]), each @ np.array([-b, a])
        area = np.ptp(along) * np.ptp(across) / (a * a + b * b)
        assert area == pytest.approx(edges(each)[0], rel=1e-9, abs=1e-6)


def blobs(seed: int, height: int, width: int, count: int = 7) -> np.ndarray:
    """Rotated rectangles and ellipses with the proportions of text, on noise."""
    random = np.random.default_rng(seed)
    image = np.zeros((height, width), np.float32)
    for k in range(count):
        centre = (random.uniform(0, width), random.uniform(0, height))
        size = (random.uniform(4, 60), random.uniform(2, 16))
        box = (centre, size, random.uniform(-90, 90))
        level = float(random.uniform(0.6, 1.0))
        if k % 2:
            cv2.ellipse(image, box, level, -1)
        else:
            cv2.fillPoly(image, [np.round(cv2.boxPoints(box)).astype(np.int32)], level)
    return image * random.uniform(0.8, 1.0, image.shape).astype(np.float32)


def ordered(corners: np.ndarray) -> np.ndarray:
    """Corners clockwise, from the upper one of the two leftmost."""
    by_x = corners[np.argsort(corners[:, 0], kind="stable")]
    left, right = by_x[:2], by_x[2:]
    left, right = left[np.argsort(left[:, 1])], right[np.argsort(right[:, 1])]
    return np.array([left[0], right[0], right[1], left[1]])


def boxes_by_opencv(
    image: np.ndarray, threshold: float, ratio: float
) -> list[tuple[np.ndarray, float, float]]:
    """For every shape, the enlarged rectangle's corners, the score, and the shorter side."""
    mask = (image > threshold).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    found = []
    for contour in contours:
        areas = edges(contour[:, 0])
        (x, y), (w, h), angle = cv2.minAreaRect(contour)
        assert w * h == pytest.approx(areas[0], rel=1e-4, abs=1e-3)
        offset = w * h * ratio / (2 * (w + h)) if w + h > 0 else 0.0
        turn = np.deg2rad(angle)
        along = (columns - x) * np.cos(turn) + (rows - y) * np.sin(turn)
        across = (rows - y) * np.cos(turn) - (columns - x) * np.sin(turn)
        inside = (np.abs(along) <= w / 2 + 1e-3) & (np.abs(across) <= h / 2 + 1e-3)
        corners = ordered(cv2.boxPoints(((x, y), (w + 2 * offset, h + 2 * offset), angle)))
        found.append((corners, float(image[inside].mean(dtype=np.float64)), min(w, h)))
    return found


@pytest.mark.parametrize("seed", range(12))
def test_boxes_are_opencvs(seed: int) -> None:
    image = blobs(seed, 150, 200)
    corners, scores, found = ops.decode_db(torch.from_numpy(image)[None, None], 0.3, 0.45, 1.7, 60)
    expected = [each for each in boxes_by_opencv(image, 0.3, 1.7) if each[1] >= 0.45 and each[2] >= 3]
    expected.sort(key=lambda each: -each[1])
    assert len(expected) >= 1
    assert found[0].tolist() == [True] * len(expected) + [False] * (60 - len(expected))
    np.testing.assert_allclose(scores[0, : len(expected)], [score for _, score, _ in expected], atol=1e-6)
    for k, (box, _, _) in enumerate(expected):
        np.testing.assert_allclose(corners[0, k], box, atol=2e-3)
    assert not corners[0, len(expected) :].any() and not scores[0, len(expected) :].any()


@pytest.mark.parametrize("ratio", [0.0, 1.5, 2.0])
def test_an_upright_rectangle_in_closed_form(ratio: float) -> None:
    probability = torch.zeros(1, 1, 40, 60, dtype=torch.float64)
    probability[0, 0, 10:21, 8:39] = 0.9  # 30 x 10 between centres
    corners, scores, found = ops.decode_db(probability, unclip_ratio=ratio, max_candidates=3)
    d = 30 * 10 * ratio / 80
    expected = torch.tensor([[8 - d, 10 - d], [38 + d, 10 - d], [38 + d, 20 + d], [8 - d, 20 + d]])
    torch.testing.assert_close(corners[0, 0], expected.double(), rtol=1e-14, atol=1e-12)
    torch.testing.assert_close(
        scores, torch.tensor([[0.9, 0.0, 0.0]], dtype=torch.float64), rtol=1e-12, atol=0
    )
    assert found.tolist() == [[True, False, False]]


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_corners_of_half_precision_are_float32(dtype: torch.dtype) -> None:
    probability = torch.zeros(1, 1, 30, 2200, dtype=dtype)
    probability[0, 0, 10:21, 2051:2102] = 0.875
    corners, scores, _ = ops.decode_db(probability, unclip_ratio=0.0, max_candidates=1)
    assert corners.dtype == torch.float32 and scores.dtype == dtype and scores.item() == 0.875
    assert corners[0, 0].tolist() == [[2051.0, 10.0], [2101.0, 10.0], [2101.0, 20.0], [2051.0, 20.0]]


def test_a_diamond() -> None:
    """A rectangle rotated by 45 degrees contains exactly its pixels."""
    y, x = torch.meshgrid(torch.arange(30.0), torch.arange(30.0), indexing="ij")
    probability = torch.where((x - 14).abs() + (y - 15).abs() <= 8, 0.7, 0.1)[None, None]
    corners, scores, _ = ops.decode_db(probability, unclip_ratio=0.0, max_candidates=1)
    torch.testing.assert_close(scores, torch.tensor([[0.7]]))
    expected = torch.tensor([[14.0, 7.0], [22.0, 15.0], [14.0, 23.0], [6.0, 15.0]])
    torch.testing.assert_close(corners[0, 0], expected, rtol=0, atol=1e-5)


def test_the_largest_shapes_are_looked_at() -> None:
    probability = torch.zeros(1, 1, 30, 60)
    for k, (level, size) in enumerate([(0.9, 4), (0.7, 8), (0.8, 8), (0.95, 5)]):
        probability[0, 0, 2 : 2 + size, 14 * k + 1 : 14 * k + 1 + size] = level
    _, scores, found = ops.decode_db(probability, max_candidates=2)
    torch.testing.assert_close(scores, torch.tensor([[0.8, 0.7]]))
    assert found.all()
    _, scores, found = ops.decode_db(probability, max_candidates=6, min_size=4.0)
    torch.testing.assert_close(scores, torch.tensor([[0.95, 0.8, 0.7, 0.0, 0.0, 0.0]]))


def test_images_of_a_batch_are_apart() -> None:
    maps = torch.from_numpy(np.stack([blobs(seed, 70, 100) for seed in range(3)]))[:, None]
    together = ops.decode_db(maps, box_threshold=0.4, max_candidates=20)
    assert together[2].any(1).all()
    for i in range(3):
        alone = ops.decode_db(maps[i : i + 1], box_threshold=0.4, max_candidates=20)
        assert all(torch.equal(t[i], a[0]) for t, a in zip(together, alone, strict=True))


@pytest.mark.parametrize("level", [0.0, 1.0, float("nan")])
@pytest.mark.parametrize(("height", "width"), [(1, 1), (1, 9), (6, 7)])
def test_nothing_everything_and_nan(level: float, height: int, width: int) -> None:
    corners, scores, found = ops.decode_db(torch.full((1, 1, height, width), level), max_candidates=50)
    is_box = level == 1.0 and height > 3
    assert found.sum() == int(is_box) and torch.isfinite(corners).all()
    assert scores[0, 0] == (1.0 if is_box else 0.0)


def test_an_empty_batch() -> None:
    corners, scores, found = ops.decode_db(torch.zeros(0, 1, 8, 8), max_candidates=4)
    assert corners.shape == (0, 4, 4, 2) and scores.shape == found.shape == (0, 4)


X = torch.rand(1, 1, 8, 9)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.decode_db(X[0]), ValueError, r"probability: expected shape"),
        (lambda: ops.decode_db(X.int()), TypeError, "probability: expected a floating-point"),
        (lambda: ops.decode_db(X.expand(1, 2, 8, 9)), ValueError, r"probability: expected shape \(B, 1, H"),
        (lambda: ops.decode_db(X, unclip_ratio=-1.0), ValueError, "unclip_ratio: expected 0 or more"),
        (lambda: ops.decode_db(X, max_candidates=0), ValueError, "max_candidates: expected a positive"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
