"""SORT and BYTE as defined in their papers, on lists of tracks, in NumPy and SciPy; and scenes for
tracking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import linear_sum_assignment

MOVES = np.eye(7) + np.diag(np.ones(3), 4)
MOVES_BY = np.diag([1, 1, 1, 1, 0.01, 0.01, 0.0001])
MEASURED_BY = np.diag([1, 1, 10, 10])
UNKNOWN = block_diag(10 * np.eye(4), 10000 * np.eye(3))


@dataclass
class Track:
    identity: int
    state: np.ndarray
    spread: np.ndarray
    age: int = 0
    hits: int = 1
    since: int = 0
    detection: int = 0

    def predict(self) -> None:
        if self.state[2] + self.state[6] <= 0:
            self.state[6] = 0
        self.state = MOVES @ self.state
        self.spread = MOVES @ self.spread @ MOVES.T + MOVES_BY

    def update(self, box: np.ndarray) -> None:
        """In information form (inverse covariances)."""
        before, weight = np.linalg.inv(self.spread), np.eye(7)[:, :4] @ np.linalg.inv(MEASURED_BY)
        self.spread = np.linalg.inv(before + weight @ np.eye(7)[:4])
        self.state = self.spread @ (before @ self.state + weight @ measured(box))

    @property
    def box(self) -> np.ndarray:
        x, y, area, ratio = self.state[:4]
        width, height = np.sqrt(area * ratio), np.sqrt(area / ratio)
        return np.array([x - width / 2, y - height / 2, x + width / 2, y + height / 2])


def measured(box: np.ndarray) -> np.ndarray:
    width, height = box[2] - box[0], box[3] - box[1]
    return np.array([(box[0] + box[2]) / 2, (box[1] + box[3]) / 2, width * height, width / height])


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    width, height = np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])
    if width <= 0 or height <= 0:
        return 0.0
    area = width * height
    return area / (np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - area)


class Tracker:
    """Associates in rounds: each round takes the detections whose scores are above its entry of ``rounds``,
    but not above the entry before. New tracks begin at detections of the first round with scores above
    ``new``."""

    def __init__(self, least: float, max_age: int, min_hits: int, rounds: list[float], new: float) -> None:
        self.least, self.max_age, self.min_hits = least, max_age, min_hits
        self.rounds, self.new = rounds, new
        self.tracks: list[Track] = []
        self.given = 0

    def frame(self, boxes: np.ndarray, scores: np.ndarray) -> None:
        for track in self.tracks:
            track.predict()
        waiting, most, begins = list(self.tracks), np.inf, []
        for threshold in self.rounds:
            candidates = [j for j in range(len(boxes)) if threshold < scores[j] <= most]
            pairs = self.pairs(waiting, boxes, candidates)
            if most == np.inf:
                begins = [j for j in candidates if j not in {j for _, j in pairs} and scores[j] > self.new]
            for track, j in pairs:
                track.update(boxes[j])
                track.hits, track.since, track.detection = track.hits + 1, 0, j
                waiting.remove(track)
            most = threshold
        for track in waiting:
            track.since, track.detection = track.since + 1, 0
        for track in self.tracks:
            track.age += 1
        self.tracks = [
            t for t in self.tracks if t.since == 0 or (t.since < self.max_age and t.hits >= self.min_hits)
        ]
        for j in begins:
            self.given += 1
            state = np.concatenate([measured(boxes[j]), np.zeros(3)])
            self.tracks.append(Track(self.given, state, UNKNOWN.copy(), detection=j))

    def pairs(self, tracks: list[Track], boxes: np.ndarray, candidates: list[int]) -> list[tuple[Track, int]]:
        if not tracks or not candidates:
            return []
        overlaps = np.array([[overlap(t.box, boxes[j]) for j in candidates] for t in tracks])
        rows, columns = linear_sum_assignment(overlaps, maximize=True)
        return [
            (tracks[i], candidates[j])
            for i, j in zip(rows, columns, strict=True)
            if overlaps[i, j] >= self.least
        ]


def scene(seed: int, frames: int, objects: int = 8) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each frame, boxes and their scores in descending order: objects that move straight and cross, are
    missed, have low scores if occluded, and come and go; and false detections."""
    random = np.random.default_rng(seed)
    centre, speed = random.uniform(0, 400, (objects, 2)), random.uniform(-4, 4, (objects, 2))
    size, begin = random.uniform(30, 80, (objects, 2)), random.integers(0, frames // 3, objects)
    end = begin + random.integers(frames // 3, frames, objects)
    result = []
    for k in range(frames):
        there = (begin <= k) & (k < end) & (random.random(objects) > 0.1)
        middle = (centre + k * speed + random.normal(0, 1, (objects, 2)))[there]
        half = (size * random.uniform(0.97, 1.03, (objects, 2)))[there] / 2
        boxes = np.concatenate([middle - half, middle + half], 1)
        scores = np.where(random.random(len(boxes)) < 0.25, random.uniform(0.1, 0.6, len(boxes)), 0.0)
        scores = np.where(scores > 0, scores, random.uniform(0.6, 1.0, len(boxes)))
        corner = random.uniform(0, 400, (random.integers(0, 3), 2))
        false = np.concatenate([corner, corner + random.uniform(20, 60, corner.shape)], 1)
        boxes = np.concatenate([boxes, false])
        scores = np.concatenate([scores, random.uniform(0, 0.9, len(false))])
        order = np.argsort(-scores)
        result.append((boxes[order], scores[order]))
    return result
