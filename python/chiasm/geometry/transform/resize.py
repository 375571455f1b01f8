"""Resizing."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.broadcasting import in_batch, like_given
from ...primitives.core.checks import check_choice, check_pair, check_pixels
from ...primitives.resampling.resizing import (
    area_means,
    resized,
    resized_bytes,
    resized_bytes_antialias,
    resized_nearest,
    resized_words,
    wide_bytes,
)
from ...primitives.resampling.taps import larger, smaller


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
    Without antialias, "bicubic" has a = -0.75 (PyTorch, OpenCV), with antialias -0.5 (PyTorch, Pillow).
    "nearest" uses pixel floor(i * in / out) in exact arithmetic; PyTorch rounds the ratio to float32. "area"
    is the mean over the area that a pixel of the output covers, like OpenCV's INTER_AREA for a reduction.
    "lanczos4" weighs 8 x 8 pixels by sinc(d) sinc(d / 4), scaled to add up to 1 along each axis, as OpenCV's
    INTER_LANCZOS4 does (K. Turkowski, Filters for Common Resampling Tasks, Graphics Gems I, 1990); "lanczos"
    has three lobes, as in Pillow.

    For uint8, "bilinear" without antialias has weights in multiples of 1/256 and is rounded (halves up); it
    is identical to OpenCV's INTER_LINEAR_EXACT. With antialias, weights are multiples of 1/2^22 and the
    result is rounded (halves up) after each axis; it is identical to Pillow's ``Image.resize`` of the rows
    and then of the columns. (Pillow resizes the columns first if this is faster.) "area" is the exact mean,
    and "bicubic" without antialias and "lanczos4" have weights in multiples of 1/2^11; they are rounded once
    (halves up) and differ from OpenCV's by at most one level. For int16 and uint16 "area" is the exact mean,
    "bilinear" and "bicubic" have weights in multiples of 1/2^18, and "lanczos4" of 1/2^17; they are rounded
    once, too.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), floating point or uint8; without antialias also int16 or
            uint16.
        size: (height, width) of the output, or one number for ``side``; then the other side keeps the aspect
            ratio. Either may come from another tensor's shape, which makes the output size dynamic in
            exported graphs.
        interpolation: "nearest", "bilinear", "bicubic", "area", "lanczos4", or with antialias "lanczos".
        align_corners: True aligns the centres of the corner pixels, False the outer edges. None is False.
            "area" must have False or None.
        side: the side whose length a single size gives: "short", "long", "vert" or "horz".
        antialias: stretch the filter by the reduction factor (not for "nearest" and "lanczos4"; "area" always
            does).

    Returns:
        (B, C, height, width).

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D, a size is not positive, or a choice is not as above.

    Example:
        >>> resize(torch.ones(1, 3, 4, 6), (2, 3)).shape
        torch.Size([1, 3, 2, 3])
        >>> resize(torch.ones(1, 3, 4, 6), 2).shape
        torch.Size([1, 3, 2, 3])
    """
    return like_given(
        _resize_of_batch(in_batch(input, "input"), size, interpolation, align_corners, side, antialias), input
    )


def _resize_of_batch(
    input: Tensor,
    size: Union[int, Tuple[int, int]],
    interpolation: str,
    align_corners: Optional[bool],
    side: str,
    antialias: bool,
) -> Tensor:
    check_pixels(input, "input", not antialias)
    check_choice(
        interpolation, ["nearest", "bilinear", "bicubic", "area", "lanczos4", "lanczos"], "interpolation"
    )
    check_choice(side, ["short", "long", "vert", "horz"], "side")
    if antialias and interpolation in ["nearest", "area", "lanczos4"]:
        raise ValueError(f"antialias: expected False for interpolation '{interpolation}', got True")
    if not antialias and interpolation == "lanczos":
        raise ValueError("antialias: expected True for interpolation 'lanczos', got False")
    height, width = size_of(input.size(2), input.size(3), size, side)
    if height < 1 or width < 1:
        raise ValueError(f"size: expected positive sizes, got ({height}, {width})")
    corners = align_corners is not None and align_corners
    if corners and interpolation == "area":
        raise ValueError("align_corners: expected False for interpolation 'area', got True")
    antialias = antialias or interpolation == "area"
    if not input.is_floating_point():
        if interpolation == "nearest":
            return resized_nearest(input, height, width)
        if interpolation == "area":
            return area_means(input, height, width)
        if antialias:
            return resized_bytes_antialias(input, height, width, interpolation, corners)
        if input.dtype != torch.uint8:
            return resized_words(input, height, width, interpolation, corners)
        if interpolation == "bilinear":
            return resized_bytes(input, height, width, corners)
        return wide_bytes(input, height, width, interpolation, corners)
    return resized(input, height, width, interpolation, corners, antialias)


def size_of(height: int, width: int, size: Union[int, Tuple[int, int]], side: str) -> Tuple[int, int]:
    """(height, width) of the result of ``resize``."""
    if not isinstance(size, int):
        check_pair(size, "size")
        return size
    base = width
    if side == "vert":
        base = height
    elif side == "short":
        base = smaller(height, width)
    elif side == "long":
        base = larger(height, width)
    return size * height // base, size * width // base
