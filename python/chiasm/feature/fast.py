"""Corners by comparison with a circle of pixels."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels
from ..primitives.core.layout import in_planes
from ..primitives.features.extrema import largest
from ..primitives.filters.padding import padded


def fast_response(input: Tensor) -> Tensor:
    """FAST-9: the largest threshold by which nine neighbouring pixels of the circle of 16 around a pixel are
    all brighter, or all darker, than it.

    E. Rosten, T. Drummond, Machine learning for high-speed corner detection, ECCV 2006. OpenCV's response to
    bytes is 1 less, and its border of three pixels is empty; here pixels beyond the border are the nearest of
    the image.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8.

    Returns:
        (B, C, H, W) in units of input, of its dtype; 0 where no nine pixels are brighter or darker.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D.

    Example:
        >>> spot = torch.zeros(1, 1, 9, 9)
        >>> spot[..., 4, 4] = 0.75
        >>> fast_response(spot)[0, 0, 4, 4]
        tensor(0.7500)
    """
    check_pixels(input, "input")
    if input.dtype == torch.uint8:
        exact = in_planes(input).to(torch.float32)
        return _score(padded(exact, (3, 3), (3, 3), "replicate")).to(torch.uint8)
    return _score(padded(input, (3, 3), (3, 3), "replicate"))


def _score(p: Tensor) -> Tensor:
    height, width = p.size(2) - 6, p.size(3) - 6
    # The circle, from the top on; by symmetry rows are the columns of a quarter before.
    across = [0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1]
    centre = p[:, :, 3 : 3 + height, 3 : 3 + width]
    brighter: List[Tensor] = []
    for k in range(16):
        row, column = 3 + across[(k + 12) % 16], 3 + across[k]
        brighter.append(p[:, :, row : row + height, column : column + width] - centre)
    return torch.maximum(_arcs(brighter), _arcs([-d for d in brighter])).clamp(min=0)


def _arcs(values: List[Tensor]) -> Tensor:
    """The largest of the least values of each nine neighbours on the circle of 16, their minima shared."""
    least = values
    for step in [1, 2, 4]:
        least = [torch.minimum(least[k], least[(k + step) % 16]) for k in range(16)]
    return largest([torch.minimum(least[k], values[(k + 8) % 16]) for k in range(16)])
