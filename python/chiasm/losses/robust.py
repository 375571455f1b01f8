"""Robust functions of the difference of two tensors.

All are members of the family in J. T. Barron, A general and adaptive robust loss function, CVPR 2019, with
scale 1: nearly half the square of a small difference d, and less and less sensitive to large differences.
"""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_same_shape
from ..primitives.numbers.loss_reduction import narrowed, reduced, widened


def charbonnier_loss(img1: Tensor, img2: Tensor, reduction: Optional[str] = "none") -> Tensor:
    """sqrt(d^2 + 1) - 1 of the difference d (Barron's alpha = 1, also called pseudo-Huber).

    Args:
        img1: (*), floating point.
        img2: like img1.
        reduction: "none" (or None), "mean" or "sum".

    Returns:
        (*), or a scalar for "mean" and "sum".

    Raises:
        TypeError: if img1 or img2 is not floating point.
        ValueError: if the shapes differ or reduction is unknown.

    Example:
        >>> charbonnier_loss(torch.tensor([0.0, 0.75]), torch.zeros(2))
        tensor([0.0000, 0.2500])
    """
    square = _squared_difference(img1, img2)
    # keeps the digits of small differences, which the subtraction of 1 would lose
    return _as_given(square / (torch.sqrt(square + 1.0) + 1.0), reduction, img1, img2)


def welsch_loss(img1: Tensor, img2: Tensor, reduction: Optional[str] = "none") -> Tensor:
    """1 - exp(-d^2 / 2) of the difference d (Barron's alpha = -infinity, also called Leclerc).

    Args:
        img1: (*), floating point.
        img2: like img1.
        reduction: "none" (or None), "mean" or "sum".

    Returns:
        (*), or a scalar for "mean" and "sum".

    Raises:
        TypeError: if img1 or img2 is not floating point.
        ValueError: if the shapes differ or reduction is unknown.

    Example:
        >>> welsch_loss(torch.tensor([0.0, 1.0]), torch.zeros(2))
        tensor([0.0000, 0.3935])
    """
    return _as_given(-torch.expm1(-0.5 * _squared_difference(img1, img2)), reduction, img1, img2)


def cauchy_loss(img1: Tensor, img2: Tensor, reduction: Optional[str] = "none") -> Tensor:
    """log(d^2 / 2 + 1) of the difference d (Barron's alpha = 0, also called Lorentzian).

    Args:
        img1: (*), floating point.
        img2: like img1.
        reduction: "none" (or None), "mean" or "sum".

    Returns:
        (*), or a scalar for "mean" and "sum".

    Raises:
        TypeError: if img1 or img2 is not floating point.
        ValueError: if the shapes differ or reduction is unknown.

    Example:
        >>> cauchy_loss(torch.tensor([0.0, 2.0]), torch.zeros(2))
        tensor([0.0000, 1.0986])
    """
    return _as_given(torch.log1p(0.5 * _squared_difference(img1, img2)), reduction, img1, img2)


def geman_mcclure_loss(img1: Tensor, img2: Tensor, reduction: Optional[str] = "none") -> Tensor:
    """2 d^2 / (d^2 + 4) of the difference d (Barron's alpha = -2).

    Args:
        img1: (*), floating point.
        img2: like img1.
        reduction: "none" (or None), "mean" or "sum".

    Returns:
        (*), or a scalar for "mean" and "sum".

    Raises:
        TypeError: if img1 or img2 is not floating point.
        ValueError: if the shapes differ or reduction is unknown.

    Example:
        >>> geman_mcclure_loss(torch.tensor([0.0, 2.0]), torch.zeros(2))
        tensor([0., 1.])
    """
    square = _squared_difference(img1, img2)
    return _as_given(2.0 * square / (square + 4.0), reduction, img1, img2)


def _squared_difference(img1: Tensor, img2: Tensor) -> Tensor:
    check_floating(img1, "img1")
    check_floating(img2, "img2")
    check_same_shape(img2, img1, "img2", "img1")
    difference = widened(img1) - widened(img2)
    return difference * difference


def _as_given(loss: Tensor, reduction: Optional[str], img1: Tensor, img2: Tensor) -> Tensor:
    """The loss, reduced, in the dtype of the two images."""
    return narrowed(reduced(loss, reduction), img1, img2)
