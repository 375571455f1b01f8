"""Smoothness of depth where the image is smooth."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image


def inverse_depth_smoothness_loss(idepth: Tensor, image: Tensor) -> Tensor:
    """Smoothness of inverse depth d except at edges of an image I: the mean of \\|dx d\\| exp(-\\|dx I\\|)
    plus the mean of \\|dy d\\| exp(-\\|dy I\\|).

    C. Godard et al., Unsupervised monocular depth estimation with left-right consistency, CVPR 2017, equation
    4: depth may jump where the image does. dx and dy are differences of neighbours; for the image, the mean
        of the absolute differences over its channels.

    Args:
        idepth: (B, 1, H, W), floating point; H and W at least 2.
        image: (B, C, H, W), floating point.

    Returns:
        A scalar.

    Raises:
        TypeError: if idepth or image is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> ramp = torch.arange(3.0).expand(1, 1, 3, 3)
        >>> (
        ...     inverse_depth_smoothness_loss(ramp, torch.zeros(1, 3, 3, 3)),
        ...     inverse_depth_smoothness_loss(ramp, ramp),
        ... )
        (tensor(1.), tensor(0.3679))
    """
    check_image(idepth, "idepth")
    check_image(image, "image")
    if idepth.size(1) != 1 or idepth.size(2) < 2 or idepth.size(3) < 2:
        raise ValueError(
            f"idepth: expected shape (B, 1, H, W) with H and W at least 2, got {list(idepth.shape)}"
        )
    if image.size(0) != idepth.size(0) or image.size(2) != idepth.size(2) or image.size(3) != idepth.size(3):
        raise ValueError(
            f"image: expected shape (B, C, H, W) for idepth {list(idepth.shape)}, got {list(image.shape)}"
        )
    return _smoothness(idepth, image, 3) + _smoothness(idepth, image, 2)


def _smoothness(idepth: Tensor, image: Tensor, dim: int) -> Tensor:
    edge = _steps(image, dim).mean(1, keepdim=True)
    return (_steps(idepth, dim) * torch.exp(-edge)).mean()


def _steps(x: Tensor, dim: int) -> Tensor:
    """Absolute differences of neighbours."""
    count = x.size(dim) - 1
    return (x.narrow(dim, 0, count) - x.narrow(dim, 1, count)).abs()
