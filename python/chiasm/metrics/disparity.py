"""Errors of a disparity map over the pixels whose true disparity is known."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_reduction, check_tensor
from ..primitives.numbers.loss_reduction import widened
from .reductions import check_pair, reduced_valid, safe_sqrt


def mean_absolute_disparity_error(
    input: Tensor, target: Tensor, valid_mask: Optional[Tensor] = None, reduction: str = "mean"
) -> Tensor:
    """Mean of |input - target| over the valid pixels.

    Args:
        input: (*), the estimated disparities, floating point.
        target: the true disparities, of input's shape. Values at invalid pixels have no influence, also if
            they are NaN.
        valid_mask: bool, of input's shape; by default every pixel is valid.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar in pixels (NaN if no pixel is valid), for "sum" float32 of half precision; or (*) for "none",
        0 where not valid.

    Raises:
        TypeError: if input or target is not floating point, or valid_mask not bool.
        ValueError: if target or valid_mask is not of input's shape, or reduction is unknown.

    Example:
        >>> mean_absolute_disparity_error(torch.tensor([1.0, 5.0]), torch.tensor([2.0, 2.0]))
        tensor(2.)
    """
    check_reduction(reduction)
    error, _ = _errors(input, target, valid_mask)
    return reduced_valid(error, valid_mask, reduction)


def root_mean_squared_disparity_error(
    input: Tensor, target: Tensor, valid_mask: Optional[Tensor] = None, reduction: str = "mean"
) -> Tensor:
    """Root of the mean of (input - target)^2 over the valid pixels.

    Args:
        input: (*), the estimated disparities, floating point.
        target: the true disparities, of input's shape. Values at invalid pixels have no influence, also if
            they are NaN.
        valid_mask: bool, of input's shape; by default every pixel is valid.
        reduction: the root is taken of the "mean" of the squares, of their "sum", or for "none" of each
            square.

    Returns:
        A scalar in pixels (NaN if no pixel is valid), for "sum" float32 of half precision; or (*) for "none",
        0 where not valid. If all errors are 0, the derivative is 0.

    Raises:
        TypeError: if input or target is not floating point, or valid_mask not bool.
        ValueError: if target or valid_mask is not of input's shape, or reduction is unknown.

    Example:
        >>> root_mean_squared_disparity_error(torch.tensor([1.0, 8.0]), torch.tensor([2.0, 1.0]))
        tensor(5.)
    """
    check_reduction(reduction)
    error, _ = _errors(input, target, valid_mask)
    if reduction == "none":
        return error
    # squares of half precision numbers may exceed its range
    exact = error.to(torch.float64)
    root = safe_sqrt(reduced_valid(exact * exact, valid_mask, reduction))
    return root.to(error.dtype if reduction == "mean" else widened(error).dtype)


def mean_bad_pixel_error(
    input: Tensor,
    target: Tensor,
    threshold: float = 3.0,
    valid_mask: Optional[Tensor] = None,
    reduction: str = "mean",
) -> Tensor:
    """Share of the valid pixels whose disparity error is more than a threshold.

    D. Scharstein, R. Szeliski, A taxonomy and evaluation of dense two-frame stereo correspondence algorithms,
    IJCV 47, 2002, equation 2.

    Args:
        input: (*), the estimated disparities, floating point; NaN is bad.
        target: the true disparities, of input's shape. Values at invalid pixels have no influence, also if
            they are NaN.
        threshold: the largest error of a good pixel, in pixels.
        valid_mask: bool, of input's shape; by default every pixel is valid.
        reduction: "mean", "sum" (the number of bad pixels) or "none".

    Returns:
        A scalar, in [0, 1] for "mean" (NaN if no pixel is valid), for "sum" float32 of half precision; or (*)
        for "none", 1 at bad pixels and 0 elsewhere.

    Raises:
        TypeError: if input or target is not floating point, or valid_mask not bool.
        ValueError: if target or valid_mask is not of input's shape, threshold is negative, or reduction is
            unknown.

    Example:
        >>> mean_bad_pixel_error(torch.tensor([1.0, 5.0]), torch.tensor([2.0, 1.0]))
        tensor(0.5000)
    """
    check_reduction(reduction)
    _check_threshold(threshold, "threshold")
    error, _ = _errors(input, target, valid_mask)
    return reduced_valid((~(error <= threshold)).to(error.dtype), valid_mask, reduction)


def kitti_d1_error(
    input: Tensor,
    target: Tensor,
    abs_threshold: float = 3.0,
    rel_threshold: float = 0.05,
    valid_mask: Optional[Tensor] = None,
    reduction: str = "mean",
) -> Tensor:
    """D1 error of KITTI: share of valid pixels with an error above 3 pixels and above 5 % of the true
    disparity.

    M. Menze, A. Geiger, Object scene flow for autonomous vehicles, CVPR 2015, section 4.

    Args:
        input: (*), the estimated disparities, floating point; NaN is an outlier.
        target: the true disparities, of input's shape. Values at invalid pixels have no influence, also if
            they are NaN.
        abs_threshold: the largest error of a good pixel, in pixels.
        rel_threshold: the largest error of a good pixel, as a fraction of the true disparity.
        valid_mask: bool, of input's shape; by default every pixel is valid.
        reduction: "mean", "sum" (the number of outliers) or "none".

    Returns:
        A scalar, in [0, 1] for "mean" (NaN if no pixel is valid), for "sum" float32 of half precision; or (*)
        for "none", 1 at outliers and 0 elsewhere.

    Raises:
        TypeError: if input or target is not floating point, or valid_mask not bool.
        ValueError: if target or valid_mask is not of input's shape, a threshold is negative, or reduction is
            unknown.

    Example:
        >>> kitti_d1_error(torch.tensor([14.0, 104.0]), torch.tensor([10.0, 100.0]))
        tensor(0.5000)
    """
    check_reduction(reduction)
    _check_threshold(abs_threshold, "abs_threshold")
    _check_threshold(rel_threshold, "rel_threshold")
    error, truth = _errors(input, target, valid_mask)
    good = (error <= abs_threshold) | (error <= rel_threshold * truth.abs())
    return reduced_valid((~good).to(error.dtype), valid_mask, reduction)


def _errors(input: Tensor, target: Tensor, valid_mask: Optional[Tensor]) -> Tuple[Tensor, Tensor]:
    """|input - target| and target, both 0 where not valid."""
    check_pair(input, target)
    if valid_mask is None:
        return (input - target).abs(), target
    check_tensor(valid_mask, "valid_mask")
    if valid_mask.shape != input.shape:
        raise ValueError(
            f"valid_mask: expected input's shape {list(input.shape)}, got {list(valid_mask.shape)}"
        )
    if valid_mask.dtype != torch.bool:
        raise TypeError(f"valid_mask: expected a bool tensor, got dtype {valid_mask.dtype}")
    # selected before the subtraction: invalid values may be NaN, which would make the gradient NaN
    zeros = torch.zeros_like(target)
    truth = torch.where(valid_mask, target, zeros)
    return (torch.where(valid_mask, input, zeros) - truth).abs(), truth


def _check_threshold(value: float, name: str) -> None:
    if not value >= 0.0:
        raise ValueError(f"{name}: expected zero or more, got {value}")
