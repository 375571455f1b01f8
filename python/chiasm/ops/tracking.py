"""Trackers of boxes: they assign the detections of a frame to the objects of the frames before. The state of
the objects is an input and an output of each call, in a fixed number of slots: four tensors, which are zeros
before the first frame.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_last, check_rank, check_tensor
from ..primitives.geometry.boxes import boxes_at, intersections_and_unions
from ..primitives.numbers.slots import chosen_first
from ..primitives.resampling.warping import position_dtype
from .assignment import cheapest, check_mask
from .kalman import kalman_predict, kalman_update

#: The state of the filters, their covariances, the counters, the last identity; boxes, the indices of their
#: detections, and a mask of the tracks to show.
Tracks = Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]


def sort_track(
    mean: Tensor,
    covariance: Tensor,
    counters: Tensor,
    last_id: Tensor,
    boxes: Tensor,
    found: Tensor,
    iou_threshold: float = 0.3,
    max_age: int = 30,
    min_hits: int = 3,
) -> Tracks:
    """One frame of the tracker SORT: A. Bewley et al., Simple Online and Realtime Tracking, ICIP 2016.

    A Kalman filter follows each object. Its state is the centre, the area, the aspect ratio, and the speeds
    of all but the aspect ratio, in pixels and frames. The process noise of each frame has the variances 1
    (the first four), 0.01 (the speed of the centre) and 0.0001 (the speed of the area). Measurements have the
    variances 1, 1, 10 and 10; new objects have 10, and 10000 for their speeds. If the area would become zero
    or negative, its speed is first set to 0.

    Detections are assigned to the predicted boxes with the greatest sum of IoUs; pairs with too little
    overlap are rejected. The remaining detections start new tracks, in their order, as long as there are free
    slots: so pass detections in descending order of score, as decoders return them. Computed in float64.

    Args:
        mean: (B, K, 7), floating point, the state of the filters in K slots; zeros before the first frame.
        covariance: (B, K, 7, 7), floating point, the covariance of the state; zeros before the first frame.
        counters: (B, K, 4), int64: the track's identity, from 1, 0 in empty slots; its frames since the first
            detection; its detections; and its frames since the last one. Zeros before the first frame.
        last_id: (B,), int64, the last identity in use; 0 before the first frame.
        boxes: (B, M, 4), floating point: the detections as x1, y1, x2, y2 in pixels.
        found: (B, M), bool: a mask of the slots that hold a detection. Boxes without width or height are
            ignored.
        iou_threshold: the least IoU (intersection over union) of a detection and its track; a pair without
            overlap is never assigned.
        max_age: a track ends if it has no detection in this many consecutive frames. In the paper it is 1.
        min_hits: the number of detections that confirm a track; before, a frame without a detection ends it.

    Returns:
        The new mean, covariance, counters and last_id, for the next frame; boxes (B, K, 4) of the tracks, 0
        in empty slots. These, mean and covariance have mean's dtype, float32 for half precision, which areas
        exceed. Then (B, K), int64, the index of each track's detection in this frame, 0 if there is none;
        and (B, K), bool, a mask of the tracks to show: those with a detection in this frame and at least
        ``min_hits`` in total.

    Raises:
        TypeError: if a tensor's dtype is not as above.
        ValueError: if a shape is not as above, or max_age or min_hits is not positive.

    Example:
        >>> tracks = torch.zeros(1, 2, 7), torch.zeros(1, 2, 7, 7), torch.zeros(1, 2, 4, dtype=torch.int64)
        >>> last_id, found = torch.zeros(1, dtype=torch.int64), torch.tensor([[True]])
        >>> for x in (10.0, 12.0, 14.0):
        ...     detections = torch.tensor([[[x, 5.0, x + 20.0, 45.0]]])
        ...     *tracks, last_id, boxes, index, shown = sort_track(*tracks, last_id, detections, found)
        >>> tracks[2], boxes[0, 0], shown
        (tensor([[[1, 2, 3, 0],
                 [0, 0, 0, 0]]]), tensor([13.9998,  5.0000, 33.9998, 45.0000]), tensor([[ True, False]]))
    """
    _check(mean, covariance, counters, last_id, boxes, found, max_age, min_hits)
    detections, valid = _detections(boxes, found)
    x, p, predicted = _predicted(mean, covariance)
    overlap = _overlaps(predicted, detections)
    index, matched = _associated(overlap, counters[..., 0] > 0, valid, iou_threshold)
    begins = valid & ~_used(index, matched, valid)
    return _stepped(mean, x, p, counters, last_id, detections, index, matched, begins, max_age, min_hits)


def byte_track(
    mean: Tensor,
    covariance: Tensor,
    counters: Tensor,
    last_id: Tensor,
    boxes: Tensor,
    scores: Tensor,
    found: Tensor,
    high_score: float = 0.6,
    low_score: float = 0.1,
    new_score: float = 0.7,
    iou_threshold: float = 0.2,
    max_age: int = 30,
    min_hits: int = 2,
) -> Tracks:
    """One frame of the tracker BYTE: Y. Zhang et al., ByteTrack, ECCV 2022, algorithm 1.

    First, detections with high scores are assigned to tracks. Then detections with low scores, which are
    often occluded objects, are assigned to the remaining tracks. Only detections with high scores start new
    tracks. The filter, the state and everything else are as in `sort_track`.

    Args:
        mean: (B, K, 7), floating point, as in ``sort_track``.
        covariance: (B, K, 7, 7), floating point, as in ``sort_track``.
        counters: (B, K, 4), int64, as in ``sort_track``.
        last_id: (B,), int64, as in ``sort_track``.
        boxes: (B, M, 4), floating point: the detections as x1, y1, x2, y2 in pixels. A detector's threshold
            should be ``low_score``.
        scores: (B, M), floating point: the scores of the detections.
        found: (B, M), bool: which slots hold a detection.
        high_score: detections with a score above this are assigned first.
        low_score: the other detections with a score above this are assigned second.
        new_score: detections with high scores start new tracks if their score is above this.
        iou_threshold: the least IoU (intersection over union) of a detection and its track; a pair without
            overlap is never assigned.
        max_age: a track ends if it has no detection in this many consecutive frames.
        min_hits: the number of detections that confirm a track; before, a frame without a detection ends it.

    Returns:
        As ``sort_track``.

    Raises:
        TypeError: if a tensor's dtype is not as above.
        ValueError: if a shape is not as above, or max_age or min_hits is not positive.

    Example:
        >>> tracks = torch.zeros(1, 2, 7), torch.zeros(1, 2, 7, 7), torch.zeros(1, 2, 4, dtype=torch.int64)
        >>> last_id, found = torch.zeros(1, dtype=torch.int64), torch.tensor([[True]])
        >>> for x, score in [(10.0, 0.9), (12.0, 0.8), (14.0, 0.2)]:
        ...     detections, scores = torch.tensor([[[x, 5.0, x + 20.0, 45.0]]]), torch.tensor([[score]])
        ...     *tracks, last_id, boxes, index, shown = byte_track(
        ...         *tracks, last_id, detections, scores, found
        ...     )
        >>> tracks[2][0, 0], shown
        (tensor([1, 2, 3, 0]), tensor([[ True, False]]))
    """
    _check(mean, covariance, counters, last_id, boxes, found, max_age, min_hits)
    check_floating(scores, "scores")
    if scores.shape != found.shape:
        raise ValueError(f"scores: expected shape {list(found.shape)}, got {list(scores.shape)}")
    detections, valid = _detections(boxes, found)
    if boxes.size(1) == 0:
        scores = torch.zeros_like(detections[..., 0])
    high = valid & (scores > high_score)
    low = valid & ~high & (scores > low_score)
    x, p, predicted = _predicted(mean, covariance)
    overlap = _overlaps(predicted, detections)
    tracked = counters[..., 0] > 0
    first, by_high = _associated(overlap, tracked, high, iou_threshold)
    second, by_low = _associated(overlap, tracked & ~by_high, low, iou_threshold)
    begins = high & ~_used(first, by_high, high) & (scores > new_score)
    index, matched = torch.where(by_high, first, second), by_high | by_low
    return _stepped(mean, x, p, counters, last_id, detections, index, matched, begins, max_age, min_hits)


def _check(
    mean: Tensor,
    covariance: Tensor,
    counters: Tensor,
    last_id: Tensor,
    boxes: Tensor,
    found: Tensor,
    max_age: int,
    min_hits: int,
) -> None:
    check_rank(mean, 3, "(B, K, 7)", "mean")
    check_last(mean, 7, "mean")
    check_floating(covariance, "covariance")
    check_rank(boxes, 3, "(B, M, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    batch, slots = mean.size(0), mean.size(1)
    _check_shape(covariance, [batch, slots, 7, 7], "covariance")
    _check_shape(counters, [batch, slots, 4], "counters")
    _check_shape(last_id, [batch], "last_id")
    _check_shape(boxes, [batch, boxes.size(1), 4], "boxes")
    check_mask(found, batch, boxes.size(1), "found")
    for name, value in [("counters", counters), ("last_id", last_id)]:
        if value.dtype != torch.int64:
            raise TypeError(f"{name}: expected dtype int64, got {value.dtype}")
    if max_age < 1:
        raise ValueError(f"max_age: expected a positive number, got {max_age}")
    if min_hits < 1:
        raise ValueError(f"min_hits: expected a positive number, got {min_hits}")


def _check_shape(value: Tensor, shape: List[int], name: str) -> None:
    check_tensor(value, name)
    if list(value.shape) != shape:
        raise ValueError(f"{name}: expected shape {shape}, got {list(value.shape)}")


def _detections(boxes: Tensor, found: Tensor) -> Tuple[Tensor, Tensor]:
    """The boxes in float64, and a mask of the detections; if there are no slots, one slot without a detection
    is added."""
    x = boxes.detach().to(torch.float64)
    if x.size(1) == 0:
        x = torch.zeros([x.size(0), 1, 4], dtype=torch.float64, device=x.device)
        found = torch.zeros([x.size(0), 1], dtype=torch.bool, device=x.device)
    sides = x[..., 2:] - x[..., :2]
    has_area = (sides > 0.0).all(2) & (x.abs() < float("inf")).all(2)
    # A slot without a detection may hold any values, also NaN.
    none = torch.tensor([0.0, 0.0, 1.0, 1.0], dtype=torch.float64, device=x.device)
    valid = found & has_area
    return torch.where(valid[..., None], x, none), valid


def _measured(boxes: Tensor) -> Tensor:
    """The centre, area and aspect ratio of boxes x1, y1, x2, y2."""
    sides = boxes[..., 2:] - boxes[..., :2]
    width, height = sides[..., :1], sides[..., 1:]
    return torch.cat([boxes[..., :2] + 0.5 * sides, width * height, width / height], -1)


def _boxes(state: Tensor) -> Tensor:
    """The boxes of states; NaN if there is no area."""
    area, ratio = state[..., 2:3], state[..., 3:4]
    width = torch.sqrt(area * ratio)
    half = 0.5 * torch.cat([width, area / width], -1)
    return torch.cat([state[..., :2] - half, state[..., :2] + half], -1)


def _diagonal(values: List[float], like: Tensor) -> Tensor:
    return torch.diag(torch.tensor(values, dtype=torch.float64, device=like.device))


def _predicted(mean: Tensor, covariance: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The states of this frame, their covariances, and boxes."""
    x = mean.detach().to(torch.float64)
    shrinks = x[..., 2:3] + x[..., 6:7] <= 0.0
    x = torch.cat([x[..., :6], torch.where(shrinks, torch.zeros_like(x[..., 6:7]), x[..., 6:7])], -1)
    moves = torch.eye(7, dtype=torch.float64, device=mean.device)
    moves = moves + torch.diag(torch.ones(3, dtype=torch.float64, device=mean.device), 4)
    noise = _diagonal([1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 0.0001], mean)
    x, p = kalman_predict(x, covariance.detach().to(torch.float64), moves, noise)
    return x, p, _boxes(x)


