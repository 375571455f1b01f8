"""Grids of images."""

from typing import Optional

from torch import Tensor

from ..primitives.core.checks import check_not_empty, check_rank
from ..primitives.images.grids import in_grid


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
    batch = tensor.size(0)
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
    return in_grid(tensor, columns, padding)
