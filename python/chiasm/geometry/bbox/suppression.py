"""Non-maximum suppression of boxes."""

from typing import Tuple

from torch import Tensor

from ...ops.suppression import one_class, ranked


def nms_fixed(boxes: Tensor, scores: Tensor, iou_threshold: float) -> Tuple[Tensor, Tensor]:
    """`ops.nms` with results of a fixed size: all boxes by descending score, and a mask of the kept boxes.

    Native code compares each box with the boxes that are kept so far. Other engines compare all pairs at
    once, which takes N * N bytes of memory, and repeat the decisions until none changes; the number of steps
    is the length of the longest chain of boxes that suppress each other.

    Args:
        boxes: (N, 4) as x1, y1, x2, y2, floating point.
        scores: (N,).
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box is greater than
            this.

    Returns:
        Indices (N,), int64, of all boxes by descending score (equal scores keep their order), and a mask
        (N,), bool, in the same order: True for kept boxes.

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
