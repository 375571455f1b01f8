"""Gaussian smoothing."""

import math
from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels, check_positive, check_sigmas, odd_pair
from ..primitives.core.materialise import materialised
from ..primitives.filters.correlation import correlated2d
from ..primitives.filters.fixed_point import fixed_taps, separable_bytes
from ..primitives.filters.stencil import separable as separable_per_sample
from ..primitives.filters.stencil import separable_shared


def get_gaussian_kernel1d(
    kernel_size: int,
    sigma: Union[float, Tensor],
    force_even: bool = False,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """Sampled Gaussian that sums to 1.

    Unlike in Kornia, the device is that of ``sigma`` (CPU for a float), and ``dtype`` is used only for a
    float sigma.

    Args:
        kernel_size: number of taps, odd unless force_even.
        sigma: standard deviation in pixels; a float, or a tensor (B,) or (B, 1).
        force_even: allow an even kernel_size.
        dtype: dtype of the kernel when sigma is a float.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, kernel_size), with B = 1 for a float sigma.

    Raises:
        ValueError: if kernel_size is not positive, or even without force_even, or sigma a number that is not
            positive.

    Example:
        >>> get_gaussian_kernel1d(3, 1.0).sum()
        tensor(1.)
    """
    if kernel_size < 1 or (kernel_size % 2 == 0 and not force_even):
        raise ValueError(f"kernel_size: expected a positive odd size, got {kernel_size}")
    if isinstance(sigma, Tensor):
        s = sigma.reshape(-1, 1)
    else:
        check_positive(sigma, "sigma")
        s = torch.full([1, 1], sigma, dtype=dtype)
    x = torch.arange(kernel_size, device=s.device).to(s.dtype) - (kernel_size - 1) * 0.5
    weight = torch.exp(-(x * x) / (2.0 * s * s))
    kernel = weight / weight.sum(1, keepdim=True)
    return kernel if device is None else kernel.to(device)


def gaussian_blur2d(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma: Union[Tuple[float, float], Tensor],
    border_type: str = "reflect",
    separable: bool = True,
) -> Tensor:
    """Convolve with a normalised Gaussian.

    For uint8, the taps are rounded to multiples of 1/256, the sums are exact, and the result is rounded
    (halves up); it is identical to that of OpenCV's 8-bit GaussianBlur.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_size: odd number of taps, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, positive: (y, x), or a tensor (B, 2) with one pair per sample
            (or (1, 2) for all). Values of a tensor are not checked: 0 gives NaN.
        border_type: "reflect" (edge pixel not repeated; needs H > rows // 2, W > columns // 2), "replicate",
            "circular" or "constant" (zeros).
        separable: two 1-D passes (fast) instead of one 2-D pass; the result is the same up to rounding.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if a shape, the kernel size, sigma or the border is not as above.

    Example:
        >>> gaussian_blur2d(torch.ones(1, 1, 5, 5), 3, (1.0, 1.0)).shape
        torch.Size([1, 1, 5, 5])
    """
    check_pixels(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    if input.dtype == torch.uint8:
        exact_y, exact_x = gaussian_kernels(
            ky, kx, sigma, input.size(0), torch.empty(0, dtype=torch.float64, device=input.device), "sigma"
        )
        return separable_bytes(input, fixed_taps(exact_y), fixed_taps(exact_x), border_type)
    if separable and not isinstance(sigma, Tensor):
        check_sigmas(sigma, "sigma")
        return separable_shared(input, gaussian_taps(ky, sigma[0]), gaussian_taps(kx, sigma[1]), border_type)
    kernel_y, kernel_x = gaussian_kernels(ky, kx, sigma, input.size(0), input, "sigma")
    if separable:
        return separable_per_sample(input, kernel_y, kernel_x, border_type)
    kernel = materialised(kernel_y[:, :, None] * kernel_x[:, None, :], 1)
    return correlated2d(input, kernel, border_type)


def gaussian_taps(kernel_size: int, sigma: float) -> List[float]:
    """The weights of ``get_gaussian_kernel1d`` as numbers; raise ValueError if they are more than any image
    has pixels along an axis, as for a sigma of 1e30."""
    if kernel_size > 65535:
        raise ValueError(f"kernel_size, sigma: expected a window of at most 65535 taps, got {kernel_size}")
    weights = [math.exp(-0.5 * ((i - (kernel_size - 1) * 0.5) / sigma) ** 2) for i in range(kernel_size)]
    total = 0.0
    for weight in weights:
        total += weight
    return [weight / total for weight in weights]


def gaussian_kernels(
    ky: int, kx: int, sigma: Union[Tuple[float, float], Tensor], batch: int, like: Tensor, name: str
) -> Tuple[Tensor, Tensor]:
    """Kernels (B or 1, ky) and (B or 1, kx), for a batch of size B, in the dtype and on the device of
    ``like``."""
    if isinstance(sigma, Tensor):
        if sigma.dim() != 2 or sigma.size(1) != 2:
            raise ValueError(f"{name}: expected shape (B, 2), got {list(sigma.shape)}")
        if sigma.size(0) != batch and sigma.size(0) != 1:
            raise ValueError(f"{name}: expected shape ({batch}, 2) or (1, 2), got {list(sigma.shape)}")
        s = sigma.to(like.dtype)
        # Stored, so that the exponentials of the taps are not computed again for every pixel.
        return materialised(get_gaussian_kernel1d(ky, s[:, 0]), 1), materialised(
            get_gaussian_kernel1d(kx, s[:, 1]), 1
        )
    check_sigmas(sigma, name)
    kernel_y = torch.tensor([gaussian_taps(ky, sigma[0])], dtype=like.dtype, device=like.device)
    kernel_x = torch.tensor([gaussian_taps(kx, sigma[1])], dtype=like.dtype, device=like.device)
    return kernel_y, kernel_x
