"""Means over windows that divide an axis into a number of parts: `adaptive_avg_pool2d`, and `interpolate` by
area.

torch.onnx and Inductor compute the windows once, at the sizes of the example.
"""

from __future__ import annotations

from functools import partial
from typing import Any, cast

import torch
from torch import Tensor
from torch.fx.experimental.symbolic_shapes import statically_known_true

from chiasm.primitives.core.materialise import stored_index
from chiasm.primitives.resampling.taps import nearest_index

aten = torch.ops.aten


def means(input: Tensor, output_size: list[int]) -> Tensor:
    """The mean of window i along an axis of n parts, rows floor(i * H / n) to ceil((i + 1) * H / n) - 1."""
    result = input.to(_sum_dtype(input))
    for dim, parts in enumerate(output_size, input.dim() - len(output_size)):
        extent = result.shape[dim]
        if statically_known_true(extent == parts):
            continue
        if statically_known_true(parts == 1):
            result = result.mean(dim, keepdim=True)
        else:
            begin, end = _windows(extent, parts, input.device)
            result = _sums(result, dim, begin, end, parts) / _along(end - begin, dim, result)
    return result.to(input.dtype)


def _means_backward(gradient: Tensor, input: Tensor, spatial: int) -> Tensor:
    """Row h is in the windows floor(h * n / H) to ceil((h + 1) * n / H) - 1."""
    result = gradient.to(_sum_dtype(gradient))
    for dim in range(input.dim() - spatial, input.dim()):
        extent, parts = input.shape[dim], result.shape[dim]
        if statically_known_true(extent == parts):
            continue
        begin, end = _windows(extent, parts, input.device)
        result = result / _along(end - begin, dim, result)
        result = _sums(result, dim, *_windows(parts, extent, input.device), extent)
    return result.to(gradient.dtype)


def _windows(extent: int, parts: int, device: torch.device) -> tuple[Tensor, Tensor]:
    """The begin and the end of each window."""
    # In float64, which is exact: Inductor knows no limits of integer quotients.
    ends = (torch.arange(1, parts + 1, device=device) * extent).to(torch.float64) / parts
    return stored_index(nearest_index(extent, parts, device)), stored_index(torch.ceil(ends).to(torch.int64))


def _sums(x: Tensor, dim: int, begin: Tensor, end: Tensor, parts: int) -> Tensor:
    extent = x.shape[dim]
    pixel = begin[:, None] + torch.arange((extent - 1) // parts + 2, device=x.device)
    inside = pixel < end[:, None]
    taps = x.index_select(dim, pixel.clamp(0, extent - 1).reshape(-1))
    taps = cast("Tensor", taps.unflatten(dim, pixel.shape))
    inside = inside.reshape([*pixel.shape, *[1] * (x.dim() - 1 - dim)])
    return torch.where(inside, taps, torch.zeros_like(taps)).sum(dim + 1)


def _along(numbers: Tensor, dim: int, x: Tensor) -> Tensor:
    return numbers.reshape([-1, *[1] * (x.dim() - 1 - dim)]).to(x.dtype)


def _sum_dtype(x: Tensor) -> torch.dtype:
    return torch.float32 if x.dtype in (torch.float16, torch.bfloat16) else x.dtype


#: Decompositions of the operators in gradients.
MEANS: dict[Any, Any] = {
    aten._adaptive_avg_pool2d.default: means,
    aten._adaptive_avg_pool3d.default: means,
    aten._adaptive_avg_pool2d_backward.default: partial(_means_backward, spatial=2),
    aten._adaptive_avg_pool3d_backward.default: partial(_means_backward, spatial=3),
}
