"""Connected sets of pixels, by union-find in whole-image steps: as many as the logarithm of the longest path,
in practice under ten.

After Y. Zhang, A. Azad, Z. Hu, FastSV: a distributed-memory connected component algorithm with fast
convergence, SIAM PP 2020. Every pixel has a parent in its component, of no higher index. In a step the root
of each tree that touches a tree of lower index is hung below it, and all trees become shallower.
"""

from typing import Tuple

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..filters.minmax import minmax_filter
from ..images.histograms import bincount
from ..kernels import operators as kernels
from ..numbers.search import first_and_last


@primitive
def numbered_components(x: Tensor, limit: int) -> Tensor:
    """1 + the lowest flat index in the 8-connected component of each pixel of (B, C, H, W) that is above 0,
    and 0 for other pixels, as int64. ``limit`` bounds the steps.

    >>> numbered_components(torch.tensor([[[[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]]), 9)
    tensor([[[[1, 0, 3],
              [1, 0, 3]]]])
    """
    mask = (x if x.is_floating_point() else x.to(torch.float32)) > 0
    roots = component_labels(mask.flatten(0, 1), limit).to(torch.int64)
    return torch.where(mask, roots.reshape(mask.shape) + 1, torch.zeros_like(mask, dtype=torch.int64))


@numbered_components.lowering(
    "native", when=lambda x, limit: kernels.available(x) and kernels.runs_to_its_end(limit)
)
def _numbered_components_kernel(x: Tensor, limit: int) -> Tensor:
    return kernels.connected_components(_pixels(x), False)


@primitive
def labelled_components(x: Tensor) -> Tensor:
    """``numbered_components`` of (B, C, H, W) with labels that count from 1, in the order of the components'
    first pixels, row by row.

    >>> labelled_components(torch.tensor([[[[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]]))
    tensor([[[[1, 0, 2],
              [1, 0, 2]]]])
    """
    roots = numbered_components(x, 2147483647).flatten(0, 1).flatten(1)
    pixel = torch.arange(roots.size(1), device=roots.device)
    opened = (roots == pixel + 1).to(torch.int64).cumsum(1)
    # A background pixel reads any number, for which 0 is then put.
    label = torch.where(roots > 0, opened.gather(1, (roots - 1).clamp(min=0)), torch.zeros_like(roots))
    return label.reshape(x.shape)


@labelled_components.lowering("native", when=kernels.available)
def _labelled_components_kernel(x: Tensor) -> Tensor:
    return kernels.connected_components(_pixels(x), True)


def _pixels(x: Tensor) -> Tensor:
    """``x`` in a type that the kernel takes: half precision as float32."""
    return x if kernels.has_pixel_kernel(x) else x.to(torch.float32)


@primitive
def label_statistics(labels: Tensor, slots: int) -> Tensor:
    """(N, slots, 7), int64: for each label of (N, H, W) from 0 on the left column, the top row, the width,
    the height, the number of pixels, and the sums of their columns and rows; 0 if a label has no pixels.
    Labels from ``slots`` on are not counted.

    >>> label_statistics(torch.tensor([[[1, 0, 2], [1, 0, 2]]]), 3)[0]
    tensor([[1, 0, 1, 2, 2, 2, 1],
            [0, 0, 1, 2, 2, 0, 1],
            [2, 0, 1, 2, 2, 4, 1]])
    """
    height, width = labels.size(1), labels.size(2)
    slot = labels.clamp(max=slots)
    column, row = torch.arange(width, device=labels.device), torch.arange(height, device=labels.device)
    left, across, area, x = _extent(slot * width + column, slots, width)
    top, down, _, y = _extent(slot * height + row[:, None], slots, height)
    return torch.stack([left, top, across, down, area, x, y], -1)


def _extent(place: Tensor, slots: int, size: int) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """The first place along an axis, the extent, the number of pixels and the sum of their places, all (N,
    slots), from the pixels' places (N, H, W): ``size`` for each slot, and for the rest."""
    counts = bincount(place.flatten(1), (slots + 1) * size).reshape(-1, slots + 1, size)[:, :slots]
    area = counts.sum(-1)
    first, last = first_and_last(counts > 0)
    extent = torch.where(area > 0, last - first + 1, torch.zeros_like(area))
    total = (counts.to(torch.int64) * torch.arange(size, device=place.device)).sum(-1)
    return first, extent, area, total


label_statistics.lowering("native", when=kernels.available)(kernels.label_statistics)


def component_labels(mask: Tensor, limit: int) -> Tensor:
    """The lowest flat index in the 8-connected component of each pixel of (N, H, W) bool, as (N, H * W)
    int32.

    Pixels outside the mask have their own index. ``limit`` bounds the steps.

    >>> component_labels(torch.tensor([[[True, False, True], [True, False, True]]]), 9)
    tensor([[0, 1, 2, 0, 4, 2]], dtype=torch.int32)
    """
    count = mask.size(1) * mask.size(2)
    own = torch.arange(count, device=mask.device, dtype=torch.int32)
    parent = own[None] + torch.zeros_like(mask.reshape(mask.size(0), count), dtype=torch.int32)
    return _joined(parent, limit, mask)


def reached(mask: Tensor, seeds: Tensor, limit: int) -> Tensor:
    """The pixels of ``mask`` that are 8-connected within it to a pixel of ``seeds``, a subset of ``mask``;
    (N, H, W) bool."""
    roots = component_labels(mask, limit)
    seeded = seeds.reshape(roots.size(0), roots.size(1))
    none = torch.zeros_like(roots)
    flags = lower_at(none, roots, none - 1, seeded)
    return mask & (flags.gather(1, roots.to(torch.int64)) < 0).reshape(
        mask.size(0), mask.size(1), mask.size(2)
    )


@primitive
def lower_at(values: Tensor, index: Tensor, offers: Tensor, active: Tensor) -> Tensor:
    """values (N, P) int32, each lowered to the smallest of the ``active`` offers whose ``index`` is its
    position.

    Compiled code has no atomic minimum: there *some* active offer is taken instead of the smallest. The
    result is the same if all offers are equal, and suffices if the caller repeats until nothing changes.
    """
    own = torch.arange(values.size(1), device=values.device, dtype=torch.int32)
    slot = torch.where(active, index, own)
    return values.scatter_reduce(1, slot.to(torch.int64), torch.where(active, offers, values), "amin")


@lower_at.lowering("native")
def _lower_to_any(values: Tensor, index: Tensor, offers: Tensor, active: Tensor) -> Tensor:
    own = torch.arange(values.size(1), device=values.device, dtype=torch.int32)
    # An inactive offer gets its own slot beyond the end, so that threads do not all write to one place.
    slot = torch.where(active, index, own + values.size(1))
    offered = torch.cat([values, values], 1).scatter(1, slot.to(torch.int64), offers)
    return torch.minimum(values, offered[:, : values.size(1)])


@until_stable
def _joined(parent: Tensor, k: Tensor, mask: Tensor) -> Tensor:
    inside = mask.reshape(parent.size(0), parent.size(1))
    nobody = 2147483647
    own = torch.where(inside, parent, torch.full_like(parent, nobody)).reshape(
        -1, 1, mask.size(1), mask.size(2)
    )
    lowest = minmax_filter(own, 3, 3, "constant", False, float(nobody)).reshape(
        parent.size(0), parent.size(1)
    )
    parent = lower_at(parent, parent, lowest, inside & (lowest < parent))
    for _ in range(3):
        parent = parent.gather(1, parent.to(torch.int64))
    return parent
