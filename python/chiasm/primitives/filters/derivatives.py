"""First derivatives by finite differences."""

from typing import Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.layout import as_rows, from_rows, in_planes
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..numbers.loss_reduction import narrowed, widened
from .padding import stencil


@primitive
def first_derivatives(p: Tensor, mode: str, normalized: bool) -> Tuple[Tensor, Tensor]:
    """d/dx and d/dy (B, C, H, W) of an image padded by one pixel; one Conv node in ONNX.

    >>> dx, dy = first_derivatives(torch.arange(5.0).expand(1, 1, 3, 5), "diff", True)
    >>> dx, dy
    (tensor([[[[1., 1., 1.]]]]), tensor([[[[0., 0., 0.]]]]))
    """
    if mode == "diff":
        height, width = p.size(2) - 2, p.size(3) - 2
        dx = p[:, :, 1 : height + 1, 2 : width + 2] - p[:, :, 1 : height + 1, 0:width]
        dy = p[:, :, 2 : height + 2, 1 : width + 1] - p[:, :, 0:height, 1 : width + 1]
        scale = 0.5
    elif mode == "sobel":
        dx, dy = sobel_sums(p)
        scale = 0.125
    elif mode == "scharr":
        dx, dy = smoothed_differences(p, 3.0, 10.0)
        scale = 1.0 / 32.0
    else:
        dx, dy = smoothed_differences(p, 1.0, 1.0)
        scale = 1.0 / 6.0
    if not normalized:
        scale = 1.0
    return dx * scale, dy * scale


_SMOOTHING = {
    "diff": ([0.0, 1.0, 0.0], 0.5),
    "sobel": ([1.0, 2.0, 1.0], 0.125),
    "scharr": ([3.0, 10.0, 3.0], 1.0 / 32.0),
    "prewitt": ([1.0, 1.0, 1.0], 1.0 / 6.0),
}


# ONNX Runtime has no Conv for other types on the CPU.
@first_derivatives.lowering("onnx", when=lambda p, *_: p.dtype == torch.float32)
def _one_convolution(p: Tensor, mode: str, normalized: bool) -> Tuple[Tensor, Tensor]:
    smooth, scale = _SMOOTHING[mode]
    across = torch.tensor(smooth, dtype=p.dtype, device=p.device) * (scale if normalized else 1.0)
    along = torch.tensor([-1.0, 0.0, 1.0], dtype=p.dtype, device=p.device)
    kernels = torch.stack([across[:, None] * along, along[:, None] * across])[:, None]
    both = F.conv2d(p.reshape(-1, 1, p.size(2), p.size(3)), kernels)
    both = both.reshape(p.size(0), p.size(1), 2, both.size(2), both.size(3))
    return both[:, :, 0], both[:, :, 1]


def sobel_sums(p: Tensor) -> Tuple[Tensor, Tensor]:
    """Sobel's sums without a scale. Every form adds in the same order, so equal pixels give equal sums."""
    height, width = p.size(2) - 2, p.size(3) - 2
    smooth = p[:, :, 0:height] + 2.0 * p[:, :, 1 : height + 1] + p[:, :, 2 : height + 2]
    slope = p[:, :, 2 : height + 2] - p[:, :, 0:height]
    return (
        smooth[..., 2 : width + 2] - smooth[..., 0:width],
        slope[..., 0:width] + 2.0 * slope[..., 1 : width + 1] + slope[..., 2 : width + 2],
    )


def smoothed_differences(p: Tensor, side: float, middle: float) -> Tuple[Tensor, Tensor]:
    """Differences of the second neighbours along one axis, smoothed along the other by ``side``, ``middle``,
    ``side``, without a scale, of an image padded by one pixel."""
    height, width = p.size(2) - 2, p.size(3) - 2
    top, centre, bottom = p[:, :, 0:height], p[:, :, 1 : height + 1], p[:, :, 2 : height + 2]
    smooth = (top + bottom) * side + centre * middle
    slope = bottom - top
    return (
        smooth[..., 2 : width + 2] - smooth[..., 0:width],
        (slope[..., 0:width] + slope[..., 2 : width + 2]) * side + slope[..., 1 : width + 1] * middle,
    )


