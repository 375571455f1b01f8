"""Strict local maxima: non-maximum suppression."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.checks import check_image
from ...primitives.features.extrema import strict_maxima
from ...primitives.resampling.volumes import check_volume


def nms2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], mask_only: bool = False) -> Tensor:
    """Keep strict local maxima and set all other pixels to zero. A pixel is kept if it exceeds every other
    pixel of the window around it and the window lies inside the image: pixels near the border are never kept.
    A window of k pixels reaches (k - 1) // 2 before its centre and k // 2 after it.

    Args:
        input: (B, C, H, W), floating point, without NaN.
        kernel_size: size of the window, one for both axes or (rows, columns), of more than one pixel.
        mask_only: return a mask of the maxima instead.

    Returns:
        (B, C, H, W) in input's dtype, or bool with mask_only. Differentiable in input.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or the window not of more than one pixel.

    Example:
        >>> x = torch.zeros(1, 1, 5, 5)
        >>> x[0, 0, 2, 2] = 3.0
        >>> nms2d(x, 3).sum(), nms2d(x, 3, True).nonzero()
        (tensor(3.), tensor([[0, 0, 2, 2]]))
    """
    check_image(input, "input")
    if isinstance(kernel_size, int):
        rows, columns = kernel_size, kernel_size
    else:
        rows, columns = kernel_size
    if rows < 1 or columns < 1 or rows * columns == 1:
        raise ValueError(
            f"kernel_size: expected positive sizes of more than one pixel, got ({rows}, {columns})"
        )
    return _suppressed(input, strict_maxima(input.detach(), 1, rows, columns), mask_only)


def nms3d(input: Tensor, kernel_size: Union[int, Tuple[int, int, int]], mask_only: bool = False) -> Tensor:
    """``nms2d`` for volumes. A voxel is kept if it exceeds every other voxel of the window around it and the
    window lies inside the volume: voxels near the border are never kept. A window of k voxels reaches (k - 1)
    // 2 before its centre and k // 2 after it.

    Args:
        input: (B, C, D, H, W), floating point, without NaN.
        kernel_size: size of the window, one for all axes or (slices, rows, columns), of more than one voxel.
        mask_only: return a mask of the maxima instead.

    Returns:
        (B, C, D, H, W) in input's dtype, or bool with mask_only. Differentiable in input.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D or the window not of more than one voxel.

    Example:
        >>> x = torch.zeros(1, 1, 3, 4, 5)
        >>> x[0, 0, 1, 2, 3] = 3.0
        >>> nms3d(x, 3, True).nonzero()
        tensor([[0, 0, 1, 2, 3]])
    """
    check_volume(input, "input")
    if isinstance(kernel_size, int):
        slices, rows, columns = kernel_size, kernel_size, kernel_size
    else:
        slices, rows, columns = kernel_size
    if slices < 1 or rows < 1 or columns < 1 or slices * rows * columns == 1:
        raise ValueError(
            f"kernel_size: expected positive sizes of more than one voxel, got ({slices}, {rows}, {columns})"
        )
    maxima = strict_maxima(input.detach().flatten(0, 1), slices, rows, columns)
    return _suppressed(input, maxima.reshape(input.shape), mask_only)


def nms3d_minmax(input: Tensor) -> Tuple[Tensor, Tensor]:
    """Masks of the strict maxima and minima of 3x3x3 neighbourhoods, by the rules of ``nms3d``.

    Args:
        input: (B, C, D, H, W), floating point, without NaN.

    Returns:
        maxima, minima: (B, C, D, H, W), bool.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D.

    Example:
        >>> x = torch.zeros(1, 1, 3, 4, 5)
        >>> x[0, 0, 1, 2, 3] = -3.0
        >>> [int(mask.sum()) for mask in nms3d_minmax(x)]
        [0, 1]
    """
    check_volume(input, "input")
    x = input.detach().flatten(0, 1)
    return strict_maxima(x, 3, 3, 3).reshape(input.shape), strict_maxima(-x, 3, 3, 3).reshape(input.shape)


def _suppressed(input: Tensor, maxima: Tensor, mask_only: bool) -> Tensor:
    if mask_only:
        return maxima
    return torch.where(maxima, input, torch.zeros_like(input))
