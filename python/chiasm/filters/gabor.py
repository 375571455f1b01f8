"""Gabor filters: waves multiplied by a Gaussian."""

import math
from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_all_broadcastable, check_image, odd_pair
from .correlation import check_kernel_batch, filter2d
from .gaussian_kernels import as_column


def get_gabor_kernel2d(
    kernel_size: Union[int, Tuple[int, int]],
    sigma: Union[float, Tensor],
    theta: Union[float, Tensor],
    lambd: Union[float, Tensor],
    gamma: Union[float, Tensor] = 0.5,
    psi: Union[float, Tensor] = 0.0,
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """A cosine wave times a Gaussian, like OpenCV's ``getGaborKernel``. The kernel is exp(-(u^2 + gamma^2
    v^2) / (2 sigma^2)) cos(2 pi u / lambd + psi).

    J. G. Daugman, Uncertainty relation for resolution in space, spatial frequency, and orientation, 1985.
    Here u = -(x cos(theta) + y sin(theta)) and v = x sin(theta) - y cos(theta), where x and y are measured
    from the centre of the kernel.

    Args:
        kernel_size: odd, one for both axes or (rows, columns).
        sigma: standard deviation along the wave, in pixels. This and the following are floats or tensors
            (B,).
        theta: direction of the wave, in radians, clockwise from x.
        lambd: wavelength in pixels.
        gamma: the ratio of sigma to the standard deviation across the wave.
        psi: phase in radians; 0 gives an even kernel, pi / 2 (OpenCV's default) an odd one.
        dtype: dtype of the kernel when all are floats.

    Returns:
        (B, rows, columns), with B = 1 for floats; not normalised.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if the kernel size is not odd and positive, or a shape not as above.

    Example:
        >>> get_gabor_kernel2d((1, 3), 1.0, 0.0, 4.0)
        tensor([[[-2.6512e-08,  1.0000e+00, -2.6512e-08]]])
    """
    ky, kx = odd_pair(kernel_size, "kernel_size")
    kind, device = dtype, torch.device("cpu")
    for value in (sigma, theta, lambd, gamma, psi):
        if isinstance(value, Tensor):
            kind, device = value.dtype, value.device
    columns = [
        as_column(sigma, kind, "sigma").to(device),
        as_column(theta, kind, "theta").to(device),
        as_column(lambd, kind, "lambd").to(device),
        as_column(gamma, kind, "gamma").to(device),
        as_column(psi, kind, "psi").to(device),
    ]
    check_all_broadcastable(columns, ["sigma", "theta", "lambd", "gamma", "psi"])
    s, angle, wavelength, aspect, phase = [column[:, None] for column in columns]
    x = (torch.arange(kx, device=device).to(kind) - kx // 2)[None, None, :]
    y = (torch.arange(ky, device=device).to(kind) - ky // 2)[None, :, None]
    u = -(x * torch.cos(angle) + y * torch.sin(angle))
    v = (x * torch.sin(angle) - y * torch.cos(angle)) * aspect
    return torch.exp(-0.5 * (u * u + v * v) / (s * s)) * torch.cos(2.0 * math.pi * u / wavelength + phase)


def gabor(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma: Union[float, Tensor],
    theta: Union[float, Tensor],
    lambd: Union[float, Tensor],
    gamma: Union[float, Tensor] = 0.5,
    psi: Union[float, Tensor] = 0.0,
    border_type: str = "reflect",
) -> Tensor:
    """Correlate with ``get_gabor_kernel2d``, with one kernel for each sample if its arguments are tensors.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd, one for both axes or (rows, columns).
        sigma, theta, lambd, gamma, psi: floats or tensors (B,); see ``get_gabor_kernel2d``.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape, the kernel size or the border is not as above.

    Example:
        >>> stripes = torch.cos(torch.arange(16.0) * math.pi / 2).expand(1, 1, 16, 16)
        >>> (gabor(stripes, 7, 2.0, 0.0, 4.0).abs() > gabor(stripes, 7, 2.0, math.pi / 2, 4.0).abs())[
        ...     0, 0, 8, 8
        ... ]
        tensor(True)
    """
    check_image(input, "input")
    kernel = get_gabor_kernel2d(kernel_size, sigma, theta, lambd, gamma, psi, input.dtype)
    check_kernel_batch(kernel, input, "sigma, theta, lambd, gamma, psi")
    return filter2d(input, kernel.to(input.device), border_type)
