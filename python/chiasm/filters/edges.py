"""Gradient magnitudes by the operators of Scharr, Prewitt and Roberts."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.filters.padding import stencil


def scharr(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Scharr's kernels, with the smoothing 3, 10, 3; the border is replicated. H.
    Scharr, Optimale Operatoren in der digitalen Bildverarbeitung, 2000. The magnitude is nearly independent
    of the edge direction.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the kernels by 32, so that the result is in intensity per pixel; OpenCV does not.
            scikit-image's ``scharr`` is sqrt(2) times the normalized result.
        eps: keeps the derivative finite where the gradient is zero.

    Returns:
        (B, C, H, W), sqrt(dx^2 + dy^2 + eps).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D.

    Example:
        >>> scharr(torch.arange(5.0).expand(1, 1, 5, 5), eps=0.0)[0, 0, 2]
        tensor([0.5000, 1.0000, 1.0000, 1.0000, 0.5000])
    """
    check_image(input, "input")
    return _magnitude(input, (1, 1), (1, 1), "replicate", 3.0, 10.0, 1.0 / 32.0 if normalized else 1.0, eps)


def prewitt(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Prewitt's kernels, with the smoothing 1, 1, 1; the border is replicated.

    J. M. S. Prewitt, Object enhancement and extraction, 1970.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the kernels by 6, so that the result is in intensity per pixel. scikit-image's
            ``prewitt`` is sqrt(2) times the normalized result.
        eps: keeps the derivative finite where the gradient is zero.

    Returns:
        (B, C, H, W), sqrt(dx^2 + dy^2 + eps).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D.

    Example:
        >>> prewitt(torch.arange(5.0).expand(1, 1, 5, 5), eps=0.0)[0, 0, 2]
        tensor([0.5000, 1.0000, 1.0000, 1.0000, 0.5000])
    """
    check_image(input, "input")
    return _magnitude(input, (1, 1), (1, 1), "replicate", 1.0, 1.0, 1.0 / 6.0 if normalized else 1.0, eps)


def roberts(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Roberts' cross, the two diagonal differences of each 2x2 square.

    L. G. Roberts, Machine perception of three-dimensional solids, 1963. The result belongs to the lower right
    corner of its pixel. The border is replicated.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the differences by sqrt(2), the pixels' distance, so that the result is in
            intensity per pixel, as in scikit-image's ``roberts``.
        eps: keeps the derivative finite where the gradient is zero.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D.

    Example:
        >>> roberts(torch.arange(4.0).expand(1, 1, 3, 4), eps=0.0)[0, 0, 0]
        tensor([1., 1., 1., 0.])
    """
    check_image(input, "input")
    # The cross needs no margin before the image; a stencil has the same margin at both ends of its rows.
    return _cross(input, (1, 1), (1, 1), "replicate", 0.5 if normalized else 1.0, eps)


@stencil
def _cross(p: Tensor, scale: float, eps: float) -> Tensor:
    height, width = p.size(2) - 2, p.size(3) - 2
    upper, lower = p[:, :, 1 : height + 1, 1:], p[:, :, 2 : height + 2, 1:]
    first = upper[..., :width] - lower[..., 1:]
    second = upper[..., 1:] - lower[..., :width]
    return torch.sqrt((first * first + second * second) * scale + eps)


@stencil
def _magnitude(p: Tensor, side: float, middle: float, scale: float, eps: float) -> Tensor:
    height, width = p.size(2) - 2, p.size(3) - 2
    top, centre, bottom = p[:, :, 0:height], p[:, :, 1 : height + 1], p[:, :, 2 : height + 2]
    smooth = (top + bottom) * side + centre * middle
    slope = bottom - top
    dx = (smooth[..., 2 : width + 2] - smooth[..., 0:width]) * scale
    dy = (
        (slope[..., 0:width] + slope[..., 2 : width + 2]) * side + slope[..., 1 : width + 1] * middle
    ) * scale
    return torch.sqrt(dx * dx + dy * dy + eps)
