"""Boxes of detectors: against torchvision, and decoders against loops in NumPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
import torchvision
from torch import Tensor
from torch.autograd import gradcheck

from chiasm import ops


def boxes(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    """Boxes of positive size; many overlap."""
    generator = torch.Generator().manual_seed(seed)
    corner = torch.rand((*shape, 2), generator=generator, dtype=torch.float64) * 40
    size = 3 + 20 * torch.rand((*shape, 2), generator=generator, dtype=torch.float64)
    return torch.cat([corner, corner + size], -1).to(dtype)


PAIRS = ["box_iou", "generalized_box_iou", "distance_box_iou", "complete_box_iou"]


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize(("n", "m"), [(1, 1), (7, 5), (0, 3), (40, 60)])
def test_pairs_are_torchvisions(name: str, n: int, m: int) -> None:
    first, second = boxes(n), boxes(m, seed=1)
    expected = getattr(torchvision.ops, name)(first, second)
    torch.testing.assert_close(getattr(ops, name)(first, second), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", PAIRS)
def test_leading_dimensions_are_torchvisions(name: str) -> None:
    first, second = boxes(2, 3, 7), boxes(3, 5, seed=1)
    for call in (getattr(ops, name), torch.jit.script(getattr(ops, name))):
        torch.testing.assert_close(call(first, second), getattr(torchvision.ops, name)(first, second))
    torch.testing.assert_close(ops.box_area(first), torchvision.ops.box_area(first))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
@pytest.mark.parametrize("name", ["box_area", *PAIRS, *(f"{pair}_loss" for pair in PAIRS[1:])])
def test_areas_beyond_half_precision(name: str, dtype: torch.dtype) -> None:
    """The area of the least of these boxes is 270^2, and float16 ends at 65504."""
    given = [(90 * boxes(9, seed=seed)).to(dtype) for seed in ([0] if name == "box_area" else [0, 1])]
    actual = getattr(ops, name)(*given)
    expected = getattr(torchvision.ops, name)(*(x.float() for x in given))
    assert actual.dtype == torch.float32 and expected.isfinite().all()
    torch.testing.assert_close(actual, expected)


LOSSES = ["generalized_box_iou_loss", "distance_box_iou_loss", "complete_box_iou_loss"]


@pytest.mark.parametrize("name", LOSSES)
@pytest.mark.parametrize("reduction", ["mean", "sum", "none"])
def test_losses_of_no_boxes_are_torchvisions(name: str, reduction: str) -> None:
    for call in (getattr(ops, name), torch.jit.script(getattr(ops, name))):
        none = torch.zeros(0, 4, requires_grad=True)
        actual = call(none, torch.zeros(0, 4), reduction)
        expected = getattr(torchvision.ops, name)(torch.zeros(0, 4), torch.zeros(0, 4), reduction)
        assert torch.equal(actual.detach(), expected)
        assert torch.autograd.grad(actual.sum(), none)[0].shape == (0, 4)


@pytest.mark.parametrize("name", LOSSES)
@pytest.mark.parametrize("reduction", ["none", "mean", "sum"])
def test_losses_and_their_gradients_are_torchvisions(name: str, reduction: str) -> None:
    ours, theirs = boxes(20).requires_grad_(), boxes(20).requires_grad_()
    target = boxes(20, seed=1)
    actual = getattr(ops, name)(ours, target, reduction)
    expected = getattr(torchvision.ops, name)(theirs, target, reduction)
    torch.testing.assert_close(actual, expected, rtol=0, atol=1e-12)
    actual.sum().backward()
    expected.sum().backward()
    torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", LOSSES[:2])
def test_gradients_of_losses(name: str) -> None:
    loss = getattr(ops, name)
    assert gradcheck(loss, (boxes(5).requires_grad_(), boxes(5, seed=1).requires_grad_()))


def test_boxes_without_height_have_gradients() -> None:
    """The value is torchvision's, also of corners in the wrong order; only its gradient is NaN there."""
    flat, target = torch.tensor([[1.0, 2.0, 6.0, 2.0]], dtype=torch.float64), boxes(1)
    for other in (flat, flat[:, [2, 1, 0, 3]], target[:, [0, 3, 2, 1]], target[:, [2, 1, 0, 3]]):
        for pair in ((other, target), (target, other)):
            mine = [x.clone().requires_grad_() for x in pair]
            loss = ops.complete_box_iou_loss(*mine)
            torch.testing.assert_close(loss.detach(), torchvision.ops.complete_box_iou_loss(*pair))
            loss.sum().backward()
            assert all(x.grad is not None and x.grad.isfinite().all() for x in mine)
    flat.requires_grad_()
    (grad,) = torch.autograd.grad(ops.complete_box_iou(flat, target).sum(), flat)
    assert grad.isfinite().all()
    empty = torch.ones(1, 4, dtype=torch.float64, requires_grad=True)
    loss = ops.complete_box_iou_loss(empty, target)
    (grad,) = torch.autograd.grad(loss.sum(), empty)
    assert loss.isfinite().all() and grad.isfinite().all()


