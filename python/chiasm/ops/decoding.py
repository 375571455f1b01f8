"""Decoders of detectors: boxes, scores and labels in a fixed number of slots."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_pair, check_rank
from ..primitives.geometry.boxes import boxes_at, wide
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.slots import above_or_nothing
from .boxes import box_convert
from .suppression import batched_nms_fixed

Detections = Tuple[Tensor, Tensor, Tensor, Tensor]


def decode_yolov8(
    output: Tensor,
    score_threshold: float = 0.25,
    iou_threshold: float = 0.45,
    max_output: int = 300,
    candidates: int = 1000,
) -> Detections:
    """Decode the output of YOLO v8, v9 or v11: best class of each place, score threshold, suppression.

    Args:
        output: the network's output, (B, 4 + C, N), floating point: centre, width and height of a box at each
            of N places, and the scores of C classes, in [0, 1].
        score_threshold: objects are dropped unless their score is above this, which NaN is not.
        iou_threshold: if the IoU (intersection over union) of two boxes of a class is greater than this, only
            the one with the higher score is kept.
        max_output: the number K of slots for objects.
        candidates: only this many places, those with the highest scores, take part in the suppression.

    Returns:
        Boxes (B, K, 4) as x1, y1, x2, y2 in pixels of the network's input, float32 for half precision;
        scores (B, K); labels (B, K), int64; and (B, K), bool, a mask of the slots that hold an object.
        Objects are in descending order of score; empty slots are 0.

    Raises:
        TypeError: if output is not floating point.
        ValueError: if output is not (B, 4 + C, N) with C at least 1, or max_output or candidates is not
            positive.

    Example:
        >>> output = torch.zeros(1, 6, 3)
        >>> output[0, :, 1] = torch.tensor([10.0, 20.0, 4.0, 6.0, 0.2, 0.9])
        >>> boxes, scores, labels, found = decode_yolov8(output, max_output=2)
        >>> boxes[0, 0], scores, labels, found
        (tensor([ 8., 17., 12., 23.]), tensor([[0.9000, 0.0000]]), tensor([[1, 0]]), tensor([[ True, False]]))
    """
    _check_output(output, 2, "(B, 4 + C, N)", 5)
    boxes, classes = output[:, :4].transpose(1, 2), output[:, 4:]
    best = above_or_nothing(classes.amax(1), score_threshold)
    values, places = stable_topk(best, fewer(candidates, best.size(1)))
    scores = classes.gather(2, places[:, None].expand(-1, classes.size(1), -1)).transpose(1, 2)
    return _selected(boxes, scores, values, places, score_threshold, iou_threshold, max_output)


def decode_yolov5(
    output: Tensor,
    score_threshold: float = 0.25,
    iou_threshold: float = 0.45,
    max_output: int = 300,
    candidates: int = 1000,
) -> Detections:
    """Decode the output of YOLO v5, v6 or v7. Otherwise as ``decode_yolov8``.

    Args:
        output: the network's output, (B, N, 5 + C), floating point: centre, width and height of a box at each
            of N places, the objectness (probability of an object), and the scores of C classes.
        score_threshold: objects are dropped unless their score, objectness times class score, is above this,
            which NaN is not.
        iou_threshold: if the IoU (intersection over union) of two boxes of a class is greater than this, only
            the one with the higher score is kept.
        max_output: the number K of slots for objects.
        candidates: only this many places, those with the highest scores, take part in the suppression.

    Returns:
        Boxes (B, K, 4), scores (B, K), labels (B, K), and the mask of slots that hold an object, as in
        ``decode_yolov8``.

    Raises:
        TypeError: if output is not floating point.
        ValueError: if output is not (B, N, 5 + C) with C at least 1, or max_output or candidates is not
            positive.

    Example:
        >>> output = torch.zeros(1, 3, 7)
        >>> output[0, 1] = torch.tensor([10.0, 20.0, 4.0, 6.0, 0.5, 0.2, 0.8])
        >>> decode_yolov5(output, max_output=1)[1]
        tensor([[0.4000]])
    """
    _check_output(output, 1, "(B, N, 5 + C)", 6)
    classes = output[..., 5:] * output[..., 4:5]
    best = above_or_nothing(classes.amax(2), score_threshold)
    values, places = stable_topk(best, fewer(candidates, best.size(1)))
    scores = classes.gather(1, places[..., None].expand(-1, -1, classes.size(2)))
    return _selected(output[..., :4], scores, values, places, score_threshold, iou_threshold, max_output)


def decode_detr(
    logits: Tensor,
    pred_boxes: Tensor,
    size: Tuple[int, int],
    score_threshold: float = 0.5,
    max_output: int = 300,
) -> Detections:
    """Decode the output of RT-DETR or Deformable DETR: the highest scores over all queries and classes.

    Args:
        logits: the network's output, (B, Q, C), floating point: logits (before the sigmoid function) of C
            classes for each of Q queries.
        pred_boxes: (B, Q, 4), floating point: centre, width and height as fractions of the image's sides.
        size: height and width of the image.
        score_threshold: objects are dropped unless their score is above this, which NaN is not.
        max_output: the number K of slots for objects, at most Q * C.

    Returns:
        Boxes (B, K, 4) as x1, y1, x2, y2 in pixels, float32 for half precision; scores (B, K); labels (B, K),
        int64; and (B, K), bool, a mask of the slots that hold an object. Objects are in descending order of
        score; empty slots are 0.

    Raises:
        TypeError: if logits or pred_boxes is not floating point.
        ValueError: if a shape is not as above, or max_output is not from 1 to Q * C.

    Example:
        >>> logits, boxes = torch.tensor([[[-9.0, 2.0]]]), torch.tensor([[[0.5, 0.5, 0.2, 0.4]]])
        >>> [part[0, 0] for part in decode_detr(logits, boxes, (100, 200), max_output=2)]
        [tensor([ 80.0000,  30.0000, 120.0000,  70.0000]), tensor(0.8808), tensor(1), tensor(True)]
    """
    check_rank(logits, 3, "(B, Q, C)", "logits")
    check_floating(logits, "logits")
    check_floating(pred_boxes, "pred_boxes")
    if pred_boxes.dim() != 3 or pred_boxes.shape[:2] != logits.shape[:2] or pred_boxes.size(2) != 4:
        raise ValueError(
            f"pred_boxes: expected shape (B, Q, 4) for logits {list(logits.shape)}, got"
            f" {list(pred_boxes.shape)}"
        )
    check_pair(size, "size")
    if max_output < 1 or max_output > logits.size(1) * logits.size(2):
        raise ValueError(f"max_output: expected a number from 1 to Q * C, got {max_output}")
    each = logits.flatten(1)
    places = stable_topk(above_or_nothing(each, float("-inf")), max_output)[1]
    scores = torch.sigmoid(each.gather(1, places))
    queries = places // logits.size(2)
    labels = places - queries * logits.size(2)
    picked = box_convert(wide(boxes_at(pred_boxes, queries)), "cxcywh", "xyxy")
    height, width = float(size[0]), float(size[1])
    sides = torch.tensor([width, height, width, height], dtype=picked.dtype, device=picked.device)
    return where_found(picked * sides, scores, labels, scores > score_threshold)


def _check_output(output: Tensor, places: int, layout: str, least: int) -> None:
    check_rank(output, 3, layout, "output")
    check_floating(output, "output")
    if output.size(3 - places) < least:
        raise ValueError(f"output: expected shape {layout} with C at least 1, got {list(output.shape)}")


def fewer(candidates: int, places: int) -> int:
    """The number of places that take part in the suppression."""
    if candidates < 1:
        raise ValueError(f"candidates: expected a positive number, got {candidates}")
    return min(candidates, places)


def _selected(
    boxes: Tensor,
    scores: Tensor,
    values: Tensor,
    places: Tensor,
    score_threshold: float,
    iou_threshold: float,
    max_output: int,
) -> Detections:
    """The detections of boxes (B, N, 4) at places (B, M); their scores are (B, M, C), with the maxima
    ``values``."""
    # Converted first: otherwise the export would fuse the slice of the tensor and the selection of boxes into
    # one operator, which OpenVINO rejects.
    chosen = boxes_at(box_convert(wide(boxes), "cxcywh", "xyxy"), places)
    return suppressed(chosen, values, scores.argmax(2), iou_threshold, max_output, score_threshold)


def suppressed(
    boxes: Tensor,
    scores: Tensor,
    labels: Tensor,
    iou_threshold: float,
    max_output: int,
    score_threshold: float,
) -> Detections:
    """The boxes (B, N, 4), scores and labels (B, N) that `batched_nms_fixed` keeps."""
    if isinstance(boxes.size(1), int) and boxes.size(1) == 0:
        # empty slots read the first place, and there is none: one whose score is above no threshold
        batch = boxes.size(0)
        boxes, labels = boxes.new_zeros([batch, 1, 4]), labels.new_zeros([batch, 1])
        scores = scores.new_full([batch, 1], float("-inf"))
    slots, found = batched_nms_fixed(boxes, scores, labels, iou_threshold, max_output, score_threshold)
    return where_found(boxes_at(boxes, slots), scores.gather(1, slots), labels.gather(1, slots), found)


def where_found(boxes: Tensor, scores: Tensor, labels: Tensor, found: Tensor) -> Detections:
    """The same detections, with 0 in empty slots."""
    return (
        torch.where(found[..., None], boxes, torch.zeros_like(boxes)),
        torch.where(found, scores, torch.zeros_like(scores)),
        torch.where(found, labels, torch.zeros_like(labels)),
        found,
    )
