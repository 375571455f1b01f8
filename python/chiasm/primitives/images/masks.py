"""Masks of integer pixels: those in a range, masked pixels, and both sides of a threshold."""

from typing import Optional

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows, in_planes
from ..core.lowering import primitive
from ..core.pixels import has_words, one_or_per_sample, pixel_range, saturated
from ..kernels import operators as kernels
from ..numbers.rounding import known_or
from .color_planes import as_pixels, from_pixels
from .tables import table_entries


@primitive
def mask_in_range(x: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """(B, 1, H, W), bytes: 255 where all channels of (B, C, H, W), integers of 8 or 16 bits, are from ``low``
    to ``high``, else 0. The bounds are float32, (C, 1, 1) or (B, C, 1, 1); they need not be integers, nor in
    the range of the pixels."""
    if x.dtype != torch.uint8:
        levels = in_planes(x).to(torch.float32)
        within = ((levels >= low) & (levels <= high)).to(torch.float32)
        return (255.0 * within.amin(1, keepdim=True)).to(torch.uint8)
    level = torch.arange(256, device=x.device).to(torch.float32)
    tables = ((level >= low) & (level <= high)).to(torch.uint8) * 255
    planes = in_planes(x)
    rows = tables.expand(x.size(0), x.size(1), 1, 256).reshape(-1, 256)
    inside = table_entries(planes.flatten(2).flatten(0, 1), rows).reshape(planes.shape)
    return inside.to(torch.float32).amin(1, keepdim=True).to(torch.uint8)


@mask_in_range.lowering("native", when=kernels.available)
def _in_range_kernel(x: Tensor, low: Tensor, high: Tensor) -> Tensor:
    pixels, is_frame = as_pixels(x)
    first, last = pixel_range(x)
    least = known_or(torch.ceil(low), last + 1.0).clamp(first, last + 1).to(torch.int32)
    most = known_or(torch.floor(high), first - 1.0).clamp(first - 1, last).to(torch.int32)
    least, most = least.reshape(-1, x.size(1)), most.reshape(-1, x.size(1))
    sets = torch.broadcast_shapes([least.size(0)], [most.size(0)])[0]
    least, most = least.expand(sets, -1), most.expand(sets, -1)
    mask = kernels.in_range(pixels, least.contiguous(), most.contiguous(), is_frame)
    return mask.unflatten(1, [1, x.size(2), x.size(3)])


@primitive
def masked_pixels(x: Tensor, mask: Tensor) -> Tensor:
    """Integers of 8 or 16 bits (B, C, H, W) where a mask (B, 1, H, W) of bytes is 255, and 0 where it is 0.

    >>> x, mask = torch.tensor([[[[-300, 5]]]], dtype=torch.int16), torch.tensor([[[[255, 0]]]])
    >>> masked_pixels(x, mask.to(torch.uint8))
    tensor([[[[-300,    0]]]], dtype=torch.int16)
    """
    if x.dtype == torch.uint8:
        return x & mask
    return torch.where(mask > 0, x.to(torch.int32), torch.zeros_like(mask, dtype=torch.int32)).to(x.dtype)


@masked_pixels.lowering("native", when=kernels.available)
def _masked_pixels_kernel(x: Tensor, mask: Tensor) -> Tensor:
    pixels, is_frame = as_pixels(x)
    return from_pixels(kernels.masked_pixels(pixels, mask.flatten(1), is_frame), x, x.size(1))


@primitive
def split_at(x: Tensor, limit: Tensor, above: Optional[Tensor], below: Optional[Tensor]) -> Tensor:
    """16 bits (B, *): ``above`` where x is above a limit, elsewhere ``below``; None stands for x. The others
    are int32, broadcast against x, and are saturated.

    >>> split_at(torch.tensor([[3, 7, 9]], dtype=torch.int16), torch.tensor([5]), torch.tensor([6]), None)
    tensor([[3, 6, 6]], dtype=torch.int16)
    """
    pixels = x.to(torch.int32)
    high = pixels if above is None else above
    low = pixels if below is None else below
    return saturated(torch.where(pixels > limit, high, low), x)


def _splits_samples(x: Tensor, limit: Tensor, above: Optional[Tensor], below: Optional[Tensor]) -> bool:
    """Whether a kernel takes x, and each limit is one number, or one for each sample."""
    limits = [each for each in (limit, above, below) if each is not None]
    return has_words(x) and x.dim() > 1 and one_or_per_sample(x, *limits)


@split_at.lowering("native", when=_splits_samples)
def _split_kernel(x: Tensor, limit: Tensor, above: Optional[Tensor], below: Optional[Tensor]) -> Tensor:
    none = torch.zeros([1], dtype=torch.int32)
    limits = [none if each is None else each.to(torch.int32).reshape(-1) for each in (limit, above, below)]
    together = torch.stack(torch.broadcast_tensors(*limits), 1)
    rows = as_rows(x)[0] if x.dim() == 4 else x
    made = kernels.split_at(rows.flatten(1), together, above is None, below is None).reshape(rows.shape)
    return from_rows(made, x) if x.dim() == 4 else made
