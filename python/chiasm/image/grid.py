"""Grids of images."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_not_empty, check_rank


def make_grid(tensor: Tensor, n_row: Optional[int] = None, padding: int = 2) -> Tensor:
    """Arrange a batch of images in a grid, row by row, with zeros between images and in empty cells.

    Args:
        tensor: (B, C, H, W), any dtype.
        n_row: images in a row; by default the least n with n * n >= B. It must be given to export the op with
            a batch of any size.
        padding: pixels between neighbours; there are none around the grid.

    Returns:
        (C, R * (H + padding) - padding, n_row * (W + padding) - padding) with R rows, R = ceil(B / n_row).

    Raises:
        ValueError: if tensor is not (B, C, H, W) or B is 0, n_row is not positive or padding is negative.

    Example:
        >>> make_grid(torch.ones(3, 1, 1, 1), n_row=2, padding=1)[0]
        tensor([[1., 0., 1.],
                [0., 0., 0.],
                [1., 0., 0.]])
    """
    check_rank(tensor, 4, "(B, C, H, W)", "tensor")
    batch, channels, height, width = tensor.shape
    if batch < 1:
        raise ValueError(f"tensor: expected at least one image, got {list(tensor.shape)}")
    check_not_empty(tensor, 3, "tensor")
    columns = 1
    if n_row is None:
        while columns * columns < batch:
            columns += 1
    else:
        columns = n_row
    if columns < 1:
        raise ValueError(f"n_row: expected a positive number, got {n_row}")
    if padding < 0:
        raise ValueError(f"padding: expected zero or more, got {padding}")
    rows = (batch + columns - 1) // columns
    tall, wide = height + padding, width + padding
    # The source of each row and column of the grid; indices past the end of an image are its padding.
    y, x = (
        torch.arange(rows * tall - padding, device=tensor.device),
        torch.arange(columns * wide - padding, device=tensor.device),
    )
    grid_row, grid_column = (
        torch.div(y, tall, rounding_mode="floor"),
        torch.div(x, wide, rounding_mode="floor"),
    )
    row, column = y - grid_row * tall, x - grid_column * wide
    image = grid_row[:, None] * columns + grid_column
    inside = (row < height)[:, None] & (column < width) & (image < batch)
    pixel = (image.clamp(max=batch - 1) * height + row.clamp(max=height - 1)[:, None]) * width + column.clamp(
        max=width - 1
    )
    flat = tensor.permute(1, 0, 2, 3).reshape(channels, batch * height * width)
    grid = flat.index_select(1, pixel.reshape(-1)).reshape(channels, y.size(0), x.size(0))
    return torch.where(inside, grid, torch.zeros_like(grid))
