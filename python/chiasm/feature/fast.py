"""FAST corners: comparison of a pixel with a circle of pixels."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels
from ..primitives.core.layout import in_planes
from ..primitives.features.extrema import largest
from ..primitives.filters.padding import padded


def fast_response(input: Tensor) -> Tensor:
    """FAST-9 response: the largest threshold for which nine contiguous pixels of the circle of 16 are
    brighter or darker.

    All nine must be brighter, or all darker, than the centre pixel by this threshold. E. Rosten, T. Drummond,
    Machine learning for high-speed corner detection, ECCV 2006. OpenCV's response for uint8 is 1 less, and
    zero in a border of three pixels; here the border is replicated.

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
    # The circle, from the top; by symmetry, the rows are the columns of the quarter before.
    across = [0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1]
    centre = p[:, :, 3 : 3 + height, 3 : 3 + width]
    brighter: List[Tensor] = []
    for k in range(16):
        row, column = 3 + across[(k + 12) % 16], 3 + across[k]
        brighter.append(p[:, :, row : row + height, column : column + width] - centre)
    return torch.maximum(_arcs(brighter), _arcs([-d for d in brighter])).clamp(min=0)


def _arcs(values: List[Tensor]) -> Tensor:
    """The maximum over all arcs of nine pixels of the circle of 16 of the arc's minimum; arcs share partial
    minima."""
    least = values
    for step in [1, 2, 4]:
        least = [torch.minimum(least[k], least[(k + step) % 16]) for k in range(16)]
    return largest([torch.minimum(least[k], values[(k + 8) % 16]) for k in range(16)])
