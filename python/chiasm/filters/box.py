"""Filters computed from sums over windows: box blur, Laplacian."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_pixels, odd_pair
from ..primitives.core.window_sizes import positive_pair
from ..primitives.filters.correlation import box_sums
from ..primitives.filters.fixed_point import box_bytes, laplacian_bytes
from ..primitives.numbers.loss_reduction import narrowed, widened


def box_blur(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    border_type: str = "reflect",
    separable: bool = True,
) -> Tensor:
    """Mean of each pixel's window. For uint8, the sums are exact, and the mean is rounded once (halves to
    even). If both sizes are odd, the result is identical to that of OpenCV's 8-bit ``blur``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_size: one for both axes or (rows, columns). An even window reaches one pixel further down and
            right. For uint8, it has at most 65536 pixels, because float32 must hold the sums.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        separable: for compatibility with Kornia; it has no effect, since the sums are always separable.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D, or the kernel size or border is not as above.

    Example:
        >>> box_blur(torch.arange(5.0).reshape(1, 1, 1, 5), (1, 3), "replicate").flatten()
        tensor([0.3333, 1.0000, 2.0000, 3.0000, 3.6667])
    """
    check_pixels(input, "input")
    ky, kx = positive_pair(kernel_size, "kernel_size")
    if input.dtype == torch.uint8:
        if ky * kx > 65536:
            raise ValueError(f"kernel_size: expected at most 65536 pixels on bytes, got ({ky}, {kx})")
        return box_bytes(input, ky, kx, border_type)
    return narrowed(box_sums(widened(input), ky, kx, border_type, scale=1.0 / (ky * kx)), input)


def laplacian(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    border_type: str = "reflect",
    normalized: bool = True,
) -> Tensor:
    """Sum of the differences between a window's pixels and its centre pixel. This is the correlation with
    ``get_laplacian_kernel2d``. OpenCV's ``Laplacian`` uses other kernels. For uint8, the sums (not
    normalized) are int16.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_size: odd, one for both axes or (rows, columns); more than one pixel, for uint8 at most 129
            pixels.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        normalized: divide by the sum of the kernel's absolute values, 2 (rows * columns - 1); must be False
            for uint8.

    Returns:
        (B, C, H, W), of the input's dtype, or int16 for uint8.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if input is not 4-D, or the kernel size, the border or normalized is not as above.

    Example:
        >>> laplacian(torch.eye(3)[None, None], 3, "constant", normalized=False)[0, 0]
        tensor([[-7.,  2.,  1.],
                [ 2., -6.,  2.],
                [ 1.,  2., -7.]])
    """
    check_pixels(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    count = ky * kx
    if count == 1:
        raise ValueError("kernel_size: expected more than one pixel, got (1, 1)")
    if input.dtype == torch.uint8:
        if normalized:
            raise ValueError("normalized: expected False on bytes, got True")
        if count > 129:
            raise ValueError(f"kernel_size: expected at most 129 pixels on bytes, got ({ky}, {kx})")
        return laplacian_bytes(input, ky, kx, border_type)
    scale = 0.5 / (count - 1) if normalized else 1.0
    return narrowed(box_sums(widened(input), ky, kx, border_type, scale, -scale * count), input)
