"""Every second row or column."""

import torch
from torch import Tensor


def every_second(x: Tensor, dim: int, first: int, count: int) -> Tensor:
    """Every second slice of ``x`` along ``dim``, ``count`` of them, from ``first`` (0 or 1) on; beyond the
    end, the last slice again.

    By index: slices with a step have no gradient in ONNX, and cutting an odd size to an even one would put a
    condition on the size.

    >>> every_second(torch.arange(5), 0, 1, 3)
    tensor([1, 3, 4])
    """
    index = (2 * torch.arange(count, device=x.device) + first).clamp(max=x.size(dim) - 1)
    return x.index_select(dim, index)
