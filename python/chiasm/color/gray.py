"""Grey from colour, and colour from grey."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_tensor, check_values
from ..primitives.images.color_planes import arranged, check_channels, mix_bytes, mix_channels, rgb_planes


def rgb_to_grayscale(image: Tensor, rgb_weights: Optional[Tensor] = None) -> Tensor:
    """Weighted sum of the channels; by default the luma of ITU-R BT.601: 0.299 R + 0.587 G + 0.114 B.

    For uint8, the weights are multiples of 1/2^15 and the sum is rounded (halves up), so that the result is
    identical to OpenCV's.

    Args:
        image: RGB image (*, 3, H, W), floating point or uint8; the range is kept.
        rgb_weights: (3,) weights for R, G, B instead of the default; for floating-point images.

    Returns:
        (*, 1, H, W) in the image's dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8, or is uint8 and rgb_weights are given.
        ValueError: if image is not (*, 3, H, W) or rgb_weights is not (3,).

    Example:
        >>> rgb_to_grayscale(torch.ones(2, 3, 4, 5)).shape
        torch.Size([2, 1, 4, 5])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        if rgb_weights is not None:
            raise TypeError("rgb_weights: expected None for an image of bytes, whose weights are fixed")
        return mix_bytes(image, [9798, 19235, 3735, 16384], 15)
    if rgb_weights is None:
        return mix_channels(image, [0.299, 0.587, 0.114], 0.0, "image")
    red, green, blue = rgb_planes(image, "image")
    check_tensor(rgb_weights, "rgb_weights")
    if rgb_weights.dim() != 1 or rgb_weights.size(0) != 3:
        raise ValueError(f"rgb_weights: expected shape (3,), got {list(rgb_weights.shape)}")
    w = rgb_weights.to(image.dtype)
    return (w[0] * red + w[1] * green + w[2] * blue).unsqueeze(-3)


def bgr_to_grayscale(image: Tensor) -> Tensor:
    """Luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B, of an image whose channels are B, G, R.

    For uint8, the weights are multiples of 1/2^15 and the sum is rounded (halves up), so that the result is
    identical to OpenCV's.

    Args:
        image: BGR image (*, 3, H, W), floating point or uint8; the range is kept.

    Returns:
        (*, 1, H, W) in the image's dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> bgr_to_grayscale(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.1140])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return mix_bytes(image, [3735, 19235, 9798, 16384], 15)
    return mix_channels(image, [0.114, 0.587, 0.299], 0.0, "image")


def grayscale_to_rgb(image: Tensor) -> Tensor:
    """Repeat the grey channel three times.

    Args:
        image: grey image (*, 1, H, W), any dtype.

    Returns:
        (*, 3, H, W).

    Raises:
        ValueError: if image is not (*, 1, H, W).

    Example:
        >>> grayscale_to_rgb(torch.full((1, 1, 1, 1), 0.5)).flatten()
        tensor([0.5000, 0.5000, 0.5000])
    """
    check_channels(image, 1, "image")
    return arranged(image, [0, 0, 0], 0.0)
