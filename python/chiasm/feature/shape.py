"""Orientation and affine shape of patches, and frames that follow them."""

import math

import torch
from torch import Tensor

from ..filters.gradient import spatial_gradient
from ..geometry.conversions.angles import rad2deg
from ..primitives.features.orientations import orientation_histograms
from ..primitives.linalg.matrices import small_matmul
from ..primitives.resampling.warping import position_dtype
from .gradients import check_patches, gaussian_window
from .laf import check_laf, determinants, rotate_laf
from .laf_points import ellipse_to_laf
from .patches import grey_patches_of


def dominant_orientation(patches: Tensor, num_angular_bins: int = 36) -> Tensor:
    """The angle by which to rotate the frame of a patch so that its dominant gradient points along x. It is
    the peak of a histogram of directions. Gradients are weighted by a Gaussian with sigma of a sixth of the
    patch's side and split linearly between two neighbouring bins. The histogram is smoothed by (1, 4, 6, 4,
    1) / 16. The parabola through the highest bin (of equal ones the first) and its neighbours gives the peak.

    D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004.

    Args:
        patches: (N, 1, PS, PS), floating point. Half precision is computed in float32.
        num_angular_bins: bins of the histogram, at least 5.

    Returns:
        (N,) radians, from -pi to pi, counterclockwise as in ``rotate_laf``: minus the gradient's direction
        from x towards y. 0 if a patch has no gradient.

    Raises:
        TypeError: if patches is not floating point.
        ValueError: if patches is not (N, 1, PS, PS) or num_angular_bins less than 5.

    Example:
        >>> brighter_below = torch.arange(16.0)[:, None].expand(1, 1, 16, 16)
        >>> dominant_orientation(brighter_below) / torch.pi
        tensor([-0.5000])
    """
    check_patches(patches)
    if num_angular_bins < 5:
        raise ValueError(f"num_angular_bins: expected at least 5, got {num_angular_bins}")
    size = patches.size(3)
    exact = patches.to(position_dtype(patches.dtype))
    anywhere = torch.ones([1, size], dtype=exact.dtype, device=patches.device)
    histogram = orientation_histograms(
        exact, gaussian_window(size, size / 6.0, exact), anywhere, num_angular_bins
    )[:, :, 0, 0]
    near, far = (
        _shifted(histogram, 1) + _shifted(histogram, -1),
        _shifted(histogram, 2) + _shifted(histogram, -2),
    )
    smooth = 0.375 * histogram + 0.25 * near + 0.0625 * far
    peak = torch.argmax(smooth.detach(), 1, keepdim=True)
    centre, before, after = (
        smooth.gather(1, peak),
        _shifted(smooth, 1).gather(1, peak),
        _shifted(smooth, -1).gather(1, peak),
    )
    bend = 2.0 * centre - before - after
    straight = bend <= 0
    offset = 0.5 * (after - before) / torch.where(straight, torch.ones_like(bend), bend)
    offset = torch.where(straight, torch.zeros_like(offset), offset)
    angle = (peak.to(offset.dtype) + offset)[:, 0] * (-2.0 * math.pi / num_angular_bins)
    return torch.where(angle < -math.pi, angle + 2.0 * math.pi, angle).to(patches.dtype)


def affine_shape(patches: Tensor) -> Tensor:
    """The ellipses of patches: the second moments of the gradients, weighted by a Gaussian.

    A. Baumberg, Reliable Feature Matching Across Widely Separated Views, CVPR 2000; T. Lindeberg, J. Garding,
    Shape-adapted smoothing in estimation of 3-D shape cues, IVC 15(6), 1997: one step of the iteration in
    `adapt_laf_shape`. Sigma of the Gaussian is a sixth of the patch's side.

    Args:
        patches: (N, 1, PS, PS), floating point. Half precision is computed in float32.

    Returns:
        (N, 3): a, b, c of a dx^2 + 2 b dx dy + c dy^2 = 1, divided by the largest of a and c; 1, 0, 1 if a
        patch has no gradient.

    Raises:
        TypeError: if patches is not floating point.
        ValueError: if patches is not (N, 1, PS, PS).

    Example:
        >>> y, x = torch.arange(15.0)[:, None] - 7, torch.arange(15.0) - 7
        >>> affine_shape((0.2 * x * x + 0.1 * y * y)[None, None])[0].round(decimals=2)
        tensor([1.0000, 0.0000, 0.2500])
    """
    check_patches(patches)
    size = patches.size(3)
    gradient = spatial_gradient(patches.to(position_dtype(patches.dtype)), "diff")[:, 0]
    dx, dy = gradient[:, 0], gradient[:, 1]
    window = gaussian_window(size, size / 6.0, dx)
    a, b, c = (dx * dx * window).sum([1, 2]), (dx * dy * window).sum([1, 2]), (dy * dy * window).sum([1, 2])
    moments = torch.stack([a, b, c], 1)
    largest = torch.maximum(a, c)[:, None]
    flat = largest == 0
    disk = torch.tensor([1.0, 0.0, 1.0], dtype=moments.dtype, device=moments.device)
    ellipse = torch.where(flat, disk, moments / torch.where(flat, torch.ones_like(largest), largest))
    return ellipse.to(patches.dtype)


