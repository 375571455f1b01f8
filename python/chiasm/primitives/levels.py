"""The 256 levels of 8-bit images: which one a value is, how often each occurs, and tables with an entry for each."""

import torch
from torch import Tensor

from .materialise import materialised
from .target import native_forward, tracing_vjp


def to_levels(x: Tensor) -> Tensor:
    """The nearest of the 256 levels of a floating-point image, halves up, as int32; what is outside [0, 1] counts as 0 or 1, NaN as 0.

    >>> to_levels(torch.tensor([-1.0, 0.5, 2.0]))
    tensor([  0, 128, 255], dtype=torch.int32)
    """
    # floor(x * 255 + 0.5) would depend on whether a compiler fuses the product with the sum; a comparison it cannot fuse.
    scaled = (x.to(torch.float32) * 255.0).clamp(0.0, 255.0)
    whole = scaled.to(torch.int32)
    return (whole + (scaled - whole >= 0.5).to(torch.int32)).clamp(0, 255)


def count_each(index: Tensor, bins: int) -> Tensor:
    """How often each of 0 to ``bins`` - 1 occurs in the rows of (P, N): (P, bins), int32.

    >>> count_each(torch.tensor([[0, 2, 2]]), 3)
    tensor([[1, 0, 2]], dtype=torch.int32)
    """
    where = index.to(torch.int64)
    zeros = torch.zeros([index.size(0), bins], dtype=torch.int32, device=index.device)
    return zeros.scatter_add(1, where, torch.ones_like(where, dtype=torch.int32))


def whole_quotient(a: Tensor, b: Tensor) -> Tensor:
    """floor(a / b) of integers below 2^53, as int64; ONNX's form of PyTorch's own goes through float32, which ends at 2^24.

    >>> whole_quotient(torch.tensor([100000001]), torch.tensor([10]))
    tensor([10000000])
    """
    return torch.floor(a.to(torch.float64) / b.to(torch.float64)).to(torch.int64)


def look_up(table: Tensor, index: Tensor) -> Tensor:
    """Entries of the rows of ``table`` (P, K) at ``index`` (P, N), integers that must lie in range."""
    return materialised(table, 0).gather(1, index.to(torch.int64))


def running_sum(x: Tensor) -> Tensor:
    """Inclusive sums along the last axis, of a size that is a multiple of 16 (256 levels), in x's dtype.

    Native code has no loop of its own for ``cumsum``: it sums rows of 16 under a triangle, and then the rows' totals.

    >>> running_sum(torch.ones(1, 32))[0, -1]
    tensor(32.)
    """
    if native_forward() or tracing_vjp():
        rows = x.unflatten(-1, [-1, 16])
        i = torch.arange(16, device=x.device)
        inner = (rows[..., None, :] * (i[None, :] <= i[:, None]).to(x.dtype)).sum(-1, dtype=x.dtype)
        totals = inner[..., 15]
        j = torch.arange(totals.size(-1), device=x.device)
        before = (totals[..., None, :] * (j[None, :] < j[:, None]).to(x.dtype)).sum(-1, dtype=x.dtype)
        return (inner + before[..., None]).flatten(-2)
    return x.cumsum(-1, dtype=x.dtype)
