"""Histograms that count."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.images.histograms import bincount


def count_histogram(image: Tensor, n_bins: int = 256, min: float = 0.0, max: float = 1.0) -> Tensor:
    """How many pixels of each channel fall into each of n_bins equal bins of [min, max), as OpenCV's
    ``calcHist``.

    Values outside, and NaN, are not counted. There is no gradient; ``image_histogram2d`` has one.

    Args:
        image: (B, C, H, W), floating point.
        n_bins: number of bins.
        min: lower end of the first bin.
        max: upper end of the last bin, itself outside.

    Returns:
        (B, C, n_bins), int64.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not 4-D, n_bins not positive or max not above min.

    Example:
        >>> count_histogram(torch.tensor([0.0, 0.3, 0.4, 1.0]).reshape(1, 1, 2, 2), 4)
        tensor([[[1, 2, 0, 0]]])
    """
    check_image(image, "image")
    if n_bins < 1:
        raise ValueError(f"n_bins: expected a positive number, got {n_bins}")
    if max <= min:
        raise ValueError(f"max: expected a number above min = {min}, got {max}")
    # In double precision, as OpenCV has it: float32 would put values near the bins' edges on either side.
    scale = n_bins / (max - min)
    position = torch.floor(image.flatten(2).flatten(0, 1).to(torch.float64) * scale - min * scale)
    inside = (position >= 0.0) & (position < n_bins)
    index = torch.where(inside, position, torch.full_like(position, n_bins)).to(torch.int64)
    counts = bincount(index, n_bins + 1)[:, :n_bins]
    return counts.to(torch.int64).unflatten(0, [image.size(0), image.size(1)])
