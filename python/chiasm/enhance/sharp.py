"""Sharpness."""

from typing import Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given, per_sample
from ..primitives.core.checks import check_pixels
from ..primitives.filters.fixed_point import correlated_bytes, whole_taps
from ..primitives.numbers.rounding import known_or


def sharpness(input: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Sharpen or smooth: blend with a smoothed image, like Pillow's ``ImageEnhance.Sharpness``.

    The smoothing kernel is [[1, 1, 1], [1, 5, 1], [1, 1, 1]] / 13; border pixels are not smoothed. For uint8,
    the smoothed image is rounded and the difference times the factor is rounded down, as in Pillow; where
    this product is nearly a whole number, the result can differ from Pillow's by one level.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), floating point in [0, 1] or uint8, H and W at least 3.
        factor: not negative; 0 gives the smoothed image, 1 changes nothing. A number, a scalar tensor or
            (B,), one for each sample.

    Returns:
        (B, C, H, W), in [0, 1]; uint8 for uint8.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D or too small, or factor's shape is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 3, 3)
        >>> x[0, 0, 1, 1] = 0.5
        >>> sharpness(x, 2.0)[0, 0, 1]
        tensor([0.0000, 0.8077, 0.0000])
    """
    return like_given(_sharpness_of_batch(in_batch(input, "input"), factor), input)


def _sharpness_of_batch(input: Tensor, factor: Union[float, Tensor]) -> Tensor:
    check_pixels(input, "input")
    if input.size(2) < 3 or input.size(3) < 3:
        raise ValueError(f"input: expected H and W of at least 3, got {list(input.shape)}")
    height, width = input.size(2) - 2, input.size(3) - 2
    if input.dtype == torch.uint8:
        window = torch.tensor([[[1.0, 1.0, 1.0], [1.0, 5.0, 1.0], [1.0, 1.0, 1.0]]], dtype=torch.float64)
        # A sum divided by 13 is never a half, and its distance from a half is greater than the rounding
        # error.
        taps, scale = whole_taps(window.to(input.device) / 13.0)
        smooth = correlated_bytes(input, taps, scale, "replicate").to(torch.float32)
        centre = input.to(torch.float32)
        # Only the product: engines round a product and a sum together differently.
        added = torch.floor(known_or((centre - smooth) * per_sample(factor, centre, "factor"), 0.0))
        inner = (smooth + added).clamp(0.0, 255.0).to(torch.uint8)[:, :, 1 : height + 1, 1 : width + 1]
        middle = input[:, :, 1 : height + 1]
        wide = torch.cat([middle[..., :1], inner, middle[..., width + 1 :]], 3)
        return torch.cat([input[:, :, :1], wide, input[:, :, height + 1 :]], 2)
    rows = input[:, :, :height] + input[:, :, 1 : height + 1] + input[:, :, 2:]
    centre = input[:, :, 1 : height + 1, 1 : width + 1]
    smooth = (rows[..., :width] + rows[..., 1 : width + 1] + rows[..., 2:] + 4.0 * centre) / 13.0
    inner = smooth + (centre - smooth) * per_sample(factor, smooth, "factor")
    middle = input[:, :, 1 : height + 1]
    wide = torch.cat([middle[..., :1], inner, middle[..., width + 1 :]], 3)
    return torch.cat([input[:, :, :1], wide, input[:, :, height + 1 :]], 2).clamp(0.0, 1.0)
