"""Colour planes: an image as three planes, and linear mixtures of them.

Arithmetic on explicit planes, joined by ``torch.stack``, is what AOTInductor vectorises; ONNX Runtime is
fastest with a 1x1 convolution, because it does not fuse.
"""

from typing import List, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.checks import check_floating, check_rgb
from ..core.layout import in_planes, interleaved
from ..core.lowering import primitive
from ..kernels import operators as kernels


def check_channels(image: Tensor, channels: int, name: str) -> None:
    """Raise ValueError unless ``image`` is (*, channels, H, W)."""
    if image.dim() < 3 or image.size(-3) != channels:
        raise ValueError(f"{name}: expected shape (*, {channels}, H, W), got {list(image.shape)}")


def rgb_planes(image: Tensor, name: str) -> Tuple[Tensor, Tensor, Tensor]:
    """The channels (*, H, W) of a floating-point (*, 3, H, W); raise TypeError or ValueError for anything
    else."""
    check_rgb(image, name)
    check_floating(image, name)
    return channels_of(image)


def channels_of(image: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The channels (*, H, W) of (*, 3, H, W), each a plane also where a frame is stored pixel by pixel."""
    planes = in_planes(image)
    return planes.select(-3, 0), planes.select(-3, 1), planes.select(-3, 2)


@primitive
def mix_channels(image: Tensor, matrix: List[float], offset: float, name: str) -> Tensor:
    """(*, n, H, W): the channels of (*, 3, H, W) times a matrix n x 3 (row by row).

    ``offset`` is added to every channel but the first: chroma that is stored around one half.

    >>> mix_channels(torch.ones(3, 1, 1), [0.5, 0.25, 0.0, 0.0, 0.0, 1.0], 0.5, "image").flatten()
    tensor([0.7500, 1.5000])
    """
    first, second, third = rgb_planes(image, name)
    rows = len(matrix) // 3
    planes: List[Tensor] = []
    for i in range(rows):
        plane = matrix[3 * i] * first
        if matrix[3 * i + 1] != 0.0:  # compilers may not drop a product with zero
            plane = plane + matrix[3 * i + 1] * second
        if matrix[3 * i + 2] != 0.0:
            plane = plane + matrix[3 * i + 2] * third
        planes.append(plane + offset if i > 0 and offset != 0.0 else plane)
    return torch.stack(planes, -3)


@primitive
def mix_bytes(image: Tensor, weights: List[int], shift: int) -> Tensor:
    """Bytes (*, n, H, W): of each four ``weights`` the first three times the channels of bytes (*, 3, H, W),
    plus the fourth, over 2^shift, rounded down and saturated. Sums are below 2^24, which float32 holds.

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
    pixels, is_frame = _as_pixels(image)
    return _from_pixels(kernels.mix_pixels(pixels, rows, shift, is_frame), image, rows.size(0))


def _as_pixels(image: Tensor) -> Tuple[Tensor, bool]:
    """(B, C, H, W) as (B, all values), and whether its channels lie next to each other."""
    if interleaved(image):
        return image.permute(0, 2, 3, 1).flatten(1), True
    return image.flatten(1), False


def _from_pixels(values: Tensor, like: Tensor, channels: int) -> Tensor:
    """Images of so many channels of what a kernel made of ``like``."""
    if interleaved(like):
        return values.unflatten(1, [like.size(2), like.size(3), channels]).permute(0, 3, 1, 2)
    return values.unflatten(1, [channels, like.size(2), like.size(3)])


@primitive
def hsv_of_bytes(image: Tensor) -> Tensor:
    """Hue in degrees / 2, saturation and value, 0 to 255, of bytes (*, 3, H, W); rounded halves to even.

    Quotients are of whole numbers below 2^16: those that are no halves are further from them than float32
    rounds.
    """
    red, green, blue = [image.select(-3, i).to(torch.float32) for i in range(3)]
    value = torch.maximum(torch.maximum(red, green), blue)
    chroma = value - torch.minimum(torch.minimum(red, green), blue)
    turn = torch.where(
        value == red,
        green - blue,
        torch.where(value == green, blue - red + 2.0 * chroma, red - green + 4.0 * chroma),
    )
    hue = torch.round(30.0 * turn / chroma.clamp(min=1.0))
    saturation = torch.round(255.0 * chroma / value.clamp(min=1.0))
    return torch.stack([torch.where(hue < 0.0, hue + 180.0, hue), saturation, value], -3).to(torch.uint8)


@hsv_of_bytes.lowering("native", when=_is_image)
def _hsv_kernel(image: Tensor) -> Tensor:
    pixels, is_frame = _as_pixels(image)
    return _from_pixels(kernels.hsv_pixels(pixels, is_frame), image, 3)


# ONNX Runtime has this kernel for float32 alone.
@mix_channels.lowering("onnx", when=lambda image, *_: image.dtype == torch.float32)
def _convolution(image: Tensor, matrix: List[float], offset: float, name: str) -> Tensor:
    rgb_planes(image, name)  # for its errors
    rows = len(matrix) // 3
    bias = [0.0] + [offset for _ in range(rows - 1)]
    weight = torch.tensor(matrix, dtype=image.dtype, device=image.device).reshape(rows, 3, 1, 1)
    flat = image.reshape(-1, 3, image.size(-2), image.size(-1))
    mixed = F.conv2d(flat, weight, torch.tensor(bias, dtype=image.dtype, device=image.device))
    return mixed.reshape(list(image.shape[:-3]) + [rows, image.size(-2), image.size(-1)])
