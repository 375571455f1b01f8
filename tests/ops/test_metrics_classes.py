"""Metrics of classes against scikit-learn and torchmetrics."""

import numpy as np
import pytest
import torch
from sklearn.metrics import confusion_matrix as sklearn_matrix
from sklearn.metrics import jaccard_score, top_k_accuracy_score
from torch import Tensor
from torchmetrics.functional.classification import (
    multiclass_accuracy,
    multiclass_confusion_matrix,
    multiclass_jaccard_index,
)

from chiasm.metrics import Accuracy, accuracy, confusion_matrix, mean_iou

LABELS = torch.zeros(2, 5, dtype=torch.int64)
SCORES = torch.zeros(3, 4)


def labels(*shape: int, classes: int, seed: int) -> Tensor:
    return torch.randint(0, classes, shape, generator=torch.Generator().manual_seed(seed))


def predictions(target: Tensor, classes: int) -> Tensor:
    """Two of three are right."""
    right = torch.rand(target.shape, generator=torch.Generator().manual_seed(9)) < 0.67
    return torch.where(right, target, labels(*target.shape, classes=classes, seed=8))


# --- accuracy -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize(("batch", "classes"), [(1, 3), (3, 5), (301, 17)])
def test_accuracy_equals_sklearn_and_torchmetrics(batch: int, classes: int, dtype: torch.dtype) -> None:
    scores = torch.rand(batch, classes, generator=torch.Generator().manual_seed(0), dtype=torch.float64).to(
        dtype
    )
    target = labels(batch, classes=classes, seed=1)
    actual = accuracy(scores, target, [1, 2, 3])
    assert actual.dtype == dtype and actual.shape == (3,)
    for k, value in zip((1, 2, 3), actual, strict=True):
        expected = (
            top_k_accuracy_score(target, scores, k=k, labels=np.arange(classes)) if classes > k else 1.0
        )
        assert value.item() == pytest.approx(100 * expected, rel=1e-6)
        assert value.item() == pytest.approx(
            100 * multiclass_accuracy(scores, target, classes, "micro", k).item(), rel=1e-6
        )


def test_accuracy_of_more_places_than_classes_is_full() -> None:
    target = labels(7, 1, classes=4, seed=1)
    assert accuracy(torch.rand(7, 4), target, (4, 9)).tolist() == [100.0, 100.0]


def test_ties_go_to_the_lower_class() -> None:
    scores = torch.tensor([[0.5, 0.5, 0.5, 0.1]]).expand(4, 4)
    assert accuracy(scores, torch.arange(4), (1, 2, 3, 4)).tolist() == [25.0, 50.0, 75.0, 100.0]
    order = torch.sort(scores, stable=True, descending=True)[1]
    assert torch.equal(order, torch.arange(4).expand(4, 4))


def test_what_is_no_class_or_no_number_is_never_right() -> None:
    scores = torch.tensor([[0.1, 0.9], [0.1, 0.9], [0.1, torch.nan], [torch.nan, 0.1]])
    assert accuracy(scores, torch.tensor([-1, 2, 1, 1])).item() == 0.0
    assert accuracy(scores[:2], torch.tensor([-1, 2]), [2]).item() == 0.0


def test_accuracy_counts_exactly_beyond_float32() -> None:
    batch = (1 << 24) + 4
    scores = torch.zeros(1, 2, dtype=torch.float64).expand(batch, 2)
    target = torch.zeros(batch, dtype=torch.int64)
    target[0] = 1
    assert accuracy(scores, target).item() == 100.0 * (batch - 1) / batch


def test_default_of_the_module_scripts() -> None:
    scores = torch.eye(3)
    assert torch.jit.script(Accuracy())(scores, torch.arange(3)).tolist() == [100.0]


# --- confusion ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [torch.int64, torch.int32, torch.uint8])
@pytest.mark.parametrize(("shape", "classes"), [((1, 7), 2), ((3, 31, 17), 5), ((3, 1, 20, 9), 23)])
def test_confusion_equals_sklearn_and_torchmetrics(
    shape: tuple[int, ...], classes: int, dtype: torch.dtype
) -> None:
    target = labels(*shape, classes=classes, seed=0)
    pred = predictions(target, classes)
    counts = confusion_matrix(pred.to(dtype), target.to(dtype), classes)
    shares = confusion_matrix(pred.to(dtype), target.to(dtype), classes, normalized=True)
    assert counts.dtype == torch.int64 and shares.dtype == torch.float32
    for b in range(shape[0]):
        truth, found = target[b].flatten(), pred[b].flatten()
        np.testing.assert_array_equal(counts[b], sklearn_matrix(truth, found, labels=np.arange(classes)))
        np.testing.assert_array_equal(counts[b], multiclass_confusion_matrix(found, truth, classes))
        np.testing.assert_allclose(
            shares[b], sklearn_matrix(truth, found, labels=np.arange(classes), normalize="pred"), rtol=1e-7
        )


