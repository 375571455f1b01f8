"""Windows of images."""

from typing import Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.lowering import primitive


@primitive
def windows(
    x: Tensor, count: Tuple[int, int], size: Tuple[int, int], stride: Tuple[int, int], first: Tuple[int, int]
) -> Tensor:
    """``count`` (down, right) windows of (B, C, H, W), the first of which begins at ``first``; pixels outside
    the image are 0.

    Returns (B, C, down, rows, right, columns). Eager code pads and takes a view by ``unfold``, which has no
    form in ONNX. There pixels are indexed by (windows, pixels of a window), because an axis of symbolic size
    cannot be split into two.

    >>> windows(torch.ones(1, 1, 2, 3), (1, 2), (2, 2), (2, 2), (0, 0))[0, 0, 0]
    tensor([[[1., 1.],
             [1., 0.]],
    <BLANKLINE>
            [[1., 1.],
             [1., 0.]]])
    """
    bottom = max(0, first[0] + (count[0] - 1) * stride[0] + size[0] - x.size(2))
    right = max(0, first[1] + (count[1] - 1) * stride[1] + size[1] - x.size(3))
    padded = F.pad(x, [-first[1], right, -first[0], bottom])
    cut = padded.unfold(2, size[0], stride[0]).unfold(3, size[1], stride[1])
    return cut[:, :, : count[0], : count[1]].permute(0, 1, 2, 4, 3, 5)


@windows.lowering("onnx", "native", "vjp")
def _by_index(
    x: Tensor, count: Tuple[int, int], size: Tuple[int, int], stride: Tuple[int, int], first: Tuple[int, int]
) -> Tensor:
    row, column = (
        _positions(x, count[0], size[0], stride[0], first[0]),
        _positions(x, count[1], size[1], stride[1], first[1]),
    )
    inside = ((row >= 0) & (row < x.size(2)))[:, :, None, None] & (column >= 0) & (column < x.size(3))
    tall = x[:, :, row.clamp(min=0, max=x.size(2) - 1)]
    cut = tall[:, :, :, :, column.clamp(min=0, max=x.size(3) - 1)]
    return torch.where(inside, cut, torch.zeros_like(cut))


def _positions(like: Tensor, count: int, size: int, stride: int, first: int) -> Tensor:
    """(count, size): the positions of each window's pixels along an axis."""
    return (
        torch.arange(count, device=like.device)[:, None] * stride
        + torch.arange(size, device=like.device)
        + first
    )
