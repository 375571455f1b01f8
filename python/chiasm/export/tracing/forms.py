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


def _multilabel_margin_loss(input: Tensor, target: Tensor, reduction: int = 1) -> Tensor:
    """PyTorch's graphs also count what follows the -1 that ends the targets."""
    x, y = input.reshape(-1, input.shape[-1]), target.reshape(-1, input.shape[-1])
    classes = torch.arange(x.shape[1], device=y.device)
    is_used = classes < torch.where(y == -1, classes, x.shape[1]).amin(1, keepdim=True)
    is_target = (classes == torch.where(is_used, y, -1).unsqueeze(2)).any(1)
    of_targets = x.gather(1, torch.where(is_used, y, 0))
    margins = (1 - of_targets.unsqueeze(2) + x.unsqueeze(1)).clamp_min(0)
    margins = torch.where(is_used.unsqueeze(2) & ~is_target.unsqueeze(1), margins, 0)
    losses = (margins.sum((1, 2)) / x.shape[1]).reshape(input.shape[:-1])
    return (losses, losses.mean(), losses.sum())[reduction]


FORMS: dict[Any, Callable[..., Tensor]] = {
    aten.adaptive_avg_pool1d.default: means,
    aten.adaptive_avg_pool2d.default: means,
    aten.adaptive_avg_pool3d.default: means,
    aten.grid_sampler.default: sampled,
    aten.max_unpool2d.default: _max_unpool,
    aten.max_unpool3d.default: _max_unpool,
    aten.multilabel_margin_loss.default: _multilabel_margin_loss,
    aten.one_hot.default: _one_hot,
}
