"""The photometric distortion of single-shot detectors."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ..enhance.adjust import (
    adjust_brightness_accumulative,
    adjust_contrast_with_mean_subtraction,
    adjust_saturation_with_gray_subtraction,
)
from ..enhance.hue import adjust_hue
from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_pixels, check_rgb
from ..primitives.random.draws import ranks
from .decisions import applied, as_given, between, check_bounds, check_chance, drawn, numbers_of
from .noise import shuffled


def random_photometric_distort(
    input: Tensor,
    seed: Tensor,
    brightness: Tuple[float, float] = (0.875, 1.125),
    contrast: Tuple[float, float] = (0.5, 1.5),
    saturation: Tuple[float, float] = (0.5, 1.5),
    hue: Tuple[float, float] = (-0.05, 0.05),
    p: float = 0.5,
) -> Tensor:
    """Change brightness, contrast, saturation, hue and the order of the channels, each with probability
    ``p``, like torchvision's ``RandomPhotometricDistort``.

    W. Liu et al., SSD: single shot multibox detector, ECCV 2016. Contrast comes before saturation and hue or
    after them; both orders are equally likely.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        brightness: (least, greatest) of the factor, not negative; 1 changes nothing.
        contrast: the same.
        saturation: the same.
        hue: (least, greatest), in turns, within [-0.5, 0.5].
        p: probability of each of the five changes.

    Returns:
        (B, 3, H, W), of the input's dtype; bytes are rounded once, after all changes.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_photometric_distort(torch.rand(1, 3, 4, 5), torch.tensor([7])).shape
        torch.Size([1, 3, 4, 5])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(brightness, 0.0, math.inf, "brightness")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = drawn(seed, 13, input)
    x = numbers_of(input)
    factor = between(u[:, 6], contrast, x)
    stretches, early = u[:, 1] < p, u[:, 2] < 0.5
    x = applied(adjust_brightness_accumulative(x, between(u[:, 5], brightness, x)), x, u[:, 0], p)
    before = each(stretches & early, x)
    x = torch.where(before, adjust_contrast_with_mean_subtraction(x, factor), x)
    richer = adjust_saturation_with_gray_subtraction(x, between(u[:, 7], saturation, x))
    x = applied(richer, x, u[:, 3], p)
    x = applied(adjust_hue(x, between(u[:, 8], hue, x) * (2.0 * math.pi)), x, u[:, 4], p)
    after = each(stretches & ~early, x)
    x = torch.where(after, adjust_contrast_with_mean_subtraction(x, factor), x)
    return as_given(applied(shuffled(x, ranks(u[:, 9:12])), x, u[:, 12], p), input)
