"""Peak signal-to-noise ratio as a loss."""

from torch import Tensor

from ..metrics.psnr import psnr


def psnr_loss(image: Tensor, target: Tensor, max_val: float) -> Tensor:
    """Negative peak signal-to-noise ratio in decibels; see ``chiasm.metrics.psnr``.

    Args:
        image: (*), floating point.
        target: like image.
        max_val: the images' dynamic range, for example 1 or 255.

    Returns:
        A scalar. If the images are equal, it is minus infinity and its gradient is zero.

    Raises:
        TypeError: if image or target is not floating point.
        ValueError: if the shapes differ, or max_val is not positive.

    Example:
        >>> psnr_loss(torch.ones(4), 1.2 * torch.ones(4), 2.0)
        tensor(-20.0000)
    """
    return -psnr(image, target, max_val)
