"""Polygons around the shapes in masks: against OpenCV's findContours."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import ops

Polygon = tuple[bool, tuple[tuple[int, int], ...]]


def from_its_least_point(points: np.ndarray) -> tuple[tuple[int, int], ...]:
    """The polygon, rotated to begin at its smallest point."""
    path = [(int(x), int(y)) for x, y in points]
    return min((tuple(path[i:] + path[:i]) for i in range(len(path))), default=())


def of_opencv(mask: np.ndarray) -> list[Polygon]:
    found, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    return sorted((bool(hierarchy[0][i][3] >= 0), from_its_least_point(c[:, 0])) for i, c in enumerate(found))


def in_slots(points: Tensor, counts: Tensor, holes: Tensor) -> list[Polygon]:
    """The polygons of one mask."""
    return sorted(
        (bool(h), from_its_least_point(p[:n].numpy())) for p, n, h in zip(points, counts, holes) if n > 0
    )


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9, 1.0])
def test_polygons_are_opencvs(share: float) -> None:
    random = np.random.default_rng(int(share * 10))
    for height, width in [(1, 1), (1, 9), (9, 1), (2, 2), (3, 5), (12, 17), (20, 23)]:
        masks = (random.random((5, height, width)) < share).astype(np.uint8)
        slots = height * width
        found = ops.masks_to_polygons(torch.from_numpy(masks), slots, 2 * slots)
        for n in range(5):
            assert in_slots(*(part[n] for part in found)) == of_opencv(masks[n])


def test_large_shapes_with_holes() -> None:
    random = np.random.default_rng(0)
    noise = [cv2.GaussianBlur(random.random((90, 110)), (0, 0), sigma) for sigma in (1.0, 2.0, 5.0)]
    masks = np.stack([(x > np.median(x)).astype(np.uint8) for x in noise])
    found = ops.masks_to_polygons(torch.from_numpy(masks), 400, 3000)
    for n in range(3):
        expected = of_opencv(masks[n])
        assert in_slots(*(part[n] for part in found)) == expected
        assert any(is_hole for is_hole, _ in expected)


def test_the_largest_come_first_and_fill_back_to_the_mask() -> None:
    mask = np.zeros((40, 50), np.uint8)
    cv2.circle(mask, (30, 20), 15, 1, -1)
    cv2.circle(mask, (30, 20), 6, 0, -1)
    mask[3:6, 2:9] = mask[30:33, 2:9] = 1
    points, counts, holes = ops.masks_to_polygons(torch.from_numpy(mask)[None], 6, 100)
    assert holes.tolist() == [[False, True, False, False, False, False]]
    assert (counts[0, 2:] == torch.tensor([4, 4, 0, 0])).all()
    assert points[0, 2, 0].tolist() == [2.0, 3.0] and points[0, 3, 0].tolist() == [2.0, 30.0]
    assert not points[0, 4:].any() and not points[0, 2, 4:].any()
    drawn = np.zeros_like(mask)
    for slot in (0, 2, 3):
        cv2.fillPoly(drawn, [points[0, slot, : counts[0, slot]].numpy().astype(np.int32)], 1)
    inside = np.zeros_like(mask)
    cv2.fillPoly(inside, [points[0, 1, : counts[0, 1]].numpy().astype(np.int32)], 1)
    # The polygon of a hole goes through pixels of the shape.
    assert np.array_equal(drawn - (inside & (1 - mask)), mask)


def test_fewer_slots_than_polygons_and_points() -> None:
    random = np.random.default_rng(1)
    masks = torch.from_numpy((cv2.GaussianBlur(random.random((60, 70)), (0, 0), 2.0) > 0.5)[None])
    points, counts, holes = ops.masks_to_polygons(masks, 500, 500)
    some, some_counts, some_holes = ops.masks_to_polygons(masks, 3, 9)
    assert torch.equal(some_holes, holes[:, :3])
    for slot in range(3):
        whole = int(counts[0, slot])
        kept = min(whole, 9)
        assert whole > 9 and int(some_counts[0, slot]) == kept
        chosen = [i * whole // 9 for i in range(9)]
        assert torch.equal(some[0, slot], points[0, slot, chosen])


def test_any_dtype_and_no_mask() -> None:
    scores = torch.tensor([[[0.2, -1.0, 0.0], [torch.nan, 0.0, 0.0]]])
    points, counts, _ = ops.masks_to_polygons(scores, 2, 4)
    assert counts.tolist() == [[3, 0]] and points[0, 0].tolist() == [[0, 0], [0, 1], [1, 0], [0, 0]]
    assert [tuple(t.shape) for t in ops.masks_to_polygons(scores[:0], 2, 4)] == [(0, 2, 4, 2), (0, 2), (0, 2)]
    assert not ops.masks_to_polygons(torch.zeros(1, 4, 5), 2, 4)[1].any()


@pytest.mark.parametrize(
    ("mask", "slots", "message"),
    [
        (torch.ones(3, 4), (1, 1), r"masks: expected shape \(N, H, W\)"),
        (torch.ones(1, 0, 4), (1, 1), "masks: expected H and W of at least 1"),
        (torch.ones(1, 3, 4), (0, 1), "max_polygons: expected a positive number, got 0"),
        (torch.ones(1, 3, 4), (1, 0), "max_points: expected a positive number, got 0"),
    ],
)
def test_what_it_refuses(mask: Tensor, slots: tuple[int, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ops.masks_to_polygons(mask, *slots)
