"""Normalization of channels, and its inverse."""

from typing import Union

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_not_empty,
    check_number,
    check_values,
)
from ..primitives.core.layout import in_planes
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.numbers.reductions import greatest, least


def normalize(data: Tensor, mean: Union[float, Tensor], std: Union[float, Tensor]) -> Tensor:
    """Normalize each channel: (data - mean) / std.

    Args:
        data: (B, C, *), floating point, or uint8, for which mean and std are in levels (0 to 255).
        mean: a number, or a scalar tensor, (1,), (C,) or (B, C).
        std: like mean; not zero.

    Returns:
        Tensor of data's shape and dtype; float32 for uint8.

    Raises:
        TypeError: if data is neither floating point nor uint8.
        ValueError: if data has fewer than two dimensions, or mean or std more than two.

    Example:
        >>> x = torch.ones(1, 2, 1, 1)
        >>> normalize(x, torch.tensor([0.0, 1.0]), torch.tensor([2.0, 1.0])).flatten()
        tensor([0.5000, 0.0000])
    """
    check_values(data, "data")
    if data.dim() < 2:
        raise ValueError(f"data: expected shape (B, C, *), got {list(data.shape)}")
    if data.dtype == torch.uint8:
        data = in_planes(data).to(torch.float32)
    return (data - _per_channel(mean, data, "mean")) / _per_channel(std, data, "std")


def denormalize(data: Tensor, mean: Union[float, Tensor], std: Union[float, Tensor]) -> Tensor:
    """The inverse of ``normalize``, for each channel: data * std + mean.

    Args:
        data: (B, C, *), floating point.
        mean: a number, or a scalar tensor, (1,), (C,) or (B, C).
        std: like mean.

    Returns:
        Tensor of data's shape and dtype.

    Raises:
        TypeError: if data is not floating point.
        ValueError: if data has fewer than two dimensions, or mean or std more than two.

    Example:
        >>> denormalize(torch.ones(1, 2, 1, 1), torch.tensor([0.0, 1.0]), 2.0).flatten()
        tensor([2., 3.])
    """
    check_floating(data, "data")
    if data.dim() < 2:
        raise ValueError(f"data: expected shape (B, C, *), got {list(data.shape)}")
    return data * _per_channel(std, data, "std") + _per_channel(mean, data, "mean")


def normalize_min_max(input: Tensor, min_val: float = 0.0, max_val: float = 1.0, eps: float = 1e-6) -> Tensor:
    """Scale each channel of each sample linearly to [min_val, max_val].

    (input - min) / (max - min + eps) * (max_val - min_val) + min_val, with the least and greatest value of
    the channel.

    Args:
        input: (*, H, W), floating point, any values.
        min_val: the new least value.
        max_val: the new greatest value.
        eps: keeps the division defined where all values of a channel are equal.

    Returns:
        Tensor of the input's shape and dtype.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input has fewer than two dimensions or no pixels.

    Example:
        >>> normalize_min_max(torch.tensor([[[2.0, 3.0, 4.0]]]), eps=0.0)
        tensor([[[0.0000, 0.5000, 1.0000]]])
    """
    check_floating(input, "input")
    if input.dim() < 2:
        raise ValueError(f"input: expected shape (*, H, W), got {list(input.shape)}")
    check_not_empty(input, 2, "input")
    wide = widened(input)  # 1 / eps is beyond float16
    low, high = least(wide, [-2, -1]), greatest(wide, [-2, -1])
    return narrowed((wide - low) * ((max_val - min_val) / (high - low + eps)) + min_val, input)


def _per_channel(value: Union[float, Tensor], data: Tensor, name: str) -> Tensor:
    if not isinstance(value, Tensor):
        check_number(value, name)
        return torch.full([1], value, dtype=data.dtype, device=data.device)
    if value.dim() > 2:
        raise ValueError(
            f"{name}: expected a number, or a scalar tensor, (1,), (C,) or (B, C), got {list(value.shape)}"
        )
    check_broadcastable(value, data, name, "data", 0, data.dim() - 2)
    value = value.to(data.dtype)
    if value.dim() == 0:
        return value
    for _ in range(data.dim() - 2):
        value = value.unsqueeze(-1)
    return value
