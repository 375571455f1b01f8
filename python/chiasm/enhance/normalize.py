"""Standardise channels."""

from typing import Union

import torch
from torch import Tensor

from ..primitives.checks import check_floating


def normalize(data: Tensor, mean: Union[float, Tensor], std: Union[float, Tensor]) -> Tensor:
    """(data - mean) / std, per channel.

    Args:
        data: (B, C, *), floating point.
        mean: a number, or a scalar tensor, (1,), (C,) or (B, C).
        std: like mean; not zero.

    Returns:
        Tensor of data's shape and dtype.

    Raises:
        TypeError: if data is not floating point.
        ValueError: if data has fewer than two dimensions, or mean or std more than two.

    Example:
        >>> x = torch.ones(1, 2, 1, 1)
        >>> normalize(x, torch.tensor([0.0, 1.0]), torch.tensor([2.0, 1.0])).flatten()
        tensor([0.5000, 0.0000])
    """
    check_floating(data, "data")
    if data.dim() < 2:
        raise ValueError(f"data: expected shape (B, C, *), got {list(data.shape)}")
    return (data - _per_channel(mean, data, "mean")) / _per_channel(std, data, "std")


def _per_channel(value: Union[float, Tensor], data: Tensor, name: str) -> Tensor:
    if not isinstance(value, Tensor):
        return torch.full([1], value, dtype=data.dtype, device=data.device)
    if value.dim() > 2:
        raise ValueError(f"{name}: expected a number, or a scalar tensor, (1,), (C,) or (B, C), got {list(value.shape)}")
    value = value.to(data.dtype)
    if value.dim() == 0:
        return value
    for _ in range(data.dim() - 2):
        value = value.unsqueeze(-1)
    return value
