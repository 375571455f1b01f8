"""Metrics of boxes against OpenCV, scikit-learn, and the rules of Pascal VOC written as loops."""

import cv2
import numpy as np
import pytest
import torch
from sklearn.metrics import precision_recall_curve
from torch import Tensor

from chiasm.metrics import mean_average_precision, mean_iou_bbox

BOX = torch.zeros(1, 2, 4)
LABEL = torch.ones(1, 2, dtype=torch.int64)
SCORE = torch.zeros(1, 2)


def boxes(*shape: int, seed: int, size: float = 8.0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    corner = torch.rand(*shape, 2, generator=generator, dtype=torch.float64) * 10
    return torch.cat(
        [corner, corner + 0.5 + torch.rand(*shape, 2, generator=generator, dtype=torch.float64) * size], -1
    )


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    """The overlap by the areas of polygons that OpenCV intersects."""
    corners = [np.array([(x1, y1), (x2, y1), (x2, y2), (x1, y2)], np.float32) for x1, y1, x2, y2 in (a, b)]
    common = cv2.intersectConvexConvex(*corners)[0]
    return common / (cv2.contourArea(corners[0]) + cv2.contourArea(corners[1]) - common)


# --- overlap ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize(("n", "m"), [(1, 1), (5, 7), (31, 3)])
def test_iou_equals_polygons(n: int, m: int, dtype: torch.dtype) -> None:
    a, b = boxes(n, seed=0), boxes(m, seed=1)
    actual = mean_iou_bbox(a.to(dtype), b.to(dtype))
    expected = [[overlap(p, q) for q in b.numpy()] for p in a.numpy()]
    np.testing.assert_allclose(actual, expected, atol=2e-6)
    sized = [torch.cat([x[:, :2], x[:, 2:] - x[:, :2]], 1).to(dtype) for x in (a, b)]
    np.testing.assert_allclose(mean_iou_bbox(*sized, "xywh"), expected, atol=2e-6)


def test_empty_boxes_overlap_nothing() -> None:
    empty = torch.tensor(
        [[1.0, 1.0, 1.0, 1.0], [3.0, 3.0, 2.0, 2.0], [0.0, 0.0, 4.0, 4.0]], requires_grad=True
    )
    actual = mean_iou_bbox(empty, empty)
    assert actual.tolist() == [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    actual.sum().backward()
    assert torch.isfinite(empty.grad).all()


# --- average precision --------------------------------------------------------------------------------------


def voc(images: list[dict[str, np.ndarray]], n_classes: int, threshold: float) -> list[float]:
    """The average precision of each class by the challenge's rules: image by image, detection by
    detection."""
    result = []
    for c in range(1, n_classes):
        ranked = sorted(
            (
                (score, i, k)
                for i, image in enumerate(images)
                for k, score in enumerate(image["scores"])
                if image["labels"][k] == c
            ),
            key=lambda item: -item[0],
        )
        there = sum(int((image["gt_labels"] == c).sum()) for image in images)
        taken, right, curve = set(), 0, []
        for seen, (_, i, k) in enumerate(ranked, 1):
            image = images[i]
            own = [
                (overlap(image["boxes"][k], g), j)
                for j, g in enumerate(image["gt_boxes"])
                if image["gt_labels"][j] == c
            ]
            best, j = max(own, default=(0.0, -1), key=lambda item: item[0])
            if best > threshold and (i, j) not in taken:
                taken.add((i, j))
                right += 1
            curve.append((right / there if there else 0.0, right / seen))
        result.append(
            np.mean(
                [
                    max((p for r, p in curve if there and r >= t - 1e-9), default=0.0)
                    for t in np.linspace(0, 1, 11)
                ]
            )
        )
    return result


def scene(
    batch: int, found: int, there: int, classes: int, seed: int
) -> tuple[list[dict[str, np.ndarray]], dict[str, Tensor]]:
    """Images with fewer boxes than slots, as lists and as padded tensors."""
    random = np.random.default_rng(seed)
    images = []
    padded = {
        "pred_boxes": boxes(batch, found, seed=seed),
        "pred_labels": torch.full((batch, found), 1),
        "pred_scores": torch.rand(batch, found).double(),
        "gt_boxes": boxes(batch, there, seed=seed + 1),
        "gt_labels": torch.full((batch, there), 1),
        "pred_mask": torch.zeros(batch, found, dtype=torch.bool),
        "gt_mask": torch.zeros(batch, there, dtype=torch.bool),
    }
    for b in range(batch):
        gt = random.integers(0, there + 1)
        gt_boxes, gt_labels = boxes(gt, seed=100 * seed + b).numpy(), random.integers(1, classes, gt)
        # detections are moved true boxes, some twice, and some with a wrong class
        count = random.integers(0, found + 1) if gt else 0
        which = random.integers(0, max(gt, 1), count)
        found_boxes = gt_boxes[which] + random.uniform(-0.8, 0.8, (count, 4)) if gt else np.zeros((0, 4))
        found_boxes[:, 2:] = np.maximum(found_boxes[:, 2:], found_boxes[:, :2] + 0.1)
        found_labels = np.where(
            random.random(count) < 0.8, gt_labels[which] if gt else 0, random.integers(1, classes, count)
        )
        images.append(
            {
                "boxes": found_boxes,
                "labels": found_labels,
                "scores": random.random(count),
                "gt_boxes": gt_boxes,
                "gt_labels": gt_labels,
            }
        )
        for kind, values, n in (
            ("pred", ("boxes", "labels", "scores"), count),
            ("gt", ("gt_boxes", "gt_labels"), gt),
        ):
            for value in values:
                name = value if kind == "gt" else f"pred_{value}"
                padded[name][b, :n] = torch.from_numpy(images[-1][value])
            padded[f"{kind}_mask"][b, :n] = True
    return images, padded


@pytest.mark.parametrize("threshold", [0.3, 0.5])
@pytest.mark.parametrize(
    ("batch", "found", "there", "classes"), [(1, 9, 5, 2), (3, 21, 11, 4), (17, 8, 13, 6)]
)
def test_average_precision_by_the_rules(
    batch: int, found: int, there: int, classes: int, threshold: float
) -> None:
    for seed in range(3):
        images, padded = scene(batch, found, there, classes, seed)
        mean, each = mean_average_precision(**padded, n_classes=classes, threshold=threshold)
        expected = voc(images, classes, threshold)
        np.testing.assert_allclose(each, expected, atol=1e-12)
        assert mean.item() == pytest.approx(np.mean(expected))
        void = {k: v for k, v in padded.items() if not k.endswith("mask")}
        for kind in ("pred", "gt"):
            void[f"{kind}_labels"] = torch.where(
                padded[f"{kind}_mask"], padded[f"{kind}_labels"], torch.tensor([0, -1, classes])[seed]
            )
        assert torch.equal(mean_average_precision(**void, n_classes=classes, threshold=threshold)[1], each)


def test_precisions_are_sklearns() -> None:
    """Separate detections, some of them far from the true box: a classification of scores."""
    generator = torch.Generator().manual_seed(5)
    count = 37
    truth = torch.rand(count, generator=generator) < 0.6
    scores = torch.rand(1, count, generator=generator, dtype=torch.float64) + 0.3 * truth
    start = 10.0 * torch.arange(count)[:, None] + torch.tensor([0.0, 0.0, 4.0, 4.0])
    there = start[truth]
    one = torch.ones(1, count, dtype=torch.int64)
    _, each = mean_average_precision(start[None], one, scores, there[None], one[:, : len(there)], 2)
    precision, recall, _ = precision_recall_curve(truth, scores[0])
    expected = np.mean(
        [
            precision[recall >= t - 1e-9].max() if (recall[:-1] >= t - 1e-9).any() else 0.0
            for t in np.linspace(0, 1, 11)
        ]
    )
    assert each.item() == pytest.approx(expected, abs=1e-7)


def test_of_equal_scores_the_first_has_the_box() -> None:
    box = torch.tensor([[[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 2.0]]])
    label = torch.ones(1, 2, dtype=torch.int64)
    mean, _ = mean_average_precision(box, label, torch.tensor([[0.5, 0.5]]), box[:, :1], label[:, :1], 2)
    assert mean.item() == 1.0  # the second is wrong, but comes after full recall


@pytest.mark.parametrize(("images", "n", "m"), [(0, 3, 2), (2, 0, 2), (2, 3, 0), (2, 0, 0)])
def test_without_detections_or_true_boxes_the_precision_is_zero(images: int, n: int, m: int) -> None:
    found, true = torch.rand(images, n, 4), torch.rand(images, m, 4)
    labels = torch.ones(images, n, dtype=torch.int64), torch.ones(images, m, dtype=torch.int64)
    mean, each = mean_average_precision(found, labels[0], torch.rand(images, n), true, labels[1], 3)
    assert mean == 0 and each.tolist() == [0.0, 0.0]


def test_recall_of_tenths_is_exact() -> None:
    """3 of 10 are found: a recall of 0.3 is reached, although a sum of tenths would not give exactly 0.3."""
    gt = torch.cat([10.0 * torch.arange(10)[:, None], torch.zeros(10, 1)], 1)
    gt = torch.cat([gt, gt + 4.0], 1)[None]
    label = torch.ones(1, 10, dtype=torch.int64)
    mean, _ = mean_average_precision(gt[:, :3], label[:, :3], torch.rand(1, 3), gt, label, 2)
    assert mean.item() == pytest.approx(4 / 11)


WRONG = [
    (lambda: mean_iou_bbox(BOX, BOX[0]), ValueError, r"boxes_1: expected shape \(N, 4\)"),
    (lambda: mean_iou_bbox(BOX[0], BOX[0, :, :3]), ValueError, r"boxes_2: expected shape \(\*, 4\)"),
    (lambda: mean_iou_bbox(BOX[0].int(), BOX[0]), TypeError, "boxes_1: expected a floating-point"),
    (lambda: mean_iou_bbox(BOX[0], BOX[0], "polar"), ValueError, "box_format: expected one of .*got 'polar'"),
    (
        lambda: mean_average_precision(BOX[0], LABEL, SCORE, BOX, LABEL, 2),
        ValueError,
        r"pred_boxes: expected shape \(B, N, 4\)",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX.int(), LABEL, 2),
        TypeError,
        "gt_boxes: expected a floating-point",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX.expand(3, 2, 4), LABEL, 2),
        ValueError,
        "gt_boxes: expected as many images",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL[:, :1], SCORE, BOX, LABEL, 2),
        ValueError,
        r"pred_labels: expected shape \[1, 2\], got \[1, 1\]",
    ),
    (
        lambda: mean_average_precision(BOX, SCORE, SCORE, BOX, LABEL, 2),
        TypeError,
        "pred_labels: expected an integer",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE[0], BOX, LABEL, 2),
        ValueError,
        r"pred_scores: expected shape \[1, 2\], got \[2\]",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, LABEL, BOX, LABEL, 2),
        TypeError,
        "pred_scores: expected a floating-point",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX, SCORE, 2),
        TypeError,
        "gt_labels: expected an integer",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX, LABEL, 1),
        ValueError,
        "n_classes: expected at least 2, got 1",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX, LABEL, 2, 1.0),
        ValueError,
        r"threshold: expected a number in \[0, 1\), got 1.0",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX, LABEL, 2, 0.5, LABEL),
        TypeError,
        "pred_mask: expected a bool",
    ),
    (
        lambda: mean_average_precision(BOX, LABEL, SCORE, BOX, LABEL, 2, 0.5, None, LABEL[:, :1] > 0),
        ValueError,
        r"gt_mask: expected shape \[1, 2\]",
    ),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
