"""Deformable convolution: the positions of the taps depend on the data."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_image, check_rank
from ..primitives.core.window_sizes import any_pair
from ..primitives.filters.padding import check_inside
from ..primitives.linalg.matrices import small_matmul
from ..primitives.resampling.warping import position_dtype, resample_image


def deform_conv2d(
    input: Tensor,
    offset: Tensor,
    weight: Tensor,
    bias: Optional[Tensor] = None,
    stride: Union[int, Tuple[int, int]] = (1, 1),
    padding: Union[int, Tuple[int, int]] = (0, 0),
    dilation: Union[int, Tuple[int, int]] = (1, 1),
    mask: Optional[Tensor] = None,
) -> Tensor:
    """Deformable convolution: taps are shifted by offsets and, with a mask, weighted at each place.

    J. Dai et al., Deformable Convolutional Networks, ICCV 2017; with a mask, version 2, X. Zhu et al., CVPR
    2019. Taps are read by bilinear interpolation, 0 outside the input, and multiplied with the weights as
    matrices: B * C * kh * kw * OH * OW values are stored; exported gradients store O times as many.

    Args:
        input: (B, C, H, W), floating point.
        offset: (B, 2 * G * kh * kw, OH, OW): the row and column offsets of each tap, for each of G groups of
            channels.
        weight: (O, C / groups, kh, kw); its shape determines the number of groups.
        bias: (O,).
        stride: the steps between places, in rows and columns, or one number for both.
        padding: the number of rows above and below, and of columns at both sides, that are added with zeros,
            or one number for both.
        dilation: the steps between taps, in rows and columns, or one number for both.
        mask: (B, G * kh * kw, OH, OW), the factor of each tap.

    Returns:
        (B, O, OH, OW), with OH = (H + 2 * padding - dilation * (kh - 1) - 1) // stride + 1.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above, a kernel is empty or larger than the padded input, stride or
            dilation is not positive, or padding negative.

    Example:
        >>> image = torch.arange(9.0).reshape(1, 1, 3, 3)
        >>> offset = torch.tensor([0.0, 0.5])[None, :, None, None].expand(1, 2, 3, 3)
        >>> deform_conv2d(image, offset, torch.ones(1, 1, 1, 1))
        tensor([[[[0.5000, 1.5000, 1.0000],
                  [3.5000, 4.5000, 2.5000],
                  [6.5000, 7.5000, 4.0000]]]])
    """
    check_image(input, "input")
    check_rank(weight, 4, "(O, C / groups, kh, kw)", "weight")
    check_floating(weight, "weight")
    batch, channels = input.size(0), input.size(1)
    out_channels, kh, kw = weight.size(0), weight.size(2), weight.size(3)
    if weight.size(1) < 1 or kh < 1 or kw < 1:
        raise ValueError(f"weight: expected a channel and a tap at least, got {list(weight.shape)}")
    groups = channels // weight.size(1)
    if weight.size(1) * groups != channels or out_channels % groups != 0:
        raise ValueError(
            f"weight: expected shape (O, C / groups, kh, kw) for input {list(input.shape)}, got"
            f" {list(weight.shape)}"
        )
    step_y, step_x = any_pair(stride, "stride")
    margin_y, margin_x = any_pair(padding, "padding")
    spread_y, spread_x = any_pair(dilation, "dilation")
    rows = _places(input.size(2), kh, step_y, margin_y, spread_y, "rows")
    columns = _places(input.size(3), kw, step_x, margin_x, spread_x, "columns")
    taps = kh * kw
    _check_taps(offset, batch, 2 * taps, rows, columns, "offset", "(B, 2 * G * kh * kw, OH, OW)")
    parts = offset.size(1) // (2 * taps)
    if channels % parts != 0:
        raise ValueError(f"offset: expected groups that divide {channels} channels, got {list(offset.shape)}")
    if mask is not None:
        _check_taps(mask, batch, taps, rows, columns, "mask", "(B, G * kh * kw, OH, OW)")
        if mask.size(1) != parts * taps:
            raise ValueError(f"mask: expected {parts * taps} channels, got {list(mask.shape)}")
    if bias is not None:
        check_floating(bias, "bias")
        if bias.dim() != 1 or bias.size(0) != out_channels:
            raise ValueError(f"bias: expected shape ({out_channels},), got {list(bias.shape)}")
    precision = position_dtype(input.dtype)
    moved = offset.to(precision).reshape(batch * parts, taps, 2, rows, columns)
    tap_row = torch.arange(kh, device=input.device)[:, None].expand(kh, kw).reshape(taps, 1, 1)
    tap_column = torch.arange(kw, device=input.device)[None].expand(kh, kw).reshape(taps, 1, 1)
    down, across = (tap_row * spread_y).to(precision), (tap_column * spread_x).to(precision)
    row = torch.arange(rows, device=input.device).to(precision)[:, None] * step_y - margin_y
    column = torch.arange(columns, device=input.device).to(precision) * step_x - margin_x
    y = (moved[:, :, 0] + (down + row)).reshape(batch * parts, taps * rows, columns)
    x = (moved[:, :, 1] + (across + column)).reshape(batch * parts, taps * rows, columns)
    source = input.reshape(batch * parts, channels // parts, input.size(2), input.size(3))
    read = resample_image(source, x, y, "bilinear", "zeros", False, None)
    if mask is not None:
        read = read * mask.reshape(batch * parts, 1, taps * rows, columns)
    each = channels // groups * taps
    out = small_matmul(
        weight.reshape(groups, out_channels // groups, each),
        read.reshape(batch, groups, each, rows * columns),
    ).reshape(batch, out_channels, rows, columns)
    return out if bias is None else out + bias[:, None, None]


def _places(size: int, taps: int, stride: int, padding: int, dilation: int, what: str) -> int:
    """The number of places along an axis, ``what`` in the message."""
    if stride < 1 or dilation < 1:
        raise ValueError(f"stride, dilation: expected positive numbers, got {stride} and {dilation}")
    if padding < 0:
        raise ValueError(f"padding: expected zero or more, got {padding}")
    check_inside(size + 2 * padding, dilation * (taps - 1) + 1, what)
    return (size + 2 * padding - dilation * (taps - 1) - 1) // stride + 1


def _check_taps(
    value: Tensor, batch: int, multiple: int, rows: int, columns: int, name: str, layout: str
) -> None:
    """Raise unless ``value`` has a multiple of this many numbers for each place."""
    check_rank(value, 4, layout, name)
    check_floating(value, name)
    if (
        value.size(0) != batch
        or value.size(1) < multiple
        or value.size(1) % multiple != 0
        or value.size(2) != rows
        or value.size(3) != columns
    ):
        raise ValueError(
            f"{name}: expected shape {layout}, ({batch}, G * {multiple}, {rows}, {columns}), got"
            f" {list(value.shape)}"
        )
