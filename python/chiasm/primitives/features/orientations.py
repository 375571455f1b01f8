"""Directions of gradients, and histograms of them."""

import math
from typing import Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..filters.derivatives import gradient
from ..geometry.angles import angle_of
from ..kernels import operators as kernels
from ..linalg.matrices import small_matmul


def polar_gradient(image: Tensor) -> Tuple[Tensor, Tensor]:
    """Length and direction of the central differences of (N, 1, H, W), the border replicated: (N, H, W) each.

    Directions are in radians from x towards y, that is down, from -pi to pi. Where there is no gradient, both
    are 0 and have derivative 0.
    """
    both = gradient(image, (1, 1), (1, 1), "replicate", "diff", True)[:, 0]
    dx, dy = both[:, 0], both[:, 1]
    squared = dx * dx + dy * dy
    flat = squared == 0
    zero, one = torch.zeros_like(dx), torch.ones_like(dx)
    length = torch.sqrt(torch.where(flat, one, squared))
    direction = angle_of(torch.where(flat, zero, dy), torch.where(flat, one, dx))
    return torch.where(flat, zero, length), direction


def directed(length: Tensor, direction: Tensor, bins: int) -> Tensor:
    """(N, bins, H, W): each length, divided between the two of the ``bins`` directions that are next to its
    own. The first direction is 0 radians."""
    place = direction * (bins / (2.0 * math.pi))
    place = torch.where(place < 0, place + bins, place)[:, None]
    bin = torch.arange(bins, device=length.device).to(length.dtype)[:, None, None]
    away = (place - bin).abs()
    return length[:, None] * (1.0 - torch.minimum(away, bins - away)).clamp(min=0)


@primitive
def orientation_histograms(patches: Tensor, window: Tensor, space_weights: Tensor, bins: int) -> Tensor:
    """(N, bins, P, P): histograms of the gradient directions in patches (N, 1, PS, PS). The lengths, as
    ``directed``, are weighted by ``window`` (PS, PS) and added to the P x P cells by ``space_weights``
    (P, PS), for rows and for columns."""
    length, direction = polar_gradient(patches)
    planes = directed(length * window, direction, bins)
    return small_matmul(small_matmul(space_weights, planes), space_weights.transpose(-1, -2))


@orientation_histograms.lowering("native", when=kernels.has_kernel)
def _orientation_histograms_kernel(
    patches: Tensor, window: Tensor, space_weights: Tensor, bins: int
) -> Tensor:
    return kernels.orientation_histograms(
        patches[:, 0].contiguous(), window.contiguous(), space_weights.contiguous(), bins
    )
