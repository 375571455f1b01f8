"""Peak signal-to-noise ratio."""

import math

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_same_shape
from ..primitives.numbers.loss_reduction import narrowed, widened


def psnr(image: Tensor, target: Tensor, max_val: float) -> Tensor:
    """Peak signal-to-noise ratio in decibels, 10 log10(max_val^2 / mean of (image - target)^2).

    Args:
        image: (*), floating point.
        target: like image.
        max_val: the images' dynamic range, for example 1 or 255.

    Returns:
        A scalar for all values together. If the images are equal, it is infinite and its gradient is zero.

    Raises:
        TypeError: if image or target is not floating point.
        ValueError: if the shapes differ, or max_val is not positive.

    Example:
        >>> psnr(torch.ones(4), 1.2 * torch.ones(4), 2.0)
        tensor(20.0000)
    """
    check_floating(image, "image")
    check_floating(target, "target")
    check_same_shape(target, image, "target", "image")
    if not max_val > 0.0:
        raise ValueError(f"max_val: expected a positive number, got {max_val}")
    difference = widened(image) - widened(target)
    error = (difference * difference).mean()
    equal = error <= 0
    safe = torch.where(equal, torch.ones_like(error), error)
    ratio = 20.0 * math.log10(max_val) - 10.0 / math.log(10.0) * torch.log(safe)
    found = torch.where(equal, torch.full_like(error, math.inf), ratio)
    return narrowed(found, image, target)
