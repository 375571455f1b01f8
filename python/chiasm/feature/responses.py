"""Responses to corners and blobs: Shi and Tomasi, the Hessian, differences of Gaussians."""

from typing import Optional

import torch
from torch import Tensor

from ..filters.gaussian import gaussian_blur2d
from ..filters.gradient import spatial_gradient
from ..primitives.core.checks import check_image
from ..primitives.resampling.volumes import check_volume
from ..primitives.resampling.warping import position_dtype
from .structure import normalised_by_scale, structure_tensor


def gftt_response(input: Tensor, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None) -> Tensor:
    """The smaller eigenvalue of the structure tensor (Shi-Tomasi, "good features to track").

    The tensor is smoothed by a 7x7 Gaussian of sigma 1. J. Shi, C. Tomasi, Good Features to Track, CVPR 1994.

    Args:
        input: (B, C, H, W), floating point, H and W at least 4. Half precision is computed in float32.
        grads_mode: "sobel" or "diff", see ``spatial_gradient``.
        sigmas: (B,) scales; the response is multiplied by their fourth power.

    Returns:
        (B, C, H, W); large at corners, 0 on straight edges and in constant regions. If both eigenvalues are
        equal, the derivative is that of their mean.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, sigmas not 1-D, or grads_mode unknown.

    Example:
        >>> ramp = torch.arange(9.0).expand(1, 1, 9, 9)
        >>> gftt_response(ramp).abs().max()
        tensor(0.)
    """
    check_image(input, "input")
    xx, yy, xy = structure_tensor(input, grads_mode)
    difference = xx - yy
    squared = difference * difference + 4.0 * xy * xy
    isotropic = squared == 0
    gap = torch.where(
        isotropic,
        torch.zeros_like(squared),
        torch.sqrt(torch.where(isotropic, torch.ones_like(squared), squared)),
    )
    return normalised_by_scale(0.5 * (xx + yy - gap), sigmas).to(input.dtype)


def hessian_response(input: Tensor, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None) -> Tensor:
    """Determinant of the Hessian, with the second derivatives of ``spatial_gradient``.

    P. Beaudet, Rotationally invariant image operators, ICPR 1978.

    Args:
        input: (B, C, H, W), floating point. Half precision is computed in float32.
        grads_mode: "sobel" or "diff", see ``spatial_gradient``.
        sigmas: (B,) scales; the response is multiplied by their fourth power.

    Returns:
        (B, C, H, W); positive at blobs, dark or bright, negative at saddles.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, sigmas not 1-D, or grads_mode unknown.

    Example:
        >>> blob = -0.5 * (torch.arange(9.0)[:, None] - 4) ** 2 - (torch.arange(9.0) - 4) ** 2
        >>> hessian_response(blob[None, None])[0, 0, 4, 4]
        tensor(2.)
    """
    check_image(input, "input")
    second = spatial_gradient(input.to(position_dtype(input.dtype)), grads_mode, 2)
    xx, xy, yy = second[:, :, 0], second[:, :, 1], second[:, :, 2]
    return normalised_by_scale(xx * yy - xy * xy, sigmas).to(input.dtype)


def dog_response(input: Tensor) -> Tensor:
    """Differences of the neighbouring levels of a scale space, coarser minus finer.

    D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004.

    Args:
        input: (B, C, D, H, W), floating point: images, blurred more and more along D.

    Returns:
        (B, C, D - 1, H, W); negative on bright blobs, positive on dark ones.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D or D less than 2.

    Example:
        >>> dog_response(torch.tensor([1.0, 0.5, 0.25]).reshape(1, 1, 3, 1, 1)).flatten()
        tensor([-0.5000, -0.2500])
    """
    check_volume(input, "input")
    if input.size(2) < 2:
        raise ValueError(f"input: expected at least 2 levels, got {list(input.shape)}")
    return input[:, :, 1:] - input[:, :, :-1]


def dog_response_single(input: Tensor, sigma1: float = 1.0, sigma2: float = 1.6) -> Tensor:
    """Difference of an image blurred by two Gaussians, the second minus the first.

    Each kernel reaches over four standard deviations to either side, int(8 sigma + 1) taps or one more, an
    odd number. Borders are mirrored, the border pixel is not repeated.

    Args:
        input: (B, C, H, W), floating point, H and W more than four of either sigma.
        sigma1, sigma2: standard deviations in pixels, positive.

    Returns:
        (B, C, H, W); negative on bright blobs, positive on dark ones, where sigma1 is less than sigma2.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or a sigma not positive.

    Example:
        >>> spot = torch.zeros(1, 1, 15, 15)
        >>> spot[..., 7, 7] = 1.0
        >>> dog_response_single(spot)[0, 0, 7, 7] < 0
        tensor(True)
    """
    check_image(input, "input")
    if not (sigma1 > 0.0 and sigma2 > 0.0):
        raise ValueError(f"sigma1, sigma2: expected positive numbers, got {sigma1} and {sigma2}")
    return _blurred(input, sigma2) - _blurred(input, sigma1)


def _blurred(input: Tensor, sigma: float) -> Tensor:
    taps = int(8.0 * sigma + 1.0)
    return gaussian_blur2d(input, taps + 1 - taps % 2, (sigma, sigma))
