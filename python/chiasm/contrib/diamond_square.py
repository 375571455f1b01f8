"""Random textures."""

import math
from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ..enhance.normalize import normalize_min_max
from ..primitives.checks import check_image
from ..primitives.levels import whole_quotient
from ..primitives.loops import until_stable
from ..primitives.target import current_target


def diamond_square(
    random: Tensor,
    roughness: Union[float, Tensor] = 0.5,
    random_scale: Union[float, Tensor] = 1.0,
    normalize_range: Optional[Tuple[float, float]] = None,
) -> Tensor:
    """Plasma: random heights on a coarse grid, refined by midpoints that are displaced less and less.

    A. Fournier, D. Fussell, L. Carpenter, Computer rendering of stochastic models, Communications of the ACM 25(6), 1982, in the form of
    G. Miller, The definition and rendering of terrain maps, SIGGRAPH 1986. On the first grid, the least power of two wide at which one cell covers
    the image, the result is ``random_scale * random``. Then, again and again, the middle of each cell gets the mean of the cell's corners and
    the middle of each side that of the four points around it, of which only those within the image count, each plus
    ``random_scale * roughness**k * random``, k = 0, 1, ... being the step.

    Kornia draws the random numbers itself, by a function. Here they are an input, so that every backend makes the same texture; its shape,
    dtype and device are theirs. Values are not Kornia's: textures are of the same kind, not the same.

    Args:
        random: (B, C, H, W), floating point, for each pixel a random number; with a mean of 0 (uniform in [-1, 1], or normal) textures do
            not drift. H and W are at most 32768.
        roughness: factor of the displacement from step to step: a number, or a tensor of one for all or of one for each sample.
        random_scale: the first displacement, a number or a tensor like roughness.
        normalize_range: scale each channel of each sample to this range, (least, greatest).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if random is not floating point.
        ValueError: if random is not 4-D, or roughness or random_scale is a tensor of another number of entries.

    Example:
        >>> flat = torch.zeros(1, 1, 3, 3)
        >>> flat[0, 0, 0, 0] = 4.0
        >>> diamond_square(flat)[0, 0]
        tensor([[4.0000, 1.6667, 0.0000],
                [1.6667, 1.0000, 0.3333],
                [0.0000, 0.3333, 0.0000]])
    """
    check_image(random, "random")
    factor, scale = _per_sample(roughness, random, "roughness"), _per_sample(random_scale, random, "random_scale")
    if torch.jit.is_scripting() or current_target() == "eager":
        state = _grown(random, factor, scale)
    else:
        state = _filled(random, factor, scale)
    if normalize_range is None:
        return state
    return normalize_min_max(state, normalize_range[0], normalize_range[1])


def _grown(random: Tensor, factor: Tensor, scale: Tensor) -> Tensor:
    """By grids that grow: each step costs four times the one before, and all of them a third more than the last."""
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


def _filled(random: Tensor, factor: Tensor, scale: Tensor) -> Tensor:
    """By steps over the whole image, of one form whatever its size: one loop of an exported graph."""
    y, x = torch.arange(random.size(2), device=random.device), torch.arange(random.size(3), device=random.device)
    powers = torch.tensor([1 << k for k in range(16)], device=random.device)  # images are at most 32768 pixels high and wide
    cell = torch.where(powers < torch.maximum(y.amax(0), x.amax(0)), 2 * powers, torch.ones_like(powers)).amax(0)
    corner = (_within(y, cell) == 0)[:, None] & (_within(x, cell) == 0)
    # Infinity marks what is to come: a step that leaves everything as it was is then one after the last.
    state = torch.where(corner, random * scale, torch.full_like(random, math.inf))
    return _displaced(state, 16, random, whole_quotient(cell, 2 * powers), factor, scale)


@until_stable
def _displaced(state: Tensor, k: Tensor, random: Tensor, halves: Tensor, factor: Tensor, scale: Tensor) -> Tensor:
    return _refine(state, halves.index_select(0, k.reshape(1)), random * (scale * torch.pow(factor, k.to(factor.dtype))))


def _refine(state: Tensor, half: Tensor, displacement: Tensor) -> Tensor:
    """Fill in the middles of the cells, which are two halves wide, and of their sides; nothing where half is 0."""
    y, x = torch.arange(state.size(2), device=state.device), torch.arange(state.size(3), device=state.device)
    row, column = _within(y, (2 * half).clamp(min=1)), _within(x, (2 * half).clamp(min=1))
    middle_row, middle_column = ((row == half) & (half > 0))[:, None], (column == half) & (half > 0)
    county, countx = _neighbours(y, half)[:, None], _neighbours(x, half)
    corners = _beside(_beside(state, 2, y, half), 3, x, half) / (county * countx).clamp(min=1).to(state.dtype)
    state = torch.where(middle_row & middle_column, corners + displacement, state)
    around = (_beside(state, 2, y, half) + _beside(state, 3, x, half)) / (county + countx).clamp(min=1).to(state.dtype)
    side = (middle_row & (column == 0)) | ((row == 0)[:, None] & middle_column)
    return torch.where(side, around + displacement, state)


def _within(position: Tensor, cell: Tensor) -> Tensor:
    """Where in its cell a position is."""
    return position - cell * whole_quotient(position, cell)


def _neighbours(position: Tensor, half: Tensor) -> Tensor:
    """How many of the positions ``half`` before and after are within the image."""
    return (position >= half).to(torch.int64) + (position + half < position.size(0)).to(torch.int64)


def _beside(x: Tensor, dim: int, position: Tensor, half: Tensor) -> Tensor:
    """The sum of what is ``half`` before and after along a dimension, as far as it is within the image."""
    before = _row_or_column(position >= half, dim)
    after = _row_or_column(position + half < x.size(dim), dim)
    zero = torch.zeros_like(x)
    earlier = torch.where(before, x.index_select(dim, (position - half).clamp(min=0)), zero)
    return earlier + torch.where(after, x.index_select(dim, (position + half).clamp(max=x.size(dim) - 1)), zero)


def _row_or_column(mask: Tensor, dim: int) -> Tensor:
    return mask[:, None] if dim == 2 else mask


def _per_sample(value: Union[float, Tensor], random: Tensor, name: str) -> Tensor:
    if not isinstance(value, Tensor):
        return torch.full([1, 1, 1, 1], value, dtype=random.dtype, device=random.device)
    if value.dim() > 1 or (value.dim() == 1 and value.size(0) != 1 and value.size(0) != random.size(0)):
        raise ValueError(f"{name}: expected a number, or a scalar tensor, (1,) or (B,), got {list(value.shape)}")
    return value.to(random.dtype).reshape(-1, 1, 1, 1)
