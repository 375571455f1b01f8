"""Divergences between heatmaps."""

import math

import torch
from torch import Tensor

from ..primitives.core.checks import check_image, check_same_shape
from ..primitives.numbers.loss_reduction import narrowed, reduced, widened


def kl_div_loss_2d(pred: Tensor, target: Tensor, reduction: str = "mean") -> Tensor:
    """Kullback-Leibler divergence of pred from target: the sum of target log(target / pred) over each
    heatmap.

    Args:
        pred: (B, N, H, W) heatmaps, not negative, each with sum 1; floating point.
        target: like pred.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar, or (B, N) for "none". If pred is 0 at a pixel and target is not, the divergence is infinite
        and the pixel's gradient is zero.

    Raises:
        TypeError: if pred or target is not floating point.
        ValueError: if pred is not 4-D, the shapes differ, or reduction is unknown.

    Example:
        >>> kl_div_loss_2d(torch.full((1, 1, 2, 2), 0.25), torch.tensor([[[[0.5, 0.5], [0.0, 0.0]]]]))
        tensor(0.6931)
    """
    _check_heatmaps(pred, target)
    loss = reduced(_divergence(widened(target), widened(pred)), reduction)
    return narrowed(loss, pred, target)


def js_div_loss_2d(pred: Tensor, target: Tensor, reduction: str = "mean") -> Tensor:
    """Jensen-Shannon divergence of heatmaps: the mean of their Kullback-Leibler divergences from their mean,
    at most log 2.

    J. Lin, Divergence measures based on the Shannon entropy, IEEE Trans. Information Theory 37(1), 1991.

    Args:
        pred: (B, N, H, W) heatmaps, not negative, each with sum 1; floating point.
        target: like pred.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar, or (B, N) for "none".

    Raises:
        TypeError: if pred or target is not floating point.
        ValueError: if pred is not 4-D, the shapes differ, or reduction is unknown.

    Example:
        >>> js_div_loss_2d(torch.tensor([[[[1.0, 0.0]]]]), torch.tensor([[[[0.0, 1.0]]]]))
        tensor(0.6931)
    """
    _check_heatmaps(pred, target)
    p, q = widened(pred), widened(target)
    # Twice the heatmaps, whose mean is the sum: the mean of the least number and 0 is rounded to 0, from
    # which the divergence would be infinite.
    total = p + q
    loss = reduced(0.25 * (_divergence(2.0 * q, total) + _divergence(2.0 * p, total)), reduction)
    return narrowed(loss, pred, target)


def _check_heatmaps(pred: Tensor, target: Tensor) -> None:
    check_image(pred, "pred")
    check_image(target, "target")
    check_same_shape(target, pred, "target", "pred")


def _divergence(p: Tensor, q: Tensor) -> Tensor:
    """Sum of p log(p / q) over the last two axes; 0 log 0 is 0."""
    present, possible = p > 0, q > 0
    one = torch.ones_like(p)
    ratio = torch.log(torch.where(present, p, one)) - torch.log(torch.where(possible, q, one))
    term = torch.where(possible, p * ratio, torch.full_like(p, math.inf))
    return torch.where(present, term, torch.zeros_like(p)).sum([-2, -1])
