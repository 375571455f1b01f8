"""CIE XYZ."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_rgb, check_values
from ..primitives.images.color_planes import mix_bytes, mix_channels


def rgb_to_xyz(image: Tensor) -> Tensor:
    """CIE XYZ from linear RGB with the sRGB primaries and D65 white, (0.950456, 1, 1.088754).

    ITU-R BT.709; the matrix of OpenCV and Kornia. The op does not linearise: for the colorimetric values of
    an sRGB image, pass the result of ``rgb_to_linear_rgb``. For uint8, the weights are multiples of 1/2^12,
    and the sums are rounded (halves up) and saturated (Z of bright colours), so that the result is identical
    to OpenCV's.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 3, H, W): X, Y, Z.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_xyz(torch.ones(1, 3, 1, 1)).flatten()
        tensor([0.9505, 1.0000, 1.0888])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        x, y = [1689, 1465, 739, 2048], [871, 2929, 296, 2048]
        return mix_bytes(image, x + y + [79, 488, 3892, 2048], 12)
    return mix_channels(
        image,
        [0.412453, 0.357580, 0.180423, 0.212671, 0.715160, 0.072169, 0.019334, 0.119193, 0.950227],
        0.0,
        "image",
    )


def xyz_to_rgb(image: Tensor) -> Tensor:
    """RGB from CIE XYZ, the inverse of ``rgb_to_xyz``; the result is not clipped.

    For uint8, the weights are multiples of 1/2^12, and the sums are rounded (halves up) and saturated, so
    that the result is identical to OpenCV's.

    Args:
        image: XYZ image (*, 3, H, W), floating point or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> xyz_to_rgb(torch.tensor([0.950456, 1.0, 1.088754]).reshape(1, 3, 1, 1)).flatten()
        tensor([1.0000, 1.0000, 1.0000])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        red, green = [13273, -6296, -2042, 2048], [-3970, 7684, 170, 2048]
        return mix_bytes(image, red + green + [228, -836, 4331, 2048], 12)
    return mix_channels(image, weights_of_xyz(), 0.0, "image")


def weights_of_xyz() -> List[float]:
    """The weights of linear red, green and blue in X, Y and Z, row by row."""
    return [
        3.240481343200526, -1.5371515162713185, -0.4985363261688878,
        -0.9692549499965682, 1.8759900014898907, 0.04155592655829284,
        0.05564663913517716, -0.20404133836651123, 1.0573110696453443,
    ]  # fmt: skip
