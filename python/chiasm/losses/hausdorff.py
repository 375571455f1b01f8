"""Losses that estimate the Hausdorff distance of two segmentations by erosion."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_image, check_reduction
from ..primitives.filters.padding import stencil, stencil3d
from ..primitives.numbers.loss_reduction import narrowed, reduced, widened
from ..primitives.numbers.reductions import greatest, least
from ..primitives.resampling.volumes import check_volume
from .labels import check_labels, class_planes


def hausdorff_er_loss(
    pred: Tensor, target: Tensor, alpha: float = 2.0, k: int = 10, reduction: str = "mean"
) -> Tensor:
    """Hausdorff loss by erosion: the sum over i = 1..k of i^alpha times (pred - target)^2 eroded i times.

    Thicker wrong regions have a greater loss. D. Karimi, S. E. Salcudean, Reducing the Hausdorff distance in
    medical image segmentation with convolutional neural networks, IEEE TMI 39(2), 2020, equation 8. An
    erosion is soft: the mean over a pixel and its four neighbours, 0 beyond the border, minus 1/2, and at
    least 0. Each plane is then stretched to [0, 1]; without this, nothing would be left after two erosions.

    Args:
        pred: (B, C, H, W) probabilities, floating point: of C classes if C is at least 2, or of the
            foreground if C is 1.
        target: (B, 1, H, W) integer labels, 0 to C - 1, or 1 for the foreground.
        alpha: the exponent of the distance.
        k: number of erosions, the largest distance in pixels that makes a difference.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar, or the map (B, C, H, W) for "none".

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape or reduction is not as above, or k not positive.

    Example:
        >>> target = torch.zeros(1, 1, 5, 5, dtype=torch.int64)
        >>> (
        ...     hausdorff_er_loss(torch.ones(1, 1, 5, 5), target, k=1),
        ...     hausdorff_er_loss(torch.ones(1, 1, 5, 5), target, k=2),
        ... )
        (tensor(0.6000), tensor(1.6560))
    """
    check_image(pred, "pred")
    error = _squared_error(pred, target, k, reduction)
    return narrowed(reduced(_eroded_sum(error, alpha, k), reduction), pred)


def hausdorff_er_loss3d(
    pred: Tensor, target: Tensor, alpha: float = 2.0, k: int = 10, reduction: str = "mean"
) -> Tensor:
    """``hausdorff_er_loss`` for volumes; an erosion averages a voxel and its six neighbours.

    Args:
        pred: (B, C, D, H, W) probabilities, floating point: of C classes if C is at least 2, or of the
            foreground if C is 1.
        target: (B, 1, D, H, W) integer labels, 0 to C - 1, or 1 for the foreground.
        alpha: the exponent of the distance.
        k: number of erosions, the largest distance in voxels that makes a difference.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar, or the map (B, C, D, H, W) for "none".

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape or reduction is not as above, or k not positive.

    Example:
        >>> target = torch.zeros(1, 1, 3, 3, 3, dtype=torch.int64)
        >>> hausdorff_er_loss3d(torch.ones(1, 1, 3, 3, 3), target, k=1, reduction="none")[0, 0, 1]
        tensor([[0.3333, 0.6667, 0.3333],
                [0.6667, 1.0000, 0.6667],
                [0.3333, 0.6667, 0.3333]])
    """
    check_volume(pred, "pred")
    error = _squared_error(pred, target, k, reduction)
    return narrowed(reduced(_eroded_sum(error, alpha, k), reduction), pred)


def _squared_error(pred: Tensor, target: Tensor, k: int, reduction: str) -> Tensor:
    check_reduction(reduction)
    check_labels(target, "target")
    if (
        target.dim() != pred.dim()
        or target.size(0) != pred.size(0)
        or target.size(1) != 1
        or target.shape[2:] != pred.shape[2:]
    ):
        raise ValueError(
            f"target: expected shape (B, 1, *) for pred (B, C, *) {list(pred.shape)}, got"
            f" {list(target.shape)}"
        )
    if k < 1:
        raise ValueError(f"k: expected a positive number, got {k}")
    mask = target > 0 if pred.size(1) == 1 else class_planes(target[:, 0], pred.size(1))
    # Stretching multiplies the rounding errors of each erosion.
    wide = widened(pred)
    difference = wide - mask.to(wide.dtype)
    return difference * difference


def _eroded_sum(error: Tensor, alpha: float, k: int) -> Tensor:
    total = torch.zeros_like(error)
    for i in range(k):
        error = _stretched(torch.relu(_cross_mean(error) - 0.5))
        total = total + error * float(i + 1) ** alpha
    return total


def _cross_mean(x: Tensor) -> Tensor:
    """The mean over each pixel and its neighbours along the axes, which are 0 beyond the border."""
    if x.dim() == 4:
        return _cross_sum2d(x, (1, 1), (1, 1), "constant", [2, 3]) / 5.0
    return _cross_sum3d(x, (1, 1), (1, 1), (1, 1), "constant", [2, 3, 4]) / 7.0


def _cross_sum(p: Tensor, dims: List[int]) -> Tensor:
    out = _inner(p, dims, -1, 0)
    for dim in dims:
        out = out + (_inner(p, dims, dim, -1) + _inner(p, dims, dim, 1))
    return out


_cross_sum2d, _cross_sum3d = stencil(_cross_sum), stencil3d(_cross_sum)


def _inner(p: Tensor, dims: List[int], moved: int, by: int) -> Tensor:
    """``p`` without its margin of one pixel, shifted by ``by`` pixels along the axis ``moved``."""
    for dim in dims:
        p = p.narrow(dim, 1 + by if dim == moved else 1, p.size(dim) - 2)
    return p


def _stretched(x: Tensor) -> Tensor:
    """Each plane mapped from its least and greatest value to [0, 1]; a constant plane stays unchanged."""
    axes = [2, 3] if x.dim() == 4 else [2, 3, 4]
    low, high = least(x, axes), greatest(x, axes)
    varies = high > low
    span = torch.where(varies, high - low, torch.ones_like(high))
    return torch.where(varies, (x - low) / span, x)
