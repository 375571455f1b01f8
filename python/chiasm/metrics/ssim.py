"""Structural similarity."""

from torch import Tensor

from ..filters.gaussian import gaussian_taps
from ..primitives.checks import check_choice, check_image
from ..primitives.stencil import separable_each


def ssim(img1: Tensor, img2: Tensor, window_size: int, max_val: float = 1.0, eps: float = 1e-12, padding: str = "same") -> Tensor:
    """Structural similarity map with a Gaussian window of sigma 1.5.

    Z. Wang et al., Image quality assessment: from error visibility to structural similarity, IEEE TIP 13(4), 2004,
    equation 13 with K1 = 0.01 and K2 = 0.03.

    Args:
        img1: (B, C, H, W), floating point.
        img2: like img1.
        window_size: odd number of taps of the window.
        max_val: the images' dynamic range L.
        eps: added to the denominator.
        padding: "same" reflects at the border, "valid" returns only windows inside the image.

    Returns:
        (B, C, H, W), or (B, C, H - window_size + 1, W - window_size + 1) for "valid".

    Raises:
        TypeError: if an image is not floating point.
        ValueError: if an image is not 4-D, window_size not odd, or padding unknown.

    Example:
        >>> x = torch.ones(1, 1, 8, 8)
        >>> ssim(x, x, 5).min()
        tensor(1.)
    """
    check_image(img1, "img1")
    check_image(img2, "img2")
    check_choice(padding, ["same", "valid"], "padding")
    if window_size < 1 or window_size % 2 == 0:
        raise ValueError(f"window_size: expected a positive odd size, got {window_size}")
    taps = gaussian_taps(window_size, 1.5)
    c1 = (0.01 * max_val) * (0.01 * max_val)
    c2 = (0.03 * max_val) * (0.03 * max_val)
    means = separable_each([img1, img2, img1 * img1, img2 * img2, img1 * img2], taps, taps, "reflect")
    mu1, mu2 = means[0], means[1]
    var1 = means[2] - mu1 * mu1
    var2 = means[3] - mu2 * mu2
    covariance = means[4] - mu1 * mu2
    numerator = (2.0 * mu1 * mu2 + c1) * (2.0 * covariance + c2)
    denominator = (mu1 * mu1 + mu2 * mu2 + c1) * (var1 + var2 + c2)
    out = numerator / (denominator + eps)
    if padding == "valid":
        r = window_size // 2
        out = out[:, :, r : out.size(2) - r, r : out.size(3) - r]
    return out
