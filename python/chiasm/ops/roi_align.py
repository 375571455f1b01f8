"""Region pooling by bilinear interpolation at points between pixels."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.window_sizes import positive_pair
from ..primitives.geometry.regions import (
    bilinear_means,
    check_bin_channels,
    checked_regions,
    image_numbers,
    scaled_sides,
)
from ..primitives.linalg.matrices import small_matmul
from ..primitives.numbers.rounding import known_or


def roi_align(
    input: Tensor,
    boxes: Union[Tensor, List[Tensor]],
    output_size: Union[int, Tuple[int, int]],
    spatial_scale: float = 1.0,
    sampling_ratio: int = -1,
    aligned: bool = False,
) -> Tensor:
    """RoIAlign: the means of points in the bins of boxes; each point is read by bilinear interpolation.

    K. He et al., Mask R-CNN, ICCV 2017. A point up to one pixel outside the centres of the border pixels
    reads the nearest pixel; a point further outside counts as 0. There are gradients only with respect to the
    input, as in torchvision.

    With a positive ``sampling_ratio``, points are gathered: C * K * PH * PW * sampling_ratio^2 values.
    Otherwise their number depends on the box; their weights become matrices, whose products take K * PH * (B
    * H + C * W) values. Every pixel of every image takes part in these products: the input must be finite.

    Args:
        input: (B, C, H, W), floating point.
        boxes: (K, 5) as image index, x1, y1, x2, y2, floating point. An index outside the batch is clamped.
            Or a list of the boxes (L, 4) of each image, which exported ops do not take.
        output_size: the numbers PH and PW of rows and columns of bins, or one number for both.
        spatial_scale: the factor from the boxes' coordinates to pixels of the input.
        sampling_ratio: the number of points of a bin along each axis; if not positive, so many that their
            distance is at most one pixel.
        aligned: True if pixel centres are at half-integers, so that half a pixel is subtracted; then boxes
            may be smaller than a pixel.

    Returns:
        (K, C, PH, PW).

    Raises:
        TypeError: if input or boxes is not floating point.
        ValueError: if input is not (B, C, H, W), boxes not (K, 5), or output_size not positive.

    Example:
        >>> image = torch.arange(16.0).reshape(1, 1, 4, 4)
        >>> roi_align(image, torch.tensor([[0.0, 0.0, 0.0, 4.0, 4.0]]), 2, sampling_ratio=2, aligned=True)
        tensor([[[[ 2.5000,  4.5000],
                  [10.5000, 12.5000]]]])
    """
    boxes = checked_regions(input, boxes)
    rows, columns = positive_pair(output_size, "output_size")
    across, down = scaled_sides(input, boxes, spatial_scale)
    shift, least = (0.5, float("-inf")) if aligned else (0.0, 1.0)
    image = image_numbers(input, boxes)
    height, width = input.size(2), input.size(3)
    if sampling_ratio > 0:
        y, x = (
            _points(down, rows, sampling_ratio, shift, least),
            _points(across, columns, sampling_ratio, shift, least),
        )
        return bilinear_means(input[:, :, None], image, y, x, rows * columns)
    y, x = _weights(down, rows, shift, least, height), _weights(across, columns, shift, least, width)
    y, x = y.to(input.dtype), x.to(input.dtype)
    # All images are stacked vertically, and each box reads its own image.
    own = _own_image(y, image, input.size(0)).flatten(0, 1)
    stacked = input.transpose(1, 2).reshape(input.size(0) * height, input.size(1) * width)
    read = small_matmul(own, stacked).reshape(boxes.size(0), rows * input.size(1), width)
    read = small_matmul(read, x.transpose(1, 2))
    return read.reshape(boxes.size(0), rows, input.size(1), columns).transpose(1, 2)


def ps_roi_align(
    input: Tensor,
    boxes: Union[Tensor, List[Tensor]],
    output_size: Union[int, Tuple[int, int]],
    spatial_scale: float = 1.0,
    sampling_ratio: int = -1,
) -> Tensor:
    """Position-sensitive RoIAlign: each bin has its own channels.

    Z. Li et al., Light-Head R-CNN, 2017. Channel (c * PH + i) * PW + j is channel c of bin (i, j). Pixel
    centres are at half-integers, as in ``roi_align`` with ``aligned``; points outside and memory are also as
    described there. There are gradients only with respect to the input.

    Args:
        input: (B, C * PH * PW, H, W), floating point.
        boxes: (K, 5) as image index, x1, y1, x2, y2, floating point. An index outside the batch is clamped.
            Or a list of the boxes (L, 4) of each image, which exported ops do not take.
        output_size: the numbers PH and PW of rows and columns of bins, or one number for both.
        spatial_scale: the factor from the boxes' coordinates to pixels of the input.
        sampling_ratio: the number of points of a bin along each axis; if not positive, so many that their
            distance is at most one pixel; a box without area has no points: its result is 0, in torchvision
            NaN.

    Returns:
        (K, C, PH, PW).

    Raises:
        TypeError: if input or boxes is not floating point.
        ValueError: if input is not (B, C * PH * PW, H, W), boxes not (K, 5), or output_size not positive.

    Example:
        >>> image = torch.arange(4.0)[None, :, None, None].expand(1, 4, 5, 5)
        >>> ps_roi_align(image, torch.tensor([[0.0, 1.0, 1.0, 4.0, 4.0]]), 2, sampling_ratio=2)
        tensor([[[[0., 1.],
                  [2., 3.]]]])
    """
    boxes = checked_regions(input, boxes)
    rows, columns = positive_pair(output_size, "output_size")
    check_bin_channels(input, rows, columns)
    across, down = scaled_sides(input, boxes, spatial_scale)
    image, least = image_numbers(input, boxes), float("-inf")
    batch, height, width = input.size(0), input.size(2), input.size(3)
    channels = input.size(1) // (rows * columns)
    planes = input.unflatten(1, [channels, rows, columns])
    if sampling_ratio > 0:
        y, x = (
            _points(down, rows, sampling_ratio, 0.5, least),
            _points(across, columns, sampling_ratio, 0.5, least),
        )
        return bilinear_means(planes.flatten(2, 3), image, y, x, 1)
    y, x = _weights(down, rows, 0.5, least, height), _weights(across, columns, 0.5, least, width)
    y, x = y.to(input.dtype), x.to(input.dtype)
    own = _own_image(y, image, batch).transpose(0, 1)
    stacked = planes.permute(2, 0, 4, 1, 3, 5).reshape(rows, batch * height, channels * columns * width)
    read = small_matmul(own, stacked).reshape(rows, boxes.size(0), channels, columns, width)
    return (read * x[None, :, None]).sum(-1).permute(1, 2, 0, 3)


def _bins(sides: Tensor, bins: int, shift: float, least: float) -> Tuple[Tensor, Tensor]:
    """The start of boxes whose sides are (K, 2), and the size of a bin: (K, 1) each."""
    first = sides[:, :1] - shift
    return first, (sides[:, 1:] - shift - first).clamp(min=least) / bins


def _points(sides: Tensor, bins: int, per_bin: int, shift: float, least: float) -> Tensor:
    """Positions (K, bins, per_bin) along an axis."""
    first, size = _bins(sides, bins, shift, least)
    number = torch.arange(bins, device=sides.device).to(sides.dtype)
    inner = torch.arange(per_bin, device=sides.device).to(sides.dtype) + 0.5
    return (first + number * size)[:, :, None] + (inner * size / per_bin)[:, None]


def _weights(sides: Tensor, bins: int, shift: float, least: float, size: int) -> Tensor:
    """The weight of each pixel of an axis in each bin, (K, bins, size), for points less than a pixel apart.
    Only some points of a bin are near enough to a pixel: the first of them is computed from the distance of
    the points, which is more than a half unless there is only one point.
    """
    first, extent = _bins(sides, bins, shift, least)
    count = torch.ceil(extent)
    step = extent / count.clamp(min=1.0)
    number = torch.arange(bins, device=sides.device).to(sides.dtype)
    begin = (first + number * extent)[:, :, None]
    pixel = torch.arange(size, device=sides.device).to(sides.dtype)
    # A step of zero means a single point, the first.
    reach = (pixel - 1.0 - begin) / torch.where(step > 0, step, torch.ones_like(step))[:, :, None]
    nearest = torch.floor(known_or(reach, 0.0) - 0.5).clamp(min=0.0)
    nearest = torch.where((count > 1.0)[:, :, None], nearest, torch.zeros_like(nearest))
    total = torch.zeros_like(nearest)
    # At most 4 points lie within a pixel of a centre, and 2 more because of rounding.
    for k in range(6):
        point = nearest + k
        position = begin + (point + 0.5) * extent[:, :, None] / count.clamp(min=1.0)[:, :, None]
        inside = (position >= -1.0) & (position <= size) & (point < count[:, :, None])
        near = (1.0 - (position.clamp(0, size - 1) - pixel).abs()).clamp(min=0.0)
        total = total + torch.where(inside, near, torch.zeros_like(near))
    return total / count.clamp(min=1.0)[:, :, None]


def _own_image(weights: Tensor, image: Tensor, images: int) -> Tensor:
    """Weights (K, bins, H) of rows, placed into the rows of all images, (K, bins, images * H)."""
    is_own = (image[:, None] == torch.arange(images, device=image.device)).to(weights.dtype)
    return (weights[:, :, None] * is_own[:, None, :, None]).flatten(2)
