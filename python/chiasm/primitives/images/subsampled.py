"""Conversion between RGB and the formats of cameras and encoders: luma and chroma in bytes, with chroma at a
lower resolution."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.layout import in_frames, in_planes, interleaved
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..resampling.decimation import every_second
from ..resampling.taps import nearest_index
from .color_planes import as_pixels, channels_of, from_pixels


def paired(u: Tensor, v: Tensor) -> Tensor:
    """U and V, bytes (B, 1, H, W), as two channels. AOTInductor would leave a concatenation of uint8 tensors
    to libtorch.

    >>> u = torch.zeros(1, 1, 1, 1, dtype=torch.uint8)
    >>> paired(u, u + 1).flatten()
    tensor([0, 1], dtype=torch.uint8)
    """
    first = torch.arange(2, device=u.device).reshape(2, 1, 1) == 0
    return torch.where(first, u, v)


@primitive
def subsampled_to_rgb(luma: Tensor, chroma: Tensor, weights: List[int], swapped: bool) -> Tensor:
    """Bytes (B, 3, H, W) from luma (B, 1, H, W) and chroma (B, 2, h, w): U and V, or V and U if ``swapped``.
    Each pixel takes the nearest chroma.

    ``weights``, in 1/2^20: of luma; of V in red; of U and of V in green; of U in blue; and the luma of black.
    Values are rounded half up and saturated.

    >>> subsampled_to_rgb(
    ...     torch.full((1, 1, 2, 2), 90, dtype=torch.uint8),
    ...     torch.tensor([128, 138], dtype=torch.uint8).reshape(1, 2, 1, 1),
    ...     [2**20, 2**20, 0, -(2**20), 0, 10],
    ...     False,
    ... )[0, :, 1, 1]
    tensor([90, 70, 80], dtype=torch.uint8)
    """
    rows = nearest_index(chroma.size(-2), luma.size(-2), chroma.device)
    columns = nearest_index(chroma.size(-1), luma.size(-1), chroma.device)
    # In float64, which holds the sums.
    around = chroma.index_select(-2, rows).index_select(-1, columns).to(torch.float64) - 128.0
    bright = (luma[:, 0].to(torch.float64) - float(weights[5])).clamp(min=0.0) * float(weights[0])
    u, v = around[:, 1 if swapped else 0], around[:, 0 if swapped else 1]
    parts = [v * float(weights[1]), u * float(weights[2]) + v * float(weights[3]), u * float(weights[4])]
    sums = torch.stack([bright + part for part in parts], 1)
    return torch.floor((sums + 524288.0) * (1.0 / 1048576.0)).clamp(0.0, 255.0).to(torch.uint8)


@subsampled_to_rgb.lowering("native", when=lambda luma, *_: kernels.available(luma))
def _subsampled_kernel(luma: Tensor, chroma: Tensor, weights: List[int], swapped: bool) -> Tensor:
    if not interleaved(chroma):
        first, second = chroma.narrow(1, 0, 1), chroma.narrow(1, 1, 1)
        return planar_to_rgb(luma, second if swapped else first, first if swapped else second, weights)
    pairs, numbers = chroma.permute(0, 2, 3, 1).flatten(2), torch.tensor(weights, dtype=torch.int32)
    made = kernels.subsampled_pixels(luma[:, 0], pairs, numbers, swapped, interleaved(luma))
    return from_pixels(made, luma, 3)


@primitive
def planar_to_rgb(luma: Tensor, u: Tensor, v: Tensor, weights: List[int]) -> Tensor:
    """`subsampled_to_rgb` with U and V (B, 1, h, w) each in a plane of its own.

    >>> luma, u = torch.full((1, 1, 2, 2), 90, dtype=torch.uint8), torch.full((1, 1, 1, 1), 128)
    >>> planar_to_rgb(luma, u.to(torch.uint8), u.to(torch.uint8), [2**20, 0, 0, 0, 0, 10])[0, :, 1, 1]
    tensor([80, 80, 80], dtype=torch.uint8)
    """
    return subsampled_to_rgb(luma, paired(u, v), weights, False)


@planar_to_rgb.lowering("native", when=lambda luma, *_: kernels.available(luma))
def _planar_kernel(luma: Tensor, u: Tensor, v: Tensor, weights: List[int]) -> Tensor:
    numbers = torch.tensor(weights, dtype=torch.int32)
    made = kernels.subsampled_planes(
        luma[:, 0], u[:, 0].contiguous(), v[:, 0].contiguous(), numbers, interleaved(luma)
    )
    return from_pixels(made, luma, 3)


@primitive
def packed_to_rgb(image: Tensor, weights: List[int], luma_first: bool) -> Tensor:
    """Bytes (B, 3, H, 2 W) from pairs of pixels (B, 4, H, W): luma, chroma, luma, chroma, or with chroma
    first; weights as in `subsampled_to_rgb`.

    >>> packed_to_rgb(
    ...     torch.tensor([90, 128, 91, 138], dtype=torch.uint8).reshape(1, 4, 1, 1),
    ...     [2**20, 2**20, 0, 0, 0, 10],
    ...     True,
    ... )[0, 0]
    tensor([[90, 91]], dtype=torch.uint8)
    """
    first = 0 if luma_first else 1
    luma = torch.stack([image[:, first], image[:, first + 2]], -1).flatten(2).unsqueeze(1)
    chroma = torch.stack([image[:, 1 - first], image[:, 3 - first]], 1)
    return subsampled_to_rgb(luma, chroma, weights, False)


@packed_to_rgb.lowering("native", when=lambda image, *_: kernels.available(image))
def _packed_kernel(image: Tensor, weights: List[int], luma_first: bool) -> Tensor:
    rows = in_frames(image).flatten(2)
    is_frame = interleaved(image)
    made = kernels.packed_pixels(rows, torch.tensor(weights, dtype=torch.int32), luma_first, is_frame)
    if is_frame:
        return made.unflatten(1, [image.size(2), 2 * image.size(3), 3]).permute(0, 3, 1, 2)
    return made.unflatten(1, [3, image.size(2), 2 * image.size(3)])


@primitive
def chroma_means(yuv: Tensor, both: bool) -> Tuple[Tensor, Tensor]:
    """Luma (*, 1, H, W) of YUV (*, 3, H, W), and U and V at half the width, (*, 2, H, (W + 1) // 2), or at
    half the height too if ``both``: means of neighbours, in bytes rounded half up. The last row or column of
    an odd size counts twice.

    >>> luma, chroma = chroma_means(torch.tensor([1.0, 2.0]).expand(3, 1, 2), False)
    >>> luma.flatten(), chroma.flatten()
    (tensor([1., 2.]), tensor([1.5000, 1.5000]))
    """
    u, v = yuv.select(-3, 1), yuv.select(-3, 2)
    if yuv.dtype == torch.uint8:
        u, v = u.to(torch.float32), v.to(torch.float32)
    means = torch.stack([u, v], -3)
    if both:
        means = _pairs(means, -2) * 0.5
    means = _pairs(means, -1) * 0.5
    if yuv.dtype == torch.uint8:
        means = torch.floor(means + 0.5).to(torch.uint8)
    return yuv.select(-3, 0).unsqueeze(-3), means


def _is_image(image: Tensor) -> bool:
    return kernels.available(image) and image.dtype == torch.uint8 and image.dim() == 4


@chroma_means.lowering("native", when=lambda yuv, both: _is_image(yuv))
def _chroma_means_kernel(yuv: Tensor, both: bool) -> Tuple[Tensor, Tensor]:
    planes = in_planes(yuv)
    height, width = planes.size(2), planes.size(3)
    rows, columns = (height + 1) // 2 if both else height, (width + 1) // 2
    row, column = torch.arange(2 * rows if both else rows), torch.arange(2 * columns)
    even = kernels.gather_pixels(
        planes.narrow(1, 1, 2).contiguous(),
        row.clamp(max=height - 1).to(torch.int32),
        column.clamp(max=width - 1).to(torch.int32),
        1,
        0.0,
    )
    means = kernels.area_bytes(even.flatten(0, 1), rows, columns, 1).unflatten(0, [planes.size(0), 2])
    luma = planes.narrow(1, 0, 1).clone(memory_format=torch.contiguous_format)
    return luma, in_frames(means).permute(0, 3, 1, 2) if interleaved(yuv) else means


@primitive
def rgb_to_subsampled(image: Tensor, factors: List[int]) -> Tuple[Tensor, Tensor]:
    """Luma (B, 1, H, W) of bytes (B, 3, H, W), and U and V (B, 2, (H + 1) // 2, (W + 1) // 2) of the means of
    2 x 2 pixels. The last row or column of an odd size counts twice.

    ``factors``, in 1/2^20: of red, green and blue in luma, in U and in V; and the luma of black. Chroma is
    around 128. Values are rounded half up and saturated.

    >>> luma, chroma = rgb_to_subsampled(
    ...     torch.full((1, 3, 1, 1), 10, dtype=torch.uint8),
    ...     [2**19, 2**19, 0, 2**20, 0, 0, 0, 0, -(2**20), 16],
    ... )
    >>> luma.flatten(), chroma.flatten()
    (tensor([26], dtype=torch.uint8), tensor([138, 118], dtype=torch.uint8))
    """
    # In float64, which holds the sums.
    channels = [channel.to(torch.float64) for channel in channels_of(image)]
    luma = _mixed(channels, factors[0:3], factors[9], 1048576.0)
    quarters = [_pairs(_pairs(channel, -2), -1) for channel in channels]
    pairs = [_mixed(quarters, factors[k : k + 3], 128, 4194304.0) for k in (3, 6)]
    return luma.unsqueeze(1).to(torch.uint8), torch.stack(pairs, 1).to(torch.uint8)


def _mixed(channels: List[Tensor], factors: List[int], zero: int, whole: float) -> Tensor:
    """The sum of the channels times their factors, divided by ``whole``, plus ``zero``, rounded half up."""
    total = channels[0] * float(factors[0]) + channels[1] * float(factors[1])
    total = total + channels[2] * float(factors[2]) + (float(zero) + 0.5) * whole
    return torch.floor(total / whole).clamp(0.0, 255.0)


def _pairs(x: Tensor, dim: int) -> Tensor:
    """Sums of two neighbours along ``dim``; the last one of an odd number counts twice."""
    half = (x.size(dim) + 1) // 2
    return every_second(x, dim, 0, half) + every_second(x, dim, 1, half)


@rgb_to_subsampled.lowering("native", when=lambda image, *_: kernels.available(image))
def _nv12_kernel(image: Tensor, factors: List[int]) -> Tuple[Tensor, Tensor]:
    height, width = image.size(2), image.size(3)
    pixels, is_frame = as_pixels(image)
    made = kernels.nv12_pixels(pixels, torch.tensor(factors, dtype=torch.int32), height, is_frame)
    rows, columns = (height + 1) // 2, (width + 1) // 2
    luma = made.narrow(1, 0, height * width).unflatten(1, [height, width, 1])
    pairs = made.narrow(1, height * width, rows * columns * 2).unflatten(1, [rows, columns, 2])
    # Dense, because the runtime would otherwise copy them value by value.
    luma, pairs = (part.clone(memory_format=torch.contiguous_format) for part in (luma, pairs))
    chroma = pairs.permute(0, 3, 1, 2)
    return luma.permute(0, 3, 1, 2), chroma if is_frame else in_planes(chroma)
