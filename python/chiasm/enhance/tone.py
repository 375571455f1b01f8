"""Posterize, solarize, threshold."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import per_sample
from ..primitives.core.checks import check_choice, check_values
from ..primitives.core.pixels import pixel_range
from ..primitives.images.histograms import quantize_u8
from ..primitives.images.masks import split_at
from ..primitives.images.tables import levels, looked_up
from ..primitives.numbers.rounding import known_or


def posterize(input: Tensor, bits: Union[int, Tensor]) -> Tensor:
    """Keep only the upper bits of 8-bit levels, like Pillow's ``ImageOps.posterize``.

    The input is rounded to the nearest of the 256 levels. There is no gradient.

    Args:
        input: (B, *), floating point in [0, 1], or uint8.
        bits: how many bits to keep, 0 to 8: a number, or an integer tensor that is a scalar or (B,), one for
            each sample.

    Returns:
        Tensor of the input's shape and dtype: multiples of 1 / 255, or for uint8 the upper bits.

    Raises:
        TypeError: if input is neither floating point nor uint8, or bits not of an integer dtype.
        ValueError: if bits is a number outside 0 to 8 or its shape is not as above.

    Example:
        >>> (posterize(torch.tensor([[37.0, 255.0]]) / 255, 3) * 255).round()
        tensor([[ 32., 224.]])
    """
    check_values(input, "input")
    # a table, since a general pow does not compute exact powers of two on every engine
    steps = torch.tensor([256.0, 128.0, 64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0], device=input.device)
    if isinstance(bits, Tensor):
        if bits.is_floating_point():
            raise TypeError(f"bits: expected an integer tensor, got dtype {bits.dtype}")
        step = steps.index_select(0, bits.reshape(-1).clamp(0, 8).to(torch.int64))
    else:
        if not isinstance(bits, int):
            raise TypeError(f"bits: expected a whole number or a tensor, got {type(bits).__name__}")
        if bits < 0 or bits > 8:
            raise ValueError(f"bits: expected 0 to 8, got {bits}")
        step = steps[bits : bits + 1]
    if input.dtype == torch.uint8:
        return looked_up(input, _upper_bits(levels(input, 255.0), step), 255.0)
    return (_upper_bits(quantize_u8(input).to(torch.float32), step) / 255.0).to(input.dtype)


def _upper_bits(whole: Tensor, step: Tensor) -> Tensor:
    each = per_sample(step, whole, "bits")
    return torch.floor(whole / each) * each


def solarize(
    input: Tensor, thresholds: Union[float, Tensor] = 0.5, additions: Optional[Union[float, Tensor]] = None
) -> Tensor:
    """Invert the values at or above a threshold, like Pillow's ``ImageOps.solarize``.

    Args:
        input: (B, *), floating point in [0, 1], or uint8.
        thresholds: a number, a scalar tensor or (B,), one for each sample; for uint8, a level of 0 to 255.
        additions: the number to add before; the sum is limited to the range; like thresholds.

    Returns:
        Tensor of the input's shape and dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if the shape of thresholds or additions is not as above.

    Example:
        >>> solarize(torch.tensor([[0.25, 0.5, 1.0]]))
        tensor([[0.2500, 0.5000, 0.0000]])
    """
    check_values(input, "input")
    if input.dtype == torch.uint8:
        return looked_up(input, _solarized(levels(input, 255.0), thresholds, additions, 255.0), 255.0)
    return _solarized(input, thresholds, additions, 1.0)


def _solarized(
    x: Tensor, thresholds: Union[float, Tensor], additions: Optional[Union[float, Tensor]], white: float
) -> Tensor:
    if additions is not None:
        x = (x + per_sample(additions, x, "additions")).clamp(0.0, white)
    return torch.where(x < per_sample(thresholds, x, "thresholds"), x, white - x)


def threshold(
    input: Tensor, thresh: Union[float, Tensor], maxval: Union[float, Tensor] = 255.0, type: str = "binary"
) -> Tensor:
    """Compare with a threshold, like OpenCV's ``threshold``.

    Unlike in Kornia, the type is a string. Where x > thresh: "binary" gives maxval (else 0), "binary_inv" 0
    (else maxval), "trunc" thresh (else x), "tozero" x (else 0), "tozero_inv" 0 (else x). For integers,
    "trunc" gives thresh rounded down, and maxval is rounded; both saturate.

    Args:
        input: (B, *), floating point, uint8, int16 or uint16.
        thresh: a number, a scalar tensor or (B,), one for each sample.
        maxval: like thresh; used by the binary types only.
        type: "binary", "binary_inv", "trunc", "tozero" or "tozero_inv".

    Returns:
        Tensor of the input's shape and dtype.

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if type is unknown or the shape of thresh or maxval is not as above.

    Example:
        >>> threshold(torch.tensor([[0.25, 0.75]]), 0.5, 1.0)
        tensor([[0., 1.]])
    """
    check_values(input, "input", True)
    check_choice(type, ["binary", "binary_inv", "trunc", "tozero", "tozero_inv"], "type")
    if input.is_floating_point():
        return _compared(input, thresh, maxval, type)
    if input.dtype != torch.uint8:
        return _words_compared(input, thresh, maxval, type)
    made = _compared(levels(input, 255.0), thresh, maxval, type)
    if type == "trunc":
        made = torch.floor(made)  # integers above a fraction come down to the level below it
    return looked_up(input, made, 255.0)


def _words_compared(
    input: Tensor, thresh: Union[float, Tensor], maxval: Union[float, Tensor], type: str
) -> Tensor:
    exact = input.to(torch.float64)
    least, largest = pixel_range(input)
    # Integers above a number are above its floor, and none is above NaN.
    limit = known_or(torch.floor(per_sample(thresh, exact, "thresh")), float(largest))
    limit = limit.clamp(least - 1.0, float(largest)).to(torch.int32)
    high = known_or(torch.round(per_sample(maxval, exact, "maxval")), 0.0).clamp(least, largest)
    above, below = _sides(type, limit, high.to(torch.int32))
    return split_at(input, limit, above, below)


def _compared(input: Tensor, thresh: Union[float, Tensor], maxval: Union[float, Tensor], type: str) -> Tensor:
    limit = per_sample(thresh, input, "thresh")
    above, below = _sides(type, limit, per_sample(maxval, input, "maxval"))
    return torch.where(input > limit, input if above is None else above, input if below is None else below)


def _sides(type: str, limit: Tensor, high: Tensor) -> Tuple[Optional[Tensor], Optional[Tensor]]:
    """What values above the limit become, and the others; None: they stay as they are."""
    zero = torch.zeros_like(limit)
    if type == "binary":
        return high, zero
    if type == "binary_inv":
        return zero, high
    if type == "trunc":
        return limit, None
    return (None, zero) if type == "tozero" else (zero, None)
