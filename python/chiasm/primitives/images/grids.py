"""Images side by side in one."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..core.materialise import stored_index
from ..kernels import operators as kernels


@primitive
def in_grid(images: Tensor, columns: int, padding: int) -> Tensor:
    """(C, height, width): the images (B, C, H, W), ``columns`` of them in a row, with ``padding`` zeros
    between neighbours and zeros in cells without an image.

    >>> in_grid(torch.ones(3, 1, 1, 1), 2, 1)
    tensor([[[1., 0., 1.],
             [0., 0., 0.],
             [1., 0., 0.]]])
    """
    batch, height, width = images.size(0), images.size(2), images.size(3)
    tall, wide = height + padding, width + padding
    # The source of each row and column of the grid; indices past the end of an image are its padding.
    y = torch.arange(_rows(batch, columns) * tall - padding, device=images.device)
    x = torch.arange(columns * wide - padding, device=images.device)
    grid_row, grid_column = (
        torch.div(y, tall, rounding_mode="floor"),
        torch.div(x, wide, rounding_mode="floor"),
    )
    row, column = stored_index(y - grid_row * tall), stored_index(x - grid_column * wide)
    first, beside = stored_index(grid_row * columns), stored_index(grid_column)
    image = first[:, None] + beside
    inside = (row < height)[:, None] & (column < width) & (image < batch)
    numbers, rows = image.clamp(max=batch - 1), row.clamp(max=height - 1)[:, None]
    grid = images.permute(1, 0, 2, 3)[:, numbers, rows, column.clamp(max=width - 1)]
    return torch.where(inside, grid, torch.zeros_like(grid))


def _rows(batch: int, columns: int) -> int:
    return (batch + columns - 1) // columns


def _has_kernel(images: Tensor, columns: int, padding: int) -> bool:
    # AOTInductor would leave a concatenation of integers to libtorch.
    return kernels.has_kernel(images) and isinstance(columns, int) and columns <= 64


# One call for each column of the grid.
@in_grid.lowering("native", when=_has_kernel)
def _columns_kernel(images: Tensor, columns: int, padding: int) -> Tensor:
    batch, channels, height, width = images.shape
    tall = height + padding
    y = torch.arange(_rows(batch, columns) * tall - padding)
    grid_row = torch.div(y, tall, rounding_mode="floor")
    row, planes = y - grid_row * tall, torch.arange(channels)[:, None]
    parts = []
    for k in range(columns):
        image = grid_row * columns + k
        source = (image * channels + planes) * height + row
        source = torch.where((row < height) & (image < batch), source, -1).flatten().to(torch.int32)
        wide = width + (padding if k + 1 < columns else 0)
        # no image has the columns of the padding
        part = kernels.gather_pixels(
            images.flatten(0, 2), source, torch.arange(wide, dtype=torch.int32), 1, 0.0
        )
        parts.append(part.unflatten(0, [channels, y.size(0)]))
    return torch.cat(parts, 2)
