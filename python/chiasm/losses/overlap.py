"""Losses based on the overlap of two segmentations."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice
from ..primitives.numbers.loss_reduction import considered, narrowed, where_considered, widened
from .labels import check_prediction, class_planes, class_weights


def dice_loss(
    pred: Tensor,
    target: Tensor,
    average: str = "micro",
    eps: float = 1e-8,
    weight: Optional[Tensor] = None,
    ignore_index: Optional[int] = -100,
) -> Tensor:
    """Dice loss: 1 - 2 sum(p g) / (sum(p) + sum(g) + eps), with the softmax p of pred and one-hot labels g.

    The result is the mean over the batch. F. Milletari et al., V-Net, 3DV 2016, without its squares; with
    weights, C. Sudre et al., Generalised Dice overlap as a deep learning loss function, DLMIA 2017.

    Args:
        pred: (B, C, *) logits, floating point.
        target: (B, *) integer labels, 0 to C - 1 or ignore_index.
        average: "micro" puts the sums over all classes into one quotient; "macro" takes the mean of the
            quotients of the classes that a sample's labels have.
        eps: added to the denominator.
        weight: (C,), ones by default: weights of the classes' sums ("micro"), or of their quotients in a
            weighted mean ("macro").
        ignore_index: label of pixels that are ignored; None ignores no pixels.

    Returns:
        A scalar from 0 to 1. A sample whose pixels are all ignored has the loss 1.

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape or average is not as above.

    Example:
        >>> dice_loss(torch.tensor([[[9.0, -9.0], [-9.0, 9.0]]]), torch.tensor([[0, 0]]))
        tensor(0.5000)
    """
    check_choice(average, ["micro", "macro"], "average")
    check_prediction(pred, target, 3)
    logits = widened(pred)
    both, predicted, labelled = _class_sums(logits, target, ignore_index)
    weights = class_weights(weight, logits, "weight")
    loss = _averaged_loss(2.0 * both, predicted + labelled, labelled > 0.0, weights, average, eps)
    return narrowed(loss, pred)


def tversky_loss(
    pred: Tensor,
    target: Tensor,
    alpha: float,
    beta: float,
    eps: float = 1e-8,
    ignore_index: Optional[int] = -100,
    average: str = "macro",
) -> Tensor:
    """Tversky loss: 1 - TP / (TP + alpha FP + beta FN + eps), with soft counts from the softmax of pred.

    TP, FP and FN are true positives, false positives and false negatives. The result is the mean over the
    batch. S. Salehi et al., Tversky loss function for image segmentation using 3D fully convolutional deep
    networks, MLMI 2017. With alpha = beta = 1/2 it is ``dice_loss``. Every false positive of one class is a
    false negative of another: summed over all classes ("micro") the two are equal, and only alpha + beta
    matters.

    Args:
        pred: (B, C, *) logits, floating point.
        target: (B, *) integer labels, 0 to C - 1 or ignore_index.
        alpha: weight of false positives.
        beta: weight of false negatives.
        eps: added to the denominator.
        ignore_index: label of pixels that are ignored; None ignores no pixels.
        average: "micro" puts the sums over all classes into one quotient; "macro" takes the mean of the
            quotients of the classes that a sample's labels have.

    Returns:
        A scalar from 0 to 1. A sample whose pixels are all ignored has the loss 1.

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape or average is not as above.

    Example:
        >>> tversky_loss(torch.tensor([[[9.0, -9.0], [-9.0, 9.0]]]), torch.tensor([[0, 0]]), 0.3, 0.7)
        tensor(0.4118)
    """
    check_choice(average, ["micro", "macro"], "average")
    check_prediction(pred, target, 3)
    logits = widened(pred)
    both, predicted, labelled = _class_sums(logits, target, ignore_index)
    union = both + alpha * (predicted - both) + beta * (labelled - both)
    weights = class_weights(None, logits, "weight")
    return narrowed(_averaged_loss(both, union, labelled > 0.0, weights, average, eps), pred)


def _class_sums(pred: Tensor, target: Tensor, ignore_index: Optional[int]) -> Tuple[Tensor, Tensor, Tensor]:
    """Sums (B, C) over the pixels of a sample: of the softmax at the pixels of a class, of the softmax, and
    of these pixels."""
    logits, counts = where_considered(pred, considered(target, ignore_index))
    probability = torch.softmax(logits, 1) * counts.to(pred.dtype)
    label = (class_planes(target, pred.size(1)) & counts).to(pred.dtype)
    pixels = [i for i in range(2, probability.dim())]
    return (probability * label).sum(pixels), probability.sum(pixels), label.sum(pixels)


def _averaged_loss(
    part: Tensor, whole: Tensor, present: Tensor, weights: Tensor, average: str, eps: float
) -> Tensor:
    """The loss of sums (B, C); ``present``, (B, C), says which classes a sample's labels have."""
    if average == "micro":
        score = _share((part * weights).sum(1), (whole * weights).sum(1) + eps)
    else:
        # A sample without labelled pixels has the loss 1.
        shares = weights * present.to(weights.dtype)
        total = shares.sum(1)
        score = _share((_share(part, whole + eps) * shares).sum(1), total)
    return (1.0 - score).mean()


def _share(part: Tensor, whole: Tensor) -> Tensor:
    """part / whole, and 0 of nothing, with a gradient of 0."""
    return part / torch.where(whole == 0, torch.ones_like(whole), whole)
