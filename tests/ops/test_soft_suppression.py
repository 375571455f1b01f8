"""Soft non-maximum suppression: against the paper's algorithm in NumPy, and against OpenCV."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch

from chiasm import ops


def detections(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    corner = random.uniform(0, 60, (count, 2))
    boxes = np.concatenate([corner, corner + random.uniform(10, 40, (count, 2))], 1)
    return boxes, random.uniform(0, 1, count)


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    width = max(min(a[2], b[2]) - max(a[0], b[0]), 0)
    height = max(min(a[3], b[3]) - max(a[1], b[1]), 0)
    areas = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1])
    return width * height / (areas - width * height)


def by_the_paper(
    boxes: np.ndarray,
    scores: np.ndarray,
    most: int,
    method: str,
    sigma: float,
    least: float,
    threshold: float,
) -> tuple[list[int], list[float]]:
    """Figure 2, with the factors of section 3: finally all boxes above the threshold are kept."""
    left = {i: float(s) for i, s in enumerate(scores)}
    picked: list[int] = []
    final: list[float] = []
    while left:
        best = min(left, key=lambda i: (-left[i], i))
        picked.append(best)
        final.append(left.pop(best))
        for i in left:
            o = overlap(boxes[best], boxes[i])
            if method == "gaussian":
                left[i] *= np.exp(-(o**2) / sigma)
            elif o >= least:
                left[i] *= 1 - o
    kept = [k for k in range(len(picked)) if final[k] > threshold][:most]
    return [picked[k] for k in kept], [final[k] for k in kept]


@pytest.mark.parametrize("method", ["gaussian", "linear"])
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("scripted", [False, True])
def test_the_papers_algorithm(method: str, seed: int, scripted: bool) -> None:
    call = torch.jit.script(ops.soft_nms) if scripted else ops.soft_nms
    made = [detections(50, 2 * seed + k) for k in range(2)]
    scores = np.stack([(s * 10).round() / 10 for _, s in made])  # with ties, and zeros
    boxes = np.stack([b for b, _ in made])
    index, left, kept = call(torch.from_numpy(boxes), torch.from_numpy(scores), 30, method, 0.4, 0.25, 0.05)
    for b in range(2):
        picked, final = by_the_paper(boxes[b], scores[b], 30, method, 0.4, 0.25, 0.05)
        count = len(picked)
        assert index[b].tolist() == picked + [0] * (30 - count)
        np.testing.assert_allclose(left[b], final + [0.0] * (30 - count), atol=1e-14)
        assert kept[b].tolist() == [k < count for k in range(30)]


@pytest.mark.parametrize("method", ["gaussian", "linear"])
@pytest.mark.parametrize("seed", range(10))
def test_opencv(method: str, seed: int) -> None:
    """OpenCV has integer boxes and float32 scores; no overlap equals the threshold."""
    boxes, scores = detections(30, seed)
    boxes, scores = boxes.round(), scores.astype(np.float32)
    sides = np.concatenate([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]], 1).astype(int)
    way = (
        cv2.dnn.SOFT_NMSMETHOD_SOFTNMS_GAUSSIAN
        if method == "gaussian"
        else cv2.dnn.SOFT_NMSMETHOD_SOFTNMS_LINEAR
    )
    final, picked = cv2.dnn.softNMSBoxes(sides.tolist(), scores.tolist(), 0.1, 0.3123, sigma=0.5, method=way)
    index, left, kept = ops.soft_nms(
        torch.from_numpy(boxes)[None], torch.from_numpy(scores)[None], 30, method, 0.5, 0.3123, 0.1
    )
    count = int(kept.sum())
    assert 3 < count < 30
    assert index[0, :count].tolist() == np.ravel(picked).tolist()
    np.testing.assert_allclose(left[0, :count], np.ravel(final), atol=1e-5)


def test_what_is_no_detection() -> None:
    boxes = torch.tensor(
        [[[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 2.0], [4.0, 4.0, 4.0, 4.0], [4.0, 4.0, 4.0, 4.0]]]
    )
    scores = torch.tensor([[torch.nan, 0.5, 0.6, 0.7]])
    index, left, kept = ops.soft_nms(boxes, scores, 5)
    assert index.tolist() == [[3, 2, 1, 0, 0]] and kept.tolist() == [[True, True, True, False, False]]
    torch.testing.assert_close(left, torch.tensor([[0.7, 0.6, 0.5, 0.0, 0.0]]))
    # An identical box gets a score of 0
    scores = torch.tensor([[0.9, 0.8, -1.0, 0.0]])
    index, left, kept = ops.soft_nms(boxes, scores, 3, "linear", score_threshold=-5.0)
    assert index.tolist() == [[0, 1, 3]] and left[0, :2].tolist() == [scores[0, 0].item(), 0.0]


def test_no_boxes() -> None:
    index, left, kept = ops.soft_nms(torch.zeros(2, 0, 4), torch.zeros(2, 0), 3)
    assert index.tolist() == [[0] * 3] * 2 and not left.any() and not kept.any()


X, S = torch.rand(1, 5, 4), torch.rand(1, 5)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.soft_nms(X[0], S, 3), ValueError, r"boxes: expected shape \(B, N, 4\)"),
        (lambda: ops.soft_nms(X, S[0], 3), ValueError, r"scores: expected shape \[1, 5\]"),
        (lambda: ops.soft_nms(X, S.int(), 3), TypeError, "scores: expected a floating-point"),
        (lambda: ops.soft_nms(X, S, 0), ValueError, "max_output: expected a positive number, got 0"),
        (lambda: ops.soft_nms(X, S, 3, "hard"), ValueError, "method: expected one of"),
        (lambda: ops.soft_nms(X, S, 3, sigma=0.0), ValueError, "sigma: expected a positive number"),
    ],
)
def test_errors(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
