"""Structural similarity."""

from typing import List

from torch import Tensor

from ..filters.gaussian import gaussian_taps
from ..primitives.core.checks import check_choice, check_image, check_same_shape
from ..primitives.filters.correlation import centred
from ..primitives.filters.padding import check_margins
from ..primitives.filters.stencil import separable_each, separable_shared
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.resampling.volumes import check_volume


def ssim(
    img1: Tensor,
    img2: Tensor,
    window_size: int,
    max_val: float = 1.0,
    eps: float = 1e-12,
    padding: str = "same",
) -> Tensor:
    """Structural similarity map with a Gaussian window of sigma 1.5.

    Z. Wang et al., Image quality assessment: from error visibility to structural similarity, IEEE TIP 13(4),
    2004, equation 13 with K1 = 0.01 and K2 = 0.03.

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
        ValueError: if an image is not 4-D or not larger than half of the window, window_size not odd, or
            padding unknown.

    Example:
        >>> x = torch.ones(1, 1, 8, 8)
        >>> ssim(x, x, 5).min()
        tensor(1.)
    """
    found = similarity(img1, img2, window_size, max_val, eps, padding)
    return narrowed(found, img1, img2)


def similarity(
    img1: Tensor, img2: Tensor, window_size: int, max_val: float, eps: float, padding: str
) -> Tensor:
    """``ssim``; of half precision, computed and returned in float32."""
    check_image(img1, "img1")
    check_image(img2, "img2")
    check_same_shape(img2, img1, "img2", "img1")
    taps = _window(window_size, padding)
    check_margins(img1, centred(window_size), centred(window_size), "reflect", "img1")
    out = _similarity(separable_each(_moments(img1, img2, max_val), taps, taps, "reflect"), max_val, eps)
    if padding == "valid":
        r = window_size // 2
        out = out[:, :, r : out.size(2) - r, r : out.size(3) - r]
    return out


def ssim3d(
    img1: Tensor,
    img2: Tensor,
    window_size: int,
    max_val: float = 1.0,
    eps: float = 1e-12,
    padding: str = "same",
) -> Tensor:
    """Structural similarity map of volumes: ``ssim`` with a window of three dimensions.

    Args:
        img1: (B, C, D, H, W), floating point.
        img2: like img1.
        window_size: odd number of taps of the window.
        max_val: the volumes' dynamic range L.
        eps: added to the denominator.
        padding: "same" reflects at the border, "valid" returns only windows inside the volume.

    Returns:
        (B, C, D, H, W), each of the last three less by window_size - 1 for "valid".

    Raises:
        TypeError: if a volume is not floating point.
        ValueError: if a volume is not 5-D or no larger than half a window, the shapes differ, window_size is
            not odd, or padding unknown.

    Example:
        >>> x = torch.ones(1, 1, 6, 8, 8)
        >>> ssim3d(x, x, 5).min()
        tensor(1.)
    """
    found = similarity3d(img1, img2, window_size, max_val, eps, padding)
    return narrowed(found, img1, img2)


def similarity3d(
    img1: Tensor, img2: Tensor, window_size: int, max_val: float, eps: float, padding: str
) -> Tensor:
    """``ssim3d``; of half precision, computed and returned in float32."""
    check_volume(img1, "img1")
    check_volume(img2, "img2")
    check_same_shape(img2, img1, "img2", "img1")
    taps = _window(window_size, padding)
    r = window_size // 2
    if img1.size(2) <= r or img1.size(3) <= r or img1.size(4) <= r:
        raise ValueError(
            f"img1: expected more than {r} voxels along each side for window_size {window_size}, got"
            f" {list(img1.shape)}"
        )
    means = [_smoothed_volume(v, taps) for v in _moments(img1, img2, max_val)]
    out = _similarity(means, max_val, eps)
    if padding == "valid":
        out = out[:, :, r : out.size(2) - r, r : out.size(3) - r, r : out.size(4) - r]
    return out


def _window(window_size: int, padding: str) -> List[float]:
    check_choice(padding, ["same", "valid"], "padding")
    if window_size < 1 or window_size % 2 == 0:
        raise ValueError(f"window_size: expected a positive odd size, got {window_size}")
    return gaussian_taps(window_size, 1.5)


def _moments(img1: Tensor, img2: Tensor, max_val: float) -> List[Tensor]:
    """Both images, their squares and their product, with values relative to the middle of the range: so the
    subtraction of squared means from mean squares loses fewer digits."""
    a, b = widened(img1) - 0.5 * max_val, widened(img2) - 0.5 * max_val
    return [a, b, a * a, b * b, a * b]


def _smoothed_volume(x: Tensor, taps: List[float]) -> Tensor:
    """A volume convolved with the same symmetric taps along its three axes."""
    planes = separable_shared(x.flatten(0, 1), taps, taps, "reflect")
    # Along the depth, a slice is one row.
    rows = separable_shared(planes.flatten(2)[:, None], taps, [1.0], "reflect")
    return rows.reshape(x.shape)


def _similarity(means: List[Tensor], max_val: float, eps: float) -> Tensor:
    """SSIM from the window means of the results of ``_moments``."""
    c1 = (0.01 * max_val) * (0.01 * max_val)
    c2 = (0.03 * max_val) * (0.03 * max_val)
    mu1, mu2 = means[0] + 0.5 * max_val, means[1] + 0.5 * max_val
    var1 = means[2] - means[0] * means[0]
    var2 = means[3] - means[1] * means[1]
    covariance = means[4] - means[0] * means[1]
    numerator = (2.0 * mu1 * mu2 + c1) * (2.0 * covariance + c2)
    denominator = (mu1 * mu1 + mu2 * mu2 + c1) * (var1 + var2 + c2)
    return numerator / (denominator + eps)
