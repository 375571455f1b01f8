"""Levels of pyramids with every second pixel of the level below: reduction and expansion by the binomial
window 1, 4, 6, 4, 1."""

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows
from ..core.lowering import primitive
from ..filters.correlation import weigh_and_thin
from ..filters.padding import padded
from ..kernels import operators as kernels
from ..numbers.loss_reduction import narrowed, widened


def _is_bytes(x: Tensor, *_: object) -> bool:
    return kernels.available(x) and x.dtype == torch.uint8


@primitive
def blurred_and_thinned(x: Tensor, border_type: str) -> Tensor:
    """Every other pixel, from the first on, of (B, C, H, W) blurred by the binomial window along both axes.
    Sums of bytes are exact in float32, and rounded half up."""
    taps = [1.0, 4.0, 6.0, 4.0, 1.0]
    if x.dtype == torch.uint8:
        sums = weigh_and_thin(padded(x.to(torch.float32), (2, 2), (2, 2), border_type), taps, taps, 2)
        return torch.floor(sums * (1.0 / 256.0) + 0.5).to(torch.uint8)
    # float16 cannot hold the sums
    sums = weigh_and_thin(padded(widened(x), (2, 2), (2, 2), border_type), taps, taps, 2)
    return narrowed(sums * (1.0 / 256.0), x)


@blurred_and_thinned.lowering("native", when=_is_bytes)
def _blurred_and_thinned_kernel(x: Tensor, border_type: str) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.pyramid_down_bytes(rows, step, border_type), x)


@primitive
def spread_and_blurred(x: Tensor) -> Tensor:
    """(B, C, 2 H, 2 W): (B, C, H, W) with zeros between the pixels, reflected at the edges and blurred by
    four times the binomial window. Sums of bytes are exact in float32, and rounded half up."""
    if x.dtype == torch.uint8:
        sums = _spread(_spread(x.to(torch.float32), 2), 3)
        return torch.floor(sums * (1.0 / 64.0) + 0.5).to(torch.uint8)
    return narrowed(_spread(_spread(widened(x), 2), 3) * (1.0 / 64.0), x)


def _spread(x: Tensor, dim: int) -> Tensor:
    """Eight times the values at the pixels and between them, along an axis."""
    size = x.size(dim)
    pixel = torch.arange(size, device=x.device)
    # By reflection, the second pixel is before the first one, and the last pixel is behind the zero at the
    # end.
    before = x.index_select(dim, (pixel - 1).abs().clamp(max=size - 1))
    behind = x.index_select(dim, (pixel + 1).clamp(max=size - 1))
    return torch.stack([before + 6.0 * x + behind, 4.0 * (x + behind)], dim + 1).flatten(dim, dim + 1)


@spread_and_blurred.lowering("native", when=_is_bytes)
def _spread_and_blurred_kernel(x: Tensor) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.pyramid_up_bytes(rows, step), x)
