"""Differences of smoothed images."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_image, check_pixels, check_sigmas, odd_pair
from ..primitives.filters.correlation import separable_plus
from ..primitives.filters.stencil import separable_shared
from .gaussian import gaussian_blur2d, gaussian_taps


def unsharp_mask(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma: Union[Tuple[float, float], Tensor],
    border_type: str = "reflect",
) -> Tensor:
    """Sharpen: add the difference between the image and its Gaussian blur.

    For uint8, the smoothed image is the rounded result of :func:`gaussian_blur2d`, and the result is
    saturated; it is identical to ``cv2.addWeighted(x, 2, cv2.GaussianBlur(x, ...), -1, 0)``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_size: odd, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, (y, x) or a tensor (B, 2).
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).

    Returns:
        (B, C, H, W), input + (input - blurred); not clipped for floating point.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if a shape, the kernel size or the border is not as above.

    Example:
        >>> step = torch.tensor([0.0, 0.0, 1.0, 1.0]).reshape(1, 1, 1, 4)
        >>> unsharp_mask(step, (1, 3), (1.0, 1.0)).flatten()
        tensor([ 0.0000, -0.2741,  1.2741,  1.0000])
    """
    check_pixels(input, "input")
    if input.dtype == torch.uint8:
        blurred = gaussian_blur2d(input, kernel_size, sigma, border_type).to(torch.float32)
        return (2.0 * input.to(torch.float32) - blurred).clamp(0.0, 255.0).to(torch.uint8)
    if isinstance(sigma, Tensor):
        return input + (input - gaussian_blur2d(input, kernel_size, sigma, border_type))
    check_sigmas(sigma, "sigma")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    return separable_plus(
        input, gaussian_taps(ky, sigma[0]), gaussian_taps(kx, sigma[1]), border_type, -1.0, 2.0
    )


def difference_of_gaussians(
    input: Tensor,
    low_sigma: float,
    high_sigma: Optional[float] = None,
    border_type: str = "replicate",
    truncate: float = 4.0,
) -> Tensor:
    """Band-pass filter: the image smoothed with low_sigma minus the image smoothed with high_sigma.

    D. Marr, E. Hildreth, Theory of edge detection, 1980. Like scikit-image's ``difference_of_gaussians``.

    Args:
        input: (B, C, H, W), floating point.
        low_sigma: smaller standard deviation in pixels.
        high_sigma: larger standard deviation; 1.6 * low_sigma by default, which approximates a Laplacian of
            Gaussian.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        truncate: kernels end at this many standard deviations, rounded to whole pixels.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, a sigma is not positive or high_sigma is below low_sigma, or the
            border is not as above.

    Example:
        >>> difference_of_gaussians(torch.ones(1, 1, 9, 9), 1.0).abs().max() < 1e-6
        tensor(True)
    """
    check_image(input, "input")
    high = 1.6 * low_sigma if high_sigma is None else high_sigma
    if not (low_sigma > 0.0 and high >= low_sigma):
        raise ValueError(f"high_sigma: expected 0 < low_sigma <= high_sigma, got {low_sigma} and {high}")
    low_taps = gaussian_taps(2 * int(truncate * low_sigma + 0.5) + 1, low_sigma)
    high_taps = gaussian_taps(2 * int(truncate * high + 0.5) + 1, high)
    return separable_shared(input, low_taps, low_taps, border_type) - separable_shared(
        input, high_taps, high_taps, border_type
    )
