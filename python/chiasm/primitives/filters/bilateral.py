"""Bilateral filters: means over neighbours that are near in space and similar in colour."""

import torch
from torch import Tensor

from ..core.layout import in_frames, in_planes, interleaved
from ..core.lowering import primitive
from ..core.materialise import materialised
from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .padding import padded
from .stencil import join_channels, split_channels


@primitive
def bilateral_mean(
    x: Tensor,
    guide: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    range_coefficient: Tensor,
    squares: bool,
    border_type: str,
) -> Tensor:
    """Means of (B, C, H, W) weighted by exp(range_coefficient * distance^2) * kernel_y * kernel_x. Half
    precision holds neither the squares nor the sums.

    The distance between the colours of ``guide`` (B or 1, D, H, W) is the sum of absolute differences, or
    Euclidean (``squares``). The kernels are (B or 1, size) and symmetric, range_coefficient is (B or 1, 1, 1,
    1).
    """
    ry, rx = kernel_y.size(1) // 2, kernel_x.size(1) // 2
    p = padded(x, (ry, ry), (rx, rx), border_type)
    q = p if guide is x else padded(guide, (ry, ry), (rx, rx), border_type)
    return _valid_mean(p, q, kernel_y, kernel_x, range_coefficient, squares)


@bilateral_mean.lowering("native", when=kernels.has_kernel)
def _bilateral_mean_kernel(
    x: Tensor,
    guide: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    range_coefficient: Tensor,
    squares: bool,
    border_type: str,
) -> Tensor:
    return kernels.bilateral(
        x,
        guide,
        kernel_y[:, :, None] * kernel_x[:, None, :],
        range_coefficient.flatten(),
        border_type,
        squares,
    )


def _valid_mean(
    p: Tensor, guide: Tensor, kernel_y: Tensor, kernel_x: Tensor, range_coefficient: Tensor, squares: bool
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
            space_weights = (kernel_y[:, i] * kernel_x[:, j])[:, None, None, None]
            weight = torch.exp(distance * range_coefficient) * space_weights
            total = total + weight
            sums = [sums[c] + rows[c][..., j : j + width] * weight for c in range(len(planes))]
    return join_channels([s / total for s in sums])


def bilateral_bytes(
    x: Tensor,
    guide: Tensor,
    kernel_y: Tensor,
    kernel_x: Tensor,
    range_coefficient: Tensor,
    squares: bool,
    border_type: str,
) -> Tensor:
    """``bilateral_mean`` of bytes by a guide of bytes, rounded half up; the kernels and the coefficient are
    float64.

    Both factors of a weight are rounded to multiples of 1/2^16. A weight is then a multiple of 1/2^32, and
    float64 holds the sums over up to 4096 pixels exactly. Distances are integers, which index a table of the
    colour's factor.
    """
    ry, rx = kernel_y.size(1) // 2, kernel_x.size(1) // 2
    relative_y, relative_x = kernel_y / kernel_y[:, ry : ry + 1], kernel_x / kernel_x[:, rx : rx + 1]
    space_weights = known_or(torch.round(65536.0 * (relative_y[:, :, None] * relative_x[:, None, :])), 0.0)
    largest = guide.size(1) * (65025 if squares else 255)
    distance = torch.arange(largest + 1, device=x.device).to(torch.float64)
    exponent = (distance if squares else distance * distance) * range_coefficient.reshape(-1, 1)
    range_weights = known_or(torch.round(65536.0 * torch.exp(exponent)), 0.0)
    # A pixel of the same colour has the whole weight, even if all other colours have none.
    range_weights = torch.where(distance == 0.0, torch.full_like(range_weights, 65536.0), range_weights)
    return _mean_of_bytes(
        x, guide, materialised(space_weights, 0), materialised(range_weights, 0), squares, border_type
    )


@primitive
def _mean_of_bytes(
    x: Tensor, guide: Tensor, space_weights: Tensor, range_weights: Tensor, squares: bool, border_type: str
) -> Tensor:
    """Means of bytes (B, C, H, W) weighted by ``space_weights`` (B or 1, ky, kx) times the entry of
    ``range_weights`` (B or 1, K) at the distance between the colours of ``guide`` (B or 1, D, H, W), rounded
    half up. Both are integers in float64, which holds all sums exactly; ``space_weights`` are symmetric about
    their centre."""
    batch, ky, kx = x.size(0), space_weights.size(1), space_weights.size(2)
    height, width = x.size(2), x.size(3)
    ry, rx = ky // 2, kx // 2
    p = padded(in_planes(x).to(torch.float32), (ry, ry), (rx, rx), border_type)
    q = p if guide is x else padded(in_planes(guide).to(torch.float32), (ry, ry), (rx, rx), border_type)
    q = q.expand(batch, -1, -1, -1)
    table = range_weights.expand(batch, -1)
    centre = q[:, :, ry : ry + height, rx : rx + width]
    total = torch.zeros([1], dtype=torch.float64, device=p.device)
    sums = total
    for i in range(ky):
        for j in range(kx):
            difference = q[:, :, i : i + height, j : j + width] - centre
            apart = difference * difference if squares else difference.abs()
            entry = apart.sum(1).to(torch.int64).flatten(1)
            weight = table.gather(1, entry).reshape(batch, 1, height, width)
            weight = weight * space_weights[:, i, j].reshape(-1, 1, 1, 1)
            total = total + weight
            sums = sums + p[:, :, i : i + height, j : j + width].to(torch.float64) * weight
    return torch.floor((2.0 * sums + total) / (2.0 * total).clamp(min=1.0)).to(torch.uint8)


@_mean_of_bytes.lowering("native", when=lambda x, *_: kernels.available(x))
def _mean_of_bytes_kernel(
    x: Tensor, guide: Tensor, space_weights: Tensor, range_weights: Tensor, squares: bool, border_type: str
) -> Tensor:
    planes = in_planes(x)
    guides = planes if guide is x else in_planes(guide)
    made = kernels.bilateral_bytes(planes, guides, space_weights, range_weights, border_type, squares)
    return in_frames(made).permute(0, 3, 1, 2) if interleaved(x) else made
