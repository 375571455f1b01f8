"""Gaussian kernels, sampled, integrated and discrete."""

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_number,
    check_positive,
    check_sigmas,
    check_triple,
)
from .gaussian import get_gaussian_kernel1d


def gaussian(
    window_size: int,
    sigma: Union[float, Tensor],
    mean: Optional[Union[float, Tensor]] = None,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """Sampled Gaussian that sums to 1, with any mean.

    Unlike in Kornia, the device is that of ``sigma`` (CPU for a float), and ``dtype`` is used only for a
    float sigma.

    Args:
        window_size: number of taps.
        sigma: standard deviation in pixels; a float, or a tensor (B,) or (B, 1).
        mean: position of the maximum, a float or a tensor (B,) or (B, 1); for an even window, the maximum
            lies half a pixel before. window_size // 2 by default.
        dtype: dtype of the result when sigma is a float.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, window_size), with B = 1 for floats.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if window_size is not positive, or a shape is not as above.

    Example:
        >>> gaussian(3, 1.0, 0.0)
        tensor([[0.5741, 0.3482, 0.0777]])
    """
    if window_size < 1:
        raise ValueError(f"window_size: expected a positive size, got {window_size}")
    s = _deviation(sigma, dtype)
    x = _positions(window_size, s, 0.0)
    if mean is None:
        x = x - window_size // 2
    else:
        middle = as_column(mean, s.dtype, "mean").to(s.device)
        check_broadcastable(middle, s, "mean", "sigma")
        x = x - middle
    if window_size % 2 == 0:
        x = x + 0.5
    weight = torch.exp(-(x * x) / (2.0 * s * s))
    kernel = weight / weight.sum(1, keepdim=True)
    return kernel if device is None else kernel.to(device)


def get_gaussian_erf_kernel1d(
    kernel_size: int,
    sigma: Union[float, Tensor],
    force_even: bool = False,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """Gaussian integrated over each pixel, normalized to sum 1. Unlike in Kornia, an even kernel is
    symmetric, the device is that of ``sigma`` (CPU for a float), and ``dtype`` is used only for a float
    sigma.

    Args:
        kernel_size: number of taps, odd unless force_even.
        sigma: standard deviation in pixels; a float, or a tensor (B,) or (B, 1).
        force_even: allow an even kernel_size.
        dtype: dtype of the kernel when sigma is a float.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, kernel_size), with B = 1 for a float sigma.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if kernel_size is not positive, or even without force_even, or sigma's shape is not as
            above.

    Example:
        >>> get_gaussian_erf_kernel1d(3, 1.0)
        tensor([[0.2790, 0.4420, 0.2790]])
    """
    if kernel_size < 1 or (kernel_size % 2 == 0 and not force_even):
        raise ValueError(f"kernel_size: expected a positive odd size, got {kernel_size}")
    s = _deviation(sigma, dtype)
    # The edges of the pixels, in units of sqrt(2) sigma; each tap is the integral between two edges.
    x = _positions(kernel_size, s, (kernel_size - 1) * 0.5)
    t = 0.7071067811865476 / s
    weight = torch.erf((x + 0.5) * t) - torch.erf((x - 0.5) * t)
    kernel = weight / weight.sum(1, keepdim=True)
    return kernel if device is None else kernel.to(device)


def get_gaussian_discrete_kernel1d(
    kernel_size: int,
    sigma: Union[float, Tensor],
    force_even: bool = False,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """The discrete analog of the Gaussian, exp(-t) I_n(t), t = sigma^2, normalized to sum 1.

    I_n are modified Bessel functions. T. Lindeberg, Scale-space for discrete signals, TPAMI 1990. It is
    accurate for small sigmas, where a sampled Gaussian is not. The device is that of ``sigma`` (CPU for a
    float), and ``dtype`` is used only for a float sigma.

    Args:
        kernel_size: number of taps, odd.
        sigma: standard deviation in pixels; a float, or a tensor (B,) or (B, 1).
        force_even: for compatibility with Kornia; it has no effect, since there is no even form.
        dtype: dtype of the kernel when sigma is a float.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, kernel_size), with B = 1 for a float sigma.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if kernel_size is not odd and positive, or sigma's shape is not as above.

    Example:
        >>> get_gaussian_discrete_kernel1d(3, 1.0)
        tensor([[0.2358, 0.5283, 0.2358]])
    """
    if kernel_size < 1 or kernel_size % 2 == 0:
        raise ValueError(f"kernel_size: expected a positive odd size, got {kernel_size}")
    s = _deviation(sigma, dtype)
    t = s * s
    radius = kernel_size // 2
    # r(n) = I_n / I_(n-1) = t / (2 n + t r(n+1)), from an order so high that the start value has no
    # influence; the error of the start value is O(n^2 / t^2) (D. E. Amos, Computation of modified Bessel
    # functions and their ratios, 1974).
    start = radius + 32
    ratio = t / (start - 0.5 + torch.sqrt((start + 0.5) * (start + 0.5) + t * t))
    ratios: List[Tensor] = []
    for step in range(start - 1):
        order = start - 1 - step
        ratio = t / (2.0 * order + t * ratio)
        if order <= radius:
            ratios.append(ratio)
    weight = torch.ones_like(s)
    half = [weight]
    for n in range(radius):
        weight = weight * ratios[radius - 1 - n]
        half.append(weight)
    taps = [half[radius - n] for n in range(radius)] + half
    kernel = torch.cat(taps, 1)
    kernel = kernel / kernel.sum(1, keepdim=True)
    return kernel if device is None else kernel.to(device)


def get_gaussian_kernel2d(
    kernel_size: Union[int, Tuple[int, int]],
    sigma: Union[Tuple[float, float], Tensor],
    force_even: bool = False,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """Outer product of two sampled Gaussians, which sums to 1.

    Unlike in Kornia, the device is that of ``sigma`` (CPU for floats), and ``dtype`` is used only for floats.

    Args:
        kernel_size: odd unless force_even, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, (y, x) or a tensor (B, 2).
        force_even: allow even sizes.
        dtype: dtype of the kernel when sigma is floats.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, rows, columns), with B = 1 for floats.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a size is not positive, or even without force_even, or sigma's shape is not as above.

    Example:
        >>> get_gaussian_kernel2d((1, 3), (1.0, 1.0))
        tensor([[[0.2741, 0.4519, 0.2741]]])
    """
    if isinstance(kernel_size, int):
        ky, kx = kernel_size, kernel_size
    else:
        ky, kx = kernel_size
    if isinstance(sigma, Tensor):
        s = _check_sigmas(sigma, 2)
    else:
        check_sigmas(sigma, "sigma")
        s = torch.tensor([[sigma[0], sigma[1]]], dtype=dtype)
    along_y = get_gaussian_kernel1d(ky, s[:, 0], force_even)
    kernel = along_y[:, :, None] * get_gaussian_kernel1d(kx, s[:, 1], force_even)[:, None, :]
    return kernel if device is None else kernel.to(device)


def get_gaussian_kernel3d(
    kernel_size: Union[int, Tuple[int, int, int]],
    sigma: Union[Tuple[float, float, float], Tensor],
    force_even: bool = False,
    dtype: torch.dtype = torch.float32,
    device: Optional[torch.device] = None,
) -> Tensor:
    """Outer product of three sampled Gaussians, which sums to 1.

    Unlike in Kornia, the device is that of ``sigma`` (CPU for floats), and ``dtype`` is used only for floats.

    Args:
        kernel_size: odd unless force_even, one for all axes or (depth, rows, columns).
        sigma: standard deviations in voxels, (z, y, x) or a tensor (B, 3).
        force_even: allow even sizes.
        dtype: dtype of the kernel when sigma is floats.
        device: the device of the result, by default that of sigma.

    Returns:
        (B, depth, rows, columns), with B = 1 for floats.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a size is not positive, or even without force_even, or sigma's shape is not as above.

    Example:
        >>> get_gaussian_kernel3d((1, 1, 3), (1.0, 1.0, 1.0))
        tensor([[[[0.2741, 0.4519, 0.2741]]]])
    """
    if isinstance(kernel_size, int):
        kz, ky, kx = kernel_size, kernel_size, kernel_size
    else:
        kz, ky, kx = kernel_size
    if isinstance(sigma, Tensor):
        s = _check_sigmas(sigma, 3)
    else:
        check_triple(sigma, "sigma")
        if not (sigma[0] > 0.0 and sigma[1] > 0.0 and sigma[2] > 0.0):
            raise ValueError(f"sigma: expected positive numbers, got ({sigma[0]}, {sigma[1]}, {sigma[2]})")
        s = torch.tensor([[sigma[0], sigma[1], sigma[2]]], dtype=dtype)
    plane = (
        get_gaussian_kernel1d(ky, s[:, 1], force_even)[:, :, None]
        * get_gaussian_kernel1d(kx, s[:, 2], force_even)[:, None, :]
    )
    kernel = get_gaussian_kernel1d(kz, s[:, 0], force_even)[:, :, None, None] * plane[:, None]
    return kernel if device is None else kernel.to(device)


def _deviation(sigma: Union[float, Tensor], dtype: torch.dtype) -> Tensor:
    """``as_column`` for a number that must be positive."""
    if not isinstance(sigma, Tensor):
        check_positive(sigma, "sigma")
    return as_column(sigma, dtype, "sigma")


def as_column(value: Union[float, Tensor], dtype: torch.dtype, name: str) -> Tensor:
    """A float as (1, 1) of ``dtype``, a floating-point tensor (B,), (B, 1) or a scalar as (B, 1)."""
    if isinstance(value, Tensor):
        check_floating(value, name)
        if value.dim() > 2 or (value.dim() == 2 and value.size(1) != 1):
            raise ValueError(f"{name}: expected shape (B,) or (B, 1), got {list(value.shape)}")
        return value.reshape(-1, 1)
    check_number(value, name)
    return torch.full([1, 1], value, dtype=dtype)


def _positions(size: int, like: Tensor, origin: float) -> Tensor:
    return torch.arange(size, device=like.device).to(like.dtype) - origin


def _check_sigmas(sigma: Tensor, axes: int) -> Tensor:
    if sigma.dim() != 2 or sigma.size(1) != axes:
        raise ValueError(f"sigma: expected shape (B, {axes}), got {list(sigma.shape)}")
    check_floating(sigma, "sigma")
    return sigma
