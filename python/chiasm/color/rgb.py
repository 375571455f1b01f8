"""Channel order."""

from torch import Tensor

from ..primitives.core.checks import check_rgb
from ..primitives.images.color_planes import arranged


def bgr_to_rgb(image: Tensor) -> Tensor:
    """Reverse the order of the three channels (BGR to RGB, or back).

    Args:
        image: (*, 3, H, W), any dtype.

    Returns:
        The image with its first and third channel exchanged, (*, 3, H, W).

    Raises:
        ValueError: if the third dimension from the end is not 3.

    Example:
        >>> bgr_to_rgb(torch.arange(3.0).reshape(1, 3, 1, 1)).flatten()
        tensor([2., 1., 0.])
    """
    check_rgb(image, "image")
    return arranged(image, [2, 1, 0], 0.0)


def rgb_to_bgr(image: Tensor) -> Tensor:
    """Reverse the order of the three channels: the same as ``bgr_to_rgb``.

    Args:
        image: (*, 3, H, W), any dtype.

    Returns:
        The image with its first and third channel exchanged, (*, 3, H, W).

    Raises:
        ValueError: if the third dimension from the end is not 3.

    Example:
        >>> rgb_to_bgr(torch.arange(3.0).reshape(1, 3, 1, 1)).flatten()
        tensor([2., 1., 0.])
    """
    return bgr_to_rgb(image)
