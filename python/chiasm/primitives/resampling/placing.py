"""Letterboxes and crops: parts of images of bytes, resized and placed in images of one size."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.layout import as_rows, in_planes, interleaved
from ..core.lowering import primitive
from ..filters.fixed_point import rounded_sums
from ..images.color_planes import as_pixels
from ..kernels import operators as kernels
from .resizing import resampled_bytes, weighted_means
from .taps import covered_pixels, filter_radius, filter_weights


@primitive
def placed_bytes(x: Tensor, images: Tensor, boxes: Tensor, height: int, width: int, pad: int) -> Tensor:
    """Bytes (M, C, height, width), each with a part of one image, resized like `resized_bytes`, and ``pad``
    around it. ``images`` (M,), int64, has the number of each image in the bytes (B, C, H, W).

    ``boxes`` (M, 8), int64: left, top, width and height of the part to read, then of its place in the output.
    Either may reach beyond an image; outside, the pixels at the image's edge are read.

    >>> x = torch.tensor([[1, 2], [3, 4]], dtype=torch.uint8)[None, None]
    >>> placed_bytes(
    ...     x, torch.zeros(1, dtype=torch.int64), torch.tensor([[1, 0, 1, 2, 0, 1, 3, 2]]), 3, 4, 9
    ... )
    tensor([[[[9, 9, 9, 9],
              [2, 2, 2, 9],
              [4, 4, 4, 9]]]], dtype=torch.uint8)
    """
    limited = boxes.clamp(-16777216, 16777216)  # so that positions are integers that are exact in float64
    top, bottom, down, rows = _window(x.size(2), height, limited[:, 1::2])
    left, right, across, columns = _window(x.size(3), width, limited[:, 0::2])
    image = x.index_select(0, images).to(torch.float32)
    down, across = down[:, None, :, None], across[:, None, None]
    tall = [images.size(0), x.size(1), height, x.size(3)]
    both = _picked(image, top, 2, tall) * (256.0 - down) + _picked(image, bottom, 2, tall) * down
    whole = [images.size(0), x.size(1), height, width]
    sums = _picked(both, left, 3, whole) * (256.0 - across) + _picked(both, right, 3, whole) * across
    inside = rows[:, None, :, None] & columns[:, None, None]
    return torch.where(inside, rounded_sums(sums), torch.full_like(x[:1, :1, :1, :1], pad))


def _picked(x: Tensor, index: Tensor, dim: int, shape: List[int]) -> Tensor:
    spread = index[:, None, :, None] if dim == 2 else index[:, None, None]
    return x.gather(dim, spread.expand(shape))


def _window(in_size: int, out_size: int, box: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """For each pixel of the outputs (M, out_size): its two neighbours, the second's weight in 1/256, and
    whether it is in the window. ``box`` (M, 4) has the begin and size of the part to read, and of its
    place."""
    begin, count, to, length = [box[:, i : i + 1].to(torch.float64) for i in range(4)]
    some = (count >= 1.0) & (length >= 1.0)
    count, length = count.clamp(min=1.0), length.clamp(min=1.0)
    i = torch.arange(out_size, device=box.device).to(torch.float64) - to
    numerator = ((2.0 * i + 1.0) * count - length).clamp(min=0.0)
    denominator = 2.0 * length
    whole = torch.minimum(torch.floor(numerator / denominator), count - 1.0)
    rest = numerator - whole * denominator
    weight = torch.floor((512.0 * rest + denominator) / (2.0 * denominator))
    weight = torch.where(whole == count - 1.0, torch.zeros_like(weight), weight)
    first = (begin + whole).clamp(0, in_size - 1).to(torch.int64)
    second = (begin + whole + 1.0).clamp(0, in_size - 1).to(torch.int64)
    weight = torch.where(first == second, torch.zeros_like(weight), weight)
    return first, second, weight.to(torch.float32), some & (i >= 0.0) & (i < length)


@placed_bytes.lowering("native", when=kernels.available)
def _placed_kernel(x: Tensor, images: Tensor, boxes: Tensor, height: int, width: int, pad: int) -> Tensor:
    if not interleaved(x):
        # The kernel takes each plane as a separate image.
        planes = torch.arange(x.size(1), device=x.device)
        numbers = (images[:, None] * x.size(1) + planes).flatten()
        each = boxes[:, None].expand(-1, x.size(1), -1).flatten(0, 1)
        made = kernels.placed_bytes(x.flatten(0, 1), numbers, each, height, width, 1, pad)
        return made.unflatten(0, [images.size(0), x.size(1)])
    rows, step = as_rows(x)
    made = kernels.placed_bytes(rows, images, boxes, height, width, step, pad)
    return made.unflatten(2, [width, step]).permute(0, 3, 1, 2)


def placed_filtered(
    x: Tensor,
    box: Tensor,
    least: Tuple[int, int],
    height: int,
    width: int,
    pad: float,
    interpolation: str,
    antialias: bool,
) -> Tensor:
    """All of each image (B, C, H, W), resized by a filter and placed in (B, C, height, width), with ``pad``
    around it: bytes of bytes, levels in float32 of uint16.

    ``box`` (4,), int64: left, top, width and height of the place, which may reach beyond the output.
    ``least``: numbers that the place's height and width are not below; the count of the filter's taps follows
    from them, because a size cannot follow from a tensor. ``interpolation`` is "bilinear" or "area", with
    ``antialias`` also "bicubic" or "lanczos".

    >>> x = torch.tensor([10, 20, 30, 40], dtype=torch.uint8).reshape(1, 1, 1, 4)
    >>> placed_filtered(x, torch.tensor([1, 0, 2, 1]), (1, 2), 1, 4, 9.0, "area", False)
    tensor([[[[ 9, 15, 35,  9]]]], dtype=torch.uint8)
    """
    to = box.to(torch.float64)
    rows, down = _filter(x.size(2), height, to[1::2], least[0], interpolation, antialias)
    columns, across = _filter(x.size(3), width, to[0::2], least[1], interpolation, antialias)
    if x.dtype == torch.uint8:
        steps = 4194304.0
        made = resampled_bytes(x, rows, torch.round(down * steps), columns, torch.round(across * steps))
    else:
        one = torch.ones([1], dtype=torch.float64, device=x.device)
        if interpolation == "area":
            # The parts are whole numbers, which add up to the axis's size.
            down, across = torch.round(down * x.size(2)), torch.round(across * x.size(3))
            total = one * x.size(2) * x.size(3)
        else:
            # Sums of 16 bits by weights in 1/2^18 are exact.
            down, across = _whole_weights(down, 262144.0), _whole_weights(across, 262144.0)
            total = one * 68719476736.0
        made = in_planes(weighted_means(x, rows, down, columns, across, total)).to(torch.float32)
    return filled_beside(made, box, pad)


def _whole_weights(weight: Tensor, steps: float) -> Tensor:
    """Weights (n, taps), whose rows add up to 1 or 0, in units of 1 / ``steps``. The partial sums are
    rounded, so that rows add up to ``steps``, and a weight of 0 stays 0.

    >>> _whole_weights(torch.tensor([[0.3, 0.3, 0.0, 0.4]]), 2.0)
    tensor([[1., 0., 0., 1.]])
    """
    sums = torch.round(steps * weight.cumsum(1))
    return torch.cat([sums[:, :1], sums[:, 1:] - sums[:, : sums.size(1) - 1]], 1)


@primitive
def filled_beside(x: Tensor, box: Tensor, pad: float) -> Tensor:
    """Images (B, C, H, W) with ``pad`` wherever a pixel is not in ``box`` (4,): left, top, width, height.

    >>> filled_beside(torch.zeros(1, 1, 1, 4), torch.tensor([1, 0, 2, 1]), 7.0)
    tensor([[[[7., 0., 0., 7.]]]])
    """
    inside = _inside(x.size(2), box[1::2])[:, None] & _inside(x.size(3), box[0::2])
    return torch.where(inside, x, torch.full([1], pad, dtype=x.dtype, device=x.device))


def _inside(size: int, place: Tensor) -> Tensor:
    i = torch.arange(size, device=place.device) - place[:1]
    return (i >= 0) & (i < place[1:])


# Compiled tensor code takes the values of a frame one by one.
@filled_beside.lowering("native", when=lambda x, *_: kernels.available(x) and x.dtype == torch.uint8)
def _filled_kernel(x: Tensor, box: Tensor, pad: float) -> Tensor:
    images = torch.arange(x.size(0), device=x.device)
    boxes = torch.cat([box, box])[None].expand(x.size(0), -1)
    return placed_bytes(x, images, boxes, x.size(2), x.size(3), int(pad))


def _filter(
    in_size: int, out_size: int, place: Tensor, least: int, interpolation: str, antialias: bool
) -> Tuple[Tensor, Tensor]:
    """For each pixel of an axis of the output: indices and weights (out_size, taps), in float64. The image
    comes to ``place`` (2,), a begin and a size. Outside, weights are 0."""
    begin, length = place[:1], place[1:]
    i = torch.arange(out_size, device=place.device).to(torch.float64) - begin
    reduction = (in_size + least - 1) // least
    if interpolation == "area":
        index, parts = covered_pixels(i, length, in_size, reduction + 1)
        weight = parts / in_size
    else:
        factor = in_size / length
        stretch = factor.clamp(min=1.0) if antialias else torch.ones_like(factor)
        taps = 2 * filter_radius(interpolation) * reduction + 2 if antialias else 2
        index, weight = filter_weights(i, factor, stretch, in_size, taps, interpolation)
    inside = _inside(out_size, place)
    return index, torch.where(inside[:, None], weight, torch.zeros_like(weight))


@primitive
def scaled_bytes(x: Tensor, order: List[int], scale: List[float], offset: List[float]) -> Tensor:
    """(B, n, H, W), float32: the channels of bytes (B, C, H, W) with the numbers ``order``, each times its
    ``scale`` plus its ``offset``. Also of other numbers, for which there is no kernel.

    >>> x = torch.tensor([10, 20, 30], dtype=torch.uint8).reshape(1, 3, 1, 1)
    >>> scaled_bytes(x, [2, 0], [0.5, 2.0], [0.0, 1.0]).flatten()
    tensor([15., 21.])
    """
    planes: List[Tensor] = []
    for i, channel in enumerate(order):
        planes.append(x.select(-3, channel).to(torch.float32) * scale[i] + offset[i])
    return torch.stack(planes, -3)


@scaled_bytes.lowering("native", when=lambda x, *_: kernels.available(x) and x.dtype == torch.uint8)
def _scaled_kernel(x: Tensor, order: List[int], scale: List[float], offset: List[float]) -> Tensor:
    pixels, is_frame = as_pixels(x)
    numbers = torch.tensor(order, dtype=torch.int32)
    by = torch.tensor([scale, offset], dtype=torch.float32).t().contiguous()
    made = kernels.scaled_bytes(pixels, numbers, by, x.size(1), is_frame)
    return made.unflatten(2, [x.size(2), x.size(3)])