def _overlaps(tracks: Tensor, detections: Tensor) -> Tensor:
    """(B, K, M), intersection over union of boxes (B, K, 4) and (B, M, 4)."""
    common, union = intersections_and_unions(tracks[:, :, None], detections[:, None])
    return common / union


def _associated(
    overlap: Tensor, tracks: Tensor, detections: Tensor, threshold: float
) -> Tuple[Tensor, Tensor]:
    """The index of the detection of each track, and a mask of the tracks that have one."""
    # A pair without overlap is worth the same as no pair, so it is not considered.
    pairs = (overlap > 0.0) & tracks[:, :, None] & detections[:, None]
    if overlap.size(1) == 0:
        nothing = torch.zeros([overlap.size(0), 0], dtype=torch.int64, device=overlap.device)
        return nothing, nothing > 0
    costs = torch.where(pairs, 1.0 - overlap, torch.full_like(overlap, float("inf")))
    alone = torch.ones([overlap.size(0), 1], dtype=overlap.dtype, device=overlap.device)
    index, assigned = cheapest(costs, alone)
    return index, assigned & (overlap.gather(2, index[..., None])[..., 0] >= threshold)


def _used(index: Tensor, matched: Tensor, detections: Tensor) -> Tensor:
    """A mask of the detections that have a track."""
    number = torch.arange(detections.size(1), device=index.device)
    return ((index[..., None] == number) & matched[..., None]).any(1)


