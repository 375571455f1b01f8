"""Trackers against the papers' definitions in NumPy and SciPy (tracked.py), and their guarantees."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor
from tracked import Tracker, scene

from chiasm.ops import byte_track, sort_track

SLOTS, DETECTIONS = 30, 14


def start(slots: int = SLOTS, batch: int = 1, dtype: torch.dtype = torch.float64) -> list[Tensor]:
    return [
        torch.zeros(batch, slots, 7, dtype=dtype),
        torch.zeros(batch, slots, 7, 7, dtype=dtype),
        torch.zeros(batch, slots, 4, dtype=torch.int64),
        torch.zeros(batch, dtype=torch.int64),
    ]


def in_slots(boxes: np.ndarray, scores: np.ndarray) -> tuple[Tensor, Tensor, Tensor]:
    """(1, M, 4), (1, M) and (1, M), with NaN in the empty slots."""
    count = len(boxes)
    padded = np.full((DETECTIONS, 4), np.nan)
    padded[:count] = boxes
    certain = np.full(DETECTIONS, np.nan)
    certain[:count] = scores
    found = torch.arange(DETECTIONS)[None] < count
    return torch.from_numpy(padded)[None], torch.from_numpy(certain)[None], found


def assert_same_tracks(state: list[Tensor], boxes: Tensor, index: Tensor, shown: Tensor, by: Tracker) -> None:
    counters = state[2][0]
    slot = {int(row[0]): k for k, row in enumerate(counters.tolist()) if row[0] > 0}
    assert sorted(slot) == sorted(t.identity for t in by.tracks)
    assert int(state[3]) == by.given
    for track in by.tracks:
        k = slot[track.identity]
        assert counters[k].tolist() == [track.identity, track.age, track.hits, track.since]
        np.testing.assert_allclose(state[0][0, k], track.state, rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(state[1][0, k], track.spread, rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(boxes[0, k], track.box, rtol=1e-7, atol=1e-7)
        assert int(index[0, k]) == track.detection
        assert bool(shown[0, k]) == (track.since == 0 and track.hits >= by.min_hits)
    empty = counters[:, 0] == 0
    assert not any(bool(part[0][empty].any()) for part in (state[0], state[1], boxes, index, shown))


@pytest.mark.parametrize("scripted", [False, True])
@pytest.mark.parametrize(("max_age", "min_hits"), [(1, 1), (5, 3), (30, 2)])
def test_sort(max_age: int, min_hits: int, scripted: bool) -> None:
    call: Any = torch.jit.script(sort_track) if scripted else sort_track
    state, by = start(), Tracker(0.3, max_age, min_hits, [-np.inf], -np.inf)
    for boxes, scores in scene(max_age, 100):
        by.frame(boxes, scores)
        detections, _, found = in_slots(boxes, scores)
        *state, shown_boxes, index, shown = call(*state, detections, found, 0.3, max_age, min_hits)
        assert_same_tracks(state, shown_boxes, index, shown, by)
    assert by.given > 15


@pytest.mark.parametrize("scripted", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_byte(seed: int, scripted: bool) -> None:
    call: Any = torch.jit.script(byte_track) if scripted else byte_track
    state, by = start(), Tracker(0.2, 30, 2, [0.6, 0.1], 0.7)
    seconds = 0
    for boxes, scores in scene(seed, 100):
        by.frame(boxes, scores)
        detections, certain, found = in_slots(boxes, scores)
        *state, shown_boxes, index, shown = call(*state, detections, certain, found)
        assert_same_tracks(state, shown_boxes, index, shown, by)
        seconds += sum(t.since == 0 and scores[t.detection] <= 0.6 for t in by.tracks)
    assert seconds > 20


def one(x: float, y: float = 50.0) -> Tensor:
    return torch.tensor([[[x, y, x + 40.0, y + 80.0]]], dtype=torch.float64)


def followed(pattern: str, **settings: int) -> list[tuple[int, bool]]:
    """For each frame, the identity of an object, 0 without a track, and whether it is shown. The object is
    detected in frames for which the pattern has an x."""
    state, seen = start(2), []
    for k, letter in enumerate(pattern):
        found = torch.tensor([[letter == "x"]])
        *state, _, _, shown = sort_track(*state, one(3.0 * k), found, **settings)
        seen.append((int(state[2][0, :, 0].amax()), bool(shown.any())))
    return seen


@pytest.mark.parametrize("max_age", [1, 2, 5])
def test_a_gap(max_age: int) -> None:
    """A track survives a gap only if the gap is shorter than the maximum age."""
    begin = "xxxx"
    kept = followed(begin + "-" * (max_age - 1) + "x", max_age=max_age, min_hits=2)
    assert [identity for identity, _ in kept] == [1] * (4 + max_age)
    assert kept[-1] == (1, True)
    lost = followed(begin + "-" * max_age + "xx", max_age=max_age, min_hits=2)
    assert lost[3 + max_age] == (0, False)
    assert lost[-2:] == [(2, False), (2, True)]


def test_probation() -> None:
    assert followed("xx-xxx", max_age=9, min_hits=3) == [
        (1, False),
        (1, False),
        (0, False),
        (2, False),
        (2, False),
        (2, True),
    ]


def test_two_objects_that_cross_keep_their_identities() -> None:
    state = start(4)
    for k in range(60):
        detections = torch.cat([one(5.0 * k, 50.0), one(300.0 - 5.0 * k, 70.0)], 1)
        if k % 2:
            detections = detections.flip(1)
        *state, boxes, _, _ = sort_track(*state, detections, torch.ones(1, 2, dtype=torch.bool))
        assert state[2][0, :, 0].tolist() == [1, 2, 0, 0]
    np.testing.assert_allclose(boxes[0, :2, 0], [5.0 * 59, 300.0 - 5.0 * 59], atol=0.5)


def test_low_scores_keep_a_track_and_begin_none() -> None:
    def identities(scores: list[float]) -> list[int]:
        state, seen = start(2), []
        for k, score in enumerate(scores):
            found = torch.tensor([[True]])
            *state, _, _, _ = byte_track(*state, one(3.0 * k), torch.tensor([[score]]), found)
            seen.append(int(state[2][0, 0, 0]))
        return seen

    assert identities([0.5, 0.65, 0.75, 0.65, 0.3, 0.2]) == [0, 0, 1, 1, 1, 1]
    assert identities([0.9, 0.05]) == [1, 0]


def test_more_objects_than_slots() -> None:
    """The first detections get the slots; the next one gets a slot that becomes free."""
    four = torch.cat([one(100.0 * k) for k in range(4)], 1)
    state = start(2)
    *state, _, index, _ = sort_track(*state, four, torch.ones(1, 4, dtype=torch.bool))
    assert state[2][0, :, 0].tolist() == [1, 2] and index.tolist() == [[0, 1]]
    *state, _, index, _ = sort_track(*state, four, torch.tensor([[False, True, False, True]]))
    assert state[2][0, :, 0].tolist() == [3, 2] and index.tolist() == [[3, 1]]
    assert state[3].tolist() == [3]


def test_scenes_of_a_batch_do_not_touch_each_other() -> None:
    scenes = [[in_slots(*frame) for frame in scene(seed, 20)] for seed in (7, 8)]
    together, alone = start(batch=2), [start(), start()]
    for frames in zip(*scenes, strict=True):
        joined = [torch.cat(part) for part in zip(*frames, strict=True)]
        *together, boxes, _, _ = byte_track(*together, *joined)
        for b in range(2):
            *alone[b], own, _, _ = byte_track(*alone[b], *frames[b])
            for whole, part in zip([*together, boxes], [*alone[b], own], strict=True):
                torch.testing.assert_close(whole[b : b + 1], part)


def test_what_is_no_detection() -> None:
    boxes = torch.tensor([[[0.0, 0.0, 0.0, 9.0], [5.0, 5.0, 4.0, 9.0], [0.0, 0.0, torch.inf, 4.0]]])
    *state, tracked, _, shown = sort_track(*start(dtype=torch.float32), boxes, torch.ones(1, 3).bool())
    assert not state[2].any() and not tracked.any() and not shown.any()
    *state, _, _, _ = sort_track(*state, torch.zeros(1, 0, 4), torch.zeros(1, 0).bool())
    *state, _, _, _ = byte_track(*state, torch.zeros(1, 0, 4), torch.zeros(1, 0), torch.zeros(1, 0).bool())
    assert not state[2].any() and state[0].dtype == torch.float32


def test_without_slots_nothing_is_tracked() -> None:
    scores, found = torch.rand(2, 3), torch.ones(2, 3).bool()
    for state in (
        sort_track(*start(0, 2), torch.rand(2, 3, 4), found),
        byte_track(*start(0, 2), torch.rand(2, 3, 4), scores, found),
    ):
        assert [x.numel() for x in state] == [0, 0, 0, 2, 0, 0, 0]
        assert state[1].shape == (2, 0, 7, 7) and state[4].shape == (2, 0, 4)
        assert state[3].eq(0).all()


def test_the_how_to_follows_objects() -> None:
    """Section 4 of docs/howto/detector.md, with a detector that finds two boxes, which move apart."""
    page = (Path(__file__).parents[2] / "docs" / "howto" / "detector.md").read_text()
    block = re.findall(r"```python\n(.*?)```", page.partition("## 4.")[2], re.DOTALL)[0]
    scope: dict[str, Any] = {"np": np}
    exec(block, scope)

    def detector(frame: np.ndarray) -> tuple[np.ndarray, ...]:
        boxes = torch.cat([one(200.0 + 3.0 * frame[0]), one(100.0 - 3.0 * frame[0])], 1).float().numpy()
        scores = np.array([[0.9, 0.8 if frame[0] < 3 else 0.3]], np.float32)
        return boxes, scores, np.zeros((1, 2), np.int64), np.ones((1, 2), bool)

    def tracker(*inputs: np.ndarray) -> list[np.ndarray]:
        return [part.numpy() for part in byte_track(*map(torch.from_numpy, inputs))]

    seen = list(scope["follow"](detector, tracker, np.arange(6), slots=5))
    assert [sorted(frame) for frame in seen] == [[]] + [[1, 2]] * 5
    np.testing.assert_allclose(seen[5][1], [215.0, 50.0, 255.0, 130.0], atol=0.1)
    np.testing.assert_allclose(seen[5][2], [85.0, 50.0, 125.0, 130.0], atol=0.1)


T, X, S, F = start(2, dtype=torch.float32), torch.rand(1, 3, 4), torch.rand(1, 3), torch.ones(1, 3).bool()


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: sort_track(T[0][..., :4], *T[1:], X, F), ValueError, r"mean: expected shape \(\*, 7\)"),
        (lambda: sort_track(T[0].int(), *T[1:], X, F), TypeError, "mean: expected a floating-point"),
        (
            lambda: sort_track(T[0], T[0], *T[2:], X, F),
            ValueError,
            r"covariance: expected shape \[1, 2, 7, 7\]",
        ),
        (lambda: sort_track(*T[:2], T[2].int(), T[3], X, F), TypeError, "counters: expected dtype int64"),
        (lambda: sort_track(*T[:3], T[2], X, F), ValueError, r"last_id: expected shape \[1\]"),
        (lambda: sort_track(*T, X[0], F), ValueError, r"boxes: expected shape \(B, M, 4\)"),
        (lambda: sort_track(*T, X.expand(2, 3, 4), F), ValueError, r"boxes: expected shape \[1, 3, 4\]"),
        (lambda: sort_track(*T, X, F[:, :2]), ValueError, r"found: expected shape \[1, 3\]"),
        (lambda: sort_track(*T, X, S), TypeError, "found: expected dtype bool"),
        (lambda: sort_track(*T, X, F, max_age=0), ValueError, "max_age: expected a positive number, got 0"),
        (lambda: sort_track(*T, X, F, min_hits=0), ValueError, "min_hits: expected a positive number"),
        (lambda: byte_track(*T, X, S[:, :1], F), ValueError, r"scores: expected shape \[1, 3\]"),
        (lambda: byte_track(*T, X, F, F), TypeError, "scores: expected a floating-point"),
    ],
)
def test_errors(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
