"""Tables of levels that a user has."""

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_pixels, check_tensor
from ..primitives.images.histograms import lut as entries
from ..primitives.images.tables import table_entries


def lut(image: Tensor, table: Tensor) -> Tensor:
    """Replace each byte by the entry of a table at it, like OpenCV's ``LUT``.

    Args:
        image: (B, C, H, W), (C, H, W) or (H, W), uint8.
        table: (256,), or (B, 256) with one for each image; uint8 or floating point.

    Returns:
        Tensor of the image's shape and the table's dtype. Differentiable in a table of floating point.

    Raises:
        TypeError: if image is not uint8, or table neither uint8 nor floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> squares = (torch.arange(256) ** 2 // 255).to(torch.uint8)
        >>> lut(torch.tensor([[0, 16, 128, 255]], dtype=torch.uint8), squares)
        tensor([[  0,   1,  64, 255]], dtype=torch.uint8)
    """
    batch = in_batch(image, "image")
    check_pixels(batch, "image")
    if batch.dtype != torch.uint8:
        raise TypeError(f"image: expected a uint8 tensor, got dtype {image.dtype}")
    check_tensor(table, "table")
    whole = table.dim() == 1 or (table.dim() == 2 and table.size(0) == batch.size(0))
    if not whole or table.size(-1) != 256:
        raise ValueError(f"table: expected shape (256,) or (B, 256), got {list(table.shape)}")
    tables = table.expand(batch.size(0), 256)
    if table.dtype == torch.uint8:
        return like_given(table_entries(batch, tables), image)
    if not table.is_floating_point():
        raise TypeError(f"table: expected a floating-point or uint8 tensor, got dtype {table.dtype}")
    return like_given(entries(tables, batch.flatten(1)).reshape(batch.shape), image)
