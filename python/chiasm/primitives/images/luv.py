"""CIE L*u*v*: the parts that conversions of floats and of bytes share, and the conversions of bytes."""

from typing import List

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .color_planes import as_pixels, channels_of, entries, from_pixels, mix_channels


@primitive
def luv_of_bytes(image: Tensor, light: Tensor, matrix: List[float], curve: Tensor) -> Tensor:
    """Bytes L* 2.55, (u* + 134) 255 / 354 and (v* + 140) 255 / 262 from red, green and blue (*, 3, H, W),
    rounded half up.

    ``light`` (256,) has the linear light of each byte, which ``matrix`` (row by row) converts to X, Y and Z:
    integers that are exact in float64. L* is the entry of the ``curve`` nearest to Y / 2^22.
    """
    red, green, blue = [entries(light, channel) for channel in channels_of(image)]
    x = red * matrix[0] + green * matrix[1] + blue * matrix[2]
    y = red * matrix[3] + green * matrix[4] + blue * matrix[5]
    z = red * matrix[6] + green * matrix[7] + blue * matrix[8]
    lightness = entries(curve, torch.floor(y / 4194304.0 + 0.5))
    # One quotient and a few products follow; each is rounded, in this order.
    weight = (x + 15.0 * y + 3.0 * z).clamp(min=1.0)
    scale = 13.0 * lightness
    # Minus the quotients of white, which greys match to the last digit.
    white_x, white_y = matrix[0] + matrix[1] + matrix[2], matrix[3] + matrix[4] + matrix[5]
    white = white_x + 15.0 * white_y + 3.0 * (matrix[6] + matrix[7] + matrix[8])
    u = scale * (4.0 * x / weight - 4.0 * white_x / white)
    v = scale * (9.0 * y / weight - 9.0 * white_y / white)
    made = torch.stack([lightness * 2.55, (u + 134.0) * (255.0 / 354.0), (v + 140.0) * (255.0 / 262.0)], -3)
    return torch.floor(made + 0.5).clamp(0.0, 255.0).to(torch.uint8)


def _is_image(image: Tensor, *_: object) -> bool:
    return kernels.available(image) and image.dim() == 4


@luv_of_bytes.lowering("native", when=_is_image)
def _luv_kernel(image: Tensor, light: Tensor, matrix: List[float], curve: Tensor) -> Tensor:
    pixels, is_frame = as_pixels(image)
    made = kernels.luv_pixels(pixels, light, _rows(matrix), curve, is_frame)
    return from_pixels(made, image, 3)


def _rows(matrix: List[float]) -> Tensor:
    return torch.tensor(matrix, dtype=torch.float64).reshape(3, 3)


def linear_of_luv(
    lightness: Tensor, y: Tensor, u: Tensor, v: Tensor, matrix: List[float], eps: float
) -> Tensor:
    """X, Y and Z of lightness, for which Y is known, and u* and v*, mixed by ``matrix``. |v* + 13 L* v'| (v'
    of white) up to ``eps`` counts as black."""
    # 13 L u' and 13 L v': only their ratios count, so there is no division by L.
    up = u + 2.571912227675923 * lightness
    vp = v + 6.088448610215335 * lightness
    dark = vp.abs() <= eps
    ratio = torch.where(dark, torch.zeros_like(y), y / torch.where(dark, torch.ones_like(vp), vp))
    x = 2.25 * up * ratio
    z = (39.0 * lightness - 0.75 * up) * ratio - 5.0 * y
    return mix_channels(torch.stack([x, y, z], -3), matrix, 0.0, "image")


@primitive
def bytes_of_luv(
    image: Tensor, lightness: Tensor, luminance: Tensor, matrix: List[float], curve: Tensor, eps: float
) -> Tensor:
    """The inverse of ``luv_of_bytes``: bytes (*, 3, H, W), the entries of ``curve`` that are nearest to the
    linear light times 2^14. The L* and Y of each byte are ``lightness`` and ``luminance`` (256,)."""
    first, second, third = channels_of(image)
    u = second.to(torch.float64) * (354.0 / 255.0) - 134.0
    v = third.to(torch.float64) * (262.0 / 255.0) - 140.0
    linear = linear_of_luv(entries(lightness, first), entries(luminance, first), u, v, matrix, eps)
    return entries(curve, torch.floor(linear.clamp(0.0, 1.0) * 16384.0 + 0.5))


@bytes_of_luv.lowering("native", when=_is_image)
def _bytes_kernel(
    image: Tensor, lightness: Tensor, luminance: Tensor, matrix: List[float], curve: Tensor, eps: float
) -> Tensor:
    pixels, is_frame = as_pixels(image)
    made = kernels.from_luv_pixels(pixels, lightness, luminance, _rows(matrix), curve, eps, is_frame)
    return from_pixels(made, image, 3)
