"""Y'UV, with chroma at full, half (4:2:2) and quarter (4:2:0) resolution."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_not_empty, check_rgb, check_values
from ..primitives.images.color_planes import (
    check_channels,
    luma_chroma,
    mix_bytes,
    mix_channels,
)
from ..primitives.images.subsampled import chroma_means, subsampled_to_rgb
from ..primitives.resampling.taps import nearest_index


def rgb_to_yuv(image: Tensor) -> Tensor:
    """Luma and the chroma channels of PAL.

    ITU-R BT.470-6: U = 0.436 (B - Y) / (1 - 0.114), V = 0.615 (R - Y) / (1 - 0.299). Kornia's and OpenCV's
    matrices are this matrix rounded to three digits. OpenCV adds 0.5 to U and V in float32. For uint8, the
    chroma is around 128 and is computed from the rounded Y: 0.492 (B - Y) and 0.877 (R - Y), saturated. All
    factors are multiples of 1/2^14, and each value is rounded (halves up), so that the result is identical to
    OpenCV's.

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        (*, 3, H, W): Y in [0, 1], U in [-0.436, 0.436], V in [-0.615, 0.615], or all as bytes.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_yuv(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([ 0.2990, -0.1471,  0.6150])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        return luma_chroma(image, [4899, 9617, 1868], 8061, 14369)
    rows = [
        0.299,
        0.587,
        0.114,
        -0.14713769751693,
        -0.28886230248307,
        0.436,
        0.615,
        -0.5149857346647645,
        -0.10001426533523537,
    ]
    return mix_channels(image, rows, 0.0, "image")


def yuv_to_rgb(image: Tensor) -> Tensor:
    """RGB from PAL's Y'UV, the inverse of ``rgb_to_yuv``; the result is not clipped.

    For uint8, R = Y + 1.14 V', G = Y - 0.395 U' - 0.581 V', B = Y + 2.032 U' with U' = U - 128, V' = V - 128.
    The factors are multiples of 1/2^14, and the sums are rounded (halves up) and saturated, so that the
    result is identical to OpenCV's.

    Args:
        image: YUV image (*, 3, H, W), floating point: Y in [0, 1], U in [-0.436, 0.436], V in [-0.615,
            0.615]; or uint8.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> yuv_to_rgb(torch.tensor([0.299, -0.14714, 0.615]).reshape(1, 3, 1, 1)).flatten().round(
        ...     decimals=4
        ... ).abs()
        tensor([1., 0., 0.])
    """
    check_rgb(image, "image")
    check_values(image, "image")
    if image.dtype == torch.uint8:
        # The factors times 2^14. The last number of each row subtracts 128 times the row's chroma factors and
        # adds one half.
        red, green = [16384, 0, 18678, -2382592], [16384, -6472, -9519, 2055040]
        return mix_bytes(image, red + green + [16384, 33292, 0, -4253184], 14)
    rows = [
        1.0,
        0.0,
        1.1398373983739838,
        1.0,
        -0.39465170435897035,
        -0.5805986066674977,
        1.0,
        2.032110091743119,
        0.0,
    ]
    return mix_channels(image, rows, 0.0, "image")


def rgb_to_yuv420(image: Tensor) -> Tuple[Tensor, Tensor]:
    """``rgb_to_yuv`` with chroma at half the width and height, each the mean of 2 x 2 pixels.

    Unlike Kornia, it takes odd sizes: the last row or column then counts twice, as in JPEG. For uint8, the
    means of the uint8 result of ``rgb_to_yuv`` are rounded (halves up).

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        Y (*, 1, H, W), and U, V (*, 2, (H + 1) // 2, (W + 1) // 2).

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> [list(part.shape) for part in rgb_to_yuv420(torch.ones(1, 3, 4, 6))]
        [[1, 1, 4, 6], [1, 2, 2, 3]]
    """
    yuv = rgb_to_yuv(image)
    return chroma_means(yuv, True)


def rgb_to_yuv422(image: Tensor) -> Tuple[Tensor, Tensor]:
    """``rgb_to_yuv`` with chroma at half the width, each the mean of two pixels.

    Unlike Kornia, it takes an odd width: the last column then counts twice. For uint8, the means of the uint8
    result of ``rgb_to_yuv`` are rounded (halves up).

    Args:
        image: RGB image (*, 3, H, W), floating point in [0, 1], or uint8.

    Returns:
        Y (*, 1, H, W), and U, V (*, 2, H, (W + 1) // 2).

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> [list(part.shape) for part in rgb_to_yuv422(torch.ones(1, 3, 4, 6))]
        [[1, 1, 4, 6], [1, 2, 4, 3]]
    """
    yuv = rgb_to_yuv(image)
    return chroma_means(yuv, False)


def yuv420_to_rgb(imagey: Tensor, imageuv: Tensor) -> Tensor:
    """RGB from luma and chroma of half the width and height; each chroma sample is repeated over its 2 x 2
    pixels.

    Args:
        imagey: Y (*, 1, H, W), floating point in [0, 1], or uint8.
        imageuv: U, V (*, 2, (H + 1) // 2, (W + 1) // 2), as ``rgb_to_yuv`` scales them.

    Returns:
        (*, 3, H, W): red, green, blue, not clipped; for uint8 as in ``yuv_to_rgb``.

    Raises:
        TypeError: if an image is neither floating point nor uint8, or one is uint8 and the other one is not.
        ValueError: if a shape is not as above.

    Example:
        >>> yuv420_to_rgb(torch.ones(1, 1, 4, 6), torch.zeros(1, 2, 2, 3)).shape
        torch.Size([1, 3, 4, 6])
    """
    _check_pair(imagey, imageuv)
    _check_half(imagey, imageuv, -2)
    _check_half(imagey, imageuv, -1)
    return planar_yuv_to_rgb(imagey, imageuv)


def yuv422_to_rgb(imagey: Tensor, imageuv: Tensor) -> Tensor:
    """RGB from luma and chroma of half the width; each chroma sample is repeated over its two pixels.

    Args:
        imagey: Y (*, 1, H, W), floating point in [0, 1], or uint8.
        imageuv: U, V (*, 2, H, (W + 1) // 2), as ``rgb_to_yuv`` scales them.

    Returns:
        (*, 3, H, W): red, green, blue, not clipped; for uint8 as in ``yuv_to_rgb``.

    Raises:
        TypeError: if an image is neither floating point nor uint8, or one is uint8 and the other one is not.
        ValueError: if a shape is not as above.

    Example:
        >>> yuv422_to_rgb(torch.ones(1, 1, 4, 6), torch.zeros(1, 2, 4, 3)).shape
        torch.Size([1, 3, 4, 6])
    """
    _check_pair(imagey, imageuv)
    if imageuv.size(-2) != imagey.size(-2):
        raise ValueError(f"imageuv: expected the height {imagey.size(-2)} of imagey, got {imageuv.size(-2)}")
    _check_half(imagey, imageuv, -1)
    return planar_yuv_to_rgb(imagey, imageuv)


def planar_yuv_to_rgb(imagey: Tensor, imageuv: Tensor) -> Tensor:
    """RGB from luma and chroma of any resolution, by the nearest chroma sample.

    Bundles use this op instead of ``yuv420_to_rgb`` and ``yuv422_to_rgb``, because a bundle cannot state
    sizes that depend on each other.

    Args:
        imagey: Y (*, 1, H, W), floating point in [0, 1], or uint8.
        imageuv: U, V (*, 2, h, w), as ``rgb_to_yuv`` scales them.

    Returns:
        (*, 3, H, W): red, green, blue, not clipped; for uint8 as in ``yuv_to_rgb``.

    Raises:
        TypeError: if an image is neither floating point nor uint8, or one is uint8 and the other one is not.
        ValueError: if a shape is not as above.

    Example:
        >>> planar_yuv_to_rgb(torch.ones(1, 1, 8, 8), torch.zeros(1, 2, 2, 3)).shape
        torch.Size([1, 3, 8, 8])
    """
    _check_pair(imagey, imageuv)
    if imagey.dtype == torch.uint8:
        # the factors of ``yuv_to_rgb`` in units of 1/2^20
        factors = [1048576, 1195392, -414208, -609216, 2130688, 0]
        if imagey.dim() == 4:
            return subsampled_to_rgb(imagey, imageuv, factors, False)
        luma, chroma = [part.reshape((-1,) + part.shape[-3:]) for part in (imagey, imageuv)]
        return subsampled_to_rgb(luma, chroma, factors, False).reshape(
            imagey.shape[:-3] + (3,) + imagey.shape[-2:]
        )
    rows = nearest_index(imageuv.size(-2), imagey.size(-2), imageuv.device)
    columns = nearest_index(imageuv.size(-1), imagey.size(-1), imageuv.device)
    chroma = imageuv.index_select(-2, rows).index_select(-1, columns)
    planes = [imagey.select(-3, 0), chroma.select(-3, 0), chroma.select(-3, 1)]
    return yuv_to_rgb(torch.stack(planes, -3))


def _check_pair(imagey: Tensor, imageuv: Tensor) -> None:
    check_channels(imagey, 1, "imagey")
    check_values(imagey, "imagey")
    check_channels(imageuv, 2, "imageuv")
    check_values(imageuv, "imageuv")
    check_not_empty(imagey, 2, "imagey")
    check_not_empty(imageuv, 2, "imageuv")
    if (imagey.dtype == torch.uint8) != (imageuv.dtype == torch.uint8):
        raise TypeError(
            f"imageuv: expected uint8 with an imagey of uint8 and no other, got {imageuv.dtype} and"
            f" {imagey.dtype}"
        )
    if imageuv.shape[:-3] != imagey.shape[:-3]:
        raise ValueError(
            f"imageuv: expected the leading dimensions of imagey {list(imagey.shape)}, got"
            f" {list(imageuv.shape)}"
        )


def _check_half(imagey: Tensor, imageuv: Tensor, dim: int) -> None:
    expected = (imagey.size(dim) + 1) // 2
    if imageuv.size(dim) != expected:
        side = "width" if dim == -1 else "height"
        raise ValueError(
            f"imageuv: expected a {side} of {expected} for an imagey of {imagey.size(dim)}, got"
            f" {imageuv.size(dim)}"
        )
