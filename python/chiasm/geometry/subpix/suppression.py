"""Strict local maxima: non-maximum suppression."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ...primitives.checks import check_image
from ...primitives.padding import join_columns, padded_parts
from ...primitives.volumes import check_volume


def nms2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], mask_only: bool = False) -> Tensor:
    """Keep strict local maxima, set the rest to zero.

    A pixel stays when it exceeds every other pixel of the window around it, and the window lies inside the image: the pixels near the
    border never stay. A window of k pixels reaches (k - 1) // 2 before its centre and k // 2 after it.

    Args:
        input: (B, C, H, W), floating point, without NaN.
        kernel_size: size of the window, one for both axes or (rows, columns), of more than one pixel.
        mask_only: return where the maxima are instead.

    Returns:
        (B, C, H, W) in input's dtype, or bool where mask_only. Differentiable in input.

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
        raise ValueError(f"kernel_size: expected positive sizes of more than one pixel, got ({rows}, {columns})")
    return _suppressed(input, _strict_maxima(input.detach(), 1, rows, columns), mask_only)


def nms3d(input: Tensor, kernel_size: Union[int, Tuple[int, int, int]], mask_only: bool = False) -> Tensor:
    """``nms2d`` of volumes.

    A voxel stays when it exceeds every other voxel of the window around it, and the window lies inside the volume: the voxels near the
    border never stay. A window of k voxels reaches (k - 1) // 2 before its centre and k // 2 after it.

    Args:
        input: (B, C, D, H, W), floating point, without NaN.
        kernel_size: size of the window, one for all axes or (slices, rows, columns), of more than one voxel.
        mask_only: return where the maxima are instead.

    Returns:
        (B, C, D, H, W) in input's dtype, or bool where mask_only. Differentiable in input.

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
        raise ValueError(f"kernel_size: expected positive sizes of more than one voxel, got ({slices}, {rows}, {columns})")
    maxima = _strict_maxima(input.detach().flatten(0, 1), slices, rows, columns)
    return _suppressed(input, maxima.reshape(input.shape), mask_only)


def nms3d_minmax(input: Tensor) -> Tuple[Tensor, Tensor]:
    """Where a volume's strict maxima and its strict minima among 3x3x3 voxels are, by the rules of ``nms3d``.

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
    return _strict_maxima(x, 3, 3, 3).reshape(input.shape), _strict_maxima(-x, 3, 3, 3).reshape(input.shape)


def _suppressed(input: Tensor, maxima: Tensor, mask_only: bool) -> Tensor:
    if mask_only:
        return maxima
    return torch.where(maxima, input, torch.zeros_like(input))


def _strict_maxima(x: Tensor, slices: int, rows: int, columns: int) -> Tensor:
    """Which voxels of (N, D, H, W) exceed all others of their windows."""
    # An infinite border: where the window reaches out, nothing exceeds it.
    beyond = float("inf")
    if slices > 1:
        plane = torch.full_like(x[:, 0:1], beyond)
        deep = torch.cat([plane for _ in range((slices - 1) // 2)] + [x] + [plane for _ in range(slices // 2)], 1)
    else:
        deep = x
    parts = padded_parts(deep, (rows - 1) // 2, rows // 2, (columns - 1) // 2, columns // 2, "constant", beyond)
    return x > join_columns([_largest_neighbour(p, slices, rows, columns) for p in parts])


def _largest_neighbour(p: Tensor, slices: int, rows: int, columns: int) -> Tensor:
    """The largest of each valid window's voxels apart from its centre."""
    depth, height, width = p.size(1) - slices + 1, p.size(2) - rows + 1, p.size(3) - columns + 1
    middle_slice, middle_row, middle_column = (slices - 1) // 2, (rows - 1) // 2, (columns - 1) // 2
    each_row = [p[:, :, i : i + height] for i in range(rows)]
    whole_column = largest(each_row)
    each_column = [whole_column[..., j : j + width] for j in range(columns)]
    # In the centre's plane: whole columns, which neighbouring windows share, and the centre's column without it.
    around = _without(each_column, middle_column)
    if rows > 1:
        around.append(largest(_without(each_row, middle_row))[..., middle_column : middle_column + width])
    found = [plane[:, middle_slice : middle_slice + depth] for plane in around]
    if slices > 1:
        whole_plane = largest(each_column)
        found += _without([whole_plane[:, k : k + depth] for k in range(slices)], middle_slice)
    return largest(found)


def largest(values: List[Tensor]) -> Tensor:
    """The largest of tensors, elementwise.

    >>> largest([torch.tensor([1, 5]), torch.tensor([2, 3])])
    tensor([2, 5])
    """
    out = values[0]
    for value in values[1:]:
        out = torch.maximum(out, value)
    return out


def _without(values: List[Tensor], k: int) -> List[Tensor]:
    return values[:k] + values[k + 1 :]
