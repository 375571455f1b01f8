"""Gradient magnitudes by the operators of Scharr, Prewitt and Roberts."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels
from ..primitives.core.layout import in_planes
from ..primitives.filters.derivatives import length_of_differences, lengths_of_bytes
from ..primitives.filters.padding import stencil
from ..primitives.numbers.loss_reduction import narrowed, widened


def scharr(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Scharr's kernels, with the smoothing 3, 10, 3; the border is replicated. H.
    Scharr, Optimale Operatoren in der digitalen Bildverarbeitung, 2000. The magnitude is nearly independent
    of the edge direction.

    Args:
        input: (B, C, H, W), floating point or uint8.
        normalized: divide the kernels by 32, so that the result is in intensity per pixel; OpenCV does not.
            scikit-image's ``scharr`` is sqrt(2) times the normalized result.
        eps: keeps the derivative finite where the gradient is zero; not used for uint8.

    Returns:
        (B, C, H, W), sqrt(dx^2 + dy^2 + eps), for uint8 rounded to the nearest integer (halves to even) and
        saturated.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> scharr(torch.arange(5.0).expand(1, 1, 5, 5), eps=0.0)[0, 0, 2]
        tensor([0.5000, 1.0000, 1.0000, 1.0000, 0.5000])
    """
    return _length(input, 3, 10, 32 if normalized else 1, eps)


def prewitt(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Prewitt's kernels, with the smoothing 1, 1, 1; the border is replicated.

    J. M. S. Prewitt, Object enhancement and extraction, 1970.

    Args:
        input: (B, C, H, W), floating point or uint8.
        normalized: divide the kernels by 6, so that the result is in intensity per pixel. scikit-image's
            ``prewitt`` is sqrt(2) times the normalized result.
        eps: keeps the derivative finite where the gradient is zero; not used for uint8.

    Returns:
        (B, C, H, W), sqrt(dx^2 + dy^2 + eps), for uint8 rounded to the nearest integer (halves to even) and
        saturated.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> prewitt(torch.arange(5.0).expand(1, 1, 5, 5), eps=0.0)[0, 0, 2]
        tensor([0.5000, 1.0000, 1.0000, 1.0000, 0.5000])
    """
    return _length(input, 1, 1, 6 if normalized else 1, eps)


def roberts(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Gradient magnitude by Roberts' cross, the two diagonal differences of each 2x2 square.

    L. G. Roberts, Machine perception of three-dimensional solids, 1963. The result belongs to the lower right
    corner of its pixel. The border is replicated.

    Args:
        input: (B, C, H, W), floating point or uint8.
        normalized: divide the differences by sqrt(2), the pixels' distance, so that the result is in
            intensity per pixel, as in scikit-image's ``roberts``.
        eps: keeps the derivative finite where the gradient is zero; not used for uint8.

    Returns:
        (B, C, H, W), for uint8 rounded to the nearest integer and saturated.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> roberts(torch.arange(4.0).expand(1, 1, 3, 4), eps=0.0)[0, 0, 0]
        tensor([1., 1., 1., 0.])
    """
    check_pixels(input, "input")
    scale = 0.5 if normalized else 1.0
    # The cross needs no margin before the image; a stencil has the same margin at both ends of its rows.
    if input.dtype == torch.uint8:
        exact = in_planes(input).to(torch.float64)
        lengths = _cross(exact, (1, 1), (1, 1), "replicate", scale, 0.0)
        return torch.round(lengths).clamp(max=255.0).to(torch.uint8)
    return narrowed(_cross(widened(input), (1, 1), (1, 1), "replicate", scale, eps), input)


def _length(input: Tensor, side: int, middle: int, divisor: int, eps: float) -> Tensor:
    check_pixels(input, "input")
    if input.dtype == torch.uint8:
        return lengths_of_bytes(input, side, middle, divisor)
    lengths = length_of_differences(
        widened(input), (1, 1), (1, 1), "replicate", float(side), float(middle), 1.0 / divisor, eps
    )
    return narrowed(lengths, input)


@stencil
def _cross(p: Tensor, scale: float, eps: float) -> Tensor:
    height, width = p.size(2) - 2, p.size(3) - 2
    upper, lower = p[:, :, 1 : height + 1, 1:], p[:, :, 2 : height + 2, 1:]
    first = upper[..., :width] - lower[..., 1:]
    second = upper[..., 1:] - lower[..., :width]
    return torch.sqrt(first * (first * scale) + second * (second * scale) + eps)
