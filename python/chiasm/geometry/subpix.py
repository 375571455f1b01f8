"""Local maxima."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.checks import check_image, odd_pair
from ..primitives.padding import join_columns, padded_parts


def nms2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], mask_only: bool = False) -> Tensor:
    """Keep strict local maxima, set the rest to zero.

    A pixel stays when it exceeds every other pixel of the window around it. The border is replicated, so that a pixel of
    the outermost row or column meets its own copy and never stays. Kornia's also drops maxima that are not positive.
    Unlike Kornia's, a mask comes in input's dtype, so that the return type is one.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd size of the window, one for both axes or (rows, columns).
        mask_only: return 1 for maxima and 0 elsewhere instead.

    Returns:
        (B, C, H, W) in input's dtype.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or a kernel size is not odd and at least 3.

    Example:
        >>> x = torch.zeros(1, 1, 5, 5)
        >>> x[0, 0, 2, 2] = 3.0
        >>> nms2d(x, 3).sum()
        tensor(3.)
    """
    check_image(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    if ky < 3 or kx < 3:
        raise ValueError(f"kernel_size: expected sizes of at least 3, got ({ky}, {kx})")
    parts = padded_parts(input, ky // 2, ky // 2, kx // 2, kx // 2, "replicate")
    mask = (input > join_columns([_largest_neighbour(p, ky, kx) for p in parts])).to(input.dtype)
    if mask_only:
        return mask
    return input * mask


def _largest_neighbour(p: Tensor, ky: int, kx: int) -> Tensor:
    height = p.size(2) - ky + 1
    width = p.size(3) - kx + 1
    # Columns without their middle pixel, then whole columns, which the neighbouring windows share.
    gap = torch.maximum(p[:, :, 0:height], p[:, :, ky - 1 : ky - 1 + height])
    for i in range(1, ky - 1):
        if i != ky // 2:
            gap = torch.maximum(gap, p[:, :, i : i + height])
    column = torch.maximum(gap, p[:, :, ky // 2 : ky // 2 + height])
    out = gap[..., kx // 2 : kx // 2 + width]
    for j in range(kx):
        if j != kx // 2:
            out = torch.maximum(out, column[..., j : j + width])
    return out
