"""Thresholds: fixed, adaptive (local), and computed from the histogram."""

import math
from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import (
    check_choice,
    check_not_empty,
    check_number,
    check_pixels,
    check_values,
    odd_pair,
)
from ..primitives.core.layout import in_planes
from ..primitives.filters.correlation import box_sums
from ..primitives.filters.fixed_point import box_bytes, fixed_taps, separable_bytes
from ..primitives.filters.stencil import separable_shared
from ..primitives.images.histograms import aminmax, bincount, partial_sums, row_histograms
from ..primitives.images.masks import mask_in_range, masked_pixels
from ..primitives.images.tables import table_entries
from ..primitives.numbers.loss_reduction import widened
from ..primitives.numbers.rounding import to_index
from .gaussian import gaussian_taps


def in_range(
    input: Tensor,
    lower: Union[List[float], Tensor],
    upper: Union[List[float], Tensor],
    return_mask: bool = False,
) -> Tensor:
    """Keep the pixels whose channels are all between two bounds, like OpenCV's ``inRange``. Other pixels
    become 0.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        lower, upper: C numbers, or tensors (C,) or (B, C); pixels equal to a bound are inside.
        return_mask: return a mask instead: 1 (for integers 255) inside and 0 outside.

    Returns:
        (B, C, H, W) of input's dtype, or the mask (B, 1, H, W), for integers uint8, otherwise of input's
        dtype.

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if a shape is not as above.

    Example:
        >>> in_range(torch.arange(5.0).reshape(1, 1, 1, 5), [1.0], [3.0]).flatten()
        tensor([0., 1., 2., 3., 0.])
    """
    return like_given(_in_range_of_batch(in_batch(input, "input"), lower, upper, return_mask), input)


def _in_range_of_batch(
    input: Tensor, lower: Union[List[float], Tensor], upper: Union[List[float], Tensor], return_mask: bool
) -> Tensor:
    check_pixels(input, "input", True)
    # float32 represents integers of 16 bits exactly
    dtype = input.dtype if input.is_floating_point() else torch.float32
    low, high = _bound(lower, input, dtype, "lower"), _bound(upper, input, dtype, "upper")
    if not input.is_floating_point():
        mask = mask_in_range(input, low, high)
        return mask if return_mask else masked_pixels(input, mask)
    mask = ((input >= low) & (input <= high)).to(dtype).amin(1, keepdim=True)
    return mask if return_mask else torch.where(mask > 0, input, torch.zeros_like(input))


def _bound(bound: Union[List[float], Tensor], input: Tensor, dtype: torch.dtype, name: str) -> Tensor:
    if isinstance(bound, Tensor):
        b = bound.to(dtype)
    else:
        for each in bound:
            check_number(each, name)
        b = torch.tensor(bound, dtype=dtype, device=input.device)
    if b.dim() > 2 and b.size(-1) == 1 and b.size(-2) == 1:
        b = b.squeeze(-1).squeeze(-1)  # (C, 1, 1) and (B, C, 1, 1)
    if (b.dim() != 1 and b.dim() != 2) or b.size(-1) != input.size(1):
        raise ValueError(
            f"{name}: expected shape (C,) or (B, C) with input's {input.size(1)} channels, got"
            f" {list(b.shape)}"
        )
    return b[..., None, None]


def adaptive_threshold(
    input: Tensor,
    max_value: float,
    adaptive_method: str = "mean",
    threshold_type: str = "binary",
    block_size: int = 3,
    c: float = 0.0,
    rounded: bool = True,
) -> Tensor:
    """Compare each pixel with the mean of its neighbourhood, like OpenCV's ``adaptiveThreshold``. The border
    is replicated.

    For uint8, "mean" is identical to OpenCV's. "gaussian" uses the rounded mean of :func:`gaussian_blur2d`,
    whose weights are multiples of 1/256; a mean halfway between two levels is rounded up here, and to the
    even one by OpenCV. From a block_size of 11 on, OpenCV's weights are not such multiples, so that its mean
    may be another level.

    Args:
        input: (B, C, H, W), floating point or uint8. With ``rounded``, in whole levels, for example 0 to 255.
        max_value: value of the pixels above the threshold; for uint8 a whole number, 0 to 255.
        adaptive_method: "mean" of the block, or "gaussian": weighted by ``cv2.getGaussianKernel(block_size,
            0)``, which has fixed weights up to size 9, and sigma 0.15 * block_size + 0.35 above.
        threshold_type: "binary" sets pixels above the threshold to max_value and others to 0, "binary_inv"
            the reverse.
        block_size: side of the neighbourhood, odd, at least 3; for uint8 at most 255.
        c: subtracted from the mean.
        rounded: round the mean and c to whole levels, like OpenCV. If False, input may be in any unit, but
            not uint8.

    Returns:
        (B, C, H, W) of 0 and max_value.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D, or another argument is not as above.

    Example:
        >>> adaptive_threshold(torch.tensor([9.0, 9.0, 1.0, 9.0]).reshape(1, 1, 1, 4), 1.0, c=2.0).flatten()
        tensor([1., 1., 0., 1.])
    """
    check_pixels(input, "input")
    check_choice(adaptive_method, ["mean", "gaussian"], "adaptive_method")
    check_choice(threshold_type, ["binary", "binary_inv"], "threshold_type")
    size = odd_pair(block_size, "block_size")[0]
    if size < 3:
        raise ValueError(f"block_size: expected at least 3, got {size}")
    if input.dtype == torch.uint8:
        return _adaptive_threshold_of_bytes(
            input, max_value, adaptive_method, threshold_type, size, c, rounded
        )
    wide = widened(input)  # float16 holds neither sums nor means of levels
    if adaptive_method == "mean":
        # Sums of levels are exact, and the mean of an odd number of levels is never half-way between two
        # levels.
        mean = box_sums(wide, size, size, "replicate") * (1.0 / (size * size))
    else:
        taps = _opencv_taps(size)
        mean = separable_shared(wide, taps, taps, "replicate")
    offset = c
    if rounded:
        mean = torch.round(mean)
        offset = float(math.ceil(c)) if threshold_type == "binary" else float(math.floor(c))
    above = wide - mean > -offset
    inside = above if threshold_type == "binary" else torch.logical_not(above)
    return inside.to(input.dtype) * max_value


