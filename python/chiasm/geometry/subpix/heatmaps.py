"""Heat maps with one peak: conversion to a distribution, to its mean, and back.

A. Nibali, Z. He, S. Morgan, L. Prendergast, Numerical Coordinate Regression with Convolutional Neural
Networks, arXiv:1801.07372, 2018. Half precision is computed in float32.
"""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_image, check_last, check_number
from ...primitives.resampling.warping import position_dtype
from ..conversions.pixels import normalisation


def spatial_softmax2d(input: Tensor, temperature: Optional[Union[Tensor, float]] = None) -> Tensor:
    """The softmax of each channel over its pixels: exp(v / temperature), divided by its sum.

    Args:
        input: (B, N, H, W), floating point.
        temperature: positive, a number or a tensor of one element, whose value is not checked; a smaller
            value gives a sharper peak. 1 by default.

    Returns:
        (B, N, H, W), positive; the sum of each channel is 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the temperature is not one positive number.

    Example:
        >>> spatial_softmax2d(torch.tensor([[[[0.0, 0.0], [0.0, 1.0]]]]), 0.5)[0, 0]
        tensor([[0.0963, 0.0963],
                [0.0963, 0.7112]])
    """
    check_image(input, "input")
    return _softmax(input, temperature).to(input.dtype)


def spatial_expectation2d(input: Tensor, normalized_coordinates: bool = True) -> Tensor:
    """The mean position of each channel, weighted by its values.

    Args:
        input: (B, N, H, W), floating point; each channel sums to 1, like the result of ``spatial_softmax2d``.
            For a channel with the sum s the result is s times the mean.
        normalized_coordinates: True: positions in [-1, 1], the centres of the outermost pixels (an axis of
            one pixel is 0); False: positions in pixels from 0.

    Returns:
        (B, N, 2), x and y.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D.

    Example:
        >>> spatial_expectation2d(torch.tensor([[[[0.0, 0.0, 0.0], [0.0, 0.25, 0.75]]]]), False)
        tensor([[[1.7500, 1.0000]]])
    """
    check_image(input, "input")
    return _expectation(input, normalized_coordinates).to(input.dtype)


def spatial_soft_argmax2d(
    input: Tensor, temperature: Optional[Union[Tensor, float]] = None, normalized_coordinates: bool = True
) -> Tensor:
    """The mean position of each channel under the softmax over its pixels: ``spatial_expectation2d`` of
    ``spatial_softmax2d``.

    The result is near the position of the largest value if this exceeds the other values by many
    temperatures; for two equal peaks it is the midpoint.

    Args:
        input: (B, N, H, W), floating point.
        temperature: positive, a number or a tensor of one element, whose value is not checked; a smaller
            value gives a sharper peak. 1 by default.
        normalized_coordinates: True: positions in [-1, 1], the centres of the outermost pixels (an axis of
            one pixel is 0); False: positions in pixels from 0.

    Returns:
        (B, N, 2), x and y.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the temperature is not one positive number.

    Example:
        >>> heatmap = torch.zeros(1, 1, 4, 5)
        >>> heatmap[0, 0, 2, 3] = 100.0
        >>> spatial_soft_argmax2d(heatmap, normalized_coordinates=False)
        tensor([[[3., 2.]]])
    """
    check_image(input, "input")
    return _expectation(_softmax(input, temperature), normalized_coordinates).to(input.dtype)