@pytest.mark.parametrize("source", ["xyxy", "xywh", "cxcywh"])
@pytest.mark.parametrize("target", ["xyxy", "xywh", "cxcywh"])
def test_formats_are_torchvisions(source: str, target: str) -> None:
    x = torchvision.ops.box_convert(boxes(9), "xyxy", source)
    expected = torchvision.ops.box_convert(x, source, target)
    torch.testing.assert_close(ops.box_convert(x, source, target), expected)


def test_areas_clips_and_sizes_are_torchvisions() -> None:
    x = boxes(30) - 10
    torch.testing.assert_close(ops.box_area(x), torchvision.ops.box_area(x))
    clipped = ops.clip_boxes_to_image(x, (20, 30))
    torch.testing.assert_close(clipped, torchvision.ops.clip_boxes_to_image(x, (20, 30)))
    for least in (0.0, 5.0, 100.0):
        assert torch.equal(ops.remove_small_boxes(x, least), torchvision.ops.remove_small_boxes(x, least))


@pytest.mark.parametrize("seed", range(40))
def test_suppression_is_torchvisions(seed: int) -> None:
    """With ties of scores; no overlap is so close to the threshold that rounding would decide."""
    generator = torch.Generator().manual_seed(seed)
    n = int(torch.randint(1, 300, (), generator=generator))
    x = boxes(n, seed=seed)
    scores = (torch.rand(n, generator=generator, dtype=torch.float64) * 20).round() / 20
    labels = torch.randint(0, 4, (n,), generator=generator)
    expected = torchvision.ops.batched_nms(x, scores, labels, 0.4)
    # torchvision sorts stably, so boxes of equal score keep their order
    assert torch.equal(ops.batched_nms(x, scores, labels, 0.4), expected)
    assert torch.equal(ops.nms(x, scores, 0.4), torchvision.ops.nms(x, scores, 0.4))
    slots, found = ops.batched_nms_fixed(x[None], scores[None], labels[None], 0.4, 20, 0.3)
    best = expected[scores[expected] > 0.3][:20]
    assert slots[0].tolist() == best.tolist() + [0] * (20 - len(best))
    assert found[0].tolist() == [True] * len(best) + [False] * (20 - len(best))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_suppression_of_boxes_of_half_precision(dtype: torch.dtype) -> None:
    x = (20 * boxes(200)).to(dtype)
    scores = torch.randperm(200).to(torch.float32) / 256
    kept = torchvision.ops.nms(x.float(), scores, 0.4)
    assert torch.equal(ops.nms(x, scores, 0.4), kept) and len(kept) < 150
    slots, _ = ops.batched_nms_fixed(x[None], scores[None], torch.zeros(1, 200, dtype=torch.int64), 0.4, 20)
    assert torch.equal(slots[0], kept[:20])


def test_scores_of_nan_suppress_nothing() -> None:
    x, scores, labels = boxes(100), torch.rand(100, dtype=torch.float64), torch.randint(0, 3, (100,))
    scores[::3] = float("nan")
    known = torch.where(scores > 0.2)[0]
    expected = known[torchvision.ops.batched_nms(x[known], scores[known], labels[known], 0.4)]
    slots, found = ops.batched_nms_fixed(x[None], scores[None], labels[None], 0.4, 30, 0.2)
    assert slots[0][found[0]].tolist() == expected[:30].tolist() and len(expected) > 5


def test_boxes_with_corners_in_the_wrong_order_suppress_nothing() -> None:
    x = boxes(60)
    x[::4, 2] = x[::4, 0] - 1000  # an area below -3000, so that unions are negative
    x[1::4, 3] = x[1::4, 1] - 1000
    scores = torch.rand(60, dtype=torch.float64)
    expected = torchvision.ops.nms(x, scores, 0.3)
    assert torch.equal(ops.nms(x, scores, 0.3), expected) and len(expected) < 60


def test_any_score_counts_without_a_threshold() -> None:
    scores = torch.tensor([-5.0, float("-inf"), -7.0, 0.0], dtype=torch.float64)
    apart = torch.arange(4.0)[:, None] * 10 + torch.tensor([0.0, 0.0, 5.0, 5.0])
    assert ops.nms(apart, scores, 0.5).tolist() == [3, 0, 2, 1]
    assert ops.batched_nms(apart, scores, torch.zeros(4, dtype=torch.int64), 0.5).tolist() == [3, 0, 2, 1]