def _adaptive_threshold_of_bytes(
    input: Tensor,
    max_value: float,
    adaptive_method: str,
    threshold_type: str,
    size: int,
    c: float,
    rounded: bool,
) -> Tensor:
    if size > 255:
        raise ValueError(f"block_size: expected at most 255 for bytes, got {size}")
    if not rounded:
        raise ValueError("rounded: expected True for bytes, got False")
    if not (max_value >= 0.0 and max_value <= 255.0) or max_value != math.floor(max_value):
        raise ValueError(f"max_value: expected a whole number, 0 to 255, for bytes, got {max_value}")
    if adaptive_method == "mean":
        mean = box_bytes(input, size, size, "replicate")
    else:
        taps = fixed_taps(torch.tensor([_opencv_taps(size)], dtype=torch.float64, device=input.device))
        mean = separable_bytes(input, taps, taps, "replicate")
    difference = input.to(torch.float32) - mean.to(torch.float32)
    if threshold_type == "binary":
        inside = difference > -float(math.ceil(c))
    else:
        inside = difference <= -float(math.floor(c))
    return (inside.to(torch.float32) * max_value).to(torch.uint8)


def _opencv_taps(size: int) -> List[float]:
    """The weights that OpenCV uses for a sigma of 0. The fixed weights are multiples of 1/256, so that sums
    of levels are exact."""
    half: List[float] = []
    if size == 3:
        half = [64.0, 128.0]
    elif size == 5:
        half = [16.0, 64.0, 96.0]
    elif size == 7:
        half = [8.0, 28.0, 56.0, 72.0]
    elif size == 9:
        half = [4.0, 13.0, 30.0, 51.0, 60.0]
    else:
        return gaussian_taps(size, 0.3 * ((size - 1) * 0.5 - 1.0) + 0.8)
    return [half[min(i, size - 1 - i)] / 256.0 for i in range(size)]


