"""Nearest neighbours among vectors, the same ones on every backend: of equally near ones the first."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..linalg.matrices import small_matmul


@primitive
def cdist_squared(a: Tensor, b: Tensor) -> Tensor:
    """(B, N, M): squared Euclidean distances of the vectors a (B, N, D) from b (B, M, D). Without a gradient.

    |a|^2 + |b|^2 - 2 a.b, one matrix product, in float64: in float32, this difference of large numbers would
    leave no correct digit of a distance of 1e-3 between unit vectors. For float32 vectors the result is then
    rounded to float32, so that equal vectors have equal distances, although a library may add up their
    products in different orders.
    """
    left, right = a.detach().to(torch.float64), b.detach().to(torch.float64)
    lengths = (left * left).sum(-1)[:, :, None] + (right * right).sum(-1)[:, None, :]
    squared = lengths - 2.0 * small_matmul(left, right.transpose(-1, -2))
    return squared if a.dtype == torch.float64 else squared.to(torch.float32)


@cdist_squared.lowering("native", when=lambda a, b: kernels.has_kernel(a) and b.dtype == a.dtype)
def _squared_distances_kernel(a: Tensor, b: Tensor) -> Tensor:
    return kernels.cdist_squared(a.detach().contiguous(), b.detach().contiguous())


@primitive
def two_smallest(x: Tensor, along_rows: bool) -> Tensor:
    """(B, N, 2): the positions of the smallest and the second smallest number in each row of x (B, N, M), or
    in each column: (B, M, 2).

    The first of equal numbers counts. A position is -1 if no number, or no second one, is less than infinity.

    >>> two_smallest(torch.tensor([[[3.0, 1.0, 2.0], [1.0, 1.0, float("inf")]]]), True)
    tensor([[[1, 2],
             [0, 1]]])
    """
    rows = x if along_rows else x.transpose(1, 2)
    infinity = torch.full_like(rows, float("inf"))
    rows = torch.where(rows < infinity, rows, infinity)  # NaN counts as infinite
    first = torch.argmin(rows, -1, keepdim=True)
    others = torch.where(first == torch.arange(rows.size(-1), device=x.device), infinity, rows)
    second = torch.argmin(others, -1, keepdim=True)
    found = torch.cat([rows.gather(-1, first), others.gather(-1, second)], -1) < float("inf")
    places = torch.cat([first, second], -1)
    return torch.where(found, places, torch.full_like(places, -1))


@two_smallest.lowering("native", when=kernels.has_kernel)
def _two_smallest_kernel(x: Tensor, along_rows: bool) -> Tensor:
    return kernels.two_smallest(x.contiguous(), along_rows)
