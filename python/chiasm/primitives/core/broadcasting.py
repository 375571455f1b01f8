"""Settings that are one number for all or one for each sample."""

from typing import Union

import torch
from torch import Tensor

from .checks import broadcastable, check_number


def per_sample(value: Union[float, Tensor], like: Tensor, name: str) -> Tensor:
    """``value`` as a tensor of ``like``'s dtype that broadcasts against it, one entry a sample where it is
    (B,).

    >>> per_sample(torch.ones(2), torch.zeros(2, 3, 4, 5), "factor").shape
    torch.Size([2, 1, 1, 1])
    """
    if not isinstance(value, Tensor):
        check_number(value, name)
        return torch.full([1], value, dtype=like.dtype, device=like.device)
    value = value.to(like.dtype)
    if value.dim() == 0 or (value.dim() == like.dim() and broadcastable(value, like)):
        return value
    # The batch first: in a symbolic shape it is the same symbol, and no question about its value is asked.
    if value.dim() != 1 or (value.size(0) != like.size(0) and value.size(0) != 1):
        raise ValueError(
            f"{name}: expected a number, or a tensor that is a scalar, (B,) or broadcasts against"
            f" {list(like.shape)}, got {list(value.shape)}"
        )
    for _ in range(like.dim() - 1):
        value = value.unsqueeze(-1)
    return value
