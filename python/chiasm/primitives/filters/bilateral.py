"""Means over neighbours that are near in space and alike in colour."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .padding import padded
from .stencil import join_channels, split_channels


@primitive
def bilateral_mean(
    x: Tensor,
    guide: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    falloff: Tensor,
    squares: bool,
    border_type: str,
) -> Tensor:
    """Means of (B, C, H, W) weighted by exp(falloff * distance^2) * kernel_y * kernel_x.

    The distance between the colours of ``guide`` (B or 1, D, H, W) is the sum of absolute differences, or
    Euclidean (``squares``). The kernels are (B or 1, size), falloff is (B or 1, 1, 1, 1).
    """
    ry, rx = kernel_y.size(1) // 2, kernel_x.size(1) // 2
    p = padded(x, (ry, ry), (rx, rx), border_type)
    q = p if guide is x else padded(guide, (ry, ry), (rx, rx), border_type)
    return _valid_mean(p, q, kernel_y, kernel_x, falloff, squares)


@bilateral_mean.lowering("native", when=kernels.has_kernel)
def _bilateral_mean_kernel(
    x: Tensor,
    guide: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    falloff: Tensor,
    squares: bool,
    border_type: str,
) -> Tensor:
    return kernels.bilateral(
        x, guide, kernel_y[:, :, None] * kernel_x[:, None, :], falloff.flatten(), border_type, squares
    )


def _valid_mean(
    p: Tensor, guide: Tensor, kernel_y: Tensor, kernel_x: Tensor, falloff: Tensor, squares: bool
) -> Tensor:
    ky, kx = kernel_y.size(1), kernel_x.size(1)
    height = p.size(2) - ky + 1
    width = p.size(3) - kx + 1
    planes = split_channels(p)
    guides = split_channels(guide)
    centres = [plane[:, :, ky // 2 : ky // 2 + height, kx // 2 : kx // 2 + width] for plane in guides]
    total = torch.zeros([1], dtype=p.dtype, device=p.device)
    sums = [total for _ in planes]
    for i in range(ky):
        rows = [plane[:, :, i : i + height] for plane in planes]
        guide_rows = [plane[:, :, i : i + height] for plane in guides]
        for j in range(kx):
            distance = torch.zeros([1], dtype=p.dtype, device=p.device)
            for c in range(len(guides)):
                difference = guide_rows[c][..., j : j + width] - centres[c]
                if squares:
                    distance = distance + (difference * difference).sum(1, keepdim=True)
                else:
                    distance = distance + difference.abs().sum(1, keepdim=True)
            if not squares:
                distance = distance * distance
            nearness = (kernel_y[:, i] * kernel_x[:, j])[:, None, None, None]
            weight = torch.exp(distance * falloff) * nearness
            total = total + weight
            sums = [sums[c] + rows[c][..., j : j + width] * weight for c in range(len(planes))]
    return join_channels([s / total for s in sums])
