"""Histograms that count pixels."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels
from ..primitives.images.histograms import bincount, level_rows


def count_histogram(image: Tensor, n_bins: int = 256, min: float = 0.0, max: float = 1.0) -> Tensor:
    """Count the pixels of each channel in n_bins equal bins of [min, max), like OpenCV's ``calcHist``.

    Values outside, and NaN, are not counted. There is no gradient; ``image_histogram2d`` has one. For uint8,
    use min 0 and max 256 to count all levels.

    Args:
        image: (B, C, H, W), floating point or uint8.
        n_bins: number of bins.
        min: lower end of the first bin.
        max: upper end of the last bin, not included.

    Returns:
        (B, C, n_bins), int64.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D, n_bins not positive or max not above min.

    Example:
        >>> count_histogram(torch.tensor([0.0, 0.3, 0.4, 1.0]).reshape(1, 1, 2, 2), 4)
        tensor([[[1, 2, 0, 0]]])
    """
    check_pixels(image, "image")
    if n_bins < 1:
        raise ValueError(f"n_bins: expected a positive number, got {n_bins}")
    if not max > min:
        raise ValueError(f"max: expected a number above min = {min}, got {max}")
    # In double precision, as in OpenCV: float32 would put values near an edge into the wrong bin.
    scale = n_bins / (max - min)
    if image.dtype == torch.uint8:
        # The bin of each level, and how often the level occurs.
        of_levels = bincount(level_rows(image), 256)
        index = _bins(torch.arange(256, device=image.device).to(torch.float64), scale, min, n_bins)
        zeros = torch.zeros([of_levels.size(0), n_bins + 1], dtype=torch.int32, device=image.device)
        places = index.to(torch.int64).expand(of_levels.size(0), 256)
        counts = zeros.scatter_add(1, places, of_levels)[:, :n_bins]
    else:
        values = image.flatten(2).flatten(0, 1).to(torch.float64)
        counts = bincount(_bins(values, scale, min, n_bins), n_bins + 1)[:, :n_bins]
    return counts.to(torch.int64).unflatten(0, [image.size(0), image.size(1)])


def _bins(values: Tensor, scale: float, min: float, n_bins: int) -> Tensor:
    """The bin of each value; n_bins for values outside all bins."""
    position = torch.floor(values * scale - min * scale)
    inside = (position >= 0.0) & (position < n_bins)
    # Native code converts float32 to integers in vectors, but not float64.
    return torch.where(inside, position, torch.full_like(position, n_bins)).to(torch.float32).to(torch.int32)
