"""Correlation and convolution with kernels that are inputs of the op."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_floating, check_pixels
from ..primitives.core.materialise import materialised
from ..primitives.filters.correlation import (
    centred,
    correlate2d_valid,
    correlated2d,
    correlated3d,
    separable_any,
)
from ..primitives.filters.fixed_point import bytes_of_sums, correlated_bytes, whole_taps
from ..primitives.filters.padding import check_border, check_inside
from ..primitives.resampling.volumes import check_volume


def filter2d(
    input: Tensor,
    kernel: Tensor,
    border_type: str = "reflect",
    normalized: bool = False,
    padding: str = "same",
    behaviour: str = "corr",
) -> Tensor:
    """Correlate every channel with a kernel. out(y, x) = sum over i, j of kernel(i, j) * input(y + i - ay, x
    + j - ax). The anchor (ay, ax) is the kernel's centre; for an even size it is (size - 1) // 2, in OpenCV
    and SciPy size // 2.

    For uint8, the kernel is rounded to multiples of a power of two, the smallest one for which no sum can
    reach 2^24: 2^-16 if the kernel's absolute values sum to 1. The sums are exact, and the result is rounded
    (halves to even) and saturated. ``cv2.filter2D`` adds 8-bit images in float32: the results differ by at
    most one level, and are the same if the kernel already consists of such multiples.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel: floating point, (kH, kW) or (1, kH, kW) for all samples, or (B, kH, kW) with one for each.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        normalized: divide the kernel by the sum of its absolute values.
        padding: "same" for an output of the input's size, "valid" for only the pixels whose whole window lies
            inside the image.
        behaviour: "corr", or "conv" to rotate the kernel by 180 degrees first, which is a convolution.

    Returns:
        (B, C, H, W); for "valid" (B, C, H - kH + 1, W - kW + 1).

    Raises:
        TypeError: if input is neither floating point nor uint8, or a kernel is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> filter2d(torch.ones(1, 1, 3, 4), torch.ones(3, 3), "constant")[0, 0]
        tensor([[4., 6., 6., 4.],
                [6., 9., 9., 6.],
                [4., 6., 6., 4.]])
    """
    check_pixels(input, "input")
    check_border(border_type)
    check_choice(padding, ["same", "valid"], "padding")
    check_choice(behaviour, ["corr", "conv"], "behaviour")
    k = _ready(kernel, input, 2, "(kH, kW) or (B, kH, kW)", normalized, behaviour == "conv", "kernel")
    if padding == "valid":
        check_inside(input.size(2), k.size(1), "rows")
        check_inside(input.size(3), k.size(2), "columns")
    if input.dtype == torch.uint8:
        return _filtered_bytes(input, k, border_type, padding)
    if padding == "valid":
        return correlate2d_valid(input, k)
    return correlated2d(input, k, border_type)


def _filtered_bytes(input: Tensor, kernel: Tensor, border_type: str, padding: str) -> Tensor:
    taps, scale = whole_taps(kernel)
    if padding == "valid":
        return bytes_of_sums(correlate2d_valid(input.to(torch.float32), taps), scale)
    return correlated_bytes(input, taps, scale, border_type)


def filter2d_separable(
    input: Tensor,
    kernel_x: Tensor,
    kernel_y: Tensor,
    border_type: str = "reflect",
    normalized: bool = False,
    padding: str = "same",
) -> Tensor:
    """``filter2d`` with the outer product of two one-dimensional kernels, in two passes (for uint8 in one).

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_x: the horizontal kernel, (kW,) or (1, kW) for all samples, or (B, kW) with one for each.
        kernel_y: the vertical kernel, (kH,), (1, kH) or (B, kH).
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        normalized: divide each kernel by the sum of its absolute values.
        padding: "same" for an output of the input's size, "valid" for only the pixels whose whole window lies
            inside the image.

    Returns:
        (B, C, H, W); for "valid" (B, C, H - kH + 1, W - kW + 1).

    Raises:
        TypeError: if input is neither floating point nor uint8, or a kernel is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> filter2d_separable(torch.ones(1, 1, 3, 4), torch.ones(3), torch.ones(1), "constant")[0, 0, 0]
        tensor([2., 3., 3., 2.])
    """
    check_pixels(input, "input")
    check_border(border_type)
    check_choice(padding, ["same", "valid"], "padding")
    kx = _ready(kernel_x, input, 1, "(kW,) or (B, kW)", normalized, False, "kernel_x")
    ky = _ready(kernel_y, input, 1, "(kH,) or (B, kH)", normalized, False, "kernel_y")
    if padding == "valid":
        check_inside(input.size(2), ky.size(1), "rows")
        check_inside(input.size(3), kx.size(1), "columns")
    if input.dtype == torch.uint8:
        return _filtered_bytes(input, ky[:, :, None] * kx[:, None, :], border_type, padding)
    if padding == "valid":
        return separable_any(input, ky, kx, (0, 0), (0, 0), border_type)
    return separable_any(input, ky, kx, centred(ky.size(1)), centred(kx.size(1)), border_type)


def filter3d(
    input: Tensor,
    kernel: Tensor,
    border_type: str = "replicate",
    normalized: bool = False,
    behaviour: str = "corr",
) -> Tensor:
    """``filter2d`` for volumes.

    Args:
        input: (B, C, D, H, W), floating point.
        kernel: (kD, kH, kW) or (1, kD, kH, kW) for all samples, or (B, kD, kH, kW) with one for each.
        border_type: "reflect" (the edge voxel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        normalized: divide the kernel by the sum of its absolute values.
        behaviour: "corr", or "conv" to reverse the kernel along its three axes first.

    Returns:
        (B, C, D, H, W).

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> filter3d(torch.ones(1, 1, 3, 3, 3), torch.ones(3, 3, 3), normalized=True)[0, 0, 1, 1]
        tensor([1.0000, 1.0000, 1.0000])
    """
    check_volume(input, "input")
    check_border(border_type)
    check_choice(behaviour, ["corr", "conv"], "behaviour")
    k = _ready(kernel, input, 3, "(kD, kH, kW) or (B, kD, kH, kW)", normalized, behaviour == "conv", "kernel")
    return correlated3d(input, k, border_type)


def correlate2d(
    input: Tensor,
    kernel: Tensor,
    border_type: str = "reflect",
    normalized: bool = False,
    padding: str = "same",
) -> Tensor:
    """``filter2d`` with behaviour "corr": the kernel is not rotated.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel: floating point, (kH, kW), (1, kH, kW) or (B, kH, kW).
        border_type, normalized, padding: see ``filter2d``.

    Returns:
        (B, C, H, W); for padding "valid" (B, C, H - kH + 1, W - kW + 1).

    Raises:
        TypeError, ValueError: as ``filter2d``.

    Example:
        >>> correlate2d(torch.eye(3)[None, None], torch.tensor([[0.0, 0.0, 1.0]]), "constant")[0, 0]
        tensor([[0., 0., 0.],
                [1., 0., 0.],
                [0., 1., 0.]])
    """
    return filter2d(input, kernel, border_type, normalized, padding, "corr")


def convolve2d(
    input: Tensor,
    kernel: Tensor,
    border_type: str = "reflect",
    normalized: bool = False,
    padding: str = "same",
) -> Tensor:
    """``filter2d`` with behaviour "conv": the kernel is rotated by 180 degrees.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel: floating point, (kH, kW), (1, kH, kW) or (B, kH, kW).
        border_type, normalized, padding: see ``filter2d``.

    Returns:
        (B, C, H, W); for padding "valid" (B, C, H - kH + 1, W - kW + 1).

    Raises:
        TypeError, ValueError: as ``filter2d``.

    Example:
        >>> convolve2d(torch.eye(3)[None, None], torch.tensor([[0.0, 0.0, 1.0]]), "constant")[0, 0]
        tensor([[0., 1., 0.],
                [0., 0., 1.],
                [0., 0., 0.]])
    """
    return filter2d(input, kernel, border_type, normalized, padding, "conv")


def correlate3d(
    input: Tensor, kernel: Tensor, border_type: str = "replicate", normalized: bool = False
) -> Tensor:
    """``filter3d`` with behaviour "corr": the kernel is not reversed.

    Args:
        input: (B, C, D, H, W), floating point.
        kernel: (kD, kH, kW), (1, kD, kH, kW) or (B, kD, kH, kW).
        border_type, normalized: see ``filter3d``.

    Returns:
        (B, C, D, H, W).

    Raises:
        TypeError, ValueError: as ``filter3d``.

    Example:
        >>> correlate3d(torch.arange(4.0).reshape(1, 1, 1, 1, 4), torch.tensor([[[0.0, 0.0, 1.0]]])).flatten()
        tensor([1., 2., 3., 3.])
    """
    return filter3d(input, kernel, border_type, normalized, "corr")


def convolve3d(
    input: Tensor, kernel: Tensor, border_type: str = "replicate", normalized: bool = False
) -> Tensor:
    """``filter3d`` with behaviour "conv": the kernel is reversed along its three axes.

    Args:
        input: (B, C, D, H, W), floating point.
        kernel: (kD, kH, kW), (1, kD, kH, kW) or (B, kD, kH, kW).
        border_type, normalized: see ``filter3d``.

    Returns:
        (B, C, D, H, W).

    Raises:
        TypeError, ValueError: as ``filter3d``.

    Example:
        >>> convolve3d(torch.arange(4.0).reshape(1, 1, 1, 1, 4), torch.tensor([[[0.0, 0.0, 1.0]]])).flatten()
        tensor([0., 0., 1., 2.])
    """
    return filter3d(input, kernel, border_type, normalized, "conv")


def fft_conv(
    input: Tensor,
    kernel: Tensor,
    border_type: str = "reflect",
    normalized: bool = False,
    padding: str = "same",
    behaviour: str = "corr",
) -> Tensor:
    """``filter2d`` under the name of Kornia's convolution by Fourier transforms. This op uses no Fourier
    transform: not every runtime has one, and the direct sum is exact. Its time grows with the kernel's area.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel: floating point, (kH, kW), (1, kH, kW) or (B, kH, kW).
        border_type, normalized, padding, behaviour: see ``filter2d``.

    Returns:
        (B, C, H, W); for padding "valid" (B, C, H - kH + 1, W - kW + 1).

    Raises:
        TypeError, ValueError: as ``filter2d``.

    Example:
        >>> fft_conv(torch.ones(1, 1, 4, 4), torch.ones(3, 3), padding="valid").flatten()
        tensor([9., 9., 9., 9.])
    """
    return filter2d(input, kernel, border_type, normalized, padding, behaviour)


def check_kernel_batch(kernel: Tensor, input: Tensor, names: str) -> None:
    """Raise unless the kernels of the arguments ``names`` are one, or one for each sample of ``input``."""
    if kernel.size(0) != input.size(0) and kernel.size(0) != 1:
        raise ValueError(
            f"{names}: expected one value, or one for each of input's {input.size(0)} samples, got"
            f" {kernel.size(0)}"
        )


def _ready(
    kernel: Tensor, input: Tensor, rank: int, layout: str, normalized: bool, flip: bool, name: str
) -> Tensor:
    """The kernel with a leading axis of B or 1, in input's dtype (for uint8 float64), normalized and reversed
    as requested."""
    check_floating(kernel, name)
    if kernel.dim() != rank and kernel.dim() != rank + 1:
        raise ValueError(f"{name}: expected shape {layout}, got {list(kernel.shape)}")
    k = kernel.to(torch.float64 if input.dtype == torch.uint8 else input.dtype)
    if kernel.dim() == rank:
        k = k[None]
    elif k.size(0) != input.size(0) and k.size(0) != 1:
        raise ValueError(
            f"{name}: expected a first dimension of 1 or input's {input.size(0)}, got {list(kernel.shape)}"
        )
    axes: List[int] = [i for i in range(1, rank + 1)]
    for axis in axes:
        if k.size(axis) < 1:
            raise ValueError(f"{name}: expected at least one number, got {list(kernel.shape)}")
    if normalized:
        k = k / k.abs().sum(axes, keepdim=True)
    if flip:
        k = torch.flip(k, axes)
    # Stored, so that the kernel's arithmetic is not repeated for every pixel and tap.
    return materialised(k, 1)
