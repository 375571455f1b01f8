"""What matching functions share: which descriptors are near, and how their results are laid out.

Which descriptor is nearest is decided by |a|^2 + |b|^2 - 2 a.b, one matrix product, in float64: in float32 that difference of large numbers
would leave of a distance of 1e-3 between unit vectors not one digit. For float32 descriptors it is then rounded to float32, so that equal
descriptors, whose products a library may add up in different orders, are equally far. The distances of the pairs that were chosen are
computed anew from their differences; they alone carry gradients.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.checks import check_floating
from ..primitives.linalg import small_matmul


def batched(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor]) -> Tuple[Tensor, Tensor, Optional[Tensor]]:
    """The inputs, checked, with a batch."""
    check_floating(desc1, "desc1")
    check_floating(desc2, "desc2")
    if desc1.dim() != 2 and desc1.dim() != 3:
        raise ValueError(f"desc1: expected shape (N1, D) or (B, N1, D), got {list(desc1.shape)}")
    if desc2.dim() != desc1.dim() or desc2.size(-1) != desc1.size(-1) or desc2.size(0) < 1 or desc2.size(-2) < 1:
        raise ValueError(f"desc2: expected some descriptors like those of desc1 {list(desc1.shape)}, got {list(desc2.shape)}")
    if desc1.dim() == 3 and desc2.size(0) != desc1.size(0):
        raise ValueError(f"desc2: expected desc1's batch of {desc1.size(0)}, got {list(desc2.shape)}")
    if dm is not None:
        check_floating(dm, "dm")
        if dm.dim() != desc1.dim() or dm.size(-2) != desc1.size(-2) or dm.size(-1) != desc2.size(-2):
            raise ValueError(f"dm: expected {desc1.size(-2)} x {desc2.size(-2)} distances, got {list(dm.shape)}")
    if desc1.dim() == 2:
        return desc1[None], desc2[None], None if dm is None else dm[None]
    return desc1, desc2, dm


def dissimilarities(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], mask1: Optional[Tensor], mask2: Optional[Tensor]) -> Tensor:
    """(B, N1, N2) to compare by: squared distances or what is given; infinite where a mask says so. Without a gradient."""
    if dm is None:
        a, b = desc1.detach().to(torch.float64), desc2.detach().to(torch.float64)
        lengths = (a * a).sum(-1)[:, :, None] + (b * b).sum(-1)[:, None, :]
        far = lengths - 2.0 * small_matmul(a, b.transpose(-1, -2))
        if desc1.dtype != torch.float64:
            far = far.to(torch.float32)
    else:
        far = dm.detach()
    nowhere = torch.full_like(far, float("inf"))
    if mask1 is not None:
        far = torch.where(_checked(mask1, desc1, "mask1")[:, :, None], far, nowhere)
    if mask2 is not None:
        far = torch.where(_checked(mask2, desc2, "mask2")[:, None, :], far, nowhere)
    return far


def _checked(mask: Tensor, desc: Tensor, name: str) -> Tensor:
    """(B, N)."""
    if mask.dtype != torch.bool:
        raise TypeError(f"{name}: expected dtype torch.bool, got {mask.dtype}")
    if mask.dim() > 2 or mask.size(-1) != desc.size(1):
        raise ValueError(f"{name}: expected one entry for each of {desc.size(1)} descriptors, got {list(mask.shape)}")
    return mask if mask.dim() == 2 else mask[None]


def distances_to(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], index: Tensor) -> Tensor:
    """(B, N1): how far the descriptors of the first set are from those of index (B, N1)."""
    if dm is not None:
        return dm.gather(-1, index[..., None])[..., 0]
    chosen = desc2.gather(1, index[..., None].expand(-1, -1, desc2.size(2)))
    difference = desc1.to(torch.float64) - chosen.to(torch.float64)
    squared = (difference * difference).sum(-1)
    same = squared == 0
    distance = torch.sqrt(torch.where(same, torch.ones_like(squared), squared))
    return torch.where(same, torch.zeros_like(squared), distance).to(desc1.dtype)


def others_than(far: Tensor, index: Tensor) -> Tensor:
    """``far`` without the entries at index."""
    chosen = index[..., None] == torch.arange(far.size(-1), device=far.device)
    return torch.where(chosen, torch.full_like(far, float("inf")), far)


def ratios_to(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], far: Tensor, index: Tensor, others: Tensor) -> Tuple[Tensor, Tensor]:
    """Distance at index over the least distance among ``others``, and whether there are both: (B, N1) each."""
    nearest = distances_to(desc1, desc2, dm, index)
    second = distances_to(desc1, desc2, dm, torch.argmin(others, -1))
    tested = (torch.amin(others, -1) < float("inf")) & (torch.amin(far, -1) < float("inf"))
    usable = tested & (second > 0)
    ratio = nearest / torch.where(usable, second, torch.ones_like(second))
    return torch.where(usable, ratio, torch.ones_like(ratio)), tested


def is_mutual(far: Tensor, index: Tensor) -> Tensor:
    """Whether each descriptor of the first set is the nearest to that of the second set at its index."""
    back = torch.argmin(far, -2)
    return back.gather(-1, index) == torch.arange(far.size(-2), device=far.device)


def result_rows(distance: Tensor, index: Tensor, valid: Tensor, desc1: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The results, with the batch that desc1 has."""
    own = torch.arange(index.size(-1), device=index.device).expand_as(index)
    pairs = torch.stack([own, index], -1)
    pairs = torch.where(valid[..., None], pairs, torch.full_like(pairs, -1))
    distance = torch.where(valid, distance, torch.zeros_like(distance))[..., None]
    if desc1.dim() == 2:
        return distance[0], pairs[0], valid[0]
    return distance, pairs, valid