@primitive
def sobel_magnitude(x: Tensor, normalized: bool, eps: float) -> Tensor:
    """sqrt(dx^2 + dy^2 + eps) of Sobel's ``first_derivatives`` of (B, C, H, W); the border is replicated."""
    # float16 cannot hold the squares
    return narrowed(_magnitude(widened(x), (1, 1), (1, 1), "replicate", normalized, eps), x)


@sobel_magnitude.lowering("native", when=kernels.has_kernel)
def _sobel_kernel(x: Tensor, normalized: bool, eps: float) -> Tensor:
    return kernels.sobel(x, 0.125 if normalized else 1.0, eps)


@stencil
def _magnitude(p: Tensor, normalized: bool, eps: float) -> Tensor:
    dx, dy = first_derivatives(p, "sobel", normalized)
    return torch.sqrt(dx * dx + dy * dy + eps)


@stencil
def gradient(p: Tensor, mode: str, normalized: bool) -> Tensor:
    """(B, C, 2, H, W): d/dx and d/dy of an image padded by one pixel."""
    dx, dy = first_derivatives(p, mode, normalized)
    return torch.stack([dx, dy], 2)


@primitive
def magnitude_of_bytes(x: Tensor, normalized: bool) -> Tensor:
    """``sobel_magnitude`` of bytes (B, C, H, W), rounded to the nearest byte, half to even, and saturated.
    The sums are integers below 2^24, so float32 distinguishes their roots from halves."""
    lengths = sobel_magnitude(in_planes(x).to(torch.float32), False, 0.0)
    return torch.round(lengths * (0.125 if normalized else 1.0)).clamp(max=255.0).to(torch.uint8)


@magnitude_of_bytes.lowering("native", when=kernels.available)
def _magnitude_of_bytes_kernel(x: Tensor, normalized: bool) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.magnitude_of_bytes(rows, step, 1, 2, 8 if normalized else 1), x)


@primitive
def lengths_of_bytes(x: Tensor, side: int, middle: int, divisor: int) -> Tensor:
    """sqrt(dx^2 + dy^2) / divisor of the ``smoothed_differences`` of bytes (B, C, H, W), rounded to the
    nearest byte, half to even, and saturated; the border is replicated.

    Sums of squares reach 2^25, beyond the whole numbers of float32. In float64, roots of whole numbers that
    are not whole are further from a half than their rounding error, and a quotient of whole numbers is exact
    at halves; the divisor is a tensor, because some devices replace division by a number with multiplication.
    """
    exact = in_planes(x).to(torch.float64)
    lengths = length_of_differences(exact, (1, 1), (1, 1), "replicate", float(side), float(middle), 1.0, 0.0)
    quotient = lengths / torch.full([1], float(divisor), dtype=torch.float64, device=x.device)
    return torch.round(quotient).clamp(max=255.0).to(torch.uint8)


@lengths_of_bytes.lowering("native", when=kernels.available)
def _lengths_of_bytes_kernel(x: Tensor, side: int, middle: int, divisor: int) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.magnitude_of_bytes(rows, step, side, middle, divisor), x)


@stencil
def length_of_differences(p: Tensor, side: float, middle: float, scale: float, eps: float) -> Tensor:
    """sqrt(dx^2 + dy^2 + eps) of the ``smoothed_differences``, each times ``scale``."""
    dx, dy = smoothed_differences(p, side, middle)
    dx, dy = dx * scale, dy * scale
    return torch.sqrt(dx * dx + dy * dy + eps)


@primitive
def derivatives_of_bytes(x: Tensor, mode: str) -> Tensor:
    """(B, C, 2, H, W), int16: d/dx and d/dy of bytes (B, C, H, W) without a scale, integers that float32
    holds exactly; the border is replicated."""
    exact = in_planes(x).to(torch.float32)
    return gradient(exact, (1, 1), (1, 1), "replicate", mode, False).to(torch.int16)


@derivatives_of_bytes.lowering("native", when=lambda x, mode: kernels.available(x))
def _derivatives_kernel(x: Tensor, mode: str) -> Tensor:
    (side, centre, _), _ = _SMOOTHING[mode]
    planes = in_planes(x).flatten(0, 1)
    return kernels.derivatives_of_bytes(planes, int(side), int(centre)).unflatten(0, [x.size(0), x.size(1)])
