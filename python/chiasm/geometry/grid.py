"""Coordinates of every pixel or voxel."""

from typing import Optional

import torch
from torch import Tensor

from .conversions.pixels import normalisation

__all__ = ["create_meshgrid", "create_meshgrid3d"]


def __dir__() -> list[str]:
    return __all__


def create_meshgrid(
    height: int,
    width: int,
    normalized_coordinates: bool = True,
    device: Optional[torch.device] = None,
    dtype: Optional[torch.dtype] = None,
    align_corners: bool = True,
) -> Tensor:
    """The coordinates (x, y) of every pixel, in the format of `torch.nn.functional.grid_sample`.

    In an exported op, the sizes may come from a tensor's shape: they stay symbolic.

    Args:
        height: height of the image, in pixels.
        width: width of the image, in pixels.
        normalized_coordinates: True: coordinates in [-1, 1]; False: in pixels, 0 to width - 1 and 0 to height
            - 1.
        device: the device of the result.
        dtype: the dtype of the result; PyTorch's default dtype by default.
        align_corners: True: -1 and 1 are the centres of the outermost pixels (an axis of one pixel is then
            0); False: -1 and 1 are their outer edges. No effect on pixel coordinates.

    Returns:
        (1, height, width, 2).

    Raises:
        ValueError: if a size is not positive.

    Example:
        >>> create_meshgrid(2, 3)[0, 1]
        tensor([[-1.,  1.],
                [ 0.,  1.],
                [ 1.,  1.]])
    """
    if height < 1 or width < 1:
        raise ValueError(f"height, width: expected positive sizes, got ({height}, {width})")
    x, y = _positions(width, device, dtype), _positions(height, device, dtype)
    grid = torch.stack([x.expand(height, width), y[:, None].expand(height, width)], -1)[None]
    if normalized_coordinates:
        half, offset = normalisation([width, height], align_corners, grid.dtype, grid.device)
        return grid / half + offset
    return grid


def create_meshgrid3d(
    depth: int,
    height: int,
    width: int,
    normalized_coordinates: bool = True,
    device: Optional[torch.device] = None,
    dtype: Optional[torch.dtype] = None,
) -> Tensor:
    """The coordinates (z, x, y), in this order, of every voxel.

    In an exported op, the sizes may come from a tensor's shape: they stay symbolic.

    Args:
        depth: depth of the volume, in voxels.
        height: height of the volume, in voxels.
        width: width of the volume, in voxels.
        normalized_coordinates: True: coordinates in [-1, 1], the centres of the outermost voxels
            (`align_corners=True`; an axis of one voxel is 0); False: in voxels from 0.
        device: the device of the result.
        dtype: the dtype of the result; PyTorch's default dtype by default.

    Returns:
        (1, depth, height, width, 3).

    Raises:
        ValueError: if a size is not positive.

    Example:
        >>> create_meshgrid3d(2, 3, 4, normalized_coordinates=False)[0, 1, 2, 3]
        tensor([1., 3., 2.])
    """
    if depth < 1 or height < 1 or width < 1:
        raise ValueError(f"depth, height, width: expected positive sizes, got ({depth}, {height}, {width})")
    x, y, z = (
        _positions(width, device, dtype),
        _positions(height, device, dtype),
        _positions(depth, device, dtype),
    )
    axes = [
        z[:, None, None].expand(depth, height, width),
        x.expand(depth, height, width),
        y[:, None].expand(depth, height, width),
    ]
    grid = torch.stack(axes, -1)[None]
    if normalized_coordinates:
        half, offset = normalisation([depth, width, height], True, grid.dtype, grid.device)
        return grid / half + offset
    return grid


def _positions(size: int, device: Optional[torch.device], dtype: Optional[torch.dtype]) -> Tensor:
    return torch.arange(size, device=device).to(torch.zeros([], dtype=dtype).dtype)
