"""Region pooling over whole pixels: maxima, and means of position-sensitive channels."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.window_sizes import positive_pair
from ..primitives.geometry.regions import (
    box_maxima,
    box_means,
    check_bin_channels,
    checked_regions,
    image_numbers,
    scaled_sides,
    whole,
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
    bin with NaN is NaN. Except natively, the op takes memory for K * C * PH * W values, and for log2(H)
    copies of the input (in exports 16, so that H is at most 32768). There are gradients with respect to the
    input; equal maxima share them.

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
    height, width = input.size(2), input.size(3)
    across, down = scaled_sides(input, boxes, spatial_scale)
    left, right = _whole_bins(across, bin_columns, 1.0)
    top, bottom = _whole_bins(down, bin_rows, 1.0)
    left, right = to_index(left, width + 1), to_index(right, width + 1)
    top, bottom = to_index(top, height + 1), to_index(bottom, height + 1)
    return box_maxima(input, image_numbers(input, boxes), top, bottom, left, right)


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
    last row and column, as in torchvision; it is 0 if it touches none. Except natively, sums are differences
    of a summed-area table in float64: the input must be finite, and a value 1e10 times as large as those of a
    bin spoils the bin's mean, even if it is outside. There are gradients with respect to the input.

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
    height, width = input.size(2), input.size(3)
    across, down = scaled_sides(input, boxes, spatial_scale)
    left, right = _whole_bins(across, bin_columns, 0.0)
    top, bottom = _whole_bins(down, bin_rows, 0.0)
    left, right = to_index(left, width), to_index(right, width)
    top, bottom = to_index(top, height), to_index(bottom, height)
    return box_means(
        input.unflatten(1, [input.size(1) // (bin_rows * bin_columns), bin_rows * bin_columns]),
        image_numbers(input, boxes),
        top,
        bottom,
        left,
        right,
    )


def _whole_bins(sides: Tensor, bins: int, ends: float) -> Tuple[Tensor, Tensor]:
    """The start and the end of the ``bins`` bins of boxes whose sides are (K, 2): (K, bins), in whole pixels;
    ``ends`` is 1 if the last pixel belongs to a box, otherwise 0."""
    rounded = whole(sides)
    first, last = rounded[:, :1], rounded[:, 1:]
    # The quotient is computed first, as in torchvision, for the same rounding.
    size = (last - first + ends).clamp(min=1.0) / bins
    number = torch.arange(bins, device=sides.device).to(sides.dtype)
    return torch.floor(number * size) + first, torch.ceil((number + 1.0) * size) + first
