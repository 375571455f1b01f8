"""Operators that are written out in every graph: torch.onnx and Inductor have no right form of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import torch
from torch import Tensor

from .adaptive_means import means
from .grid_sample import sampled

aten = torch.ops.aten


def _one_hot(index: Tensor, num_classes: int) -> Tensor:
    """By an operator that checks indices, as in eager Python: PyTorch's graphs assert on data instead."""
    zeros = torch.zeros([*index.shape, num_classes], dtype=index.dtype, device=index.device)
    return zeros.scatter(-1, index.unsqueeze(-1), 1)


def _max_unpool(input: Tensor, indices: Tensor, output_size: list[int], *_: Any) -> Tensor:
    """PyTorch's graphs trust these indices."""
    spatial = len(output_size)
    zeros = input.new_zeros([*input.shape[:-spatial], math.prod(output_size)])
    result = zeros.scatter(-1, indices.flatten(-spatial), input.flatten(-spatial))
    return cast("Tensor", result.unflatten(-1, output_size))


FORMS: dict[Any, Callable[..., Tensor]] = {
    aten.adaptive_avg_pool1d.default: means,
    aten.adaptive_avg_pool2d.default: means,
    aten.adaptive_avg_pool3d.default: means,
    aten.grid_sampler.default: sampled,
    aten.max_unpool2d.default: _max_unpool,
    aten.max_unpool3d.default: _max_unpool,
    aten.one_hot.default: _one_hot,
}
