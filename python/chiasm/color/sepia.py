"""Sepia toning."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_not_empty, check_rgb, check_values
from ..primitives.images.color_planes import channels_of, mix_bytes, mix_channels
from ..primitives.numbers.reductions import greatest


def sepia(input: Tensor, rescale: bool = True, eps: float = 1e-6) -> Tensor:
    """Apply a sepia tone, by the matrix (0.393, 0.769, 0.189; 0.349, 0.686, 0.168; 0.272, 0.534, 0.131).

    S. Toub, Sepia Tone, StringLogicalComparer, and More, MSDN Magazine, January 2005. The rows sum to about
    1.35, 1.2 and 0.94.

    For uint8, the factors are multiples of 1/2^14. The exact sums (with rescale, divided by the largest sum)
    are rounded (halves up) and saturated.

    Args:
        input: RGB image (*, 3, H, W), floating point or uint8.
        rescale: divide each image by its largest value, so that the result does not exceed 1 (for uint8, 255)
            and keeps its tint.
        eps: added to that largest value; not used for uint8.

    Returns:
        (*, 3, H, W).

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not (*, 3, H, W).

    Example:
        >>> sepia(torch.ones(1, 3, 1, 1), rescale=False).flatten()
        tensor([1.3510, 1.2030, 0.9370])
    """
    check_rgb(input, "input")
    check_values(input, "input")
    check_not_empty(input, 2, "input")
    if input.dtype == torch.uint8:
        return _sepia_of_bytes(input, rescale)
    toned = mix_channels(input, [0.393, 0.769, 0.189, 0.349, 0.686, 0.168, 0.272, 0.534, 0.131], 0.0, "input")
    if rescale:
        return toned / (greatest(toned, [-3, -2, -1]) + eps)
    return toned


def _sepia_of_bytes(input: Tensor, rescale: bool) -> Tensor:
    rows = [[6439, 12599, 3097], [5718, 11239, 2753], [4456, 8749, 2146]]
    if not rescale:
        return mix_bytes(input, rows[0] + [8192] + rows[1] + [8192] + rows[2] + [8192], 14)
    red, green, blue = channels_of(input)
    planes: List[Tensor] = []
    for row in rows:
        # Whole numbers below 2^24, which float32 holds.
        sums = red.to(torch.float32) * float(row[0]) + green.to(torch.float32) * float(row[1])
        planes.append(sums + blue.to(torch.float32) * float(row[2]))
    toned = torch.stack(planes, -3)
    most = toned.amax([-3, -2, -1], keepdim=True).clamp(min=1.0).to(torch.float64)
    return torch.floor((510.0 * toned.to(torch.float64) + most) / (2.0 * most)).to(torch.uint8)
