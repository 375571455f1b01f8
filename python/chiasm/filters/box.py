"""Filters made of sums over windows: box blur, Laplacian."""

from typing import Tuple, Union

from torch import Tensor

from ..primitives.core.checks import check_image, odd_pair
from ..primitives.core.window_sizes import positive_pair
from ..primitives.filters.correlation import box_sums


def box_blur(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    border_type: str = "reflect",
    separable: bool = True,
) -> Tensor:
    """Mean of each pixel's window.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: one for both axes or (rows, columns). An even window reaches one pixel further down and
            right.
        border_type: "reflect" (the edge pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        separable: as in Kornia; both values give the same sums, which are always separable.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the kernel size or border is not as above.

    Example:
        >>> box_blur(torch.arange(5.0).reshape(1, 1, 1, 5), (1, 3), "replicate").flatten()
        tensor([0.3333, 1.0000, 2.0000, 3.0000, 3.6667])
    """
    check_image(input, "input")
    ky, kx = positive_pair(kernel_size, "kernel_size")
    return box_sums(input, ky, kx, border_type, scale=1.0 / (ky * kx))


def laplacian(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    border_type: str = "reflect",
    normalized: bool = True,
) -> Tensor:
    """Sum of the differences between a window's pixels and its middle one.

    That is the correlation with ``get_laplacian_kernel2d``. OpenCV's ``Laplacian`` has other kernels.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd, one for both axes or (rows, columns); more than one pixel.
        border_type: "reflect" (the edge pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        normalized: divide by the sum of the kernel's absolute values, 2 (rows * columns - 1).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the kernel size or border is not as above.

    Example:
        >>> laplacian(torch.eye(3)[None, None], 3, "constant", normalized=False)[0, 0]
        tensor([[-7.,  2.,  1.],
                [ 2., -6.,  2.],
                [ 1.,  2., -7.]])
    """
    check_image(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    count = ky * kx
    if count == 1:
        raise ValueError("kernel_size: expected more than one pixel, got (1, 1)")
    scale = 0.5 / (count - 1) if normalized else 1.0
    return box_sums(input, ky, kx, border_type, scale, -scale * count)
