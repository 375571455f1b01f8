"""Histograms by kernel density estimation, which have gradients."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_floating, check_optional, check_rank, check_tensor
from ..primitives.linalg.matrices import small_matmul


def histogram(x: Tensor, bins: Tensor, bandwidth: Tensor, epsilon: float = 1e-10) -> Tensor:
    """Density of each row's values at the bins' centres, by a Gaussian kernel, normalised to sum to 1.

    E. Parzen, On estimation of a probability density function and mode, Annals of Math. Statistics 33(3),
    1962.

    Args:
        x: (B, N) values, floating point.
        bins: (K,) centres.
        bandwidth: standard deviation of the kernel, a scalar tensor or (1,).
        epsilon: added to the denominator.

    Returns:
        (B, K).

    Raises:
        TypeError: if x is not floating point.
        ValueError: if x is not 2-D, bins not 1-D, or bandwidth more than one number.

    Example:
        >>> histogram(torch.tensor([[0.0, 1.0, 1.0]]), torch.tensor([0.0, 1.0]), torch.tensor(0.1))
        tensor([[0.3333, 0.6667]])
    """
    density = _weights(x, bins, bandwidth, "x").mean(1)
    return density / (density.sum(1, keepdim=True) + epsilon)


def histogram2d(x1: Tensor, x2: Tensor, bins: Tensor, bandwidth: Tensor, epsilon: float = 1e-10) -> Tensor:
    """Joint density of pairs of values, by a Gaussian kernel, normalised to sum to 1.

    Args:
        x1: (B, N) values, floating point.
        x2: (B, N), the values paired with x1.
        bins: (K,) centres, for both.
        bandwidth: standard deviation of the kernel, a scalar tensor or (1,).
        epsilon: added to the denominator.

    Returns:
        (B, K, K): rows are the bins of x1, columns those of x2.

    Raises:
        TypeError: if x1 or x2 is not floating point.
        ValueError: if x1 or x2 is not 2-D, their shapes differ, bins is not 1-D, or bandwidth more than one
            number.

    Example:
        >>> histogram2d(
        ...     torch.tensor([[0.0, 1.0]]),
        ...     torch.tensor([[1.0, 1.0]]),
        ...     torch.tensor([0.0, 1.0]),
        ...     torch.tensor(0.01),
        ... )
        tensor([[[0.0000, 0.5000],
                 [0.0000, 0.5000]]])
    """
    first = _weights(x1, bins, bandwidth, "x1")
    second = _weights(x2, bins, bandwidth, "x2")
    if x1.shape != x2.shape:
        raise ValueError(f"x2: expected x1's shape {list(x1.shape)}, got {list(x2.shape)}")
    joint = small_matmul(first.transpose(1, 2), second)
    return joint / (joint.sum([1, 2], keepdim=True) + epsilon)


def image_histogram2d(
    image: Tensor,
    min: float = 0.0,
    max: float = 255.0,
    n_bins: int = 256,
    bandwidth: Optional[float] = None,
    centers: Optional[Tensor] = None,
    return_pdf: bool = False,
    kernel: str = "triangular",
    eps: float = 1e-10,
) -> Tuple[Tensor, Tensor]:
    """Histogram of each plane; a kernel of u = \\|value - centre\\| / bandwidth splits each pixel between
    bins.

    "triangular" is 1 - u, "uniform" 1 and "epanechnikov" 1 - u^2 where u <= 1, "gaussian" exp(-u^2 / 2).
    Memory and time grow with pixels times bins; ``count_histogram`` is faster.

    Args:
        image: (*, H, W), floating point.
        min: lower end of the range that the bins divide, unless centers are given.
        max: upper end of that range.
        n_bins: number of bins.
        bandwidth: width of the kernel, (max - min) / n_bins by default.
        centers: (n_bins,) the bins' centres, by default those of equal bins from min on, each a bandwidth
            wide.
        return_pdf: also return the histogram divided by its sum.
        kernel: "triangular", "gaussian", "uniform" or "epanechnikov".
        eps: added to the denominator.

    Returns:
        (*, n_bins) the histogram, and (*, n_bins) the density, zeros unless return_pdf.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image has fewer than two dimensions, n_bins or bandwidth is not positive, centers is
            not (n_bins,) or kernel unknown.

    Example:
        >>> image_histogram2d(torch.tensor([[0.25, 0.75, 0.75, 0.5]]), 0.0, 1.0, 2)[0]
        tensor([1.5000, 2.5000])
    """
    check_floating(image, "image")
    check_choice(kernel, ["triangular", "gaussian", "uniform", "epanechnikov"], "kernel")
    if image.dim() < 2:
        raise ValueError(f"image: expected shape (*, H, W), got {list(image.shape)}")
    if n_bins < 1:
        raise ValueError(f"n_bins: expected a positive number, got {n_bins}")
    width = (max - min) / n_bins if bandwidth is None else bandwidth
    if not width > 0.0:
        raise ValueError(f"bandwidth: expected a positive number, got {width}")
    check_optional(centers, "centers")
    if centers is None:
        centers = min + (torch.arange(n_bins, device=image.device).to(image.dtype) + 0.5) * width
    if centers.dim() != 1 or centers.size(0) != n_bins:
        raise ValueError(f"centers: expected shape ({n_bins},), got {list(centers.shape)}")
    u = (image.flatten(-2)[..., None] - centers.to(image.dtype)).abs() / width
    near = (u <= 1.0).to(image.dtype)
    if kernel == "gaussian":
        weight = torch.exp(u * u * -0.5)
    elif kernel == "triangular":
        weight = (1.0 - u) * near
    elif kernel == "uniform":
        weight = near
    else:
        weight = (1.0 - u * u) * near
    counts = weight.sum(-2)
    if return_pdf:
        return counts, counts / (counts.sum(-1, keepdim=True) + eps)
    return counts, torch.zeros_like(counts)


def _weights(x: Tensor, bins: Tensor, bandwidth: Tensor, name: str) -> Tensor:
    """Gaussian weight of each value for each bin, (B, N, K)."""
    check_rank(x, 2, "(B, N)", name)
    check_floating(x, name)
    check_rank(bins, 1, "(K,)", "bins")
    check_tensor(bandwidth, "bandwidth")
    if bandwidth.dim() > 1 or bandwidth.numel() != 1:
        raise ValueError(f"bandwidth: expected a scalar tensor or (1,), got {list(bandwidth.shape)}")
    u = (x[:, :, None] - bins.to(x.dtype)) / bandwidth.to(x.dtype)
    return torch.exp(u * u * -0.5)
