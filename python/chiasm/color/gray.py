"""RGB to grey."""

from typing import Optional

from torch import Tensor

from ..primitives.checks import check_floating, check_rgb


def rgb_to_grayscale(image: Tensor, rgb_weights: Optional[Tensor] = None) -> Tensor:
    """Weighted sum of the channels; by default the luma of ITU-R BT.601: 0.299 R + 0.587 G + 0.114 B.

    Unlike Kornia's, it takes floating-point images only.

    Args:
        image: RGB image (*, 3, H, W), floating point; the range is kept.
        rgb_weights: (3,) weights for R, G, B instead of the default.

    Returns:
        (*, 1, H, W) in the image's dtype.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or rgb_weights is not (3,).

    Example:
        >>> rgb_to_grayscale(torch.ones(2, 3, 4, 5)).shape
        torch.Size([2, 1, 4, 5])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    red, green, blue = image.select(-3, 0), image.select(-3, 1), image.select(-3, 2)
    if rgb_weights is None:
        grey = 0.299 * red + 0.587 * green + 0.114 * blue
    else:
        if rgb_weights.dim() != 1 or rgb_weights.size(0) != 3:
            raise ValueError(f"rgb_weights: expected shape (3,), got {list(rgb_weights.shape)}")
        w = rgb_weights.to(image.dtype)
        grey = w[0] * red + w[1] * green + w[2] * blue
    return grey.unsqueeze(-3)