def otsu_threshold(
    x: Tensor, nbins: int = 256, slow_and_differentiable: bool = False, return_mask: bool = False
) -> Tuple[Tensor, Tensor]:
    """Threshold each plane by Otsu's method; values that are not above the threshold become 0.

    N. Otsu, A threshold selection method from gray-level histograms, 1979: the threshold maximises the
    variance between the classes. As in scikit-image's ``threshold_otsu``, the histogram spans each plane's
    values and the threshold is the centre of a bin; of bins with the same variance, the first one is used.
    Values in later bins are above the threshold; values in this bin are not. So on a plane that uses the
    whole range of 8-bit levels, OpenCV's THRESH_OTSU separates the same pixels. For uint8, the bins are the
    256 levels, and the threshold is one of these levels, the same as OpenCV's, but on a constant plane: there
    it is the plane's level, above which is nothing, and OpenCV's is 0.

    Args:
        x: (*, H, W), floating point or uint8; each plane has its own threshold, and must have fewer than 2^31
            pixels.
        nbins: number of bins, at least 2, for uint8 256.
        slow_and_differentiable: split each value between the nearest two bins, and average the bin centres
            with weights softmax(nbins * variance / greatest variance). This threshold has a gradient and is
            near the exact one; x is compared with it. Not for uint8.
        return_mask: return whether x is above the threshold instead of x itself.

    Returns:
        (*, H, W), x or bool, and the thresholds (*,). The threshold of a constant plane is its value.

    Raises:
        TypeError: if x is neither floating point nor uint8.
        ValueError: if x has fewer than 2 dimensions, nbins is below 2, or nbins or slow_and_differentiable is
            not allowed for uint8.

    Example:
        >>> x = torch.tensor([[0.0, 0.1, 0.2, 0.8, 0.9, 1.0]])
        >>> otsu_threshold(x, nbins=10)
        (tensor([[0.0000, 0.0000, 0.0000, 0.8000, 0.9000, 1.0000]]), tensor(0.2500))
    """
    check_values(x, "x")
    if x.dim() < 2:
        raise ValueError(f"x: expected shape (*, H, W), got {list(x.shape)}")
    check_not_empty(x, 2, "x")
    if nbins < 2:
        raise ValueError(f"nbins: expected at least 2, got {nbins}")
    if x.dtype == torch.uint8:
        if nbins != 256 or slow_and_differentiable:
            raise ValueError(
                f"nbins, slow_and_differentiable: expected 256 and False for bytes, got {nbins} and"
                f" {slow_and_differentiable}"
            )
        return _otsu_of_bytes(x, return_mask)
    planes = x.reshape(-1, x.size(-2) * x.size(-1))
    low, high = aminmax(planes)
    # A constant plane has a span of 0: its threshold is its value, and nothing is above it.
    span = torch.where(high > low, high - low, torch.ones_like(high))
    position = (planes - low) / span * float(nbins)
    if slow_and_differentiable:
        centred = (position - 0.5).clamp(0.0, float(nbins - 1)).to(torch.float64)
        first = to_index(centred.detach(), nbins - 1)
        share = centred - first
        counts = torch.zeros([planes.size(0), nbins], dtype=torch.float64, device=x.device)
        counts = counts.scatter_add(1, first, 1.0 - share).scatter_add(1, first + 1, share)
    else:
        counts = row_histograms(planes, low, span, nbins).to(torch.float64)
    variance = _between_classes(counts)
    bins = torch.arange(nbins - 1, device=x.device)
    best = variance.amax(1, keepdim=True)
    width = (high - low) / float(nbins)
    if slow_and_differentiable:
        weights = torch.softmax(
            variance / torch.where(best > 0, best, torch.ones_like(best)) * float(nbins), 1
        )
        threshold = low + ((weights * bins).sum(1, keepdim=True).to(x.dtype) + 0.5) * width
        above = planes > threshold
    else:
        found = torch.where(variance >= best, bins, torch.full_like(bins, nbins)).amin(1, keepdim=True)
        threshold = low + (found.to(x.dtype) + 0.5) * width
        above = position.floor() > found.to(x.dtype)
    above = above.reshape(x.shape)
    kept = above if return_mask else torch.where(above, x, torch.zeros_like(x))
    return kept, threshold.reshape(x.shape[:-2])


def _otsu_of_bytes(x: Tensor, return_mask: bool) -> Tuple[Tensor, Tensor]:
    rows = in_planes(x).reshape(-1, x.size(-2) * x.size(-1))
    counts = bincount(rows, 256).to(torch.float64)
    variance = _between_classes(counts)
    level = torch.arange(256, device=x.device)
    best = variance.amax(1, keepdim=True)
    inner = level[:255]
    first = torch.where(variance >= best, inner, torch.full_like(inner, 255)).amin(1, keepdim=True)
    only = torch.where(counts > 0, level, torch.zeros_like(level)).amax(1, keepdim=True)
    threshold = torch.where(best > 0, first, only)
    white = torch.full_like(level, 255) if return_mask else level
    kept = torch.where(level > threshold, white, torch.zeros_like(level)).to(torch.uint8)
    made = table_entries(rows, kept).reshape(x.shape)
    if return_mask:
        made = made.to(torch.bool)
    return made, threshold.to(torch.uint8).reshape(x.shape[:-2])


def _between_classes(counts: Tensor) -> Tensor:
    """Variance between bins 0..j and the other bins, for each j except the last: (*, n) to (*, n - 1).

    Up to a factor it is (s_1 w - s w_1)^2 / (w_1 (w - w_1)) with the number w_1 and the sum s_1 of the values
    in the first class and w, s of all. With bins numbered by integers, and whole counts, all of these are
    exact: equal variances compare equal, whatever the order in which a backend adds.
    """
    n = counts.size(-1)
    number = torch.arange(n, device=counts.device)
    moments = torch.stack([counts, counts * number], -2)
    partial = partial_sums(moments)
    total = moments.sum(-1, keepdim=True)
    w1, s1 = partial[..., 0, :], partial[..., 1, :]
    w, s = total[..., 0, :], total[..., 1, :]
    between = w1 * (w - w1)
    empty = between <= 0
    difference = s1 * w - s * w1
    return torch.where(
        empty,
        torch.zeros_like(between),
        difference * difference / torch.where(empty, torch.ones_like(between), between),
    )
