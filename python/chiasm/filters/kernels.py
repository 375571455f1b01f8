"""Constant kernels: boxes, differences, Laplacians, windows."""

import math
from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, odd_pair
from ..primitives.core.window_sizes import positive_pair


def get_box_kernel1d(
    kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """Box kernel, the mean of kernel_size pixels.

    Args:
        kernel_size: number of taps.
        device, dtype: the device and dtype of the kernel.

    Returns:
        (1, kernel_size).

    Raises:
        ValueError: if kernel_size is not positive.

    Example:
        >>> get_box_kernel1d(4)
        tensor([[0.2500, 0.2500, 0.2500, 0.2500]])
    """
    size = positive_pair(kernel_size, "kernel_size")[0]
    return torch.full([1, size], 1.0 / size, device=device, dtype=dtype)


def get_box_kernel2d(
    kernel_size: Union[int, Tuple[int, int]],
    device: Optional[torch.device] = None,
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """Box kernel, the mean of a rectangle of pixels.

    Args:
        kernel_size: one for both axes or (rows, columns).
        device, dtype: the device and dtype of the kernel.

    Returns:
        (1, rows, columns).

    Raises:
        ValueError: if kernel_size is not positive.

    Example:
        >>> get_box_kernel2d((1, 2))
        tensor([[[0.5000, 0.5000]]])
    """
    ky, kx = positive_pair(kernel_size, "kernel_size")
    return torch.full([1, ky, kx], 1.0 / (ky * kx), device=device, dtype=dtype)


def get_binary_kernel2d(
    window_size: Union[int, Tuple[int, int]],
    device: Optional[torch.device] = None,
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """One kernel for each pixel of a window; each kernel selects its pixel.

    Args:
        window_size: one for both axes or (rows, columns).
        device, dtype: the device and dtype of the kernels.

    Returns:
        (rows * columns, 1, rows, columns).

    Raises:
        ValueError: if window_size is not positive.

    Example:
        >>> get_binary_kernel2d((1, 2))
        tensor([[[[1., 0.]]],
        <BLANKLINE>
        <BLANKLINE>
                [[[0., 1.]]]])
    """
    ky, kx = positive_pair(window_size, "window_size")
    return torch.eye(ky * kx, device=device, dtype=dtype).reshape(ky * kx, 1, ky, kx)


def get_hanning_kernel1d(
    kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """Hann window 0.5 - 0.5 cos(2 pi i / (kernel_size - 1)), like ``numpy.hanning``.

    Args:
        kernel_size: number of taps, more than 2.
        device, dtype: the device and dtype of the window.

    Returns:
        (kernel_size,).

    Raises:
        ValueError: if kernel_size is below 3.

    Example:
        >>> get_hanning_kernel1d(5)
        tensor([0.0000, 0.5000, 1.0000, 0.5000, 0.0000])
    """
    if kernel_size < 3:
        raise ValueError(f"kernel_size: expected at least 3, got {kernel_size}")
    taps = [0.5 - 0.5 * math.cos(2.0 * math.pi * i / (kernel_size - 1)) for i in range(kernel_size)]
    return torch.tensor(taps, device=device, dtype=dtype)


def get_hanning_kernel2d(
    kernel_size: Union[int, Tuple[int, int]],
    device: Optional[torch.device] = None,
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """Outer product of two Hann windows.

    Args:
        kernel_size: one for both axes or (rows, columns), more than 2.
        device, dtype: the device and dtype of the window.

    Returns:
        (rows, columns).

    Raises:
        ValueError: if a size is below 3.

    Example:
        >>> get_hanning_kernel2d(3)
        tensor([[0., 0., 0.],
                [0., 1., 0.],
                [0., 0., 0.]])
    """
    ky, kx = positive_pair(kernel_size, "kernel_size")
    return get_hanning_kernel1d(ky, device, dtype)[:, None] * get_hanning_kernel1d(kx, device, dtype)[None, :]


def laplacian_1d(
    window_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """Laplacian kernel: the centre is 1 - window_size, all other taps are 1.

    Args:
        window_size: number of taps, odd.
        device, dtype: the device and dtype of the kernel.

    Returns:
        (window_size,).

    Raises:
        ValueError: if window_size is not odd and positive.

    Example:
        >>> laplacian_1d(5)
        tensor([ 1.,  1., -4.,  1.,  1.])
    """
    size = odd_pair(window_size, "window_size")[0]
    return torch.tensor(
        [1.0 - size if i == size // 2 else 1.0 for i in range(size)], device=device, dtype=dtype
    )


def get_laplacian_kernel1d(
    kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """The same as ``laplacian_1d``.

    Args:
        kernel_size: number of taps, odd.
        device, dtype: the device and dtype of the kernel.

    Returns:
        (kernel_size,).

    Raises:
        ValueError: if kernel_size is not odd and positive.

    Example:
        >>> get_laplacian_kernel1d(3)
        tensor([ 1., -2.,  1.])
    """
    return laplacian_1d(odd_pair(kernel_size, "kernel_size")[0], device, dtype)


def get_laplacian_kernel2d(
    kernel_size: Union[int, Tuple[int, int]],
    device: Optional[torch.device] = None,
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """Laplacian kernel: the centre is 1 - rows * columns, all other taps are 1.

    Args:
        kernel_size: odd, one for both axes or (rows, columns).
        device, dtype: the device and dtype of the kernel.

    Returns:
        (rows, columns).

    Raises:
        ValueError: if a size is not odd and positive.

    Example:
        >>> get_laplacian_kernel2d(3)
        tensor([[ 1.,  1.,  1.],
                [ 1., -8.,  1.],
                [ 1.,  1.,  1.]])
    """
    ky, kx = odd_pair(kernel_size, "kernel_size")
    return laplacian_1d(ky * kx, device, dtype).reshape(ky, kx)


def get_sobel_kernel2d(device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32) -> Tensor:
    """The 3x3 Sobel operators for d/dx and d/dy, not normalized.

    Args:
        device, dtype: the device and dtype of the kernels.

    Returns:
        (2, 3, 3).

    Example:
        >>> get_sobel_kernel2d()[0]
        tensor([[-1.,  0.,  1.],
                [-2.,  0.,  2.],
                [-1.,  0.,  1.]])
    """
    return get_spatial_gradient_kernel2d("sobel", 1, device, dtype)


def get_diff_kernel2d(device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32) -> Tensor:
    """The differences of the two neighbours along x and along y, not normalized.

    Args:
        device, dtype: the device and dtype of the kernels.

    Returns:
        (2, 3, 3).

    Example:
        >>> get_diff_kernel2d()[0]
        tensor([[ 0.,  0.,  0.],
                [-1.,  0.,  1.],
                [ 0.,  0.,  0.]])
    """
    return get_spatial_gradient_kernel2d("diff", 1, device, dtype)


def get_spatial_gradient_kernel2d(
    mode: str, order: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """The kernels of ``spatial_gradient``, not normalized.

    Args:
        mode: "sobel" or "diff".
        order: 1 or 2.
        device, dtype: the device and dtype of the kernels.

    Returns:
        d/dx and d/dy (2, 3, 3); of second order xx, xy, yy: (3, 5, 5) for "sobel", (3, 3, 3) for "diff".

    Raises:
        ValueError: if mode or order is not as above.

    Example:
        >>> get_spatial_gradient_kernel2d("diff", 2)[0]
        tensor([[ 0.,  0.,  0.],
                [ 1., -2.,  1.],
                [ 0.,  0.,  0.]])
    """
    check_choice(mode, ["sobel", "diff"], "mode")
    _check_order(order)
    smooth, slope, curve = [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, -2.0, 1.0]
    if mode == "sobel":
        smooth = [1.0, 2.0, 1.0]
        if order == 2:
            smooth, slope, curve = (
                [1.0, 4.0, 6.0, 4.0, 1.0],
                [-1.0, -2.0, 0.0, 2.0, 1.0],
                [1.0, 0.0, -2.0, 0.0, 1.0],
            )
    pairs = [(smooth, slope), (slope, smooth)]
    if order == 2:
        pairs = [(smooth, curve), (slope, slope), (curve, smooth)]
    kernels = [[[y * x + 0.0 for x in row] for y in column] for column, row in pairs]
    return torch.tensor(kernels, device=device, dtype=dtype)


def get_spatial_gradient_kernel3d(
    mode: str, order: int, device: Optional[torch.device] = None, dtype: torch.dtype = torch.float32
) -> Tensor:
    """The kernels of ``spatial_gradient3d``.

    Args:
        mode: "diff".
        order: 1 or 2.
        device, dtype: the device and dtype of the kernels.

    Returns:
        (3, 1, 3, 3, 3): d/dx, d/dy, d/dz; of second order (6, 1, 3, 3, 3): xx, yy, zz, xy, yz, xz, of which
        the mixed ones are four times the derivative.

    Raises:
        ValueError: if mode or order is not as above.

    Example:
        >>> get_spatial_gradient_kernel3d("diff", 1)[0, 0, 1]
        tensor([[ 0.0000,  0.0000,  0.0000],
                [-0.5000,  0.0000,  0.5000],
                [ 0.0000,  0.0000,  0.0000]])
    """
    check_choice(mode, ["diff"], "mode")
    _check_order(order)
    one, slope, curve = [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, -2.0, 1.0]
    half = [0.5 * tap for tap in slope]
    factors = [(one, one, half), (one, half, one), (half, one, one)]
    if order == 2:
        factors = [(one, one, curve), (one, curve, one), (curve, one, one)]
        factors += [(one, slope, slope), (slope, slope, one), (slope, one, slope)]
    kernels: List[List[List[List[List[float]]]]] = []
    for along_z, along_y, along_x in factors:
        kernels.append([[[[z * y * x + 0.0 for x in along_x] for y in along_y] for z in along_z]])
    return torch.tensor(kernels, device=device, dtype=dtype)


def _check_order(order: int) -> None:
    if order != 1 and order != 2:
        raise ValueError(f"order: expected 1 or 2, got {order}")
