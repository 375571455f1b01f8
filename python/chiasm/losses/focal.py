"""Focal losses: cross entropy with more weight on examples that are hard to classify."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_same_shape
from ..primitives.numbers.loss_reduction import (
    considered,
    narrowed,
    reduced_where,
    where_considered,
    widened,
)
from .labels import check_prediction, class_planes, class_weights


def focal_loss(
    pred: Tensor,
    target: Tensor,
    alpha: Optional[float],
    gamma: float = 2.0,
    reduction: str = "none",
    weight: Optional[Tensor] = None,
    ignore_index: Optional[int] = -100,
) -> Tensor:
    """Focal loss -alpha_t (1 - p_t)^gamma log(p_t), where p_t is the softmax of a pixel's true class.

    T.-Y. Lin et al., Focal loss for dense object detection, ICCV 2017. For two classes it is the binary loss
    of the difference of their logits.

    Args:
        pred: (B, C, *) logits of at least two classes, floating point.
        target: (B, *) integer labels, 0 to C - 1 or ignore_index.
        alpha: weight of the classes from 1 on; class 0, the background, has 1 - alpha. None means no such
            weights.
        gamma: reduces the weight of well classified pixels; 0 gives the cross entropy.
        reduction: "none", "sum" or "mean". The mean is over all C entries of all pixels, also of those that
            are ignored, as in Kornia: C times it is the mean over pixels.
        weight: (C,), the weight of the pixels of each class; ones by default.
        ignore_index: label of pixels that are ignored; None ignores no pixels.

    Returns:
        (B, C, *), the loss in the plane of a pixel's true class, 0 in the other planes and at ignored pixels;
        or a scalar.

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape or reduction is not as above.

    Example:
        >>> focal_loss(torch.tensor([[[0.0, 3.0], [0.0, 0.0]]]), torch.tensor([[1, 0]]), 0.5)
        tensor([[[0.0000e+00, 5.4642e-05],
                 [8.6643e-02, 0.0000e+00]]])
    """
    check_prediction(pred, target, 2)
    if pred.size(1) < 2:
        raise ValueError(f"pred: expected at least 2 classes, got {list(pred.shape)}")
    counts = considered(target, ignore_index)
    logits, every = where_considered(widened(pred), counts)
    planes = class_planes(target, pred.size(1))
    own = torch.where(planes, logits, torch.zeros_like(logits)).sum(1)
    # The odds of the class against all others give p_t and 1 - p_t without cancellation, also for very
    # confident predictions.
    loss = _focused(
        own - _log_sum_exp(torch.where(planes, torch.full_like(logits, -float("inf")), logits)), gamma
    )
    if alpha is not None:
        loss = loss * torch.where(
            target > 0, torch.full_like(loss, alpha), torch.full_like(loss, 1.0 - alpha)
        )
    if weight is not None:
        shape = [-1] + [1] * (target.dim() - 1)
        weights = class_weights(weight, logits, "weight").reshape(shape)
        loss = loss * (planes.to(logits.dtype) * weights).sum(1)
    each = torch.where(planes, loss[:, None], torch.zeros_like(logits))
    return narrowed(reduced_where(each, every.expand_as(each), reduction), pred)


def binary_focal_loss_with_logits(
    pred: Tensor,
    target: Tensor,
    alpha: Optional[float] = 0.25,
    gamma: float = 2.0,
    reduction: str = "none",
    pos_weight: Optional[Tensor] = None,
    weight: Optional[Tensor] = None,
    ignore_index: Optional[int] = -100,
) -> Tensor:
    """Binary focal loss, where p is the sigmoid of pred and y is the target. The loss is -alpha (1 - p)^gamma
    y log(p) - (1 - alpha) p^gamma (1 - y) log(1 - p). T.-Y. Lin et al., Focal loss for dense object
    detection, ICCV 2017.

    Args:
        pred: (B, C, *) logits, or of any shape without weights; floating point.
        target: like pred, 0 or 1 (or between), or ignore_index; of any dtype.
        alpha: weight of positive examples; negative ones have 1 - alpha. None means no such weights.
        gamma: reduces the weight of well classified examples; 0 gives the cross entropy.
        reduction: "none", "sum" or "mean" (over all examples, also those that are ignored, as in Kornia).
        pos_weight: (C,), an additional weight of the positive examples of each class; ones by default.
        weight: (C,), the weight of all examples of each class; ones by default.
        ignore_index: target of examples that are ignored; None ignores no examples.

    Returns:
        A tensor of pred's shape, 0 where ignored; or a scalar.

    Raises:
        TypeError: if pred is not floating point.
        ValueError: if the shapes differ, or a weight's or reduction is not as above.

    Example:
        >>> binary_focal_loss_with_logits(torch.tensor([[0.0, 3.0]]), torch.tensor([[1, 0]]))
        tensor([[0.0433, 2.0747]])
    """
    check_floating(pred, "pred")
    check_same_shape(target, pred, "target", "pred")
    counts = considered(target, ignore_index)
    wide = widened(pred)
    logits = torch.where(counts, wide, torch.zeros_like(wide))
    y = torch.where(counts, target.to(wide.dtype), torch.zeros_like(wide))
    positive, negative = y * _focused(logits, gamma), (1.0 - y) * _focused(-logits, gamma)
    if alpha is not None:
        positive, negative = alpha * positive, (1.0 - alpha) * negative
    if pos_weight is not None:
        positive = positive * _of_channels(pos_weight, wide, "pos_weight")
    loss = positive + negative
    if weight is not None:
        loss = loss * _of_channels(weight, wide, "weight")
    return narrowed(reduced_where(loss, counts, reduction), pred)


def _focused(logit: Tensor, gamma: float) -> Tensor:
    """-(1 - p)^gamma log(p) for the sigmoid p, computed by logarithms, whose gradients are finite also if p
    is 0 or 1."""
    return -_log_sigmoid(logit) * torch.exp(gamma * _log_sigmoid(-logit))


def _log_sigmoid(x: Tensor) -> Tensor:
    """logsigmoid of PyTorch has no ONNX form. The half also gives the right gradient at 0, where the gradient
    of |x| is 0."""
    negative = torch.where(x > 0, torch.zeros_like(x), 0.5 * (x - x.abs()))
    return negative - torch.log1p(torch.exp(-x.abs()))


def _log_sum_exp(x: Tensor) -> Tensor:
    """log(sum(exp(x))) over the classes, some of which may be minus infinity; if all are, about -1e30."""
    largest = x.detach().amax(1, keepdim=True).clamp(min=-1e30)
    return torch.log(torch.exp(x - largest).sum(1).clamp(min=1e-30)) + largest.squeeze(1)


def _of_channels(weight: Tensor, pred: Tensor, name: str) -> Tensor:
    if pred.dim() < 2:
        raise ValueError(f"pred: expected shape (B, C, *) with {name}, got {list(pred.shape)}")
    return class_weights(weight, pred, name).reshape([-1] + [1] * (pred.dim() - 2))
