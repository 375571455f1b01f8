"""Random changes of single values and of histograms."""

import math
from typing import Tuple, Union

import torch
from torch import Tensor

from ..enhance.arithmetic import invert
from ..enhance.clahe import equalize_clahe
from ..enhance.equalization import autocontrast, equalize
from ..enhance.normalize import denormalize, normalize, normalize_min_max
from ..enhance.sharp import sharpness as sharpened
from ..enhance.tone import posterize, solarize
from ..primitives.core.checks import check_image, check_pair, check_pixels
from .decisions import applied, between, check_bounds, check_chance, drawn, white_of, whole_between


def random_auto_contrast(input: Tensor, seed: Tensor, clip_output: bool = True, p: float = 1.0) -> Tensor:
    """Stretch each channel to the whole range, by ``normalize_min_max`` to [0, 1]; uint8 by ``autocontrast``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        clip_output: limit the result to [0, 1], since rounding may exceed this range.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> random_auto_contrast(torch.tensor([[[[0.25, 0.5, 0.75]]]]), torch.tensor([7]))
        tensor([[[[0.0000, 0.5000, 1.0000]]]])
    """
    check_pixels(input, "input")
    check_chance(p)
    if input.dtype == torch.uint8:
        stretched = autocontrast(input)
    else:
        stretched = normalize_min_max(input)
        if clip_output:
            stretched = stretched.clamp(0.0, 1.0)
    return applied(stretched, input, drawn(seed, 1, input)[:, 0], p)