def _stepped(
    before: Tensor,
    x: Tensor,
    p: Tensor,
    counters: Tensor,
    last_id: Tensor,
    detections: Tensor,
    index: Tensor,
    matched: Tensor,
    begins: Tensor,
    max_age: int,
    min_hits: int,
) -> Tracks:
    """The tracks after the update by their detections, including new tracks."""
    sight = torch.eye(7, dtype=torch.float64, device=x.device)[:4]
    noise = _diagonal([1.0, 1.0, 10.0, 10.0], x)
    seen_x, seen_p = kalman_update(x, p, _measured(boxes_at(detections, index)), sight, noise)
    x = torch.where(matched[..., None], seen_x, x)
    p = torch.where(matched[..., None, None], seen_p, p)

    id, age, hits, since = counters.unbind(2)
    zero = torch.zeros_like(id)
    hits = hits + matched.to(torch.int64)
    since = torch.where(matched, zero, since + 1)
    stays = (id > 0) & (matched | ((since < max_age) & (hits >= min_hits)))

    # The first detections that start tracks are put into the empty slots, in order, as long as slots are
    # free.
    slots = id.size(1)
    begins = begins & (begins.to(torch.int64).cumsum(1) <= slots)
    number = torch.arange(begins.size(1), device=id.device).expand_as(begins)
    rank = ((~stays).to(torch.int64).cumsum(1) - 1).clamp(min=0)
    beginning = chosen_first(number, begins, slots, -1).gather(1, rank)
    begun = ~stays & (beginning >= 0)
    index = torch.where(begun, beginning, torch.where(matched, index, zero))
    measured = _measured(boxes_at(detections, index))
    new = torch.cat([measured, torch.zeros_like(measured[..., :3])], 2)
    uncertain = _diagonal([10.0, 10.0, 10.0, 10.0, 10000.0, 10000.0, 10000.0], x)
    there = stays | begun
    x = torch.where(begun[..., None], new, torch.where(stays[..., None], x, torch.zeros_like(x)))
    p = torch.where(
        begun[..., None, None],
        uncertain,
        torch.where(stays[..., None, None], p, torch.zeros_like(p)),
    )
    begun_counters = torch.stack([last_id[:, None] + 1 + rank, zero, zero + 1, zero], 2)
    stays_counters = torch.stack([id, age + 1, hits, since], 2)
    after = torch.where(begun[..., None], begun_counters, torch.zeros_like(counters))
    after = torch.where(stays[..., None], stays_counters, after)
    boxes = _boxes(x)
    dtype = position_dtype(before.dtype)
    shown = there & (after[..., 3] == 0) & (after[..., 2] >= min_hits)
    return (
        x.to(dtype),
        p.to(dtype),
        after,
        last_id + begun.to(torch.int64).sum(1),
        torch.where(there[..., None], boxes, torch.zeros_like(boxes)).to(dtype),
        index,
        shown,
    )
