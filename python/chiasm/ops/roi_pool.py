"""Region pooling over whole pixels: maxima, and means of position-sensitive channels."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.window_sizes import positive_pair
from ..primitives.filters.integral import integral
from ..primitives.geometry.regions import (
    check_bin_channels,
    checked_regions,
    image_numbers,
    scaled_sides,
    whole,
    window_maxima,
)
from ..primitives.numbers.rounding import to_index


def roi_pool(
    input: Tensor,
    boxes: Union[Tensor, List[Tensor]],
    output_size: Union[int, Tuple[int, int]],
    spatial_scale: float = 1.0,
) -> Tensor:
    """RoIPool: the maxima of the pixels in the bins of boxes.

    R. Girshick, Fast R-CNN, ICCV 2015. Corners are rounded to pixels (halves away from zero), and both corner
    pixels belong to the box. A bin contains all pixels that it touches; a bin that touches no pixel is 0, a
    bin with NaN is NaN. The op takes memory for K * C * PH * W values, and for log2(H) copies of the input
    (in exports 16, so that H is at most 32768). There are gradients with respect to the input; equal maxima
    share them.

    Args:
        input: (B, C, H, W), floating point.
        boxes: (K, 5) as image index, x1, y1, x2, y2, floating point. An index outside the batch is clamped.
            Or a list of the boxes (L, 4) of each image, which exported ops do not take.
        output_size: the numbers PH and PW of rows and columns of bins, or one number for both.
        spatial_scale: the factor from the boxes' coordinates to pixels of the input.

    Returns:
        (K, C, PH, PW).

    Raises:
        TypeError: if input or boxes is not floating point.
        ValueError: if input is not (B, C, H, W), boxes not (K, 5), or output_size not positive.

    Example:
        >>> image = torch.arange(16.0).reshape(1, 1, 4, 4)
        >>> roi_pool(image, torch.tensor([[0.0, 0.0, 0.0, 3.0, 3.0]]), 2)
        tensor([[[[ 5.,  7.],
                  [13., 15.]]]])
    """
    boxes = checked_regions(input, boxes)
    bin_rows, bin_columns = positive_pair(output_size, "output_size")
    count, channels, height, width = boxes.size(0), input.size(1), input.size(2), input.size(3)
    across, down = scaled_sides(input, boxes, spatial_scale)
    left, right = _whole_bins(across, bin_columns, 1.0)
    top, bottom = _whole_bins(down, bin_rows, 1.0)
    left, right = to_index(left, width + 1), to_index(right, width + 1)
    top, bottom = to_index(top, height + 1), to_index(bottom, height + 1)
    # For an empty bin some row is read, and ignored below.
    first = top.clamp(max=height - 1).flatten()
    image = image_numbers(input, boxes)[:, None].expand(-1, bin_rows).flatten()
    rows = window_maxima(
        input.permute(0, 2, 1, 3).flatten(2), image, first, torch.maximum(bottom.flatten(), first + 1)
    )
    rows = rows.reshape(count, bin_rows, channels, width)
    column = torch.arange(width, device=input.device)
    lowest = torch.full_like(rows[:, :, :, :1], float("-inf"))
    maxima: List[Tensor] = []
    for q in range(bin_columns):
        inside = (column >= left[:, q : q + 1]) & (column < right[:, q : q + 1])
        maxima.append(torch.where(inside[:, None, None], rows, lowest).amax(-1))
    filled = (bottom > top)[:, :, None] & (right > left)[:, None]
    pooled = torch.stack(maxima, -1).transpose(1, 2)
    return torch.where(filled[:, None], pooled, torch.zeros_like(pooled))


def ps_roi_pool(
    input: Tensor,
    boxes: Union[Tensor, List[Tensor]],
    output_size: Union[int, Tuple[int, int]],
    spatial_scale: float = 1.0,
) -> Tensor:
    """Position-sensitive RoIPool: the means of the pixels in the bins of boxes; each bin has its own
    channels.

    J. Dai et al., R-FCN, NIPS 2016. Channel (c * PH + i) * PW + j is channel c of bin (i, j). Corners are
    rounded to pixels (halves away from zero). A bin contains all pixels that it touches, except the input's
    last row and column, as in torchvision; it is 0 if it touches none. Sums are differences of a summed-area
    table in float64, so the input must be finite. There are gradients with respect to the input.

    Args:
        input: (B, C * PH * PW, H, W), floating point.
        boxes: (K, 5) as image index, x1, y1, x2, y2, floating point. An index outside the batch is clamped.
            Or a list of the boxes (L, 4) of each image, which exported ops do not take.
        output_size: the numbers PH and PW of rows and columns of bins, or one number for both.
        spatial_scale: the factor from the boxes' coordinates to pixels of the input.

    Returns:
        (K, C, PH, PW).

    Raises:
        TypeError: if input or boxes is not floating point.
        ValueError: if input is not (B, C * PH * PW, H, W), boxes not (K, 5), or output_size not positive.

    Example:
        >>> image = torch.arange(4.0)[None, :, None, None].expand(1, 4, 5, 5)
        >>> ps_roi_pool(image, torch.tensor([[0.0, 0.0, 0.0, 4.0, 4.0]]), 2)
        tensor([[[[0., 1.],
                  [2., 3.]]]])
    """
    boxes = checked_regions(input, boxes)
    bin_rows, bin_columns = positive_pair(output_size, "output_size")
    check_bin_channels(input, bin_rows, bin_columns)
    count, height, width = boxes.size(0), input.size(2), input.size(3)
    channels = input.size(1) // (bin_rows * bin_columns)
    across, down = scaled_sides(input, boxes, spatial_scale)
    left, right = _whole_bins(across, bin_columns, 0.0)
    top, bottom = _whole_bins(down, bin_rows, 0.0)
    left, right = to_index(left, width)[:, None], to_index(right, width)[:, None]
    top, bottom = to_index(top, height)[:, :, None], to_index(bottom, height)[:, :, None]
    # A row and a column of zeros before the first, so that each sum is computed from four corners.
    padded = torch.nn.functional.pad(input.to(torch.float64), [1, 0, 1, 0])
    table = integral(padded).unflatten(1, [channels, bin_rows * bin_columns]).transpose(0, 1)
    flat = table.reshape(channels, input.size(0) * bin_rows * bin_columns * (height + 1) * (width + 1))
    place = torch.arange(bin_rows * bin_columns, device=input.device).reshape(bin_rows, bin_columns)
    plane = image_numbers(input, boxes)[:, None, None] * (bin_rows * bin_columns) + place
    total = torch.zeros([1], dtype=flat.dtype, device=flat.device)
    for y, x, sign in [(bottom, right, 1.0), (top, right, -1.0), (bottom, left, -1.0), (top, left, 1.0)]:
        index = (plane * (height + 1) + y) * (width + 1) + x
        total = total + sign * flat.gather(1, index.reshape(1, -1).expand(channels, -1))
    area = ((bottom - top) * (right - left)).clamp(min=0)
    mean = total.reshape(channels, count, bin_rows, bin_columns) / area.clamp(min=1)
    return torch.where(area > 0, mean, torch.zeros_like(mean)).transpose(0, 1).to(input.dtype)


def _whole_bins(sides: Tensor, bins: int, ends: float) -> Tuple[Tensor, Tensor]:
    """The start and the end of the ``bins`` bins of boxes whose sides are (K, 2): (K, bins), in whole pixels;
    ``ends`` is 1 if the last pixel belongs to a box, otherwise 0."""
    rounded = whole(sides)
    first, last = rounded[:, :1], rounded[:, 1:]
    # The quotient is computed first, as in torchvision, for the same rounding.
    size = (last - first + ends).clamp(min=1.0) / bins
    number = torch.arange(bins, device=sides.device).to(sides.dtype)
    return torch.floor(number * size) + first, torch.ceil((number + 1.0) * size) + first
