"""Histogram equalisation and automatic contrast: one table of 256 levels for each plane."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_pixels
from ..primitives.images.histograms import bincount, level_rows, lut, running_sum, whole_quotient
from ..primitives.images.tables import table_entries
from ..primitives.resampling.volumes import check_volume


def equalize(input: Tensor) -> Tensor:
    """Equalize the histogram of each channel, like Pillow's ``ImageOps.equalize``.

    The input is rounded to the nearest of 256 levels. There is no gradient. For uint8, the result is
    identical to Pillow's.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), floating point in [0, 1], or uint8.

    Returns:
        (B, C, H, W): multiples of 1 / 255, or uint8.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> x = (torch.arange(1024.0) // 8).reshape(1, 1, 32, 32) / 255
        >>> equalize(x)[0, 0, -1, -1]
        tensor(1.)
    """
    return like_given(_equalize_of_batch(in_batch(input, "input")), input)


def _equalize_of_batch(input: Tensor) -> Tensor:
    check_pixels(input, "input")
    return _equalized(input)


def equalize3d(input: Tensor) -> Tensor:
    """``equalize`` for volumes, with one histogram for each channel.

    Args:
        input: (B, C, D, H, W) in [0, 1], floating point.

    Returns:
        (B, C, D, H, W): multiples of 1 / 255.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D.

    Example:
        >>> equalize3d(torch.ones(1, 1, 2, 3, 4)).shape
        torch.Size([1, 1, 2, 3, 4])
    """
    check_volume(input, "input")
    return _equalized(input)


def autocontrast(image: Tensor, cutoff: Union[float, Tuple[float, float]] = 0.0) -> Tensor:
    """Stretch the levels of each channel to the whole range, like Pillow's ``ImageOps.autocontrast``. The
    image is rounded to the nearest of 256 levels. The exact result is rounded down to a level (Pillow's float
    arithmetic gives one level less at some whole numbers). There is no gradient.

    Args:
        image: (B, C, H, W), floating point in [0, 1], or uint8.
        cutoff: percentage of the pixels to ignore at each end of the histogram, or (dark end, bright end).

    Returns:
        (B, C, H, W): multiples of 1 / 255, or uint8. A constant channel stays as it is.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D or a cutoff is negative or their sum 100 or more.

    Example:
        >>> autocontrast(torch.tensor([51.0, 102.0]).reshape(1, 1, 1, 2) / 255).flatten()
        tensor([0., 1.])
    """
    check_pixels(image, "image")
    if isinstance(cutoff, (float, int)):
        low, high = cutoff * 1.0, cutoff * 1.0
    else:
        low, high = cutoff
    if not (low >= 0.0 and high >= 0.0 and low + high < 100.0):
        raise ValueError(
            f"cutoff: expected percentages that are not negative and sum to less than 100, got ({low},"
            f" {high})"
        )
    levels = level_rows(image)
    counts = bincount(levels, 256)
    upto = running_sum(counts)
    pixels = upto[:, 255:].to(torch.float64)
    darkest = (upto <= torch.floor(pixels * low / 100.0)).sum(1, keepdim=True)
    brightest = 255 - (pixels - upto + counts <= torch.floor(pixels * high / 100.0)).sum(1, keepdim=True)
    span = brightest - darkest
    level = torch.arange(256, device=image.device)
    stretched = whole_quotient((level - darkest).clamp(min=0) * 255, span.clamp(min=1)).clamp(max=255)
    table = torch.where(span > 0, stretched, level)
    return _applied(table, levels, image)


def _equalized(x: Tensor) -> Tensor:
    levels = level_rows(x)
    counts = bincount(levels, 256)
    upto = running_sum(counts)
    level = torch.arange(256, device=x.device)
    brightest = torch.where(counts > 0, level, torch.zeros_like(level)).amax(1, keepdim=True)
    step = whole_quotient(upto[:, 255:] - counts.gather(1, brightest), torch.full_like(brightest, 255))
    spread = whole_quotient(upto - counts + whole_quotient(step, torch.full_like(step, 2)), step.clamp(min=1))
    return _applied(torch.where(step > 0, spread.clamp(max=255), level), levels, x)


def _applied(table: Tensor, levels: Tensor, like: Tensor) -> Tensor:
    if like.dtype == torch.uint8:
        return table_entries(levels, table.to(torch.uint8)).reshape(like.shape)
    return lut(table.to(like.dtype) / 255.0, levels).reshape(like.shape)
