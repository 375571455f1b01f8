"""Metrics of the classes of images and of pixels: accuracy, confusion matrix, IoU."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank, check_tensor
from ..primitives.images.histograms import bincount


def accuracy(pred: Tensor, target: Tensor, topk: List[int] = (1,)) -> Tensor:  # pyright: ignore[reportArgumentType]
    """Top-k accuracy: the percentage of samples whose true class is among the k highest scores. Of equal
    scores the one with the lower class index is ranked higher, as in a stable sort. NaN is ranked highest,
    but not for the true class.

    Args:
        pred: (B, C), a score for each class, floating point.
        target: (B,) or (B, 1), the true classes, integers; a class outside 0 to C - 1 is never correct.
        topk: the values of k, each at least 1.

    Returns:
        (K,) in pred's dtype: the percentages for each k of topk. Kornia returns a list of K scalars. One
        tensor has the same signature for every K, since the outputs of an artifact are named one by one;
        ``acc1, acc5 = accuracy(pred, target, (1, 5))`` reads the same.

    Raises:
        TypeError: if pred is not floating point, or target not integer.
        ValueError: if pred is not (B, C), target not (B,) or (B, 1), or topk is empty or has a number below
            1.

    Example:
        >>> accuracy(torch.tensor([[0.1, 0.7, 0.2], [0.5, 0.2, 0.3]]), torch.tensor([1, 2]), (1, 2))
        tensor([ 50., 100.])
    """
    check_rank(pred, 2, "(B, C)", "pred")
    check_floating(pred, "pred")
    if pred.size(1) < 1:
        raise ValueError(f"pred: expected at least one class, got {list(pred.shape)}")
    check_integer_tensor(target, "target")
    if (target.dim() != 1 and not (target.dim() == 2 and target.size(1) == 1)) or target.size(0) != pred.size(
        0
    ):
        raise ValueError(
            f"target: expected shape (B,) or (B, 1) for pred {list(pred.shape)}, got {list(target.shape)}"
        )
    if len(topk) == 0:
        raise ValueError("topk: expected at least one number, got none")
    for k in topk:
        if k < 1:
            raise ValueError(f"topk: expected numbers of at least 1, got {k}")
    truth = target.to(torch.int64).reshape(-1, 1)
    classes = torch.arange(pred.size(1), device=pred.device)
    own = pred.gather(1, truth.clamp(min=0, max=pred.size(1) - 1))
    behind = (pred < own) | ((pred == own) & (classes >= truth)) | (classes == truth)
    ahead = (~behind).to(torch.int64).sum(1, keepdim=True)
    known = (truth >= 0) & (truth < pred.size(1))
    right = known & (ahead < torch.tensor(topk, device=pred.device))
    return (100.0 * right.to(torch.float64).mean(0)).to(pred.dtype)


def confusion_matrix(pred: Tensor, target: Tensor, num_classes: int, normalized: bool = False) -> Tensor:
    """Confusion matrix of each sample of a batch: counts of (true class, predicted class).

    Args:
        pred: (B, *), the predicted classes, integers.
        target: the true classes, of pred's shape. An element is not counted if either class is outside 0 to
            num_classes - 1, so that -1 or 255 can mark unknown pixels.
        num_classes: number of classes, at least 2.
        normalized: divide each column by its sum (scikit-learn's ``normalize="pred"``); a column of zeros
            stays unchanged.

    Returns:
        (B, num_classes, num_classes): row i and column j has the number of elements with the true class i and
        the predicted class j. int64 and exact (Kornia's is float32, exact up to 2^24); float32 if normalized.

    Raises:
        TypeError: if pred or target is not integer.
        ValueError: if pred has no dimension, target is not of its shape, or num_classes is less than 2.

    Example:
        >>> confusion_matrix(torch.tensor([[0, 1, 1, 1]]), torch.tensor([[0, 0, 1, 1]]), 2)
        tensor([[[1, 1],
                 [0, 2]]])
    """
    counts = _counts(pred, target, num_classes)
    if not normalized:
        return counts
    total = counts.sum(1, keepdim=True).clamp(min=1)
    return (counts.to(torch.float64) / total.to(torch.float64)).to(torch.float32)


def mean_iou(pred: Tensor, target: Tensor, num_classes: int, eps: float = 1e-6) -> Tensor:
    """Intersection over union (IoU) of the pixels of each class, for each sample of a batch. As in Kornia,
    the caller computes their mean.

    Args:
        pred: (B, *), the predicted classes, integers.
        target: the true classes, of pred's shape. An element is not counted if either class is outside 0 to
            num_classes - 1.
        num_classes: number of classes, at least 2.
        eps: added to the intersection and to the union: a class that occurs in neither input gets 1. Exclude
            such classes from a mean.

    Returns:
        (B, num_classes), float32, in [0, 1].

    Raises:
        TypeError: if pred or target is not integer.
        ValueError: if pred has no dimension, target is not of its shape, num_classes is less than 2, or eps
            is not positive.

    Example:
        >>> mean_iou(torch.tensor([[0, 1, 1, 1]]), torch.tensor([[0, 0, 1, 1]]), 2)
        tensor([[0.5000, 0.6667]])
    """
    if not eps > 0.0:
        raise ValueError(f"eps: expected a positive number, got {eps}")
    counts = _counts(pred, target, num_classes)
    diagonal = torch.arange(num_classes, device=pred.device)
    common = torch.where(diagonal[:, None] == diagonal, counts, torch.zeros_like(counts)).sum(1)
    union = counts.sum(1) + counts.sum(2) - common
    return ((common.to(torch.float64) + eps) / (union.to(torch.float64) + eps)).to(torch.float32)


def check_integer_tensor(value: Tensor, name: str) -> None:
    """Raise TypeError unless ``value`` has an integer dtype."""
    check_tensor(value, name)
    if value.is_floating_point() or value.is_complex():
        raise TypeError(f"{name}: expected an integer tensor, got dtype {value.dtype}")


def _counts(pred: Tensor, target: Tensor, num_classes: int) -> Tensor:
    """(B, num_classes, num_classes), int64: rows are true classes."""
    check_integer_tensor(pred, "pred")
    check_integer_tensor(target, "target")
    if pred.dim() < 1:
        raise ValueError("pred: expected shape (B, *), got a scalar")
    if target.shape != pred.shape:
        raise ValueError(f"target: expected pred's shape {list(pred.shape)}, got {list(target.shape)}")
    if num_classes < 2:
        raise ValueError(f"num_classes: expected at least 2, got {num_classes}")
    found, truth = pred[..., None].flatten(1).to(torch.int64), target[..., None].flatten(1).to(torch.int64)
    known = (found >= 0) & (found < num_classes) & (truth >= 0) & (truth < num_classes)
    pairs = num_classes * num_classes
    truth = torch.where(known, truth, torch.zeros_like(truth))  # otherwise the product may overflow
    index = torch.where(known, truth * num_classes + found, torch.full_like(truth, pairs))
    return bincount(index, pairs + 1)[:, :pairs].unflatten(1, [num_classes, num_classes]).to(torch.int64)
