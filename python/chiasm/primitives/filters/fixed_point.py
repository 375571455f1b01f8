"""Linear filters on bytes in fixed point: taps are multiples of 1/256 or of another power of two, so that
sums are integers below 2^24. float32 holds these exactly, so every engine gives the same bytes, in whatever
order it adds."""

from typing import List, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.layout import as_rows, from_rows
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .correlation import box_sums, correlated2d
from .padding import padded
from .stencil import separable


def fixed_taps(taps: Tensor) -> Tensor:
    """Symmetric taps (N, K) that sum to 1, as integer multiples (N, K // 2 + 1) of 1/256 from the middle
    outwards.

    From the ends inwards, each tap takes the rounding error of the one before (error diffusion); the middle
    tap takes the rest of 256. These are the taps of OpenCV's GaussianBlur of 8 bits.

    >>> fixed_taps(torch.tensor([[0.05, 0.25, 0.4, 0.25, 0.05]]))
    tensor([[102,  64,  13]], dtype=torch.int32)
    """
    wanted = taps.to(torch.float64) * 256.0
    error = torch.zeros_like(wanted[:, 0])
    side: List[Tensor] = []
    middle = torch.full_like(error, 256.0)
    for i in range(taps.size(1) // 2):
        tap = torch.round(wanted[:, i] + error)
        error = wanted[:, i] + error - tap
        middle = middle - 2.0 * tap
        side.append(tap)
    side.append(middle)
    side.reverse()
    return torch.stack(side, 1).to(torch.int32)


def both_sides(taps: Tensor) -> Tensor:
    """All taps (N, K) from those of the middle outwards, as float32."""
    all_taps = taps.to(torch.float32)
    return torch.cat([all_taps[:, 1:].flip(1), all_taps], 1)


@primitive
def separable_bytes(x: Tensor, taps_y: Tensor, taps_x: Tensor, border_type: str) -> Tensor:
    """Correlate uint8 (B, C, H, W) with ``fixed_taps`` (B or 1, ky) down the columns and (B or 1, kx) along
    the rows; rounded half up."""
    return rounded_sums(separable(x.to(torch.float32), both_sides(taps_y), both_sides(taps_x), border_type))


def rounded_sums(sums: Tensor) -> Tensor:
    """Sums divided by 2^16, rounded to the nearest byte, half up: exact in float32."""
    return torch.floor(sums * (1.0 / 65536.0) + 0.5).to(torch.uint8)


@separable_bytes.lowering("native", when=kernels.available)
def _separable_bytes_kernel(x: Tensor, taps_y: Tensor, taps_x: Tensor, border_type: str) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.separable_bytes(rows, taps_y, taps_x, step, border_type), x)


@separable_bytes.lowering("onnx", when=lambda _, taps_y, taps_x, *__: taps_y.size(0) == taps_x.size(0) == 1)
def _two_convolutions(x: Tensor, taps_y: Tensor, taps_x: Tensor, border_type: str) -> Tensor:
    ry, rx = taps_y.size(1) - 1, taps_x.size(1) - 1
    # Channels are folded into the batch, as separable_shared does.
    flat = padded(x.to(torch.float32).flatten(0, 1)[:, None], (ry, ry), (rx, rx), border_type)
    column, row = both_sides(taps_y)[:, None, :, None], both_sides(taps_x)[:, None, None, :]
    return rounded_sums(F.conv2d(F.conv2d(flat, column), row).squeeze(1).reshape(x.shape))


@primitive
def box_bytes(x: Tensor, ky: int, kx: int, border_type: str) -> Tensor:
    """Means of uint8 (B, C, H, W) over windows of ky x kx pixels, at most 65536; rounded half to even.

    An even window reaches one pixel further down and right.
    """
    sums = box_sums(x.to(torch.float32), ky, kx, border_type)
    # Divide, do not multiply by the reciprocal: float32 quotients are exact at halves, and no other quotient
    # rounds to one. The divisor is a tensor, because some devices replace division by a number with
    # multiplication.
    area = torch.full([1], float(ky * kx), dtype=torch.float32, device=x.device)
    return torch.round(sums / area).to(torch.uint8)


@box_bytes.lowering("native", when=kernels.available)
def _box_bytes_kernel(x: Tensor, ky: int, kx: int, border_type: str) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.box_bytes(rows, ky, kx, step, border_type), x)


@primitive
def laplacian_bytes(x: Tensor, ky: int, kx: int, border_type: str) -> Tensor:
    """Sums of uint8 (B, C, H, W) over windows of ky x kx pixels, odd and at most 129, minus as many times the
    centre: int16, exact.

    >>> laplacian_bytes(torch.tensor([[[[1, 2, 4]]]], dtype=torch.uint8), 1, 3, "replicate")
    tensor([[[[ 1,  1, -2]]]], dtype=torch.int16)
    """
    return box_sums(x.to(torch.float32), ky, kx, border_type, 1.0, -1.0 * (ky * kx)).to(torch.int16)


@laplacian_bytes.lowering("native", when=kernels.available)
def _laplacian_bytes_kernel(x: Tensor, ky: int, kx: int, border_type: str) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.laplacian_bytes(rows, ky, kx, step, border_type), x)


def whole_taps(taps: Tensor) -> Tuple[Tensor, Tensor]:
    """Taps (N, kh, kw) as integers, and the power of two (N,) of which they are multiples: the smallest from
    2^-23 to 2^23 for which sums of bytes are below 2^24. NaN becomes 0; magnitudes above 2^31 become 2^31.

    >>> whole_taps(torch.tensor([[[0.5, 0.3]]], dtype=torch.float64))
    (tensor([[[32768., 19661.]]]), tensor([1.5259e-05]))
    """
    wanted = known_or(taps.to(torch.float64), 0.0).clamp(-2147483648.0, 2147483648.0)
    count = taps.size(1) * taps.size(2)
    # Chosen from a list, not computed: engines' logarithms differ in the last digits.
    steps = torch.tensor([2.0**k for k in range(-23, 24)], dtype=torch.float64, device=taps.device)
    # rounding adds at most half a step to each
    largest = 255.0 * (wanted.abs().sum([1, 2])[:, None] / steps + 0.5 * count)
    step = torch.where(largest < 16777216.0, steps, torch.full_like(steps, 2.0**23)).amin(1)
    whole = torch.round(wanted / step[:, None, None])
    return whole.to(torch.float32), step.to(torch.float32)


@primitive
def correlated_bytes(x: Tensor, taps: Tensor, scale: Tensor, border_type: str) -> Tensor:
    """Correlate uint8 (B, C, H, W) with ``whole_taps`` (B or 1, kh, kw) and (B or 1,); rounded half to even
    and saturated."""
    return bytes_of_sums(correlated2d(x.to(torch.float32), taps, border_type), scale)


def bytes_of_sums(sums: Tensor, scale: Tensor) -> Tensor:
    """Sums (B, C, H, W) times powers of two (B or 1,), rounded to the nearest byte, half to even."""
    return torch.round(sums * scale[:, None, None, None]).clamp(0.0, 255.0).to(torch.uint8)


@correlated_bytes.lowering("native", when=kernels.available)
def _correlated_bytes_kernel(x: Tensor, taps: Tensor, scale: Tensor, border_type: str) -> Tensor:
    rows, step = as_rows(x)
    return from_rows(kernels.correlate_bytes(rows, taps, scale, step, border_type), x)
