"""Rotated boxes: against SciPy's intersections of half-planes in double, and against OpenCV."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from scipy.spatial import ConvexHull, HalfspaceIntersection
from torch.autograd import gradcheck

from chiasm import ops


def boxes(count: int, seed: int = 0) -> np.ndarray:
    """Many overlap."""
    random = np.random.default_rng(seed)
    centre, sides = random.uniform(0, 40, (count, 2)), random.uniform(4, 25, (count, 2))
    return np.concatenate([centre, sides, random.uniform(-400, 400, (count, 1))], 1)


def half_planes(box: np.ndarray) -> np.ndarray:
    """Rows (a, b, c) with a x + b y + c <= 0 inside."""
    cx, cy, width, height, angle = box
    u = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    v = np.array([-u[1], u[0]])
    centre = np.array([cx, cy])
    return np.array(
        [[*(s * n), -s * n @ centre - e / 2] for n, e in ((u, width), (v, height)) for s in (1, -1)]
    )


def overlap_by_scipy(a: np.ndarray, b: np.ndarray) -> float:
    """The overlap from a point inside both boxes, searched on a grid in the first; 0 if none is found."""
    planes = np.concatenate([half_planes(a), half_planes(b)])
    steps = np.linspace(-0.499, 0.499, 60)
    s, t = (g.ravel() for g in np.meshgrid(steps, steps))
    cos, sin = np.cos(np.radians(a[4])), np.sin(np.radians(a[4]))
    x, y = a[0] + s * a[2] * cos - t * a[3] * sin, a[1] + s * a[2] * sin + t * a[3] * cos
    depth = (planes[:, :2] @ np.stack([x, y]) + planes[:, 2:]).max(0)
    if depth.min() >= -1e-3:
        return 0.0
    inside = np.array([x[depth.argmin()], y[depth.argmin()]])
    common = ConvexHull(HalfspaceIntersection(planes, inside).intersections).volume
    return common / (a[2] * a[3] + b[2] * b[3] - common)


def test_intersections_are_scipys() -> None:
    first, second = boxes(30), boxes(25, seed=1)
    actual = ops.rotated_iou(torch.from_numpy(first), torch.from_numpy(second)).numpy()
    expected = np.array([[overlap_by_scipy(a, b) for b in second] for a in first])
    assert (expected > 0.05).sum() > 100 and (expected == 0).sum() > 50
    # Overlaps that the grid misses are small.
    np.testing.assert_allclose(actual[expected > 0], expected[expected > 0], atol=1e-10)
    assert actual[expected == 0].max() < 1e-3


def rectangle_intersection(a: np.ndarray, b: np.ndarray) -> tuple[int, np.ndarray]:
    first, second = [(tuple(x[:2]), tuple(x[2:4]), x[4]) for x in (a, b)]
    return cv2.rotatedRectangleIntersection(first, second)


def test_intersections_are_opencvs() -> None:
    first, second = boxes(40, seed=2), boxes(40, seed=3)
    actual = ops.rotated_iou(torch.from_numpy(first).float(), torch.from_numpy(second).float()).numpy()
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            kind, corners = rectangle_intersection(a, b)
            common = 0.0 if kind == cv2.INTERSECT_NONE else cv2.contourArea(cv2.convexHull(corners))
            expected = common / (a[2] * a[3] + b[2] * b[3] - common)
            assert abs(actual[i, j] - expected) < 1e-3


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_coincident_sides(dtype: torch.dtype) -> None:
    tight = {"rtol": 0, "atol": 1e-13 if dtype == torch.float64 else 2e-6}
    x = torch.from_numpy(boxes(200, seed=4)).to(dtype)
    same = ops.rotated_iou(x, x).diagonal()
    torch.testing.assert_close(same, torch.ones_like(same), **tight)
    # A full turn, and a quarter turn with the sides exchanged.
    turns = torch.tensor([[0.0, 0.0, 0.0, 0.0, 360.0], [0.0, 0.0, 0.0, 0.0, 90.0]], dtype=dtype)
    for other in (x + turns[0], x[:, [0, 1, 3, 2, 4]] + turns[1]):
        near = ops.rotated_iou(x, other).diagonal()
        atol = 1e-12 if dtype == torch.float64 else 1e-4
        torch.testing.assert_close(near, torch.ones_like(near), rtol=0, atol=atol)
    square = torch.tensor([[0.0, 0.0, 4.0, 4.0, 0.0]], dtype=dtype)
    others = torch.tensor(
        [
            [1.0, 0.0, 2.0, 4.0, 0.0],
            [0.0, 0.0, 2.0, 2.0, 90.0],
            [4.0, 0.0, 4.0, 4.0, 0.0],
            [4.0, 4.0, 4.0, 4.0, 180.0],
            [9.0, 0.0, 2.0, 2.0, 0.0],
            [0.0, 0.0, 32**0.5, 32**0.5, 45.0],
            [0.0, 0.0, 0.0, 5.0, 30.0],
        ],
        dtype=dtype,
    )
    expected = torch.tensor([[0.5, 0.25, 0.0, 0.0, 0.0, 0.5, 0.0]], dtype=dtype)
    torch.testing.assert_close(ops.rotated_iou(square, others), expected, **tight)


def test_upright_boxes_are_boxes() -> None:
    first, second = (torch.from_numpy(boxes(50, seed=s)) for s in (5, 6))
    first[:, 4], second[:, 4] = 0.0, 0.0
    a, b = (ops.box_convert(x[:, :4], "cxcywh", "xyxy") for x in (first, second))
    torch.testing.assert_close(ops.rotated_iou(first, second), ops.box_iou(a, b), rtol=0, atol=1e-13)


def test_far_from_the_origin() -> None:
    first, second = (torch.from_numpy(boxes(50, seed=s)) for s in (7, 8))
    shift = torch.tensor([1e6, -1e6, 0.0, 0.0, 0.0], dtype=torch.float64)
    moved = ops.rotated_iou(first + shift, second + shift)
    torch.testing.assert_close(moved, ops.rotated_iou(first, second), rtol=0, atol=1e-9)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_areas_beyond_half_precision(dtype: torch.dtype) -> None:
    """A third of these boxes of 90000 pixels overlaps; float16 ends at 65504."""
    first = torch.tensor([[500.0, 400.0, 300.0, 300.0, 0.0]], dtype=dtype)
    second = torch.tensor([[650.0, 400.0, 300.0, 300.0, 90.0]], dtype=torch.float64)
    for call in (ops.rotated_iou, torch.jit.script(ops.rotated_iou)):
        found = call(first, second.to(dtype))
        shift = second.to(dtype)[0, 0].item() - first[0, 0].item()
        expected = (300.0 - shift) / (300.0 + shift)
        assert found.dtype == torch.float32 and found.item() == pytest.approx(expected, rel=1e-5)


def test_no_boxes() -> None:
    assert ops.rotated_iou(torch.zeros(0, 5), torch.zeros(3, 5)).shape == (0, 3)
    assert ops.rotated_iou(torch.zeros(1, 5), torch.zeros(1, 5)).isnan().all()
    index, kept = ops.rotated_nms_fixed(
        torch.zeros(1, 0, 5), torch.zeros(1, 0), torch.zeros(1, 0).long(), 0.5, 2
    )
    assert index.tolist() == [[0, 0]] and not kept.any()


def test_gradient() -> None:
    inputs = [torch.from_numpy(boxes(4, seed=s)).requires_grad_() for s in (9, 10)]
    assert gradcheck(ops.rotated_iou, inputs)
    first, second = torch.tensor([[0.0, 0.0, 4.0, 4.0, 0.0]]).requires_grad_(), torch.ones(1, 5)
    ops.rotated_iou(first, second * 0).sum().backward()
    assert first.grad is not None and first.grad.isfinite().all()


def kept_by_opencv(x: np.ndarray, scores: np.ndarray, inside_is_all: bool) -> list[int]:
    """A loop with OpenCV's areas. ``inside_is_all``: a box inside another counts as a full overlap."""
    kept: list[int] = []
    for i in np.argsort(-scores, kind="stable"):
        if scores[i] <= 0.21:
            break
        overlaps = [0.0]
        for k in kept:
            kind, corners = rectangle_intersection(x[i], x[k])
            common = 0.0 if kind == cv2.INTERSECT_NONE else cv2.contourArea(cv2.convexHull(corners))
            share = common / (x[i, 2] * x[i, 3] + x[k, 2] * x[k, 3] - common)
            overlaps.append(1.0 if kind == cv2.INTERSECT_FULL and inside_is_all else share)
        if max(overlaps) <= 0.3:
            kept.append(int(i))
    return kept


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("scripted", [False, True])
def test_suppression_is_opencvs(seed: int, scripted: bool) -> None:
    """OpenCV's NMSBoxesRotated counts a box inside another as a full overlap."""
    call = torch.jit.script(ops.rotated_nms_fixed) if scripted else ops.rotated_nms_fixed
    x, scores = boxes(60, seed), np.random.default_rng(seed).permutation(60).astype(np.float32) / 60
    rectangles = [(tuple(b[:2]), tuple(b[2:4]), b[4]) for b in x]
    theirs = np.ravel(cv2.dnn.NMSBoxesRotated(rectangles, scores.tolist(), 0.21, 0.3)).tolist()
    assert theirs == kept_by_opencv(x, scores, inside_is_all=True)
    expected = kept_by_opencv(x, scores, inside_is_all=False)
    assert 5 < len(expected) < 40
    both, of_both = np.stack([x, x[::-1]]), np.stack([scores, scores[::-1]])
    together = torch.from_numpy(both).float(), torch.from_numpy(of_both), torch.zeros(2, 60).long()
    index, kept = call(*together, 0.3, 45, 0.21)
    assert index[0].tolist() == expected + [0] * (45 - len(expected))
    assert index[1].tolist() == [59 - i for i in expected] + [0] * (45 - len(expected))
    assert kept.tolist() == [[k < len(expected) for k in range(45)]] * 2
    assert call(*together, 0.3, 3, 0.21)[0][0].tolist() == expected[:3]


