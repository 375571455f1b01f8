"""Operators that are written out in every graph: torch.onnx and Inductor have no right form of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor

from chiasm.primitives.resampling.volumes import sample_volume
from chiasm.primitives.resampling.warping import from_normalized, sample_image

from .adaptive_means import means

aten = torch.ops.aten


def _one_hot(index: Tensor, num_classes: int) -> Tensor:
    """By an operator that checks indices, as in eager Python: PyTorch's graphs assert on data instead."""
    zeros = torch.zeros([*index.shape, num_classes], dtype=index.dtype, device=index.device)
    return zeros.scatter(-1, index.unsqueeze(-1), 1)


def _max_unpool(input: Tensor, indices: Tensor, output_size: list[int], *_: Any) -> Tensor:
    """PyTorch's graphs trust these indices."""
    spatial = len(output_size)
    zeros = input.new_zeros([*input.shape[:-spatial], math.prod(output_size)])
    return zeros.scatter(-1, indices.flatten(-spatial), input.flatten(-spatial)).unflatten(-1, output_size)


def _grid_sampler(
    input: Tensor, grid: Tensor, interpolation: int, padding: int, align_corners: bool
) -> Tensor:
    """As in eager Python also where a position is not finite: moved into the image it is the first pixel, or
    the last voxel, of its axis; else an image's result is NaN, and 0 in mode "nearest"; a volume's is 0."""
    mode = ("bilinear", "nearest", "bicubic")[interpolation]
    beyond = ("zeros", "border", "reflection")[padding]
    # The last coordinate counts slices, which are the first axis.
    sizes = input.shape[:1:-1]
    at = [from_normalized(grid[..., i], size, align_corners) for i, size in enumerate(sizes)]
    finite = torch.stack([torch.isfinite(position) for position in at]).all(0)
    moved = beyond != "zeros" and mode != "bicubic"
    if moved:
        kept = torch.isfinite if beyond == "reflection" else lambda position: ~torch.isnan(position)
        instead = [0] * 2 if len(sizes) == 2 else [size - 1 for size in sizes]
        at = [torch.where(kept(x), x, torch.full_like(x, end)) for x, end in zip(at, instead, strict=True)]
    if len(sizes) == 3:
        x, y, z = at
        return sample_volume(input, x, y, z, mode, beyond, align_corners)
    x, y = at
    out = sample_image(input, x, y, mode, beyond, align_corners, None)
    return out if moved or mode == "nearest" else torch.where(finite[:, None], out, math.nan)


FORMS: dict[Any, Callable[..., Tensor]] = {
    aten.adaptive_avg_pool1d.default: means,
    aten.adaptive_avg_pool2d.default: means,
    aten.adaptive_avg_pool3d.default: means,
    aten.grid_sampler.default: _grid_sampler,
    aten.max_unpool2d.default: _max_unpool,
    aten.max_unpool3d.default: _max_unpool,
    aten.one_hot.default: _one_hot,
}
