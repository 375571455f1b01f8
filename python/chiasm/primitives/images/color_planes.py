"""Colour planes: an image as three planes, and linear mixtures of them.

Arithmetic on explicit planes, joined by ``torch.stack``, is what AOTInductor vectorises; ONNX Runtime is
fastest with a 1x1 convolution, because it does not fuse.
"""

from typing import List, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.checks import check_floating, check_rgb, check_tensor
from ..core.layout import in_planes, interleaved
from ..core.lowering import primitive
from ..kernels import operators as kernels


def check_channels(image: Tensor, channels: int, name: str) -> None:
    """Raise ValueError unless ``image`` is (*, channels, H, W)."""
    check_tensor(image, name)
    if image.dim() < 3 or image.size(-3) != channels:
        raise ValueError(f"{name}: expected shape (*, {channels}, H, W), got {list(image.shape)}")


def rgb_planes(image: Tensor, name: str) -> Tuple[Tensor, Tensor, Tensor]:
    """The channels (*, H, W) of a floating-point (*, 3, H, W); raise TypeError or ValueError for anything
    else."""
    check_rgb(image, name)
    check_floating(image, name)
    return channels_of(image)


def channels_of(image: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The channels (*, H, W) of (*, 3, H, W), each a plane, even if the image is stored pixel by pixel."""
    planes = in_planes(image)
    return planes.select(-3, 0), planes.select(-3, 1), planes.select(-3, 2)


@primitive
def arranged(image: Tensor, order: List[int], fill: float) -> Tensor:
    """(*, n, H, W): the channels of (*, C, H, W) with the numbers ``order``; a number that is not a channel's
    gives a plane of ``fill``.

    >>> arranged(torch.arange(3).reshape(3, 1, 1), [2, 1, 0, -1], 9.0).flatten()
    tensor([2, 1, 0, 9])
    """
    planes: List[Tensor] = []
    for i in order:
        if 0 <= i < image.size(-3):
            planes.append(image.select(-3, i))
        else:
            planes.append(torch.full_like(image.select(-3, 0), fill))
    return torch.stack(planes, -3)


# Compiled tensor code takes the values of a frame one by one.
@arranged.lowering(
    "native",
    when=lambda image, *_: kernels.has_pixel_kernel(image) and image.dim() == 4 and interleaved(image),
)
def _arranged_pixels(image: Tensor, order: List[int], fill: float) -> Tensor:
    pixels, _ = as_pixels(image)
    numbers = torch.tensor(order, dtype=torch.int32)
    return from_pixels(kernels.arrange_pixels(pixels, numbers, image.size(1), fill), image, len(order))


@primitive
def mix_channels(image: Tensor, matrix: List[float], offset: float, name: str) -> Tensor:
    """(*, n, H, W): the channels of (*, 3, H, W) times a matrix n x 3 (row by row).

    ``offset`` is added to every channel but the first, for chroma that is stored around one half.

    >>> mix_channels(torch.ones(3, 1, 1), [0.5, 0.25, 0.0, 0.0, 0.0, 1.0], 0.5, "image").flatten()
    tensor([0.7500, 1.5000])
    """
    first, second, third = rgb_planes(image, name)
    rows = len(matrix) // 3
    planes: List[Tensor] = []
    for i in range(rows):
        plane = matrix[3 * i] * first
        if matrix[3 * i + 1] != 0.0:  # a compiler may not drop a product with zero
            plane = plane + matrix[3 * i + 1] * second
        if matrix[3 * i + 2] != 0.0:
            plane = plane + matrix[3 * i + 2] * third
        planes.append(plane + offset if i > 0 and offset != 0.0 else plane)
    return torch.stack(planes, -3)


@primitive
def mix_bytes(image: Tensor, weights: List[int], shift: int) -> Tensor:
    """Bytes (*, n, H, W), each from four ``weights``: the sum of the first three times the channels of bytes
    (*, 3, H, W), plus the fourth, divided by 2^shift, rounded down and saturated. Sums are below 2^24, exact
    in float32.

    >>> mix_bytes(torch.full((3, 1, 1), 10, dtype=torch.uint8), [1, 2, 1, 3], 2).flatten()
    tensor([10], dtype=torch.uint8)
    """
    channels = [image.select(-3, i).to(torch.float32) for i in range(3)]
    planes: List[Tensor] = []
    for i in range(len(weights) // 4):
        total = channels[0] * float(weights[4 * i]) + channels[1] * float(weights[4 * i + 1])
        total = total + channels[2] * float(weights[4 * i + 2]) + float(weights[4 * i + 3])
        planes.append(torch.floor(total * (1.0 / float(2**shift))).clamp(0.0, 255.0).to(torch.uint8))
    return torch.stack(planes, -3)


def _is_image(image: Tensor, *_: object) -> bool:
    return kernels.available(image) and image.dim() == 4


@mix_bytes.lowering("native", when=_is_image)
def _mix_bytes_kernel(image: Tensor, weights: List[int], shift: int) -> Tensor:
    rows = torch.tensor(weights, dtype=torch.int32).reshape(-1, 4)
    pixels, is_frame = as_pixels(image)
    return from_pixels(kernels.mix_pixels(pixels, rows, shift, is_frame), image, rows.size(0))


def as_pixels(image: Tensor) -> Tuple[Tensor, bool]:
    """(B, C, H, W) as (B, all values), and whether the channels of a pixel are adjacent in memory."""
    if interleaved(image):
        return image.permute(0, 2, 3, 1).flatten(1), True
    return image.flatten(1), False


def from_pixels(values: Tensor, like: Tensor, channels: int) -> Tensor:
    """A kernel's result for ``like``, as images with ``channels`` channels."""
    if interleaved(like):
        return values.unflatten(1, [like.size(2), like.size(3), channels]).permute(0, 3, 1, 2)
    return values.unflatten(1, [channels, like.size(2), like.size(3)])


@primitive
def luma_chroma(image: Tensor, weights: List[int], first: int, second: int) -> Tensor:
    """Luma and chroma of bytes (*, 3, H, W) in the order red, green, blue. Luma Y is by ``weights`` that add
    up to 2^14; chroma is 128 + ``first`` (blue - Y) and 128 + ``second`` (red - Y), with the factors in units
    of 1/2^14. Each is rounded half up and saturated.

    >>> luma_chroma(
    ...     torch.tensor([255, 0, 0], dtype=torch.uint8).reshape(3, 1, 1), [8192, 8192, 0], 8192, 8192
    ... )[:, 0, 0]
    tensor([128,  64, 192], dtype=torch.uint8)
    """
    red, green, blue = [image.select(-3, i).to(torch.float32) for i in range(3)]
    total = red * float(weights[0]) + green * float(weights[1]) + blue * float(weights[2])
    luma = torch.floor((total + 8192.0) * (1.0 / 16384.0))
    planes = [luma]
    for channel, factor in [(blue, first), (red, second)]:
        scaled = (channel - luma) * float(factor) + 2105344.0  # 128.5 * 2^14
        planes.append(torch.floor(scaled * (1.0 / 16384.0)).clamp(0.0, 255.0))
    return torch.stack(planes, -3).to(torch.uint8)


@luma_chroma.lowering("native", when=_is_image)
def _luma_chroma_kernel(image: Tensor, weights: List[int], first: int, second: int) -> Tensor:
    pixels, is_frame = as_pixels(image)
    mixed = kernels.luma_chroma_pixels(pixels, weights[0], weights[1], weights[2], first, second, is_frame)
    return from_pixels(mixed, image, 3)


@primitive
def hue_of_bytes(image: Tensor, lightness: bool) -> Tensor:
    """Hue in degrees / 2 of bytes (*, 3, H, W), then saturation and value, or lightness and saturation, 0 to
    255. Lightness is rounded half up, the others half to even.

    Quotients are of integers below 2^16: a quotient that is not a half is further from one than the rounding
    error of float32.
    """
    red, green, blue = [image.select(-3, i).to(torch.float32) for i in range(3)]
    value = torch.maximum(torch.maximum(red, green), blue)
    least = torch.minimum(torch.minimum(red, green), blue)
    chroma = value - least
    turn = torch.where(
        value == red,
        green - blue,
        torch.where(value == green, blue - red + 2.0 * chroma, red - green + 4.0 * chroma),
    )
    hue = torch.round(30.0 * turn / chroma.clamp(min=1.0))
    hue = torch.where(hue < 0.0, hue + 180.0, hue)
    total = value + least
    most = torch.minimum(total, 510.0 - total) if lightness else value
    saturation = torch.round(255.0 * chroma / most.clamp(min=1.0))
    if lightness:
        return torch.stack([hue, torch.floor((total + 1.0) * 0.5), saturation], -3).to(torch.uint8)
    return torch.stack([hue, saturation, value], -3).to(torch.uint8)


@hue_of_bytes.lowering("native", when=_is_image)
def _hue_kernel(image: Tensor, lightness: bool) -> Tensor:
    pixels, is_frame = as_pixels(image)
    return from_pixels(kernels.hue_pixels(pixels, lightness, is_frame), image, 3)


@primitive
def bytes_of_hue(image: Tensor, lightness: bool) -> Tensor:
    """The inverse of ``hue_of_bytes``: bytes of red, green and blue, rounded half up. A hue of 180 or more
    wraps around.

    A channel is an integer below 2^21, divided by 30 * 255 or by 15 * 255. A half is added to the integer, so
    that its product with the reciprocal does not fall below an integer quotient, although float32 rounds it
    by up to 2^-23 of itself.
    """
    hue, second, third = [image.select(-3, i).to(torch.float32) for i in range(3)]
    hue = torch.where(hue >= 180.0, hue - 180.0, hue)
    planes: List[Tensor] = []
    # The distance of the hue from a channel's hue, beyond a sixth of a turn; in 1/30 of a sixth, limited to 0
    # to 30.
    for part in [60.0 - (hue - 90.0).abs(), (hue - 60.0).abs() - 30.0, (hue - 120.0).abs() - 30.0]:
        away = part.clamp(0.0, 30.0)
        if lightness:
            room = third * torch.minimum(second, 255.0 - second)
            planes.append((second * 3825.0 + room * (15.0 - away) + 1912.5) * (1.0 / 3825.0))
        else:
            planes.append((third * (7650.0 - second * away) + 3825.5) * (1.0 / 7650.0))
    return torch.floor(torch.stack(planes, -3)).to(torch.uint8)


@bytes_of_hue.lowering("native", when=_is_image)
def _from_hue_kernel(image: Tensor, lightness: bool) -> Tensor:
    pixels, is_frame = as_pixels(image)
    return from_pixels(kernels.from_hue_pixels(pixels, lightness, is_frame), image, 3)


@primitive
def curved(
    image: Tensor,
    first: Tensor,
    before: List[int],
    shift_before: int,
    middle: Tensor,
    after: List[int],
    shift_after: int,
    last: Tensor,
) -> Tensor:
    """Bytes (*, 3, H, W) through tables of int32: each channel by its table of ``first`` (3, 256), then a
    mixture by ``before``, each by ``middle``, a mixture by ``after``, and each by ``last``, whose entries are
    bytes.

    A mixture is the sum of a row's first three weights times the channels, plus its fourth weight; it is
    below 2^31, divided by 2^shift, rounded down, and limited to the indices of the next table.

    >>> same, two = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], torch.arange(256, dtype=torch.int32)
    >>> x = torch.tensor([7, 8, 9], dtype=torch.uint8).reshape(3, 1, 1)
    >>> curved(x, two.repeat(3, 1), same, 0, two * 2, same, 1, 255 - two).flatten()
    tensor([248, 247, 246], dtype=torch.uint8)
    """
    channels = [entries(first[i], image.select(-3, i)) for i in range(3)]
    channels = [entries(middle, i) for i in _limited_sums(channels, before, shift_before, middle.size(0))]
    channels = [entries(last, i) for i in _limited_sums(channels, after, shift_after, last.size(0))]
    return torch.stack(channels, -3).to(torch.uint8)


def entries(table: Tensor, index: Tensor) -> Tensor:
    """The entries (*) of a table (N,) at indices (*) of any dtype."""
    return table.index_select(0, index.to(torch.int64).reshape(-1)).reshape(index.shape)


def _limited_sums(channels: List[Tensor], weights: List[int], shift: int, entries: int) -> List[Tensor]:
    """In float64, in which the sums are exact."""
    wide = [channel.to(torch.float64) for channel in channels]
    sums: List[Tensor] = []
    for i in range(3):
        total = wide[0] * float(weights[4 * i]) + wide[1] * float(weights[4 * i + 1])
        total = total + wide[2] * float(weights[4 * i + 2]) + float(weights[4 * i + 3])
        sums.append(torch.floor(total * (1.0 / float(2**shift))).clamp(0, entries - 1))
    return sums


@curved.lowering("native", when=_is_image)
def _curve_kernel(
    image: Tensor,
    first: Tensor,
    before: List[int],
    shift_before: int,
    middle: Tensor,
    after: List[int],
    shift_after: int,
    last: Tensor,
) -> Tensor:
    pixels, is_frame = as_pixels(image)
    rows = [torch.tensor(weights, dtype=torch.int32).reshape(3, 4) for weights in (before, after)]
    made = kernels.curve_pixels(
        pixels, first, rows[0], middle, rows[1], last, shift_before, shift_after, is_frame
    )
    return from_pixels(made, image, 3)


# ONNX Runtime has this kernel for float32 only.
@mix_channels.lowering("onnx", when=lambda image, *_: image.dtype == torch.float32)
def _convolution(image: Tensor, matrix: List[float], offset: float, name: str) -> Tensor:
    rgb_planes(image, name)  # for its errors
    rows = len(matrix) // 3
    bias = [0.0] + [offset for _ in range(rows - 1)]
    weight = torch.tensor(matrix, dtype=image.dtype, device=image.device).reshape(rows, 3, 1, 1)
    flat = image.reshape(-1, 3, image.size(-2), image.size(-1))
    mixed = F.conv2d(flat, weight, torch.tensor(bias, dtype=image.dtype, device=image.device))
    return mixed.reshape(list(image.shape[:-3]) + [rows, image.size(-2), image.size(-1)])
