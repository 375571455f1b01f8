"""Bayer raw images.

The colour filter array has OpenCV's name, which is the second and third pixel of the second row: "bg" has red
in the top left corner (RGGB), "gb" green with red beside it (GRBG), "rg" blue (BGGR), "gr" green with blue
beside it (GBRG).
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice
from ..primitives.filters.padding import check_margins
from ..primitives.images.bayer import demosaic, numbers, parity, rounded
from ..primitives.images.color_planes import channels_of, check_channels
from ..primitives.resampling.decimation import every_second


def raw_to_rgb(image: Tensor, cfa: str) -> Tensor:
    """RGB from a Bayer raw image, by bilinear interpolation.

    B. E. Bayer, US patent 3971065, 1976. Known samples are kept; a missing sample is the mean of the nearest
    two or four samples of its colour; for integer dtypes it is rounded (halves up). The result is identical
    to that of OpenCV's ``cvtColor``, except for the border: this op mirrors the image (reflect), OpenCV
    copies the neighbours' colours. Unlike Kornia, it takes odd sizes.

    Args:
        image: raw image (*, 1, H, W), floating point, uint8 or uint16, H and W at least 2.
        cfa: "bg", "gb", "rg" or "gr": the second and third pixel of the second row, as in OpenCV. The top
            left 2 x 2 pixels are then RGGB, GRBG, BGGR or GBRG.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is of another dtype.
        ValueError: if image is not (*, 1, H, W), or cfa is none of these.

    Example:
        >>> raw_to_rgb(torch.ones(1, 1, 4, 6), "bg").shape
        torch.Size([1, 3, 4, 6])
    """
    check_channels(image, 1, "image")
    _check_samples(image)
    check_margins(image, (1, 1), (1, 1), "reflect", "image")
    red_row, red_column = _red(cfa)
    return demosaic(image, red_row, red_column)


def rgb_to_raw(image: Tensor, cfa: str) -> Tensor:
    """Keep only the colour of each pixel that a Bayer sensor would record.

    Args:
        image: RGB image (*, 3, H, W), floating point, uint8 or uint16.
        cfa: "bg", "gb", "rg" or "gr", as in ``raw_to_rgb``.

    Returns:
        (*, 1, H, W).

    Raises:
        TypeError: if image is of another dtype.
        ValueError: if image is not (*, 3, H, W), or cfa is none of these.

    Example:
        >>> rgb_to_raw(torch.arange(3.0).reshape(3, 1, 1).expand(1, 3, 2, 2), "bg")[0, 0]
        tensor([[0., 1.],
                [1., 2.]])
    """
    check_channels(image, 3, "image")
    _check_samples(image)
    red, green, blue = channels_of(numbers(image))
    red_row, red_column = _red(cfa)
    rows = parity(image.size(-2), red_row, image.device)[:, None]
    columns = parity(image.size(-1), red_column, image.device)
    raw = torch.where(torch.logical_xor(rows, columns), green, torch.where(rows, red, blue))
    return raw.unsqueeze(-3).to(image.dtype)


def raw_to_rgb_2x2_downscaled(image: Tensor, cfa: str) -> Tensor:
    """RGB at half the width and height: each 2 x 2 samples become one pixel.

    Green is the mean of its two samples; for integer dtypes it is rounded (halves up). Unlike Kornia, it
    takes odd sizes: the last row or column is then left out.

    Args:
        image: raw image (*, 1, H, W), floating point, uint8 or uint16, H and W at least 2.
        cfa: "bg", "gb", "rg" or "gr", as in ``raw_to_rgb``.

    Returns:
        (*, 3, H // 2, W // 2): red, green, blue.

    Raises:
        TypeError: if image is of another dtype.
        ValueError: if image is not (*, 1, H, W), or cfa is none of these.

    Example:
        >>> raw_to_rgb_2x2_downscaled(torch.arange(4.0).reshape(1, 1, 2, 2), "bg").flatten()
        tensor([0.0000, 1.5000, 3.0000])
    """
    check_channels(image, 1, "image")
    _check_samples(image)
    red_row, red_column = _red(cfa)
    height, width = image.size(-2) // 2, image.size(-1) // 2
    plane = numbers(image).select(-3, 0)
    samples: List[Tensor] = []
    for row in [red_row, 1 - red_row]:
        rows = every_second(plane, -2, row, height)
        for column in [red_column, 1 - red_column]:
            samples.append(every_second(rows, -1, column, width))
    return rounded(torch.stack([samples[0], (samples[1] + samples[2]) * 0.5, samples[3]], -3), image)


def _check_samples(image: Tensor) -> None:
    if not image.is_floating_point() and image.dtype != torch.uint8 and image.dtype != torch.uint16:
        raise TypeError(f"image: expected a floating-point, uint8 or uint16 tensor, got dtype {image.dtype}")


def _red(cfa: str) -> Tuple[int, int]:
    """Row and column (0 or 1) of the first red sample."""
    check_choice(cfa, ["bg", "gb", "rg", "gr"], "cfa")
    row = 0 if cfa == "bg" or cfa == "gb" else 1
    column = 0 if cfa == "bg" or cfa == "gr" else 1
    return row, column
