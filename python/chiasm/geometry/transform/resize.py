"""Resizing."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives import kernels
from ...primitives.checks import check_choice, check_image
from ...primitives.materialise import materialised, stored_index
from ...primitives.reshaping import reshaped
from ...primitives.sampling import (
    antialias_table,
    cubic_weights,
    larger,
    nearest_index,
    smaller,
    source_positions,
    weight_dtype,
)


def resize(
    input: Tensor,
    size: Union[int, Tuple[int, int]],
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    side: str = "short",
    antialias: bool = False,
) -> Tensor:
    """Resize an image.

    Pixel centres lie at half-integers, as for ``torch.nn.functional.interpolate``, ``cv2.resize`` and Pillow.
    Without antialias, "bicubic" has a = -0.75 (torch, OpenCV), with antialias -0.5 (torch, Pillow). "nearest" takes
    pixel floor(i * in / out) in exact arithmetic, where torch rounds the ratio to float32.

    Args:
        input: (B, C, H, W), floating point.
        size: (height, width) of the output, or one number for ``side``, the other side keeping the aspect ratio.
            Either may come from another tensor's shape, which makes the output size dynamic in exported graphs.
        interpolation: "nearest", "bilinear" or "bicubic".
        align_corners: let the centres of the corner pixels coincide instead of the outer edges. None is False.
        side: what a single size is the length of: "short", "long", "vert" or "horz".
        antialias: stretch the filter by the reduction factor (not for "nearest").

    Returns:
        (B, C, height, width).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, a size is not positive, or a choice is not as above.

    Example:
        >>> resize(torch.ones(1, 3, 4, 6), (2, 3)).shape
        torch.Size([1, 3, 2, 3])
        >>> resize(torch.ones(1, 3, 4, 6), 2).shape
        torch.Size([1, 3, 2, 3])
    """
    check_image(input, "input")
    check_choice(interpolation, ["nearest", "bilinear", "bicubic"], "interpolation")
    check_choice(side, ["short", "long", "vert", "horz"], "side")
    if antialias and interpolation == "nearest":
        raise ValueError("antialias: expected False for interpolation 'nearest', got True")
    in_height, in_width = input.size(2), input.size(3)
    if isinstance(size, int):
        base = in_width
        if side == "vert":
            base = in_height
        elif side == "short":
            base = smaller(in_height, in_width)
        elif side == "long":
            base = larger(in_height, in_width)
        height, width = size * in_height // base, size * in_width // base
    else:
        height, width = size
    if height < 1 or width < 1:
        raise ValueError(f"size: expected positive sizes, got ({height}, {width})")
    corners = align_corners is not None and align_corners
    if not torch.jit.is_scripting() and kernels.has_kernel(input):
        return kernels.resize(input, height, width, interpolation, corners, antialias)
    if antialias:
        radius = 1 if interpolation == "bilinear" else 2
        columns = _antialias_axis(input, width, corners, radius, 3)
        return _antialias_axis(columns, height, corners, radius, 2)
    if interpolation == "nearest":
        rows = input.index_select(2, stored_index(nearest_index(in_height, height, input.device)))
        return rows.index_select(3, stored_index(nearest_index(in_width, width, input.device)))
    if interpolation == "bilinear":
        return _bilinear(input, height, width, corners)
    return _bicubic_axis(_bicubic_axis(input, width, corners, 3), height, corners, 2)


def _bilinear(x: Tensor, height: int, width: int, align_corners: bool) -> Tensor:
    top, bottom, down = _linear_table(x, height, align_corners, 2)
    left, right, across = _linear_table(x, width, align_corners, 3)
    upper, lower = x.index_select(2, top), x.index_select(2, bottom)
    down = down[:, None]
    # Each tap is named once, for then AOTInductor fuses the four gathers into one loop without an image in between.
    first = upper.index_select(3, left) * (1.0 - across) + upper.index_select(3, right) * across
    second = lower.index_select(3, left) * (1.0 - across) + lower.index_select(3, right) * across
    return first * (1.0 - down) + second * down


def _linear_table(x: Tensor, out_size: int, align_corners: bool, dim: int) -> Tuple[Tensor, Tensor, Tensor]:
    """Indices of the two neighbours, and the weight of the second, for each of ``out_size`` positions."""
    in_size = x.size(dim)
    whole, fraction = source_positions(in_size, out_size, align_corners, weight_dtype(x), x.device)
    first = stored_index(whole.clamp(0, in_size - 1))
    second = stored_index((whole + 1).clamp(0, in_size - 1))
    return first, second, materialised(fraction.to(x.dtype), 0)


def _bicubic_axis(x: Tensor, out_size: int, align_corners: bool, dim: int) -> Tensor:
    in_size = x.size(dim)
    whole, fraction = source_positions(in_size, out_size, align_corners, weight_dtype(x), x.device)
    whole = materialised(whole, 0)
    weights = [materialised(w.to(x.dtype), 0) for w in cubic_weights(fraction, -0.75)]
    if dim == 2:
        weights = [w[:, None] for w in weights]
    out = x.index_select(dim, (whole - 1).clamp(0, in_size - 1)) * weights[0]
    for k in range(1, 4):
        out = out + x.index_select(dim, (whole + (k - 1)).clamp(0, in_size - 1)) * weights[k]
    return out


def _antialias_axis(x: Tensor, out_size: int, align_corners: bool, radius: int, dim: int) -> Tensor:
    index, weight = antialias_table(x.size(dim), out_size, align_corners, radius, weight_dtype(x), x.device)
    taps = index.size(1)
    weight = weight.to(x.dtype)
    picked = x.index_select(dim, index.reshape(-1))
    if dim == 2:
        stacked = reshaped(picked, [x.size(0), x.size(1), out_size, taps, x.size(3)])
        return (stacked * weight[:, :, None]).sum(3)
    return (reshaped(picked, [x.size(0), x.size(1), x.size(2), out_size, taps]) * weight).sum(4)
