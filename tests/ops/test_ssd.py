"""SSD's decoder, against torchvision's."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from torch import Tensor
from torchvision.models.detection._utils import BoxCoder
from torchvision.models.detection.ssd import SSD

from chiasm import ops


def torchvisions(
    logits: Tensor,
    deltas: Tensor,
    anchors: Tensor,
    size: tuple[int, int],
    score: float,
    iou: float,
    most: int,
) -> list[dict[str, Tensor]]:
    settings = SimpleNamespace(
        box_coder=BoxCoder((10.0, 10.0, 5.0, 5.0)),
        score_thresh=score,
        nms_thresh=iou,
        detections_per_img=most,
        topk_candidates=400,
    )
    outputs = OrderedDict(cls_logits=logits, bbox_regression=deltas)
    count = len(logits)
    return SSD.postprocess_detections(settings, outputs, [anchors] * count, [size] * count)  # pyright: ignore[reportArgumentType]


def network(seed: int, classes: int, n: int = 120) -> tuple[Tensor, Tensor, Tensor]:
    random = np.random.default_rng(seed)
    corner = random.uniform(-10, 90, (n, 2))
    anchors = np.concatenate([corner, corner + random.uniform(10, 60, (n, 2))], 1)
    logits, deltas = random.normal(0, 2, (2, n, classes)), random.normal(0, 4, (2, n, 4))
    deltas[:, :3, 2:] = 40.0  # above the limit
    return torch.from_numpy(logits), torch.from_numpy(deltas), torch.from_numpy(anchors)


@pytest.mark.parametrize("classes", [2, 4, 21])
@pytest.mark.parametrize(("score", "most"), [(0.01, 40), (0.3, 400)])
def test_objects_are_torchvisions(classes: int, score: float, most: int) -> None:
    logits, deltas, anchors = network(classes, classes)
    result = ops.decode_ssd(logits, deltas, anchors, (80, 110), score, 0.45, most, 2400)
    for i, expected in enumerate(torchvisions(logits, deltas, anchors, (80, 110), score, 0.45, most)):
        count = len(expected["scores"])
        assert count > 5
        assert result[3][i].tolist() == [True] * count + [False] * (most - count)
        torch.testing.assert_close(result[0][i, :count], expected["boxes"], rtol=1e-12, atol=1e-11)
        torch.testing.assert_close(result[1][i, :count], expected["scores"], rtol=1e-12, atol=0)
        assert torch.equal(result[2][i, :count], expected["labels"])
        assert all(not part[i, count:].any() for part in result)


def test_an_anchor_may_have_two_classes() -> None:
    logits = torch.tensor([[[0.0, 3.0, 3.0]]])
    result = ops.decode_ssd(logits, torch.zeros(1, 1, 4), torch.tensor([[1.0, 2.0, 5.0, 9.0]]), (20, 20))
    assert result[2][0, :3].tolist() == [1, 2, 0] and result[3][0, :3].tolist() == [True, True, False]
    assert result[0][0, :2].tolist() == [[1.0, 2.0, 5.0, 9.0]] * 2


def test_the_best_pairs_alone_are_compared() -> None:
    logits, deltas, anchors = network(1, 5)
    everything = ops.decode_ssd(logits, deltas, anchors, (80, 110), iou_threshold=1.0, candidates=480)
    best = ops.decode_ssd(logits, deltas, anchors, (80, 110), iou_threshold=1.0, candidates=7)
    assert best[3].sum(1).tolist() == [7, 7]
    assert torch.equal(best[1][:, :7], everything[1][:, :7])


X, D, A = torch.rand(1, 5, 3), torch.rand(1, 5, 4), torch.rand(5, 4)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.decode_ssd(X[0], D, A, (9, 9)), ValueError, r"logits: expected shape \(B, N, C\)"),
        (
            lambda: ops.decode_ssd(X[..., :1], D, A, (9, 9)),
            ValueError,
            "logits: expected shape .* background",
        ),
        (lambda: ops.decode_ssd(X, D[:, :4], A, (9, 9)), ValueError, r"deltas: expected shape \(B, N, 4\)"),
        (lambda: ops.decode_ssd(X, D.int(), A, (9, 9)), TypeError, "deltas: expected a floating-point"),
        (lambda: ops.decode_ssd(X, D, A[:3], (9, 9)), ValueError, r"anchors: expected shape \(N, 4\)"),
        (lambda: ops.decode_ssd(X, D, A.int(), (9, 9)), TypeError, "anchors: expected a floating-point"),
        (
            lambda: ops.decode_ssd(X, D, A, (9, 9), candidates=0),
            ValueError,
            "candidates: expected a positive",
        ),
        (
            lambda: ops.decode_ssd(X, D, A, (9, 9), max_output=0),
            ValueError,
            "max_output: expected a positive",
        ),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
