"""Top-k with ties broken by position, the same on every backend."""

from typing import Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive


@primitive
def stable_topk(x: Tensor, k: int) -> Tuple[Tensor, Tensor]:
    """The k largest values along the last axis, descending, and their indices; among equals, the lower index
    comes first.

    ``torch.topk`` promises no order among equals, so eager code sorts stably; of long rows, only the largest
    values. ONNX Runtime's TopK and chiasm's native runtime promise the lower index first, and use ``topk``.

    >>> stable_topk(torch.tensor([1.0, 3.0, 3.0]), 2)
    (tensor([3., 3.]), tensor([1, 2]))
    """
    if k == 0 or x.size(-1) < 16 * k or x.requires_grad:
        values, indices = torch.sort(x, stable=True, dim=-1, descending=True)
        return values[..., :k], indices[..., :k]
    places = _among_largest(x, k)
    values, order = torch.sort(x.gather(-1, places), stable=True, dim=-1, descending=True)
    return values, places.gather(-1, order)


@stable_topk.lowering("onnx", when=lambda x, k: x.is_floating_point())
def _with_nan_as_infinity(x: Tensor, k: int) -> Tuple[Tensor, Tensor]:
    # ONNX Runtime does not define the order of NaN.
    indices = torch.topk(torch.where(x == x, x, torch.full_like(x, float("inf"))), k, dim=-1)[1]
    return x.gather(-1, indices), indices


@stable_topk.lowering("onnx", "native", "vjp")
def _topk(x: Tensor, k: int) -> Tuple[Tensor, Tensor]:
    values, indices = torch.topk(x, k, dim=-1)
    return values, indices


def _among_largest(x: Tensor, k: int) -> Tensor:
    """The indices, ascending, of the k largest values along the last axis, the first ones among equals. NaN
    is the largest, as in ``torch.sort``."""
    least = torch.topk(x, k, dim=-1)[0][..., k - 1 :]
    above = (x > least) | (torch.isnan(x) & ~torch.isnan(least))
    equal = (x == least) | (torch.isnan(x) & torch.isnan(least))
    missing = k - above.sum(-1, keepdim=True)
    chosen = above | (equal & (equal.cumsum(-1) <= missing))
    shape = list(x.shape)
    shape[-1] = k
    return chosen.nonzero()[:, -1].reshape(shape)
