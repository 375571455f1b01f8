"""Mirror images, and the transpose."""

from typing import List

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows
from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def flip(x: Tensor, along: bool, down: bool) -> Tensor:
    """(*, H, W) with each row reversed (``along``), and the order of rows reversed (``down``)."""
    dims: List[int] = []
    if along:
        dims.append(-1)
    if down:
        dims.append(-2)
    if x.dtype != torch.uint16:
        return x.flip(dims)
    for dim in dims:  # PyTorch cannot flip this type
        x = x.index_select(dim, x.size(dim) - 1 - torch.arange(x.size(dim), device=x.device))
    return x


# Compiled tensor code loads and stores the pixels one by one.
@flip.lowering("native", when=kernels.has_pixel_kernel)
def _flip_kernel(x: Tensor, along: bool, down: bool) -> Tensor:
    if x.dim() == 4:
        rows, step = as_rows(x)
        return from_rows(kernels.flip(rows, step, along, down), x)
    planes = x.reshape(-1, x.size(-2), x.size(-1))
    return kernels.flip(planes, 1, along, down).reshape(x.shape)


@primitive
def transposed(x: Tensor) -> Tensor:
    """(*, H, W) as (*, W, H)."""
    return x.transpose(-2, -1).contiguous()


# Compiled code reads a row of the cache for each pixel.
@transposed.lowering("native", when=kernels.has_pixel_kernel)
def _transposed_kernel(x: Tensor) -> Tensor:
    if x.dim() == 4:
        rows, step = as_rows(x)
        return from_rows(kernels.transpose_pixels(rows, step), x)
    made = kernels.transpose_pixels(x.reshape(-1, x.size(-2), x.size(-1)), 1)
    return made.reshape(x.shape[:-2] + (x.size(-1), x.size(-2)))
