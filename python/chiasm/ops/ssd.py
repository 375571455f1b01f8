"""The single-shot detector with anchors."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_last, check_rank
from ..primitives.geometry.boxes import boxes_at, wide
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.reshaping import reshaped
from ..primitives.numbers.slots import above_or_nothing
from .boxes import clip_boxes_to_image
from .decoding import Detections, fewer, suppressed


def decode_ssd(
    logits: Tensor,
    deltas: Tensor,
    anchors: Tensor,
    size: Tuple[int, int],
    score_threshold: float = 0.01,
    iou_threshold: float = 0.45,
    max_output: int = 200,
    candidates: int = 1000,
) -> Detections:
    """Decode the output of SSD: softmax, boxes from anchors, every class of every anchor, suppression.

    W. Liu et al., SSD: Single Shot MultiBox Detector, ECCV 2016, with torchvision's weights: the box centre
    is the anchor's centre plus one tenth of the first two deltas times the anchor's sides; the box sides are
    the anchor's sides times the exponential of one fifth of the last two deltas, at most 62.5 times. This is
    as in torchvision, except that ``candidates`` counts all classes together, not each class.

    Args:
        logits: the network's output, (B, N, C), floating point: logits (before the softmax function) of C
            classes at each of N anchors; the first class is the background.
        deltas: the network's output, (B, N, 4), floating point: of x, of y, of the width, of the height.
        anchors: (N, 4) as x1, y1, x2, y2 in pixels, floating point.
        size: height and width of the image, into which boxes are clipped.
        score_threshold: objects are dropped unless their score is above this, which NaN is not.
        iou_threshold: if the IoU (intersection over union) of two boxes of a class is greater than this, only
            the one with the higher score is kept.
        max_output: the number K of slots for objects.
        candidates: only this many pairs of an anchor and a class, those with the highest scores, take part in
            the suppression.

    Returns:
        Boxes (B, K, 4) as x1, y1, x2, y2 in pixels, float32 for half precision; scores (B, K); labels (B, K),
        int64, from 1 to C - 1; and (B, K), bool, a mask of the slots that hold an object. Objects are in
        descending order of score; empty slots are 0.

    Raises:
        TypeError: if logits, deltas or anchors is not floating point.
        ValueError: if a shape is not as above, C is less than 2, or max_output or candidates is not positive.

    Example:
        >>> logits = torch.tensor([[[0.0, 0.0, 2.0], [5.0, 0.0, 0.0]]])
        >>> deltas, anchors = torch.zeros(1, 2, 4), torch.tensor([[2.0, 2.0, 8.0, 6.0], [0.0, 0.0, 3.0, 3.0]])
        >>> deltas[0, 0, 0] = 5.0
        >>> [part[0, 0] for part in decode_ssd(logits, deltas, anchors, (20, 20), max_output=3)]
        [tensor([ 5.,  2., 11.,  6.]), tensor(0.7870), tensor(2), tensor(True)]
    """
    check_rank(logits, 3, "(B, N, C)", "logits")
    check_floating(logits, "logits")
    if logits.size(2) < 2:
        raise ValueError(
            f"logits: expected shape (B, N, C) with a background and a class, got {list(logits.shape)}"
        )
    check_floating(deltas, "deltas")
    if deltas.dim() != 3 or deltas.shape[:2] != logits.shape[:2] or deltas.size(2) != 4:
        raise ValueError(
            f"deltas: expected shape (B, N, 4) for logits {list(logits.shape)}, got {list(deltas.shape)}"
        )
    check_last(anchors, 4, "anchors")
    if anchors.dim() != 2 or anchors.size(0) != logits.size(1):
        raise ValueError(
            f"anchors: expected shape (N, 4) for logits {list(logits.shape)}, got {list(anchors.shape)}"
        )
    batch, classes = logits.size(0), logits.size(2) - 1
    pairs = logits.size(1) * classes
    scores = reshaped(torch.softmax(logits, 2)[..., 1:], [batch, pairs])
    values, places = stable_topk(above_or_nothing(scores, score_threshold), fewer(candidates, pairs))
    place = places // classes
    labels = places - place * classes + 1
    chosen = _about(boxes_at(wide(anchors)[None].expand(batch, -1, -1), place), wide(boxes_at(deltas, place)))
    chosen = clip_boxes_to_image(chosen, size)
    return suppressed(chosen, values, labels, iou_threshold, max_output, score_threshold)


def _about(anchors: Tensor, deltas: Tensor) -> Tensor:
    """Boxes (B, M, 4) from anchors (B, M, 4) and deltas."""
    sides = anchors[..., 2:] - anchors[..., :2]
    centre = anchors[..., :2] + 0.5 * sides + deltas[..., :2] / 10.0 * sides
    # Without this limit, the sides from an untrained network would be infinite.
    half = 0.5 * sides * torch.exp((deltas[..., 2:] / 5.0).clamp(max=math.log(62.5)))
    return torch.cat([centre - half, centre + half], 2)
