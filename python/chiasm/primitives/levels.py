"""The 256 levels of 8-bit images, in floating-point images of [0, 1]."""

import torch
from torch import Tensor


def to_levels(x: Tensor) -> Tensor:
    """The nearest of the 256 levels, halves up, as int32; what is outside [0, 1] counts as 0 or 1, NaN as 0.

    >>> to_levels(torch.tensor([-1.0, 0.5, 2.0]))
    tensor([  0, 128, 255], dtype=torch.int32)
    """
    # floor(x * 255 + 0.5) would depend on whether a compiler fuses the product with the sum; a comparison it cannot fuse.
    scaled = (x * 255.0).clamp(0.0, 255.0)
    whole = scaled.to(torch.int32)
    return (whole + (scaled - whole >= 0.5).to(torch.int32)).clamp(0, 255)
