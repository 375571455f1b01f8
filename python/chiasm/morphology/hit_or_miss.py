"""Patterns in binary images."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_image, check_tensor
from ..primitives.filters.padding import stencil


def hit_or_miss(input: Tensor, hit: Tensor, miss: Optional[Tensor] = None) -> Tensor:
    """Find a pattern: 1 where all pixels under ``hit`` are set and no pixel under ``miss`` is set.

    Not in Kornia. J. Serra, Image Analysis and Mathematical Morphology, 1982. Like SciPy's
    ``binary_hit_or_miss``, except that pixels outside the image are not set, as in OpenCV's MORPH_HITMISS for
    an image with a border of zeros.

    Args:
        input: (B, C, H, W), floating point; pixels above 0 are set.
        hit: (kh, kw), nonzero where a pixel must be set; its centre is [kh // 2, kw // 2].
        miss: (kh, kw), nonzero where no pixel may be set; by default where hit is zero.

    Returns:
        (B, C, H, W), 0 or 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> hit_or_miss(torch.tensor([[[[1.0, 1.0, 1.0, 0.0, 1.0]]]]), torch.tensor([[0.0, 1.0, 0.0]]))
        tensor([[[[0., 0., 0., 0., 1.]]]])
    """
    check_image(input, "input")
    check_tensor(hit, "hit")
    if hit.dim() != 2:
        raise ValueError(f"hit: expected shape (kh, kw), got {list(hit.shape)}")
    kh, kw = hit.size(0), hit.size(1)
    wanted = hit != 0
    unwanted = ~wanted
    if miss is not None:
        check_tensor(miss, "miss")
        if miss.dim() != 2 or miss.size(0) != kh or miss.size(1) != kw:
            raise ValueError(f"miss: expected hit's shape ({kh}, {kw}), got {list(miss.shape)}")
        unwanted = miss != 0
    # The test below: a pixel's value must be at least `least` and at most `most`.
    least, most = wanted.to(input.dtype), 1.0 - unwanted.to(input.dtype)
    filled = (input > 0).to(input.dtype)
    return _fits(filled, (kh // 2, kh - kh // 2 - 1), (kw // 2, kw - kw // 2 - 1), "constant", least, most)


@stencil
def _fits(p: Tensor, least: Tensor, most: Tensor) -> Tensor:
    kh, kw = least.size(0), least.size(1)
    height = p.size(2) - kh + 1
    width = p.size(3) - kw + 1
    worst = torch.ones([1], dtype=p.dtype, device=p.device)
    for i in range(kh):
        for j in range(kw):
            tap = p[:, :, i : i + height, j : j + width]
            worst = torch.minimum(worst, torch.minimum(tap - least[i, j], most[i, j] - tap))
    return (worst >= 0).to(p.dtype)
