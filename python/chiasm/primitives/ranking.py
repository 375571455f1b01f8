"""Top-k with ties broken by position, the same on every backend."""

from typing import Tuple

import torch
from torch import Tensor

from .target import current_target


def stable_topk(x: Tensor, k: int) -> Tuple[Tensor, Tensor]:
    """The k largest values along the last axis, descending, and their indices; of equals the lower index comes first.

    ``torch.topk`` promises no order among equals, so eager code sorts stably. ONNX Runtime's TopK and chiasm's native
    runtime do promise the lower index first, and get ``topk``.

    >>> stable_topk(torch.tensor([1.0, 3.0, 3.0]), 2)
    (tensor([3., 3.]), tensor([1, 2]))
    """
    if current_target() == "eager":
        values, indices = torch.sort(x, stable=True, dim=-1, descending=True)
        return values[..., :k], indices[..., :k]
    values, indices = torch.topk(x, k, dim=-1)
    return values, indices
