"""Luma and the scaled colour differences (chroma) of digital video."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import luma_chroma, mix_bytes, mix_channels, rgb_planes


def rgb_to_y(image: Tensor) -> Tensor:
    """Luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B: the first channel of ``rgb_to_ycbcr``.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 1, H, W).

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_y(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0.2990])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return mix_bytes(image, [4899, 9617, 1868, 8192], 14)
    return mix_channels(image, [0.299, 0.587, 0.114], 0.0, "image")


def rgb_to_ycbcr(image: Tensor) -> Tensor:
    """Luma and the two chroma channels, full range.

    ITU-R BT.601 with OpenCV's constants: Cb = 0.564 (B - Y) + 0.5, Cr = 0.713 (R - Y) + 0.5. OpenCV's order
    is Y, Cr, Cb. For uint8, the chroma is around 128 and is computed from the rounded Y. All factors are
    multiples of 1/2^14, and each value is rounded (halves up), so that the result is identical to OpenCV's.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 3, H, W): Y, Cb, Cr in [0, 1], or as bytes.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_ycbcr(torch.ones(1, 3, 1, 1)).flatten()
        tensor([1.0000, 0.5000, 0.5000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return luma_chroma(image, [4899, 9617, 1868], 9241, 11682)
    # Each row is the definition with Y written out.
    rows = [0.299, 0.587, 0.114, -0.168636, -0.331068, 0.499704, 0.499813, -0.418531, -0.081282]
    return mix_channels(image, rows, 0.5, "image")


def ycbcr_to_rgb(image: Tensor) -> Tensor:
    """RGB from full-range Y, Cb, Cr. R = Y + 1.403 Cr', G = Y - 0.714 Cr' - 0.344 Cb', B = Y + 1.773 Cb' with
    Cr' = Cr - 0.5, Cb' = Cb - 0.5. ITU-R BT.601 with OpenCV's rounded constants, so that the round trip is
    accurate to 1e-3 only. The result is not clipped. For uint8, the chroma is around 128, the factors are
    multiples of 1/2^14, and the sums are rounded (halves up) and saturated, so that the result is identical
    to OpenCV's.

    Args:
        image: YCbCr image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> ycbcr_to_rgb(torch.tensor([1.0, 0.5, 0.5]).reshape(1, 3, 1, 1)).flatten()
        tensor([1., 1., 1.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        # The factors times 2^14. The last number of each row subtracts 128 times the row's chroma factors and
        # adds one half.
        red_row, green_row = [16384, 0, 22987, -2934144], [16384, -5636, -11698, 2226944]
        return mix_bytes(image, red_row + green_row + [16384, 29049, 0, -3710080], 14)
    luma, blue, red = rgb_planes(image, "image")
    cb, cr = blue - 0.5, red - 0.5
    return torch.stack([luma + 1.403 * cr, luma - 0.714 * cr - 0.344 * cb, luma + 1.773 * cb], -3)
