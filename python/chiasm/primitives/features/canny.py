"""Thin edges: ridges of the gradient magnitude, and the connection of weak ridges to strong ones."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..filters.derivatives import sobel_sums
from ..filters.padding import stencil
from ..kernels import operators as kernels
from ..numbers.loss_reduction import narrowed, widened
from .connected_components import reached


@primitive
def canny_nms(x: Tensor, eps: float) -> Tensor:
    """The magnitude of the unnormalised Sobel gradient of (B, 1, H, W) at its maxima across the edge, 0
    elsewhere.

    The border is replicated; beyond it the magnitude is 0. ``eps`` is added to the squared magnitude.
    """
    # float16 cannot hold the squares
    gradient = _gradient(widened(x), (1, 1), (1, 1), "replicate", eps)
    return narrowed(_thinned(gradient, (1, 1), (1, 1), "constant"), x)


canny_nms.lowering("native", when=kernels.has_kernel)(kernels.canny_nms)


@stencil
def _gradient(p: Tensor, eps: float) -> Tensor:
    """Magnitude and gradient (B, 3, H, W) of (B, 1, H + 2, W + 2)."""
    dx, dy = sobel_sums(p)
    squared = dx * dx + dy * dy + eps
    positive = squared > 0
    magnitude = torch.where(
        positive,
        torch.sqrt(torch.where(positive, squared, torch.ones_like(squared))),
        torch.zeros_like(squared),
    )
    return torch.cat([magnitude, dx, dy], 1)


@stencil
def _thinned(p: Tensor) -> Tensor:
    """The ridges (B, 1, H, W) of magnitude and gradient (B, 3, H + 2, W + 2)."""
    height = p.size(2) - 2
    width = p.size(3) - 2
    centre = p[:, 0, 1 : height + 1, 1 : width + 1]
    m = p[:, 0].detach()
    dx = p[:, 1, 1 : height + 1, 1 : width + 1].detach()
    dy = p[:, 2, 1 : height + 1, 1 : width + 1].detach()
    left, right = m[:, 1 : height + 1, 0:width], m[:, 1 : height + 1, 2 : width + 2]
    above, below = m[:, 0:height, 1 : width + 1], m[:, 2 : height + 2, 1 : width + 1]
    falling = torch.maximum(m[:, 0:height, 0:width], m[:, 2 : height + 2, 2 : width + 2])
    rising = torch.maximum(m[:, 0:height, 2 : width + 2], m[:, 2 : height + 2, 0:width])
    # An ideal step has two equal adjacent pixels: the first of them is the ridge.
    across = (centre > left) & (centre >= right)
    along = (centre > above) & (centre >= below)
    diagonal = centre > torch.where((dx > 0) == (dy > 0), falling, rising)
    tangent = 0.41421356237309503  # tan(22.5 degrees)
    horizontal = dy.abs() < dx.abs() * tangent
    vertical = dx.abs() < dy.abs() * tangent
    ridge = (horizontal & across) | (vertical & along) | (~horizontal & ~vertical & diagonal)
    return torch.where(ridge, centre, torch.zeros_like(centre))[:, None]


@primitive
def canny_hysteresis(x: Tensor, low: float, high: float, limit: int) -> Tensor:
    """True for the values of (B, 1, H, W) above ``low`` that are 8-connected through such values to a value
    above ``high``. ``limit`` is as in ``reached``."""
    return reached(x[:, 0] > low, x[:, 0] > high, limit)[:, None]


@canny_hysteresis.lowering(
    "native", when=lambda x, low, high, limit: kernels.has_kernel(x) and kernels.runs_to_its_end(limit)
)
def _linked_kernel(x: Tensor, low: float, high: float, limit: int) -> Tensor:
    return kernels.canny_hysteresis(x, low, high)
