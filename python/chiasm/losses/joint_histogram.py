"""Entropies of two signals and of their pairs, by a joint histogram that has a gradient."""

import math
from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_choice,
    check_floating,
    check_not_empty,
    check_same_shape,
    check_tensor,
    expands,
)
from ..primitives.numbers.reductions import greatest, least
from ..primitives.numbers.rounding import to_index


def check_signals(
    input: Tensor, target: Tensor, kernel_function: str, num_bins: int, window_radius: float
) -> None:
    """Raise unless the arguments are valid for ``entropies``."""
    check_floating(input, "input")
    check_floating(target, "target")
    check_same_shape(target, input, "target", "input")
    check_choice(kernel_function, ["xu", "rectangular", "truncated_gaussian"], "kernel_function")
    if input.dim() < 1:
        raise ValueError("input: expected shape (*, N), got a scalar")
    check_not_empty(input, 1, "input")
    if num_bins < 2:
        raise ValueError(f"num_bins: expected at least 2, got {num_bins}")
    if not window_radius > 0.5:
        raise ValueError(f"window_radius: expected more than half a bin, got {window_radius}")


def entropies(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor],
    target_mask: Optional[Tensor],
    kernel_function: str,
    num_bins: int,
    window_radius: float,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Entropies (*) in nats, float64, of input (*, N), of target, and of the two together.

    >>> x = torch.tensor([0.0, 1.0, 0.0, 1.0])
    >>> [round(h.item(), 4) for h in entropies(x, x, None, None, "xu", 2, 1.0)]
    [0.6931, 0.6931, 0.6931]
    """
    check_signals(input, target, kernel_function, num_bins, window_radius)
    counts = _mask(input_mask, input, "input_mask") & _mask(target_mask, target, "target_mask")
    rows, row_shares = _shares(input, counts, kernel_function, num_bins, window_radius)
    columns, column_shares = _shares(target, counts, kernel_function, num_bins, window_radius)
    index: List[Tensor] = []
    share: List[Tensor] = []
    for i in range(len(rows)):
        for j in range(len(columns)):
            index.append(rows[i] * num_bins + columns[j])
            share.append(row_shares[i] * column_shares[j])
    # A value has few bins: adding to these takes a fraction of the time of weighting it for every pair of
    # bins.
    zeros = torch.zeros(
        list(counts.shape[:-1]) + [num_bins * num_bins], dtype=torch.float64, device=input.device
    )
    joint = zeros.scatter_add(-1, torch.cat(index, -1), torch.cat(share, -1))
    total = joint.sum(-1, keepdim=True)
    density = (joint / torch.where(total > 0, total, torch.ones_like(total))).unflatten(
        -1, [num_bins, num_bins]
    )
    return _entropy(density.sum(-1), 1), _entropy(density.sum(-2), 1), _entropy(density, 2)


def _mask(mask: Optional[Tensor], signal: Tensor, name: str) -> Tensor:
    if mask is None:
        return torch.ones_like(signal, dtype=torch.bool)
    check_tensor(mask, name)
    if mask.dtype != torch.bool:
        raise TypeError(f"{name}: expected dtype torch.bool, got {mask.dtype}")
    if mask.dim() < 1 or mask.size(-1) != signal.size(-1) or not expands(mask, signal):
        raise ValueError(f"{name}: expected the signals' shape {list(signal.shape)}, got {list(mask.shape)}")
    return mask.expand(signal.shape)


def _shares(
    signal: Tensor, counts: Tensor, kernel_function: str, num_bins: int, window_radius: float
) -> Tuple[List[Tensor], List[Tensor]]:
    """The bins near each value, and its share in each; shares are 0 beyond the ends and for masked values."""
    position = _positions(signal.to(torch.float64), counts, num_bins)
    first = position.detach().floor()
    bins: List[Tensor] = []
    shares: List[Tensor] = []
    reach = math.ceil(window_radius)
    for offset in range(1 - reach, reach + 1):
        bin = first + float(offset)
        distance = (position - bin).abs()
        near = counts & (distance < window_radius) & (bin >= 0) & (bin <= num_bins - 1)
        share = _kernel(distance, kernel_function, window_radius)
        bins.append(to_index(bin, num_bins))
        shares.append(torch.where(near, share, torch.zeros_like(share)))
    return bins, shares


def _positions(signal: Tensor, counts: Tensor, num_bins: int) -> Tensor:
    """Each value in units of bins: valid values are mapped from 0 (the least) to num_bins - 1 (the
    greatest)."""
    low = least(torch.where(counts, signal, torch.full_like(signal, math.inf)), [-1])
    high = greatest(torch.where(counts, signal, torch.full_like(signal, -math.inf)), [-1])
    varies = high > low
    origin = torch.where(varies, low, torch.zeros_like(low))
    span = torch.where(varies, high - low, torch.ones_like(low))
    zero = torch.zeros_like(signal)
    return torch.where(
        counts & varies, (torch.where(counts, signal, zero) - origin) / span * (num_bins - 1.0), zero
    )


def _kernel(distance: Tensor, kernel_function: str, window_radius: float) -> Tensor:
    if kernel_function == "rectangular":
        return torch.ones_like(distance)
    if kernel_function == "truncated_gaussian":
        return torch.exp(-0.5 * distance * distance)
    d = distance / window_radius
    return torch.where(d <= 0.5, 1.0 - (0.1 + 1.8 * d) * d, 1.9 - (3.7 - 1.8 * d) * d)


def _entropy(density: Tensor, dims: int) -> Tensor:
    """- sum of p log p over the last axes; 0 log 0 is 0."""
    p = density.flatten(-dims) if dims > 1 else density
    safe = torch.where(p > 0, p, torch.ones_like(p))
    return -(safe * torch.log(safe)).sum(-1)
