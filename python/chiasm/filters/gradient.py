"""Derivatives by finite differences."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_pixels
from ..primitives.filters.derivatives import (
    derivatives_of_bytes,
    gradient,
    magnitude_of_bytes,
    sobel_magnitude,
)
from ..primitives.filters.padding import stencil


def spatial_gradient(input: Tensor, mode: str = "sobel", order: int = 1, normalized: bool = True) -> Tensor:
    """First or second derivatives; the border is replicated.

    First order: "sobel", "scharr" and "prewitt" are 3x3 operators, whose smoothing is 1, 2, 1, or 3, 10, 3
    (H. Scharr, Optimale Operatoren in der digitalen Bildverarbeitung, 2000), or 1, 1, 1 (J. M. S. Prewitt,
    Object enhancement and extraction, 1970); "diff" is the central difference. Second order: "sobel" is a 5x5
    kernel, "diff" a 3x3 one; both return d2/dx2, d2/dxdy, d2/dy2.

    For uint8, the first derivatives (not normalized) are int16; those of "sobel" and "scharr" equal OpenCV's
    ``Sobel`` and ``Scharr`` with CV_16S.

    Args:
        input: (B, C, H, W), floating point or uint8.
        mode: "sobel" or "diff"; for the first order also "scharr" or "prewitt".
        order: 1 or 2; must be 1 for uint8.
        normalized: divide each kernel by its response to a slope of one intensity per pixel, or to a second
            derivative of one, so that the results are derivatives; must be False for uint8.

    Returns:
        (B, C, 2, H, W): d/dx, d/dy; or (B, C, 3, H, W): xx, xy, yy. The dtype is the input's, or int16 for
        uint8.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D, or mode, order or normalized is not as above.

    Example:
        >>> ramp = torch.arange(5.0).expand(1, 1, 5, 5)
        >>> spatial_gradient(ramp)[0, 0, :, 2, 2]
        tensor([1., 0.])
    """
    check_pixels(input, "input")
    if order != 1 and order != 2:
        raise ValueError(f"order: expected 1 or 2, got {order}")
    check_choice(mode, ["sobel", "diff", "scharr", "prewitt"] if order == 1 else ["sobel", "diff"], "mode")
    if input.dtype == torch.uint8:
        if order != 1:
            raise ValueError(f"order: expected 1 on bytes, got {order}")
        if normalized:
            raise ValueError("normalized: expected False on bytes, got True")
        return derivatives_of_bytes(input, mode)
    if order == 1:
        return gradient(input, (1, 1), (1, 1), "replicate", mode, normalized)
    radius = 2 if mode == "sobel" else 1
    return _second_derivatives(input, (radius, radius), (radius, radius), "replicate", mode, normalized)


def sobel(input: Tensor, normalized: bool = True, eps: float = 1e-6) -> Tensor:
    """Magnitude of the Sobel gradient, sqrt(dx^2 + dy^2 + eps); the border is replicated.

    I. Sobel, G. Feldman, A 3x3 isotropic gradient operator for image processing, 1968.

    For uint8, the result is rounded to the nearest integer (halves to even) and saturated.

    Args:
        input: (B, C, H, W), floating point or uint8.
        normalized: divide the kernels by 8, so that the result is in intensity per pixel; OpenCV does not.
        eps: keeps the derivative finite where the gradient is zero; not used for uint8.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> sobel(torch.arange(5.0).expand(1, 1, 5, 5), eps=0.0)[0, 0, 2]
        tensor([0.5000, 1.0000, 1.0000, 1.0000, 0.5000])
    """
    check_pixels(input, "input")
    if input.dtype == torch.uint8:
        return magnitude_of_bytes(input, normalized)
    return sobel_magnitude(input, normalized, eps)


@stencil
def _second_derivatives(p: Tensor, mode: str, normalized: bool) -> Tensor:
    if mode == "diff":
        height = p.size(2) - 2
        width = p.size(3) - 2
        middle = p[:, :, 1 : height + 1]
        dxx = middle[..., 0:width] - 2.0 * middle[..., 1 : width + 1] + middle[..., 2 : width + 2]
        centre = p[..., 1 : width + 1]
        dyy = centre[:, :, 0:height] - 2.0 * centre[:, :, 1 : height + 1] + centre[:, :, 2 : height + 2]
        slope = p[:, :, 2 : height + 2] - p[:, :, 0:height]
        dxy = slope[..., 2 : width + 2] - slope[..., 0:width]
        return torch.stack([dxx, dxy * 0.25 if normalized else dxy, dyy], 2)
    smooth_y, slope_y, curve_y = _five_taps(p, 2)
    dxx = _five_taps(smooth_y, 3)[2]
    dxy = _five_taps(slope_y, 3)[1]
    dyy = _five_taps(curve_y, 3)[0]
    # On x^2 / 2, x y and y^2 / 2, whose second derivatives are 1, the kernels give 64.
    return torch.stack([dxx, dxy, dyy], 2) * (1.0 / 64.0 if normalized else 1.0)


def _five_taps(p: Tensor, dim: int) -> Tuple[Tensor, Tensor, Tensor]:
    """Sobel's 5-tap smoothing, slope and curvature along ``dim``."""
    size = p.size(dim) - 4
    a, b, c = p.narrow(dim, 0, size), p.narrow(dim, 1, size), p.narrow(dim, 2, size)
    d, e = p.narrow(dim, 3, size), p.narrow(dim, 4, size)
    return a + 4.0 * b + 6.0 * c + 4.0 * d + e, e - a + 2.0 * (d - b), a - 2.0 * c + e