def test_confusion_of_one_label_a_sample() -> None:
    assert confusion_matrix(torch.tensor([1, 0]), torch.tensor([0, 0]), 2).tolist() == [
        [[0, 1], [0, 0]],
        [[1, 0], [0, 0]],
    ]


def test_labels_outside_are_not_counted() -> None:
    target = labels(2, 40, 31, classes=5, seed=2)
    pred = predictions(target, 5)
    marked = torch.rand(target.shape, generator=torch.Generator().manual_seed(3)) < 0.3
    known = confusion_matrix(pred, torch.where(marked, -1, target), 5)
    assert torch.equal(known, confusion_matrix(pred, torch.where(marked, 255, target), 5))
    assert torch.equal(known, confusion_matrix(torch.where(marked, 5, pred), target, 5))
    for b in range(2):
        kept = ~marked[b]
        np.testing.assert_array_equal(
            known[b], sklearn_matrix(target[b][kept], pred[b][kept], labels=np.arange(5))
        )


def test_counts_are_exact_beyond_float32() -> None:
    many = torch.zeros(1, (1 << 24) + 1, dtype=torch.uint8)
    assert confusion_matrix(many, many, 2)[0, 0, 0] == (1 << 24) + 1


# --- intersection over union --------------------------------------------------------------------------------


@pytest.mark.parametrize(("shape", "classes"), [((1, 63), 2), ((3, 31, 17), 5), ((3, 1, 20, 9), 11)])
def test_iou_equals_sklearn_and_torchmetrics(shape: tuple[int, ...], classes: int) -> None:
    target = labels(*shape, classes=classes, seed=4)
    pred = predictions(target, classes)
    actual = mean_iou(pred, target, classes, 1e-12)
    for b in range(shape[0]):
        truth, found = target[b].flatten(), pred[b].flatten()
        expected = jaccard_score(truth, found, labels=np.arange(classes), average=None, zero_division=1)
        np.testing.assert_allclose(actual[b], expected, rtol=1e-7)
        there = np.isin(np.arange(classes), np.concatenate([truth, found]))  # torchmetrics has 0 elsewhere
        other = multiclass_jaccard_index(found, truth, classes, average="none")
        np.testing.assert_allclose(actual[b][there], other[there], rtol=1e-6)


def test_iou_of_a_class_that_neither_has_is_1() -> None:
    assert mean_iou(LABELS, LABELS, 3).tolist() == [[1.0, 1.0, 1.0]] * 2


WRONG = [
    (lambda: accuracy(SCORES[0], LABELS[0]), ValueError, r"pred: expected shape \(B, C\)"),
    (lambda: accuracy(SCORES.int(), LABELS[0, :3]), TypeError, "pred: expected a floating-point"),
    (
        lambda: accuracy(SCORES, SCORES[:, 0]),
        TypeError,
        "target: expected an integer tensor, got dtype torch.float32",
    ),
    (
        lambda: accuracy(SCORES, LABELS[0]),
        ValueError,
        r"target: expected shape \(B,\) or \(B, 1\) for pred \[3, 4\], got \[5\]",
    ),
    (lambda: accuracy(SCORES, LABELS[:, :3].T), ValueError, r"target: .* got \[3, 2\]"),
    (lambda: accuracy(SCORES, LABELS[0, :3], []), ValueError, "topk: expected at least one number"),
    (
        lambda: accuracy(SCORES, LABELS[0, :3], (1, 0)),
        ValueError,
        "topk: expected numbers of at least 1, got 0",
    ),
    (lambda: confusion_matrix(SCORES, LABELS, 3), TypeError, "pred: expected an integer tensor"),
    (lambda: confusion_matrix(LABELS, SCORES, 3), TypeError, "target: expected an integer tensor"),
    (lambda: confusion_matrix(LABELS[0, 0], LABELS[0, 0], 3), ValueError, r"pred: expected shape \(B, \*\)"),
    (
        lambda: confusion_matrix(LABELS, LABELS[:1], 3),
        ValueError,
        r"target: expected pred's shape \[2, 5\], got \[1, 5\]",
    ),
    (lambda: confusion_matrix(LABELS, LABELS, 1), ValueError, "num_classes: expected at least 2, got 1"),
    (lambda: mean_iou(LABELS, LABELS, 1), ValueError, "num_classes: expected at least 2, got 1"),
    (lambda: mean_iou(LABELS, LABELS, 3, 0.0), ValueError, "eps: expected a positive number, got 0.0"),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
