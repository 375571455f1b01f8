"""Random midpoint displacement by diamonds and squares."""

import math

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from .histograms import whole_quotient


@primitive
def midpoint_displacement(random: Tensor, factor: Tensor, scale: Tensor) -> Tensor:
    """Random terrain (B, C, H, W): the centres of ever smaller cells, and of their sides, are the means of
    their neighbours, displaced by ``scale`` times ``random``. The scale is multiplied by ``factor`` from step
    to step; both are (B or 1, 1, 1, 1).

    The grid grows from step to step: each step costs four times the one before, so all steps together cost a
    third more than the last.
    """
    cell = 1
    while cell < max(random.size(2), random.size(3)) - 1:
        cell = cell * 2
    state = random[:, :, ::cell, ::cell] * scale
    one = torch.ones([1], dtype=torch.int64, device=random.device)
    while cell > 1:
        cell = cell // 2
        finer = random[:, :, ::cell, ::cell]
        for dim in [2, 3]:
            coarse = torch.div(torch.arange(finer.size(dim), device=random.device), 2, rounding_mode="floor")
            state = state.index_select(dim, coarse)
        state = _refine(state, one, finer * scale)
        scale = scale * factor
    return state


@midpoint_displacement.lowering("onnx", "native", "vjp")
def _filled(random: Tensor, factor: Tensor, scale: Tensor) -> Tensor:
    """By steps over the whole image, which are the same for every size, so that an exported graph has one
    loop."""
    y, x = (
        torch.arange(random.size(2), device=random.device),
        torch.arange(random.size(3), device=random.device),
    )
    # Images are at most 32768 pixels high and wide
    powers = torch.tensor([1 << k for k in range(16)], device=random.device)
    cell = torch.where(
        powers < torch.maximum(y.amax(0), x.amax(0)), 2 * powers, torch.ones_like(powers)
    ).amax(0)
    corner = (_within(y, cell) == 0)[:, None] & (_within(x, cell) == 0)
    # Infinity marks pixels without a value yet: only a step after the last one changes nothing.
    state = torch.where(corner, random * scale, torch.full_like(random, math.inf))
    return _displaced(state, 16, random, whole_quotient(cell, 2 * powers), factor, scale)


@until_stable
def _displaced(
    state: Tensor, k: Tensor, random: Tensor, halves: Tensor, factor: Tensor, scale: Tensor
) -> Tensor:
    return _refine(
        state, halves.index_select(0, k.reshape(1)), random * (scale * torch.pow(factor, k.to(factor.dtype)))
    )


def _refine(state: Tensor, half: Tensor, displacement: Tensor) -> Tensor:
    """Fill in the centres of the cells, which are 2 ``half`` wide, and of their sides; nothing if ``half`` is
    0."""
    y, x = torch.arange(state.size(2), device=state.device), torch.arange(state.size(3), device=state.device)
    row, column = _within(y, (2 * half).clamp(min=1)), _within(x, (2 * half).clamp(min=1))
    middle_row, middle_column = ((row == half) & (half > 0))[:, None], (column == half) & (half > 0)
    county, countx = _neighbours(y, half)[:, None], _neighbours(x, half)
    corners = _beside(_beside(state, 2, y, half), 3, x, half) / (county * countx).clamp(min=1).to(state.dtype)
    state = torch.where(middle_row & middle_column, corners + displacement, state)
    around = (_beside(state, 2, y, half) + _beside(state, 3, x, half)) / (county + countx).clamp(min=1).to(
        state.dtype
    )
    side = (middle_row & (column == 0)) | ((row == 0)[:, None] & middle_column)
    return torch.where(side, around + displacement, state)


def _within(position: Tensor, cell: Tensor) -> Tensor:
    """The offset of a position in its cell."""
    return position - cell * whole_quotient(position, cell)


def _neighbours(position: Tensor, half: Tensor) -> Tensor:
    """The number of the two positions, ``half`` before and after, that are within the image."""
    return (position >= half).to(torch.int64) + (position + half < position.size(0)).to(torch.int64)


def _beside(x: Tensor, dim: int, position: Tensor, half: Tensor) -> Tensor:
    """The sum of the pixels ``half`` before and after along a dimension, as far as they are within the
    image."""
    before = _row_or_column(position >= half, dim)
    after = _row_or_column(position + half < x.size(dim), dim)
    zero = torch.zeros_like(x)
    earlier = torch.where(before, x.index_select(dim, (position - half).clamp(min=0)), zero)
    return earlier + torch.where(
        after, x.index_select(dim, (position + half).clamp(max=x.size(dim) - 1)), zero
    )


def _row_or_column(mask: Tensor, dim: int) -> Tensor:
    return mask[:, None] if dim == 2 else mask