def test_images_of_a_batch_are_apart() -> None:
    x, scores = boxes(3, 50), torch.rand(3, 50, dtype=torch.float64)
    labels = torch.randint(0, 2, (3, 50))
    together = ops.batched_nms_fixed(x, scores, labels, 0.3, 60)
    for i in range(3):
        alone = ops.batched_nms_fixed(x[i : i + 1], scores[i : i + 1], labels[i : i + 1], 0.3, 60)
        assert torch.equal(together[0][i], alone[0][0]) and torch.equal(together[1][i], alone[1][0])


def expected_detections(
    centred: np.ndarray, scores: np.ndarray, threshold: float, overlap: float, most: int
) -> list[tuple[list[float], float, int]]:
    """The detections in one image, by torchvision."""
    labels, best = scores.argmax(1), scores.max(1)
    chosen = np.flatnonzero(best > threshold)
    corners = np.concatenate(
        [centred[chosen, :2] - centred[chosen, 2:] / 2, centred[chosen, :2] + centred[chosen, 2:] / 2], 1
    )
    kept = torchvision.ops.batched_nms(
        torch.from_numpy(corners), torch.from_numpy(best[chosen]), torch.from_numpy(labels[chosen]), overlap
    )[:most]
    return [(corners[k].tolist(), best[chosen][k], labels[chosen][k]) for k in kept.tolist()]


@pytest.mark.parametrize("classes", [1, 3, 80])
@pytest.mark.parametrize("version", ["v8", "v5"])
def test_yolo(classes: int, version: str) -> None:
    random = np.random.default_rng(classes)
    n, most = 400, 50
    centred = np.concatenate([random.uniform(0, 300, (2, n, 2)), random.uniform(20, 80, (2, n, 2))], 2)
    scores, certain = random.uniform(0, 1, (2, n, classes)), random.uniform(0, 1, (2, n, 1))
    if version == "v8":
        output = torch.from_numpy(np.concatenate([centred, scores], 2)).transpose(1, 2)
        result = ops.decode_yolov8(output, 0.5, 0.3, most)
    else:
        output = torch.from_numpy(np.concatenate([centred, certain, scores], 2))
        result = ops.decode_yolov5(output, 0.5, 0.3, most)
        scores = scores * certain
    for i in range(2):
        expected = expected_detections(centred[i], scores[i], 0.5, 0.3, most)
        assert len(expected) > 0
        assert result[3][i].tolist() == [k < len(expected) for k in range(most)]
        for k, (box, score, label) in enumerate(expected):
            np.testing.assert_allclose(result[0][i, k], box, atol=1e-9)
            assert result[1][i, k] == score and result[2][i, k] == label
        assert all(not part[i, len(expected) :].any() for part in result)


def test_yolo_compares_the_best_places_alone() -> None:
    output = torch.zeros(1, 5, 4)
    output[0, :2] = torch.tensor([10.0, 50.0, 90.0, 130.0])
    output[0, 2:4] = 8.0
    output[0, 4] = torch.tensor([0.4, 0.9, 0.6, 0.8])
    scores = ops.decode_yolov8(output, candidates=2, max_output=4)[1]
    torch.testing.assert_close(scores, torch.tensor([[0.9, 0.8, 0.0, 0.0]]))


@pytest.mark.parametrize("version", ["v8", "v5"])
def test_yolo_ignores_places_with_nan(version: str) -> None:
    random = np.random.default_rng(0)
    centred = np.concatenate([random.uniform(0, 90, (40, 2)), random.uniform(20, 80, (40, 2))], 1)
    scores = random.uniform(0, 1, (40, 3))
    scores[::2, 1] = np.nan
    if version == "v8":
        output = torch.from_numpy(np.concatenate([centred, scores], 1)).T[None]
        result = ops.decode_yolov8(output, 0.5, 0.3, 10, candidates=20)
    else:
        output = torch.from_numpy(np.concatenate([centred, np.ones((40, 1)), scores], 1))[None]
        result = ops.decode_yolov5(output, 0.5, 0.3, 10, candidates=20)
    expected = expected_detections(centred[1::2], scores[1::2], 0.5, 0.3, 10)
    assert result[1][0][result[3][0]].tolist() == [score for _, score, _ in expected]
    np.testing.assert_allclose(result[0][0][result[3][0]], [box for box, _, _ in expected])


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_decoded_boxes_of_half_precision_are_float32(dtype: torch.dtype) -> None:
    """float16 has no 1234.5, and bfloat16 no 257."""
    output = torch.tensor([1240.0, 264.0, 11.0, 14.0, 1.0, 1.0], dtype=dtype)
    centre, side = output[:2].float(), output[2:4].float()  # as far as the dtype has them
    expected = torch.cat([centre - side / 2, centre + side / 2])
    assert torch.equal(ops.decode_yolov8(output[None, :, None])[0][0, 0], expected)
    assert torch.equal(ops.decode_yolov5(output[None, None])[0][0, 0], expected)
    fractions = output[None, None, :4] / 2048
    boxes, scores, _, _ = ops.decode_detr(output[None, None, 4:5], fractions, (2048, 2048), max_output=1)
    assert torch.equal(boxes[0, 0], expected) and scores.dtype == dtype


