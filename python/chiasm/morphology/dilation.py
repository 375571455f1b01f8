"""Dilation."""

from typing import List, Optional

import torch
from torch import Tensor

from ..primitives.checks import check_choice, check_image
from ..primitives.padding import join_columns, padded_parts


def dilation(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
) -> Tensor:
    """Dilate: out(p) = max over the kernel's nonzero offsets b of tensor(p - b) + height(b).

    J. Serra, Image Analysis and Mathematical Morphology, 1982. As in SciPy's ``grey_dilation`` the element is
    reflected; OpenCV's ``dilate`` does not reflect it.

    Args:
        tensor: (B, C, H, W), floating point, of magnitude well below max_val.
        kernel: (kh, kw); nonzero entries are the neighbourhood.
        structuring_element: (kh, kw) heights b of a non-flat element; zeros (flat) by default.
        origin: [row, column] of the element's origin, [kh // 2, kw // 2] by default.
        border_type: "geodesic" (the outside never wins), "reflect", "replicate", "circular" or "constant".
        border_value: the outside's value for "constant".
        max_val: stands for infinity.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if tensor is not floating point.
        ValueError: if a shape, origin or border is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 3, 5)
        >>> x[0, 0, 1, 2] = 1.0
        >>> dilation(x, torch.ones(1, 3))[0, 0, 1]
        tensor([0., 1., 1., 1., 0.])
    """
    check_image(tensor, "tensor")
    check_choice(border_type, ["geodesic", "reflect", "replicate", "circular", "constant"], "border_type")
    if kernel.dim() != 2:
        raise ValueError(f"kernel: expected shape (kh, kw), got {list(kernel.shape)}")
    kh, kw = kernel.size(0), kernel.size(1)
    if origin is None:
        row, column = kh // 2, kw // 2
    else:
        row, column = origin[0], origin[1]
    if row < 0 or row >= kh or column < 0 or column >= kw:
        raise ValueError(f"origin: expected a position inside the ({kh}, {kw}) kernel, got [{row}, {column}]")
    heights = torch.zeros_like(kernel, dtype=tensor.dtype)
    if structuring_element is not None:
        if structuring_element.dim() != 2 or structuring_element.size(0) != kh or structuring_element.size(1) != kw:
            raise ValueError(f"structuring_element: expected the kernel's shape ({kh}, {kw}), got {list(structuring_element.shape)}")
        heights = structuring_element.to(tensor.dtype)
    heights = torch.where(kernel == 0, torch.full_like(heights, -max_val), heights)
    if border_type == "geodesic":
        border_type = "constant"
        border_value = -max_val
    outs: List[Tensor] = []
    for p in padded_parts(tensor, row, kh - row - 1, column, kw - column - 1, border_type, border_value):
        outs.append(_dilate_valid(p, heights))
    return join_columns(outs)


def _dilate_valid(p: Tensor, heights: Tensor) -> Tensor:
    kh, kw = heights.size(0), heights.size(1)
    height = p.size(2) - kh + 1
    width = p.size(3) - kw + 1
    out = p[:, :, 0:height, 0:width] + heights[kh - 1, kw - 1]
    for i in range(kh):
        for j in range(kw):
            if i + j > 0:
                shifted = p[:, :, i : i + height, j : j + width] + heights[kh - 1 - i, kw - 1 - j]
                out = torch.maximum(out, shifted)
    return out
