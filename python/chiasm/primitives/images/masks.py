"""Masks of bytes: pixels in a range, and masked pixels."""

import torch
from torch import Tensor

from ..core.layout import in_planes
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .color_planes import as_pixels, from_pixels
from .tables import table_entries


@primitive
def mask_in_range(x: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """(B, 1, H, W): 255 where all channels of bytes (B, C, H, W) are from ``low`` to ``high``, else 0. The
    bounds are float32, (C, 1, 1) or (B, C, 1, 1); they need not be integers, nor in the range of bytes."""
    level = torch.arange(256, device=x.device).to(torch.float32)
    tables = ((level >= low) & (level <= high)).to(torch.uint8) * 255
    planes = in_planes(x)
    rows = tables.expand(x.size(0), x.size(1), 1, 256).reshape(-1, 256)
    inside = table_entries(planes.flatten(2).flatten(0, 1), rows).reshape(planes.shape)
    return inside.to(torch.float32).amin(1, keepdim=True).to(torch.uint8)


@mask_in_range.lowering("native", when=kernels.available)
def _in_range_kernel(x: Tensor, low: Tensor, high: Tensor) -> Tensor:
    pixels, is_frame = as_pixels(x)
    least = known_or(torch.ceil(low), 256.0).clamp(0.0, 256.0).to(torch.int32).reshape(-1, x.size(1))
    most = known_or(torch.floor(high), -1.0).clamp(-1.0, 255.0).to(torch.int32).reshape(-1, x.size(1))
    sets = torch.broadcast_shapes([least.size(0)], [most.size(0)])[0]
    least, most = least.expand(sets, -1), most.expand(sets, -1)
    mask = kernels.in_range(pixels, least.contiguous(), most.contiguous(), is_frame)
    return mask.unflatten(1, [1, x.size(2), x.size(3)])


@primitive
def masked_pixels(x: Tensor, mask: Tensor) -> Tensor:
    """Bytes (B, C, H, W), with only the bits that are set in a mask (B, 1, H, W)."""
    return x & mask


@masked_pixels.lowering("native", when=kernels.available)
def _masked_pixels_kernel(x: Tensor, mask: Tensor) -> Tensor:
    pixels, is_frame = as_pixels(x)
    return from_pixels(kernels.masked_pixels(pixels, mask.flatten(1), is_frame), x, x.size(1))
