"""Separable resampling as tables, for the kernel ``kernels.resample``: along an axis each pixel is a sum of ``taps`` pixels by weights.

Such tables compose, so that blurring and resizing are one pass over the image.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from .sampling import antialias_table, cubic_weights, nearest_index, source_positions


def resize_taps(x: Tensor, out_size: int, interpolation: str, align_corners: bool, antialias: bool, dim: int) -> Tuple[Tensor, Tensor]:
    """Indices and weights (out_size, taps) of the pixels along one axis of x, (B, C, H, W), whose sums are its resized ones."""
    in_size = x.size(dim)
    if interpolation == "nearest":
        index = nearest_index(in_size, out_size, x.device)[:, None]
        return index, torch.ones_like(index).to(x.dtype)
    if antialias:
        index, weight = antialias_table(in_size, out_size, align_corners, 1 if interpolation == "bilinear" else 2, weight_dtype(x), x.device)
        return index, weight.to(x.dtype)
    whole, fraction = source_positions(in_size, out_size, align_corners, weight_dtype(x), x.device)
    if interpolation == "bilinear":
        first, weights = 0, [1.0 - fraction, fraction]
    else:
        first, weights = -1, cubic_weights(fraction, -0.75)
    index = whole[:, None] + torch.arange(first, first + len(weights), device=x.device)
    return index.clamp(0, in_size - 1), torch.stack(weights, 1).to(x.dtype)


def blurred_before(taps: Tuple[Tensor, Tensor], kernel: List[float], border_type: str, size: int) -> Tuple[Tensor, Tensor]:
    """Those of an image of ``size`` pixels that stand for ``taps`` of what a kernel of odd length makes of it. ("circular" has runs too long.)

    >>> index, weight = blurred_before((torch.tensor([[0], [2]]), torch.ones(2, 1)), [0.25, 0.5, 0.25], "reflect", 4)
    >>> index, weight[0]
    (tensor([[1, 0, 1],
            [1, 2, 3]]), tensor([0.2500, 0.5000, 0.2500]))
    """
    index, weight = taps
    at = index[:, :, None] + _offsets(kernel, index)
    return _inside(at, border_type, size).flatten(1), (weight[:, :, None] * _weights(at, kernel, border_type, size, weight.dtype)).flatten(1)


def blurred_after(taps: Tuple[Tensor, Tensor], kernel: List[float], border_type: str) -> Tuple[Tensor, Tensor]:
    """Those that stand for what a kernel of odd length makes of the result of ``taps``.

    >>> blurred_after((torch.tensor([[5], [6], [7]]), torch.ones(3, 1)), [0.25, 0.5, 0.25], "replicate")[0]
    tensor([[5, 5, 6],
            [5, 6, 7],
            [6, 7, 7]])
    """
    index, weight = taps
    size = index.size(0)
    at = torch.arange(size, device=index.device)[:, None] + _offsets(kernel, index)
    near = _inside(at, border_type, size)
    return index[near].flatten(1), (weight[near] * _weights(at, kernel, border_type, size, weight.dtype)[:, :, None]).flatten(1)


def _offsets(kernel: List[float], like: Tensor) -> Tensor:
    radius = len(kernel) // 2
    return torch.arange(-radius, radius + 1, device=like.device)


def _inside(at: Tensor, border_type: str, size: int) -> Tensor:
    """The pixels that positions stand for."""
    if border_type == "reflect":
        at = (size - 1) - ((size - 1) - at.abs()).abs()
    return at.clamp(0, size - 1)


def _weights(at: Tensor, kernel: List[float], border_type: str, size: int, dtype: torch.dtype) -> Tensor:
    """The kernel's, 0 where positions (..., k) are beyond an image of zeros there."""
    weight = torch.tensor(kernel, dtype=dtype, device=at.device).expand(at.shape)
    if border_type == "constant":
        return torch.where((at >= 0) & (at < size), weight, torch.zeros_like(weight))
    return weight


def weight_dtype(x: Tensor) -> torch.dtype:
    """In which fractions of x's pixels are computed: positions in half precision would be off by whole pixels."""
    if x.dtype == torch.float64:
        return torch.float64
    return torch.float32
