"""Structural dissimilarity."""

from torch import Tensor

from ..metrics.ssim import similarity, similarity3d
from ..primitives.core.checks import check_reduction
from ..primitives.numbers.loss_reduction import narrowed, reduced


def ssim_loss(
    img1: Tensor,
    img2: Tensor,
    window_size: int,
    max_val: float = 1.0,
    eps: float = 1e-12,
    reduction: str = "mean",
    padding: str = "same",
) -> Tensor:
    """(1 - SSIM) / 2, clamped to [0, 1]; see ``chiasm.metrics.ssim``.

    Args:
        img1: (B, C, H, W), floating point.
        img2: like img1.
        window_size: odd number of taps of the window.
        max_val: the images' dynamic range.
        eps: added to the denominator.
        reduction: "mean", "sum" or "none".
        padding: "same" or "valid".

    Returns:
        A scalar, or the map (B, C, H, W) for "none".

    Raises:
        TypeError: if an image is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.ones(1, 1, 8, 8)
        >>> ssim_loss(x, x, 5)
        tensor(0.)
    """
    check_reduction(reduction)
    found = similarity(img1, img2, window_size, max_val, eps, padding)
    return narrowed(reduced(_dissimilarity(found), reduction), img1, img2)


def ssim3d_loss(
    img1: Tensor,
    img2: Tensor,
    window_size: int,
    max_val: float = 1.0,
    eps: float = 1e-12,
    reduction: str = "mean",
    padding: str = "same",
) -> Tensor:
    """(1 - SSIM) / 2 of volumes, clamped to [0, 1]; see ``chiasm.metrics.ssim3d``.

    Args:
        img1: (B, C, D, H, W), floating point.
        img2: like img1.
        window_size: odd number of taps of the window.
        max_val: the volumes' dynamic range.
        eps: added to the denominator.
        reduction: "mean", "sum" or "none".
        padding: "same" or "valid".

    Returns:
        A scalar, or the map (B, C, D, H, W) for "none".

    Raises:
        TypeError: if a volume is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.ones(1, 1, 6, 8, 8)
        >>> ssim3d_loss(x, x, 5)
        tensor(0.)
    """
    check_reduction(reduction)
    found = similarity3d(img1, img2, window_size, max_val, eps, padding)
    return narrowed(reduced(_dissimilarity(found), reduction), img1, img2)


def _dissimilarity(similarity: Tensor) -> Tensor:
    return ((1.0 - similarity) * 0.5).clamp(0.0, 1.0)