@pytest.mark.parametrize("unknown", [0, 3])
def test_detr(unknown: int) -> None:
    random = np.random.default_rng(0)
    logits, centred = random.normal(0, 2, (2, 30, 5)), random.uniform(0.1, 0.9, (2, 30, 4))
    logits[:, :unknown] = np.nan
    result = ops.decode_detr(torch.from_numpy(logits), torch.from_numpy(centred), (480, 640), 0.6, 140)
    for i in range(2):
        order = np.argsort(-logits[i].reshape(-1), kind="stable")[:140]  # NaN is last
        scores = 1 / (1 + np.exp(-logits[i].reshape(-1)[order]))
        found = scores > 0.6
        assert 0 < found.sum() < 140
        assert result[3][i].tolist() == found.tolist()
        np.testing.assert_allclose(result[1][i], np.where(found, scores, 0), atol=1e-12)
        assert result[2][i].tolist() == (order % 5 * found).tolist()
        box = centred[i][order // 5] * np.array([640, 480, 640, 480])
        corners = np.concatenate([box[:, :2] - box[:, 2:] / 2, box[:, :2] + box[:, 2:] / 2], 1)
        np.testing.assert_allclose(result[0][i], corners * found[:, None], atol=1e-9)


X, S, L = boxes(1, 5, dtype=torch.float32), torch.rand(1, 5), torch.zeros(1, 5, dtype=torch.int64)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.box_area(X[..., :3]), ValueError, r"boxes: expected shape \(\*, 4\)"),
        (lambda: ops.clip_boxes_to_image(X, (4, 5, 6)), ValueError, "size: expected 2 numbers, got 3"),
        (lambda: ops.box_iou(X[0, 0], X[0]), ValueError, r"boxes1: expected shape \(\.\.\., N, 4\)"),
        (lambda: ops.box_iou(X.expand(2, 5, 4), X.expand(3, 5, 4)), ValueError, "boxes2: expected leading"),
        (lambda: ops.box_convert(X, "yxyx", "xyxy"), ValueError, "in_fmt: expected one of"),
        (lambda: ops.box_iou(X[0], X[0, :, :3]), ValueError, "boxes2: expected"),
        (lambda: ops.box_iou(X[0].int(), X[0]), TypeError, "boxes1: expected"),
        (lambda: ops.generalized_box_iou_loss(X[0], X[0, :2]), ValueError, "boxes2: expected"),
        (lambda: ops.generalized_box_iou_loss(X[0], X[0], "max"), ValueError, "reduction: expected one of"),
        (lambda: ops.batched_nms(X[0], S, L[0], 0.5), ValueError, r"scores: expected .*\(N,\)"),
        (
            lambda: ops.batched_nms_fixed(X, S[:, :2], L, 0.5, 3),
            ValueError,
            r"scores: expected shape \[1, 5\]",
        ),
        (lambda: ops.batched_nms_fixed(X, S, L.int(), 0.5, 3), TypeError, "idxs: expected dtype int64"),
        (lambda: ops.batched_nms_fixed(X, S, L, 0.5, 0), ValueError, "max_output: expected a positive"),
        (lambda: ops.decode_yolov8(X[:, :4]), ValueError, r"output: expected shape \(B, 4 \+ C, N\)"),
        (lambda: ops.decode_yolov8(X[0]), ValueError, "output: expected"),
        (lambda: ops.decode_yolov5(X), ValueError, "output: expected"),
        (lambda: ops.decode_yolov5(torch.rand(1, 3, 6), candidates=0), ValueError, "candidates: expected"),
        (lambda: ops.decode_detr(S[None], X, (4, 5)), ValueError, "pred_boxes: expected shape"),
        (lambda: ops.decode_detr(X, X, (4, 5), max_output=99), ValueError, "max_output: expected a number"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize(
    ("decode", "shape"), [(ops.decode_yolov8, (2, 6, 0)), (ops.decode_yolov5, (2, 0, 7))], ids=["v8", "v5"]
)
def test_no_places_are_no_objects(decode: Callable[..., Any], shape: tuple[int, ...]) -> None:
    for call in (decode, torch.jit.script(decode)):
        boxes, scores, labels, found = call(torch.zeros(shape), score_threshold=-1.0, max_output=5)
        assert torch.equal(boxes, torch.zeros(2, 5, 4)) and torch.equal(scores, torch.zeros(2, 5))
        assert torch.equal(labels, torch.zeros(2, 5, dtype=torch.int64)) and not found.any()