def random_equalize(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Equalize the histogram of each channel, by ``equalize``. A changed sample has no gradient.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; in a changed floating-point sample the values are multiples of 1 /
        255.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x = (torch.arange(1024.0) // 8).reshape(1, 1, 32, 32) / 255
        >>> random_equalize(x, torch.tensor([7]), 1.0)[0, 0, -1, -1]
        tensor(1.)
    """
    check_pixels(input, "input")
    check_chance(p)
    return applied(equalize(input), input, drawn(seed, 1, input)[:, 0], p)


def random_clahe(
    input: Tensor,
    seed: Tensor,
    clip_limit: Tuple[float, float] = (40.0, 40.0),
    grid_size: Tuple[int, int] = (8, 8),
    slow_and_differentiable: bool = False,
    p: float = 0.5,
) -> Tensor:
    """Equalize the histogram of each tile, by ``equalize_clahe``; the limit is uniform in ``clip_limit``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8, H and W greater than the number of tiles.
        seed: (B,), int64, one for each sample.
        clip_limit: (least, greatest) limit of a level's count in a tile, as a multiple of the mean count;
            positive.
        grid_size: number of tiles (down, across).
        slow_and_differentiable: as in ``equalize_clahe``.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_clahe(torch.rand(1, 3, 20, 30), torch.tensor([7]), (1.0, 4.0)).shape
        torch.Size([1, 3, 20, 30])
    """
    check_pixels(input, "input")
    check_bounds(clip_limit, 0.0, math.inf, "clip_limit")
    check_chance(p)
    u = drawn(seed, 2, input)
    limit = between(u[:, 1], clip_limit, u)
    equalized = equalize_clahe(input, limit, grid_size, slow_and_differentiable)
    return applied(equalized, input, u[:, 0], p)


def random_invert(input: Tensor, seed: Tensor, max_val: Union[float, Tensor] = 1.0, p: float = 0.5) -> Tensor:
    """Invert: ``max_val - input``; for uint8, ``255 - input``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        max_val: the value of white: a number, or a tensor that broadcasts against the input; must be 1 for
            uint8, whose white is always 255.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> random_invert(torch.tensor([[[[0.25, 1.0]]]]), torch.tensor([7]), p=1.0)
        tensor([[[[0.7500, 0.0000]]]])
    """
    check_pixels(input, "input")
    check_chance(p)
    if input.dtype == torch.uint8:
        if isinstance(max_val, Tensor):
            raise TypeError("max_val: expected a number, 1, for an image of bytes, whose white is 255")
        if max_val != 1.0:
            raise ValueError(f"max_val: expected 1 for an image of bytes, whose white is 255, got {max_val}")
        return applied(invert(input), input, drawn(seed, 1, input)[:, 0], p)
    white = max_val.to(input.dtype) if isinstance(max_val, Tensor) else input.new_full([1], max_val)
    return applied(white - input, input, drawn(seed, 1, input)[:, 0], p)


def random_posterize(input: Tensor, seed: Tensor, bits: Tuple[int, int] = (3, 8), p: float = 0.5) -> Tensor:
    """Keep only the upper bits of 8-bit values, by ``posterize``. A changed sample has no gradient.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        bits: (least, greatest) number of bits to keep; all numbers, including both bounds, are equally
            likely; 0 gives black.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; in a changed floating-point sample the values are multiples of 1 /
        255.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.tensor([[[[37.0, 255.0]]]]) / 255
        >>> (random_posterize(x, torch.tensor([7]), (3, 3), 1.0) * 255).round()
        tensor([[[[ 32., 224.]]]])
    """
    check_pixels(input, "input")
    check_pair(bits, "bits")
    if bits[0] < 0 or bits[1] > 8 or bits[0] > bits[1]:
        raise ValueError(f"bits: expected (least, greatest) within [0, 8], got ({bits[0]}, {bits[1]})")
    check_chance(p)
    u = drawn(seed, 2, input)
    return applied(posterize(input, whole_between(u[:, 1], bits)), input, u[:, 0], p)


def random_solarize(
    input: Tensor,
    seed: Tensor,
    thresholds: Tuple[float, float] = (0.4, 0.6),
    additions: Tuple[float, float] = (-0.1, 0.1),
    p: float = 0.5,
) -> Tensor:
    """Add a number, then invert the values at or above a threshold, by ``solarize``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        thresholds: (least, greatest) threshold, within [0, 1], as a fraction of white, also for uint8.
        additions: (least, greatest) number that is added, within [-0.5, 0.5], as a fraction of white.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.tensor([[[[0.25, 0.5, 1.0]]]])
        >>> random_solarize(x, torch.tensor([7]), (0.5, 0.5), (0.0, 0.0), 1.0)
        tensor([[[[0.2500, 0.5000, 0.0000]]]])
    """
    check_pixels(input, "input")
    check_bounds(thresholds, 0.0, 1.0, "thresholds")
    check_bounds(additions, -0.5, 0.5, "additions")
    check_chance(p)
    u = drawn(seed, 3, input)
    white = white_of(input)
    threshold, addition = between(u[:, 1], thresholds, input), between(u[:, 2], additions, input)
    solarized = solarize(input, threshold * white, addition * white)
    return applied(solarized, input, u[:, 0], p)


def random_sharpness(
    input: Tensor, seed: Tensor, sharpness: Tuple[float, float] = (0.0, 0.5), p: float = 0.5
) -> Tensor:
    """Sharpen or smooth the image, by ``enhance.sharpness``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8, H and W at least 3.
        seed: (B,), int64, one for each sample.
        sharpness: (least, greatest) of the factor, not negative; 0 gives the smoothed image, 1 changes
            nothing.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 3, 3)
        >>> x[0, 0, 1, 1] = 0.5
        >>> random_sharpness(x, torch.tensor([7]), (2.0, 2.0), 1.0)[0, 0, 1]
        tensor([0.0000, 0.8077, 0.0000])
    """
    check_pixels(input, "input")
    check_bounds(sharpness, 0.0, math.inf, "sharpness")
    check_chance(p)
    u = drawn(seed, 2, input)
    return applied(sharpened(input, between(u[:, 1], sharpness, input)), input, u[:, 0], p)


def random_normalize(input: Tensor, seed: Tensor, mean: Tensor, std: Tensor, p: float = 1.0) -> Tensor:
    """(input - mean) / std, per channel: ``enhance.normalize``.

    Args:
        input: (B, C, H, W), floating point.
        seed: (B,), int64, one for each sample.
        mean: a scalar tensor, (1,) or (C,).
        std: like mean; not zero.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x, half = torch.ones(1, 1, 1, 1), torch.tensor([0.5])
        >>> random_normalize(x, torch.tensor([7]), half, half).flatten()
        tensor([1.])
    """
    check_image(input, "input")
    check_chance(p)
    return applied(normalize(input, mean, std), input, drawn(seed, 1, input)[:, 0], p)


def random_denormalize(input: Tensor, seed: Tensor, mean: Tensor, std: Tensor, p: float = 1.0) -> Tensor:
    """input * std + mean, per channel: ``enhance.denormalize``.

    Args:
        input: (B, C, H, W), floating point.
        seed: (B,), int64, one for each sample.
        mean: a scalar tensor, (1,) or (C,).
        std: like mean.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x, half = torch.ones(1, 1, 1, 1), torch.tensor([0.5])
        >>> random_denormalize(x, torch.tensor([7]), half, half).flatten()
        tensor([1.])
    """
    check_image(input, "input")
    check_chance(p)
    return applied(denormalize(input, mean, std), input, drawn(seed, 1, input)[:, 0], p)
