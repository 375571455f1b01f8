"""Multi-scale structural dissimilarity combined with an absolute difference."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..filters.gaussian import gaussian_taps
from ..primitives.core.checks import check_image, check_interval, check_reduction, check_same_shape
from ..primitives.filters.stencil import separable_scales, separable_shared
from ..primitives.numbers.loss_reduction import narrowed, reduced, widened


def ms_ssim_loss(
    img1: Tensor,
    img2: Tensor,
    sigmas: Optional[List[float]] = None,
    data_range: float = 1.0,
    K: Tuple[float, float] = (0.01, 0.03),
    alpha: float = 0.025,
    compensation: float = 200.0,
    reduction: str = "mean",
) -> Tensor:
    """compensation (alpha (1 - MS-SSIM) + (1 - alpha) G \\|img1 - img2\\| / data_range), G the widest of the
    Gaussians.

    H. Zhao et al., Loss functions for image restoration with neural networks, IEEE TCI 3(1), 2017, equations
    9 and 14, with Gaussians of growing sigma as scales instead of smaller images. MS-SSIM is the luminance
    term of SSIM at the widest Gaussian times the product of the contrast terms of all. Windows have four
    times the largest sigma plus one taps (33), and images are reflected at the border. Channels are
    independent. Kornia adds zeros at the border, so that its loss, of grey images too, differs within twice
    the largest sigma of it; inside it is the mean over the channels, which Kornia's map (B, H, W) holds. The
    paper uses the weight 0.84, without compensation.

    Args:
        img1: (B, C, H, W), floating point; H and W more than twice the largest sigma.
        img2: like img1.
        sigmas: standard deviations in pixels, ascending; by default 0.5, 1, 2, 4 and 8.
        data_range: the images' dynamic range L.
        K: the constants of SSIM.
        alpha: weight of the dissimilarity; the absolute difference has the weight 1 - alpha.
        compensation: factor of the whole loss.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar, or the map (B, C, H, W) for "none".

    Raises:
        TypeError: if an image is not floating point.
        ValueError: if a shape or a choice is not as above, or sigmas are not ascending positive numbers of
            which the last is 1/2 or more.

    Example:
        >>> x = torch.zeros(1, 1, 20, 20)
        >>> ms_ssim_loss(x, x), ms_ssim_loss(x, x + 1.0)
        (tensor(0.), tensor(199.9995))
    """
    check_image(img1, "img1")
    check_image(img2, "img2")
    check_same_shape(img2, img1, "img2", "img1")
    check_reduction(reduction)
    scales = [0.5, 1.0, 2.0, 4.0, 8.0] if sigmas is None else sigmas
    _check_sigmas(scales)
    check_interval(K, "K")
    reach = int(2.0 * scales[-1])
    if img1.size(2) <= reach or img1.size(3) <= reach:
        raise ValueError(
            f"img1: expected more than {reach} pixels along each side for sigma {scales[-1]}, got"
            f" {list(img1.shape)}"
        )
    c1, c2 = (K[0] * data_range) * (K[0] * data_range), (K[1] * data_range) * (K[1] * data_range)
    taps = [gaussian_taps(2 * reach + 1, sigma) for sigma in scales]
    a, b = widened(img1), widened(img2)
    similarity = torch.ones_like(a)
    luminance = similarity
    for means in separable_scales([a, b, a * a, b * b, a * b], taps, "reflect"):
        mu1, mu2 = means[0], means[1]
        similarity = (
            similarity
            * (2.0 * (means[4] - mu1 * mu2) + c2)
            / (means[2] - mu1 * mu1 + means[3] - mu2 * mu2 + c2)
        )
        # Only the widest Gaussian's luminance is used
        luminance = (2.0 * mu1 * mu2 + c1) / (mu1 * mu1 + mu2 * mu2 + c1)
    difference = separable_shared((a - b).abs(), taps[-1], taps[-1], "reflect")
    loss = compensation * (alpha * (1.0 - luminance * similarity) + ((1.0 - alpha) / data_range) * difference)
    return narrowed(reduced(loss, reduction), img1, img2)


def _check_sigmas(sigmas: List[float]) -> None:
    last = 0.0
    for sigma in sigmas:
        if not sigma > last:
            raise ValueError(f"sigmas: expected ascending positive numbers, got {sigmas}")
        last = sigma
    if last < 0.5:
        raise ValueError(f"sigmas: expected the largest to be half a pixel or more, got {sigmas}")
