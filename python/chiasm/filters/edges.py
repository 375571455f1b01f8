"""Edge magnitudes by other 3x3 operators than Sobel's, and by Roberts' cross."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.filters.padding import stencil


def scharr(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Magnitude of the gradient by Scharr's kernels, smoothed by 3, 10, 3; the border is replicated.

    H. Scharr, Optimale Operatoren in der digitalen Bildverarbeitung, 2000. Nearly the same in all directions.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the kernels by 32, so that the result is in intensity per pixel; OpenCV's are not.
            scikit-image's ``scharr`` is sqrt(2) times the normalised one.
        eps: keeps the derivative finite where the gradient vanishes.

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
    """Magnitude of the gradient by Prewitt's kernels, smoothed by 1, 1, 1; the border is replicated.

    J. M. S. Prewitt, Object enhancement and extraction, 1970.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the kernels by 6, so that the result is in intensity per pixel. scikit-image's
            ``prewitt`` is sqrt(2) times that.
        eps: keeps the derivative finite where the gradient vanishes.

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
    """Magnitude of the gradient by Roberts' cross, the two diagonal differences of each 2x2 square; the
    border is replicated.

    L. G. Roberts, Machine perception of three-dimensional solids, 1963. The result belongs to the corner
    below and right of its pixel.

    Args:
        input: (B, C, H, W), floating point.
        normalized: divide the differences by sqrt(2), the pixels' distance, so that the result is in
            intensity per pixel; that is scikit-image's ``roberts``.
        eps: keeps the derivative finite where the gradient vanishes.

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
    # A margin before the image too, which the cross does not need: native code is fastest where both ends of
    # the rows are alike.
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
