"""Values that spread through an image, limited by another image."""

from typing import Optional

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..filters.minmax import morphology
from ..kernels import operators as kernels

# The magnitude of values is below 1e4. This number stands for absent pixels: outside the element and beyond
# the border.


@primitive
def reconstructed(
    seed: Tensor, mask: Tensor, element: Tensor, num_iters: Optional[int], largest: bool
) -> Tensor:
    """Dilate (``largest``) or erode the seed (B, C, H, W) by a flat element (kh, kw), which includes its
    centre, again and again but never beyond the mask, until nothing changes or for ``num_iters`` steps.

    >>> seed, mask = torch.tensor([[[[0.0, 9.0, 0.0]]]]), torch.tensor([[[[3.0, 2.0, 1.0]]]])
    >>> reconstructed(seed, mask, torch.ones(3, 3), None, True)
    tensor([[[[2., 2., 1.]]]])
    """
    # No path between pixels is longer than the number of pixels. Without this limit, an element that lacks
    # its centre could alternate for ever.
    limit = mask.size(2) * mask.size(3) if num_iters is None else num_iters
    heights = torch.zeros_like(element)
    heights = torch.where(element == 0, torch.full_like(heights, -1e4), heights)
    state = torch.minimum(seed, mask) if largest else torch.maximum(seed, mask)
    return _spread(state, limit, mask, heights, largest)


@reconstructed.lowering(
    "native",
    when=lambda seed, mask, element, num_iters, largest: (
        num_iters is None and kernels.has_kernel(seed) and mask.dtype == seed.dtype
    ),
)
def _reconstructed_kernel(
    seed: Tensor, mask: Tensor, element: Tensor, num_iters: Optional[int], largest: bool
) -> Tensor:
    window = (element.flip([0, 1]) if largest else element) != 0
    beyond = -1e4 if largest else 1e4
    return kernels.reconstructed(seed.flatten(0, 1), mask.flatten(0, 1), window, beyond, largest).reshape(
        seed.shape
    )


@until_stable
def _spread(state: Tensor, k: Tensor, mask: Tensor, heights: Tensor, largest: bool) -> Tensor:
    kh, kw = heights.size(0), heights.size(1)
    spread = morphology(state, heights, kh // 2, kw // 2, "constant", -1e4 if largest else 1e4, 1e4, largest)
    return torch.minimum(spread, mask) if largest else torch.maximum(spread, mask)
