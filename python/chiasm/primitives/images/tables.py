"""Point-wise ops on bytes: a table of the op's values at the 256 levels, looked up."""

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows, interleaved
from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..numbers.rounding import known_or


def levels(image: Tensor, white: float) -> Tensor:
    """The 256 levels for each image of a batch, (B, 256) in float64, of which the last is ``white``.

    In float64, so that engines' different rounding errors hardly ever lead to different bytes.
    """
    all_levels = torch.arange(256, device=image.device).to(torch.float64) * (white / 255.0)
    return all_levels.expand(image.size(0), 256)


def looked_up(image: Tensor, values: Tensor, white: float) -> Tensor:
    """Bytes (B, *) mapped by an op's values at their ``levels``, (B, 256): rounded half to even and
    saturated. NaN becomes 0.

    >>> x = torch.tensor([[0, 100, 200]], dtype=torch.uint8)
    >>> looked_up(x, 1.0 - levels(x, 1.0), 1.0)
    tensor([[255, 155,  55]], dtype=torch.uint8)
    """
    rounded = known_or(torch.round(values * (255.0 / white)), 0.0).clamp(0.0, 255.0)
    return table_entries(image, rounded.to(torch.uint8))


@primitive
def table_entries(image: Tensor, tables: Tensor) -> Tensor:
    """The entries of tables (B, 256) at bytes (B, *)."""
    index = image.flatten(1).to(torch.int64)
    return tables.gather(1, index).reshape(image.shape)


@table_entries.lowering("native", when=kernels.available)
def _table_entries_kernel(image: Tensor, tables: Tensor) -> Tensor:
    if image.dim() == 4:
        rows, _ = as_rows(image)
        return from_rows(kernels.lut_bytes(tables, rows.flatten(1)).unflatten(1, rows.shape[1:]), image)
    return kernels.lut_bytes(tables, image.flatten(1)).reshape(image.shape)


@primitive
def table_colours(image: Tensor, tables: Tensor) -> Tensor:
    """Bytes (B, 1, H, W) as colours (B, 3, H, W): the entries of each channel's table, (3, 256)."""
    return torch.cat([table_entries(image, row.expand(image.size(0), 256)) for row in tables.unbind(0)], 1)


@table_colours.lowering("native", when=lambda image, tables: kernels.available(image) and interleaved(image))
def _table_colours_kernel(image: Tensor, tables: Tensor) -> Tensor:
    pixels = kernels.lut_pixels(tables, image.flatten())
    return pixels.reshape(image.size(0), image.size(2), image.size(3), 3).permute(0, 3, 1, 2)
