"""Helpers for augmentations of intensities: random numbers, and the choice between changed and unchanged
samples."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.broadcasting import where_chosen
from ..primitives.core.checks import check_interval
from ..primitives.random import draws
from ..primitives.random.draws import check_seed, uniform


def drawn(seed: Tensor, count: int, input: Tensor) -> Tensor:
    """Uniform numbers in [0, 1), float32: (B, count) of seeds (B,), one for each sample of the input."""
    check_seed(seed, input.size(0))
    return uniform(seed, count)


def between(u: Tensor, bounds: Tuple[float, float], like: Tensor) -> Tensor:
    """Uniform numbers in [0, 1) mapped to the bounds, in the dtype of ``like``; float32 for uint8.

    >>> between(torch.tensor([0.0, 0.5]), (1.0, 3.0), torch.zeros(1))
    tensor([1., 2.])
    """
    moved = draws.between(u, bounds[0], bounds[1])
    return moved.to(like.dtype) if like.is_floating_point() else moved


def whole_between(u: Tensor, bounds: Tuple[int, int]) -> Tensor:
    """Uniform numbers in [0, 1) mapped to whole numbers within the bounds, which are included.

    >>> whole_between(torch.tensor([0.0, 0.5, 0.99]), (3, 5))
    tensor([3, 4, 5])
    """
    # The product may round up to the number of choices.
    count = bounds[1] - bounds[0] + 1
    return torch.floor(u * count).to(torch.int64).clamp(max=count - 1) + bounds[0]


def numbers_of(input: Tensor) -> Tensor:
    """Images in [0, 1]. uint8 becomes float64, so that the rounding differences of engines hardly ever change
    a rounded byte; other dtypes stay as they are.

    >>> numbers_of(torch.tensor([51, 255], dtype=torch.uint8))
    tensor([0.2000, 1.0000], dtype=torch.float64)
    """
    return input if input.is_floating_point() else input.to(torch.float64) / 255.0


def as_given(numbers: Tensor, input: Tensor) -> Tensor:
    """Numbers as from ``numbers_of(input)``, converted back to the input's dtype: for uint8 rounded (halves
    to even) and limited to 0 to 255.

    >>> as_given(torch.tensor([0.25, 1.5]), torch.tensor([0], dtype=torch.uint8))
    tensor([ 64, 255], dtype=torch.uint8)
    """
    if input.is_floating_point():
        return numbers
    return torch.round(numbers * 255.0).clamp(0.0, 255.0).to(torch.uint8)


def white_of(input: Tensor) -> float:
    """The value of white: 255 for uint8, otherwise 1."""
    return 1.0 if input.is_floating_point() else 255.0


def below(u: Tensor, p: float) -> Tensor:
    """Whether uniform numbers in [0, 1) are below p. If p is 1, all are; this needs no comparison, so that an
    export sees it and leaves the choice out.

    >>> below(torch.tensor([0.2, 0.7]), 0.5)
    tensor([ True, False])
    """
    check_chance(p)
    return torch.ones_like(u, dtype=torch.bool) if p >= 1.0 else u < p


def applied(changed: Tensor, input: Tensor, chance: Tensor, p: float) -> Tensor:
    """``changed`` where a sample's ``chance``, uniform in [0, 1), is below ``p``, otherwise ``input``."""
    if p >= 1.0:
        return changed
    return where_chosen(chance < p, changed, input)


def check_bounds(bounds: Tuple[float, float], least: float, greatest: float, name: str) -> None:
    """Raise unless the bounds are two numbers in order and within [least, greatest]."""
    check_interval(bounds, name)
    if not (bounds[0] >= least and bounds[0] <= bounds[1] and bounds[1] <= greatest):
        raise ValueError(
            f"{name}: expected (least, greatest) within [{least}, {greatest}], got ({bounds[0]}, {bounds[1]})"
        )


def check_positive_bounds(bounds: Tuple[float, float], name: str) -> None:
    """Raise unless the bounds are two positive numbers in order."""
    check_interval(bounds, name)
    if not (bounds[0] > 0.0 and bounds[0] <= bounds[1]):
        raise ValueError(f"{name}: expected (least, greatest), both positive, got ({bounds[0]}, {bounds[1]})")


def fitting(fill: float, image: Tensor) -> float:
    """A value that fills pixels; for bytes limited to 0 to 255.

    >>> fitting(300.0, torch.zeros(1, dtype=torch.uint8))
    255.0
    """
    return min(max(fill, 0.0), 255.0) if image.dtype == torch.uint8 else fill


def check_chance(p: float, name: str = "p") -> None:
    """Raise ValueError unless ``p`` is a probability."""
    if not (p >= 0.0 and p <= 1.0):
        raise ValueError(f"{name}: expected a probability, 0 to 1, got {p}")


def check_always(p: float) -> None:
    """Raise ValueError unless ``p`` is 1."""
    if p != 1.0:
        raise ValueError(f"p: expected 1, for the size of a result cannot hang on chance, got {p}")
