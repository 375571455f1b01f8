"""Soft non-maximum suppression: one keypoint for each window of a response, differentiable in the response.

A. Barroso-Laguna, E. Riba, D. Ponsa, K. Mikolajczyk, Key.Net: Keypoint Detection by Handcrafted and Learned
CNN Filters, ICCV 2019, sections 3.3 and 3.4. In scale space, and where windows overlap,
``geometry.subpix.conv_soft_argmax3d`` and ``conv_soft_argmax2d`` are soft, ``nms3d`` is not.
"""

import math
from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_one_channel
from ..primitives.numbers.reductions import greatest
from ..primitives.numbers.reshaping import reshaped
from ..primitives.resampling.warping import position_dtype


def index_proposal(response: Tensor, window: int, base: float = math.e) -> Tuple[Tensor, Tensor]:
    """Soft position of the maximum of each window: the mean pixel position with weights base^r / sum of
    base^r.

    Windows are adjacent, beginning at the first pixel; the last window of a row or column ends with the
    image. (The authors' program, but not their paper, divides the responses of a window by the largest one
    and subtracts 1 from the powers, so that the scale of the response has no influence. Here it has: if the
    maximum exceeds another pixel of its window by d, its weight is base^d times the weight of this pixel.)

    Args:
        response: (B, 1, H, W), floating point. Half precision is computed in float32. A pixel of -inf has
            weight 0; the coordinates of a window with only such pixels are its centre.
        window: side of a window in pixels.
        base: base of the powers, more than 1; a larger base gives a position nearer to the maximum and a
            sharper gradient.

    Returns:
        Coordinates (B, h, w, 2), x and y in pixels, float32 of half precision, where 0 is the centre of the
        first pixel, with h = ceil(H / window) and w = ceil(W / window); scores (B, h, w), the largest
        response of each window. Differentiable in response.

    Raises:
        TypeError: if response is not floating point.
        ValueError: if response is not (B, 1, H, W), window not positive or base not more than 1.

    Example:
        >>> response = torch.zeros(1, 1, 4, 6)
        >>> response[0, 0, 2, 1], response[0, 0, 1, 5] = 30.0, 20.0
        >>> coordinates, scores = index_proposal(response, 4)
        >>> coordinates[0, 0].round(decimals=2), scores[0, 0]
        (tensor([[1., 2.],
                [5., 1.]]), tensor([30., 20.]))
    """
    check_one_channel(response, "response")
    if window < 1:
        raise ValueError(f"window: expected a positive number, got {window}")
    if not base > 1.0:
        raise ValueError(f"base: expected more than 1, got {base}")
    rows, columns = _windows(response.size(2), window, response), _windows(response.size(3), window, response)
    # (B, h, window, w, window): beyond the border the last pixel is repeated, which changes no maximum, and
    # has weight 0.
    tall = response[:, 0].index_select(1, rows.flatten().clamp(max=response.size(2) - 1))
    tiles = tall.index_select(2, columns.flatten().clamp(max=response.size(3) - 1))
    tiles = reshaped(tiles, [response.size(0), rows.size(0), window, columns.size(0), window])
    score = greatest(tiles, [2, 4])[:, :, 0, :, 0]
    real = tiles.to(position_dtype(response.dtype)).clamp(min=-1e30)
    # The subtracted number cancels in the mean, so it needs no gradient.
    below = real - real.detach().amax([2, 4], keepdim=True)
    inside = (rows < response.size(2))[:, :, None, None] & (columns < response.size(3))
    weight = torch.exp(below * math.log(base)) * inside.to(below.dtype)
    across, down = weight.sum(2), weight.sum(4)
    offset = torch.arange(window, device=response.device).to(below.dtype)
    total = across.sum(-1)
    x = (across * offset).sum(-1) / total + columns[:, 0].to(total.dtype)
    y = (down * offset[:, None]).sum(2) / total + rows[:, :1].to(total.dtype)
    return torch.stack([x, y], -1), score


def multi_scale_index_proposal(
    response: Tensor, windows: Optional[List[int]] = None, base: float = math.e
) -> Tuple[Tensor, Tensor, Tensor]:
    """``index_proposal`` for windows of several sizes, with all proposals concatenated.

    Args:
        response: (B, 1, H, W), floating point.
        windows: sides of the windows in pixels; None is the paper's 8, 16, 24, 32 and 40.
        base: see ``index_proposal``.

    Returns:
        Coordinates (B, M, 2), x and y in pixels, float32 of half precision; scores (B, M); and (B, M), int64,
        the index in ``windows`` of each proposal. M is the sum of ceil(H / window) ceil(W / window) over the
        sizes; proposals are in the order of the sizes, then of rows, then of columns. Coordinates and scores
        are differentiable in response.

    Raises:
        TypeError: if response is not floating point.
        ValueError: if response is not (B, 1, H, W), windows empty, a window not positive or base not more
            than 1.

    Example:
        >>> response = torch.zeros(1, 1, 6, 6)
        >>> response[0, 0, 4, 1] = 30.0
        >>> coordinates, scores, size = multi_scale_index_proposal(response, [3, 6])
        >>> coordinates[0, [2, 4]].round(decimals=2), size[0]
        (tensor([[1., 4.],
                [1., 4.]]), tensor([0, 0, 0, 0, 1]))
    """
    sizes = [8, 16, 24, 32, 40] if windows is None else windows
    if len(sizes) < 1:
        raise ValueError("windows: expected at least one size, got none")
    places: List[Tensor] = []
    values: List[Tensor] = []
    which: List[Tensor] = []
    for k in range(len(sizes)):
        coordinates, scores = index_proposal(response, sizes[k], base)
        places.append(coordinates.flatten(1, 2))
        values.append(scores.flatten(1))
        which.append(torch.full_like(values[k], k, dtype=torch.int64))
    return torch.cat(places, 1), torch.cat(values, 1), torch.cat(which, 1)


def _windows(size: int, window: int, like: Tensor) -> Tensor:
    """The pixels of each window along an axis, (windows, window); the last window's may go on beyond the
    border."""
    first = torch.arange((size + window - 1) // window, device=like.device) * window
    return first[:, None] + torch.arange(window, device=like.device)