def render_gaussian2d(
    mean: Tensor, std: Tensor, size: Tuple[int, int], normalized_coordinates: bool = True
) -> Tensor:
    """Images of normal distributions with independent x and y; each image sums to 1. Each axis sums to 1 over
    the pixels. So a mean outside the image gives the part inside the image, scaled up; if the mean is far
    outside, this part is at the nearest border.

    Args:
        mean: (*, 2), x and y, floating point.
        std: standard deviations along x and y, not 0, of a shape that is broadcast with mean's.
        size: (height, width) of the images; may come from another tensor's shape.
        normalized_coordinates: True: mean and std are in units of [-1, 1], the centres of the outermost
            pixels (an axis of one pixel is 0); False: in pixels from 0.

    Returns:
        (*, height, width) in mean's dtype.

    Raises:
        TypeError: if mean or std is not floating point.
        ValueError: if mean or std is not (*, 2), or a size is not positive.

    Example:
        >>> render_gaussian2d(torch.tensor([1.0, 1.0]), torch.tensor([0.5, 1.0]), (3, 3), False)
        tensor([[0.0292, 0.2157, 0.0292],
                [0.0481, 0.3556, 0.0481],
                [0.0292, 0.2157, 0.0292]])
    """
    check_last(mean, 2, "mean")
    check_last(std, 2, "std")
    check_broadcastable(std, mean, "std", "mean")
    height, width = size
    if height < 1 or width < 1:
        raise ValueError(f"size: expected positive sizes, got ({height}, {width})")
    precision = position_dtype(mean.dtype)
    x, y = _axes(height, width, normalized_coordinates, precision, mean.device)
    centre, spread = mean.to(precision), std.to(precision)
    across = _profile(x, centre[..., 0:1], spread[..., 0:1])
    down = _profile(y, centre[..., 1:2], spread[..., 1:2])
    return (down[..., :, None] * across[..., None, :]).to(mean.dtype)


def inverse_temperature(temperature: Optional[Union[Tensor, float]], like: Tensor) -> Tensor:
    """1 / temperature, a tensor of no dimensions in like's dtype.

    >>> inverse_temperature(0.5, torch.zeros(1))
    tensor(2.)
    """
    if temperature is None:
        return torch.ones([], dtype=like.dtype, device=like.device)
    if isinstance(temperature, Tensor):
        if temperature.numel() != 1:
            raise ValueError(
                f"temperature: expected one positive number, got shape {list(temperature.shape)}"
            )
        return 1.0 / temperature.to(like.dtype).reshape([])
    check_number(temperature, "temperature")
    if not temperature > 0.0:
        raise ValueError(f"temperature: expected one positive number, got {temperature}")
    return torch.full([], 1.0 / temperature, dtype=like.dtype, device=like.device)


def _softmax(input: Tensor, temperature: Optional[Union[Tensor, float]]) -> Tensor:
    values = input.to(position_dtype(input.dtype))
    scaled = values * inverse_temperature(temperature, values)
    # Rows first: engines add all pixels of a frame one by one, and positions in it would be wrong by 0.02.
    raised = torch.exp(scaled - scaled.amax([2, 3], keepdim=True).detach())
    return raised / raised.sum(3, keepdim=True).sum(2, keepdim=True)


def _expectation(input: Tensor, normalized_coordinates: bool) -> Tensor:
    weights = input.to(position_dtype(input.dtype))
    x, y = _axes(input.size(2), input.size(3), normalized_coordinates, weights.dtype, weights.device)
    return torch.stack([(weights.sum(2) * x).sum(-1), (weights.sum(3) * y).sum(-1)], -1)


def _axes(
    height: int, width: int, normalized_coordinates: bool, dtype: torch.dtype, device: torch.device
) -> Tuple[Tensor, Tensor]:
    """Positions (width,) of the columns and (height,) of the rows."""
    x, y = torch.arange(width, device=device).to(dtype), torch.arange(height, device=device).to(dtype)
    if normalized_coordinates:
        half, offset = normalisation([width, height], True, dtype, device)
        return x / half[0] + offset[0], y / half[1] + offset[1]
    return x, y


def _profile(positions: Tensor, mean: Tensor, std: Tensor) -> Tensor:
    """The density of a normal distribution at positions (n,), scaled to sum 1: (*, n) for means and
    deviations (*, 1)."""
    distance = (positions - mean) / std
    return torch.softmax(-0.5 * distance * distance, -1)
