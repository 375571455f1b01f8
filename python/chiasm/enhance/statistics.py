"""Statistics of an image's channels."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels
from ..primitives.numbers.reductions import extreme_indices, moments_bytes


def mean_std_dev(image: Tensor) -> Tuple[Tensor, Tensor]:
    """Mean and standard deviation of each channel, like OpenCV's ``meanStdDev``.

    The variance divides by H * W, not by H * W - 1. For uint8, the sums are exact. Floating-point images are
    summed in float64; the variance is the mean of the squared distances from the mean. The deviation of a
    constant plane is 0, and so is its gradient.

    Args:
        image: (B, C, H, W), floating point or uint8.

    Returns:
        Mean (B, C) and standard deviation (B, C), of the image's dtype; for uint8 float64, in levels.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D or has no pixels.

    Example:
        >>> mean_std_dev(torch.tensor([1.0, 3.0, 1.0, 3.0]).reshape(1, 1, 2, 2))
        (tensor([[2.]]), tensor([[1.]]))
    """
    check_pixels(image, "image")
    if image.dtype != torch.uint8:
        values = image.to(torch.float64)
        mean = values.mean([2, 3], keepdim=True)
        # NaN and infinity propagate to both results without extra code
        variance = (values - mean).square().mean([2, 3])
        # of a constant plane the root would have an infinite slope: NaN for every pixel
        flat = variance == 0.0
        std = torch.where(flat, variance, torch.where(flat, torch.ones_like(variance), variance).sqrt())
        return mean.flatten(1).to(image.dtype), std.to(image.dtype)
    moments = moments_bytes(image).to(torch.float64) / (image.size(2) * image.size(3))
    mean, squares = moments[:, :, 0], moments[:, :, 1]
    return mean, (squares - mean * mean).clamp(min=0.0).sqrt()


def min_max_loc(image: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """The least and the greatest value of each channel and their positions, like OpenCV's ``minMaxLoc``. If a
    value occurs several times, its first position counts, row by row. NaN is ignored; for a channel with only
    NaN, the result is its first pixel.

    Args:
        image: (B, C, H, W), floating point or uint8.

    Returns:
        Least and greatest value (B, C), of the image's dtype, and their positions (B, C, 2), (x, y) in
        pixels, int64.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D or has no pixels.

    Example:
        >>> min_max_loc(torch.tensor([5.0, 7.0, 2.0, 2.0]).reshape(1, 1, 2, 2))
        (tensor([[2.]]), tensor([[7.]]), tensor([[[0, 1]]]), tensor([[[1, 0]]]))
    """
    check_pixels(image, "image")
    values = image.flatten(2)
    index = extreme_indices(image)
    extremes = values.gather(2, index)
    y = torch.div(index, image.size(3), rounding_mode="floor")
    places = torch.stack([index - y * image.size(3), y], 3)
    return extremes[:, :, 0], extremes[:, :, 1], places[:, :, 0], places[:, :, 1]
