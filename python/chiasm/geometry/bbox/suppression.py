"""Non-maximum suppression of boxes."""

from typing import Tuple

from torch import Tensor

from ...ops.suppression import one_class, ranked


def nms_fixed(boxes: Tensor, scores: Tensor, iou_threshold: float) -> Tuple[Tensor, Tensor]:
    """`ops.nms` with results of a fixed size: all boxes by falling score, and which of them are kept.

    Native code compares each box with those that are kept. Elsewhere all pairs are compared at once, N * N
    bytes of memory, and the decisions repeated until none changes, which takes as many steps as the longest
    chain of boxes that decide about each other.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,).
        iou_threshold: boxes are dropped whose intersection with a kept one is more than this part of the
            union.

    Returns:
        Indices (N,), int64, of all boxes by falling score, of equal scores the first first; and (N,), bool,
        in the same order: which are kept.

    Raises:
        TypeError, ValueError: if boxes is not a floating-point (N, 4) tensor or scores is not (N,).

    Example:
        >>> nms_fixed(
        ...     torch.tensor([[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.9], [5.0, 0.0, 6.0, 1.0]]),
        ...     torch.tensor([0.5, 0.9, 0.7]),
        ...     0.5,
        ... )
        (tensor([1, 2, 0]), tensor([ True,  True, False]))
    """
    return ranked(boxes, scores, one_class(scores), iou_threshold)