def orient_laf(laf: Tensor, img: Tensor, PS: int = 32) -> Tensor:
    """Rotate frames so that the dominant gradient of their patches points along x.

    Args:
        laf: (B, N, 2, 3), floating point, in pixels.
        img: (B, 1 or 3, H, W), floating point; colours are converted to grey.
        PS: side of the patches.

    Returns:
        (B, N, 2, 3), of the same shapes and centres.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape or PS is not as above.

    Example:
        >>> brighter_below = torch.arange(32.0)[:, None].expand(1, 1, 32, 32)
        >>> orient_laf(torch.tensor([[[[5.0, 0.0, 16.0], [0.0, 5.0, 16.0]]]]), brighter_below).round().long()
        tensor([[[[ 0, -5, 16],
                  [ 5,  0, 16]]]])
    """
    check_laf(laf, "laf")
    angle = dominant_orientation(grey_patches_of(img, laf, PS)).unflatten(0, [laf.size(0), laf.size(1)])
    return rotate_laf(laf, rad2deg(angle.to(laf.dtype))[..., None])


def adapt_laf_shape(laf: Tensor, img: Tensor, PS: int = 32, iterations: int = 1) -> Tensor:
    """Adapt the shape of frames to the image, so that gradients in their patches are equally strong in all
    directions. A becomes A times the upright frame of the ellipse of its patch (``affine_shape``), divided by
    the root of its determinant: the area does not change.

    Args:
        laf: (B, N, 2, 3), floating point, in pixels.
        img: (B, 1 or 3, H, W), floating point; colours are converted to grey.
        PS: side of the patches.
        iterations: number of iterations.

    Returns:
        (B, N, 2, 3), of the same centres and scales. A frame whose patch has no ellipse is unchanged.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape, PS or iterations is not as above.

    Example:
        >>> y, x = torch.arange(64.0)[:, None] - 32, torch.arange(64.0) - 32
        >>> blob = torch.exp(-(x * x / 4 + y * y) / 100)[None, None]
        >>> laf = adapt_laf_shape(torch.tensor([[[[12.0, 0.0, 32.0], [0.0, 12.0, 32.0]]]]), blob, 32, 8)
        >>> laf[0, 0, 0, 0] / laf[0, 0, 1, 1] > 1.8
        tensor(True)
    """
    check_laf(laf, "laf")
    if iterations < 1:
        raise ValueError(f"iterations: expected a positive number, got {iterations}")
    for _ in range(iterations):
        moments = (
            affine_shape(grey_patches_of(img, laf, PS)).unflatten(0, [laf.size(0), laf.size(1)]).to(laf.dtype)
        )
        laf = reshaped_by(laf, moments)
    return laf


def reshaped_by(laf: Tensor, moments: Tensor) -> Tensor:
    """Frames (B, N, 2, 3) of the shape of ellipses (B, N, 3), of the same areas; those without an ellipse
    stay."""
    shape = ellipse_to_laf(torch.cat([torch.zeros_like(moments[..., :2]), moments], -1))
    area = determinants(shape)
    proper = area > 0
    root = torch.sqrt(torch.where(proper, area, torch.ones_like(area))).to(laf.dtype)[..., None, None]
    adapted = torch.cat([small_matmul(laf[..., :2], shape[..., :2] / root), laf[..., 2:]], -1)
    return torch.where(proper[..., None, None], adapted, laf)


def _shifted(histogram: Tensor, by: int) -> Tensor:
    """Entry k of (N, bins) moved to k + by, around."""
    bins = histogram.size(1)
    index = (torch.arange(bins, device=histogram.device) + (bins - by)) % bins
    return histogram.index_select(1, index)
