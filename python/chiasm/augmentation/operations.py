"""The operations of AutoAugment and of the methods after it; each sample gets one operation.

E. Cubuk et al., AutoAugment: learning augmentation policies from data, CVPR 2019, table 6. All operations are
computed for all samples, then one is selected. The five operations that move pixels are one warp, and the
three that blend with black or grey are one blend, so that 14 operations cost eight passes.
"""

import math
from typing import List

import torch
from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..enhance.equalization import equalize
from ..enhance.sharp import sharpness
from ..enhance.tone import posterize, solarize
from ..primitives.core.broadcasting import each
from ..primitives.resampling.warping import resample_affine


def names() -> List[str]:
    """The names of the operations; the index in this list is the operation's number."""
    return [
        "Identity",
        "ShearX",
        "ShearY",
        "TranslateX",
        "TranslateY",
        "Rotate",
        "Brightness",
        "Color",
        "Contrast",
        "Sharpness",
        "Posterize",
        "Solarize",
        "AutoContrast",
        "Equalize",
        "Invert",
    ]


def amounts(
    operation: Tensor,
    level: Tensor,
    sign: Tensor,
    reach: List[float],
    height: int,
    width: int,
    relative: bool,
) -> Tensor:
    """The amount of an operation, in its units, from a level in [0, 1] and a sign of -1 or 1; all are (B,).

    ``reach`` is the amount at level 1: the tangent of a shear, the translation (with ``relative`` as a
    fraction of the side), the angle in degrees, the factor of a blend, and the number of bits; its last
    number is the number of bits at level 0. Translations are whole pixels, rounded towards zero.
    """
    signed = level * sign
    zero = torch.zeros_like(level)
    across = reach[1] * width if relative else reach[1]
    down = reach[1] * height if relative else reach[1]
    amount = torch.where((operation == 1) | (operation == 2), signed * reach[0], zero)
    amount = torch.where(operation == 3, torch.trunc(signed * across), amount)
    amount = torch.where(operation == 4, torch.trunc(signed * down), amount)
    amount = torch.where(operation == 5, signed * reach[2], amount)
    amount = torch.where((operation >= 6) & (operation <= 9), 1.0 + signed * reach[3], amount)
    amount = torch.where(operation == 10, reach[5] - torch.round(level * reach[4]), amount)
    return torch.where(operation == 11, 1.0 - level, amount)


def operated(x: Tensor, operation: Tensor, amount: Tensor, mode: str) -> Tensor:
    """Each sample (B, 3, H, W) after its operation (B,) with its amount (B,)."""
    which = each(operation, x)
    value = amount.to(x.dtype)
    result = torch.where((which >= 1) & (which <= 5), _moved(x, operation, amount, mode), x)
    result = torch.where((which >= 6) & (which <= 8), _blended(x, which, each(value, x)), result)
    result = torch.where(which == 9, sharpness(x, value), result)
    bits = torch.where(operation == 10, amount, torch.full_like(amount, 8.0)).to(torch.int64)
    result = torch.where(which == 10, posterize(x, bits), result)
    result = torch.where(which == 11, solarize(x, value), result)
    result = torch.where(which == 12, _stretched(x), result)
    result = torch.where(which == 13, equalize(x), result)
    return torch.where(which == 14, 1.0 - x, result)


def _moved(x: Tensor, operation: Tensor, amount: Tensor, mode: str) -> Tensor:
    """Shears about the upper left corner, translations, and counterclockwise rotations about the centre;
    pixels outside are black."""
    height, width = x.size(2), x.size(3)
    value = amount.to(torch.float64)
    zero = torch.zeros_like(value)
    angle = torch.where(operation == 5, value, zero) * (math.pi / 180.0)
    c, s = torch.cos(angle), torch.sin(angle)
    cx, cy = (width - 1) * 0.5, (height - 1) * 0.5
    shear_x, shear_y = torch.where(operation == 1, value, zero), torch.where(operation == 2, value, zero)
    # The corner is half a pixel away from the centre of the first pixel.
    move_x = cx - c * cx + s * cy + shear_x * 0.5 - torch.where(operation == 3, value, zero)
    move_y = cy - s * cx - c * cy + shear_y * 0.5 - torch.where(operation == 4, value, zero)
    inverse = torch.stack([c, shear_x - s, move_x, s + shear_y, c, move_y], 1).reshape(-1, 2, 3)
    return resample_affine(x, inverse, height, width, mode, "zeros", True, None)


def _blended(x: Tensor, which: Tensor, factor: Tensor) -> Tensor:
    """Blend with black, grey or the mean grey, like Pillow's ``ImageEnhance``."""
    grey = rgb_to_grayscale(x)
    other = torch.where(which == 8, grey.mean([1, 2, 3], keepdim=True), grey)
    other = torch.where(which == 6, torch.zeros_like(other), other)
    return (other + (x - other) * factor).clamp(0.0, 1.0)


def _stretched(x: Tensor) -> Tensor:
    """Each channel stretched to [0, 1]; a constant channel stays as it is."""
    low, high = x.amin([2, 3], keepdim=True), x.amax([2, 3], keepdim=True)
    flat = high == low
    return torch.where(flat, x, (x - low) / torch.where(flat, torch.ones_like(high), high - low))
