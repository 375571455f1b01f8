"""Bayer images: each pixel has one colour, red, green or blue."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..core.materialise import materialised
from ..filters.padding import padded
from ..kernels import operators as kernels
from .color_planes import as_pixels, from_pixels


@primitive
def demosaic(image: Tensor, red_row: int, red_column: int) -> Tensor:
    """Red, green and blue (*, 3, H, W) from (*, 1, H, W), in which every other row and column has red,
    starting at ``red_row`` and ``red_column`` (0 or 1).

    A missing colour is the mean of the nearest two or four pixels that have it; integers are rounded half up.
    The border is mirrored at the pixels' centres.

    >>> demosaic(torch.tensor([[1.0, 2.0], [4.0, 8.0]])[None], 0, 0)[:, 0, 0]
    tensor([1., 3., 8.])
    """
    height, width = image.size(-2), image.size(-1)
    # Mirroring keeps every sample's colour. The result is stored, because the interior reads it nine times.
    flat = numbers(image).reshape(-1, 1, height, width)
    p = padded(flat, (1, 1), (1, 1), "reflect")[:, 0]
    centre = p[:, 1 : height + 1, 1 : width + 1]
    beside = (p[:, 1 : height + 1, 0:width] + p[:, 1 : height + 1, 2 : width + 2]) * 0.5
    above = (p[:, 0:height, 1 : width + 1] + p[:, 2 : height + 2, 1 : width + 1]) * 0.5
    corners = (
        p[:, 0:height, 0:width]
        + p[:, 0:height, 2 : width + 2]
        + p[:, 2 : height + 2, 0:width]
        + p[:, 2 : height + 2, 2 : width + 2]
    )
    corners = corners * 0.25
    reds, columns = parity(height, red_row, image.device)[:, None], parity(width, red_column, image.device)
    # In a row with red samples blue is above and below; in the others it is the other way round.
    red = torch.where(reds, torch.where(columns, centre, beside), torch.where(columns, above, corners))
    blue = torch.where(reds, torch.where(columns, corners, above), torch.where(columns, beside, centre))
    green = torch.where(torch.logical_xor(reds, columns), centre, (beside + above) * 0.5)
    rgb = torch.stack([red, green, blue], 1).reshape(list(image.shape[:-3]) + [3, height, width])
    return rounded(rgb, image)


def _has_kernel(image: Tensor, *_: object) -> bool:
    whole = image.dtype == torch.uint8 or image.dtype == torch.uint16
    return kernels.available(image) and whole and image.dim() == 4


@demosaic.lowering("native", when=_has_kernel)
def _demosaic_kernel(image: Tensor, red_row: int, red_column: int) -> Tensor:
    _, is_frame = as_pixels(image)
    return from_pixels(kernels.demosaic(image[:, 0], red_row, red_column, is_frame), image, 3)


def numbers(image: Tensor) -> Tensor:
    """Integers as float32, which holds them and the means of four exactly."""
    return image if image.is_floating_point() else image.to(torch.float32)


def rounded(rgb: Tensor, image: Tensor) -> Tensor:
    """``rgb`` in the type of ``image``, rounded half up if these are integers."""
    return rgb if image.is_floating_point() else torch.floor(rgb + 0.5).to(image.dtype)


def parity(size: int, first: int, device: torch.device) -> Tensor:
    """(size,) bool: whether the position is even (``first`` 0) or odd (1)."""
    # As stored floats, of which native code compares eight at once.
    odd = materialised(torch.bitwise_and(torch.arange(size, device=device), 1).to(torch.float32), 0)
    return odd == float(first)