def test_classes_and_ties() -> None:
    x = torch.tensor([[[5.0, 5.0, 8.0, 4.0, 30.0]] * 4])
    scores, classes = torch.tensor([[0.5, 0.9, 0.9, 0.5]]), torch.tensor([[0, 1, 1, 2]])
    index, kept = ops.rotated_nms_fixed(x, scores, classes, 0.5, 4)
    assert index.tolist() == [[1, 0, 3, 0]] and kept.tolist() == [[True, True, True, False]]


X, S, L = torch.rand(1, 5, 5), torch.rand(1, 5), torch.zeros(1, 5, dtype=torch.int64)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.rotated_iou(X, X[0]), ValueError, r"boxes1: expected shape \(N, 5\)"),
        (lambda: ops.rotated_iou(X[0], X[0, :, :4]), ValueError, r"boxes2: expected shape \(M, 5\)"),
        (lambda: ops.rotated_iou(X[0].int(), X[0]), TypeError, "boxes1: expected a floating-point"),
        (lambda: ops.rotated_nms_fixed(X, S[0], L, 0.5, 3), ValueError, r"scores: expected shape \[1, 5\]"),
        (lambda: ops.rotated_nms_fixed(X, S, L[0], 0.5, 3), ValueError, r"idxs: expected shape \[1, 5\]"),
        (lambda: ops.rotated_nms_fixed(X, S, L.int(), 0.5, 3), TypeError, "idxs: expected dtype int64"),
        (lambda: ops.rotated_nms_fixed(X, S, L, 0.5, 0), ValueError, "max_output: expected a positive"),
    ],
)
def test_errors(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
