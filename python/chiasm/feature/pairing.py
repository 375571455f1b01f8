"""Helpers of the matching functions: distances between descriptors, and the layout of results.
``nearest.cdist_squared`` decides which descriptor is nearest. The distances of the chosen pairs are computed
again from their differences; only these have gradients.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_tensor
from ..primitives.features.matching import cdist_squared, two_smallest


def batched(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor]) -> Tuple[Tensor, Tensor, Optional[Tensor]]:
    """The inputs, checked, with a batch."""
    check_floating(desc1, "desc1")
    check_floating(desc2, "desc2")
    if desc1.dim() != 2 and desc1.dim() != 3:
        raise ValueError(f"desc1: expected shape (N1, D) or (B, N1, D), got {list(desc1.shape)}")
    if desc2.dim() != desc1.dim() or desc2.size(-1) != desc1.size(-1):
        raise ValueError(
            f"desc2: expected descriptors like those of desc1 {list(desc1.shape)}, got {list(desc2.shape)}"
        )
    if desc1.dim() == 3 and desc2.size(0) != desc1.size(0):
        raise ValueError(f"desc2: expected desc1's batch of {desc1.size(0)}, got {list(desc2.shape)}")
    if dm is not None:
        check_floating(dm, "dm")
        if dm.dim() != desc1.dim() or dm.size(-2) != desc1.size(-2) or dm.size(-1) != desc2.size(-2):
            raise ValueError(
                f"dm: expected {desc1.size(-2)} x {desc2.size(-2)} distances, got {list(dm.shape)}"
            )
        if dm.dim() == 3 and dm.size(0) != desc1.size(0):
            raise ValueError(f"dm: expected desc1's batch of {desc1.size(0)}, got {list(dm.shape)}")
    if desc1.dim() == 2:
        return desc1[None], desc2[None], None if dm is None else dm[None]
    return desc1, desc2, dm


def dissimilarities(
    desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], mask1: Optional[Tensor], mask2: Optional[Tensor]
) -> Tensor:
    """(B, N1, N2) for the comparison: squared distances or ``dm``; infinite where a mask is False. Without a
    gradient."""
    far = cdist_squared(desc1, desc2) if dm is None else dm.detach()
    nowhere = torch.full_like(far, float("inf"))
    if mask1 is not None:
        far = torch.where(_checked(mask1, desc1, far.size(0), "mask1")[:, :, None], far, nowhere)
    if mask2 is not None:
        far = torch.where(_checked(mask2, desc2, far.size(0), "mask2")[:, None, :], far, nowhere)
    return far


def _checked(mask: Tensor, desc: Tensor, batch: int, name: str) -> Tensor:
    """(B or 1, N)."""
    check_tensor(mask, name)
    if mask.dtype != torch.bool:
        raise TypeError(f"{name}: expected dtype torch.bool, got {mask.dtype}")
    if mask.dim() < 1 or mask.dim() > 2 or mask.size(-1) != desc.size(1):
        raise ValueError(
            f"{name}: expected one entry for each of {desc.size(1)} descriptors, got {list(mask.shape)}"
        )
    if mask.dim() == 1:
        return mask[None]
    if mask.size(0) != batch and mask.size(0) != 1:
        raise ValueError(f"{name}: expected a batch of {batch}, or 1, got {list(mask.shape)}")
    return mask


def distances_to(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], index: Tensor) -> Tensor:
    """(B, N1): distances of the descriptors of the first set from those at index (B, N1), where this is not
    negative."""
    index = index.clamp(min=0)
    if dm is not None:
        return dm.gather(-1, index[..., None])[..., 0]
    chosen = desc2.gather(1, index[..., None].expand(-1, -1, desc2.size(2)))
    difference = desc1.to(torch.float64) - chosen.to(torch.float64)
    squared = (difference * difference).sum(-1)
    same = squared == 0
    distance = torch.sqrt(torch.where(same, torch.ones_like(squared), squared))
    return torch.where(same, torch.zeros_like(squared), distance).to(desc1.dtype)


def ratios_to(
    desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], index: Tensor, second_index: Tensor
) -> Tuple[Tensor, Tensor]:
    """The distance at index divided by that at second_index, and whether both exist: (B, N1) each."""
    nearest, second = distances_to(desc1, desc2, dm, index), distances_to(desc1, desc2, dm, second_index)
    tested = (index >= 0) & (second_index >= 0)
    usable = tested & (second > 0)
    ratio = nearest / torch.where(usable, second, torch.ones_like(second))
    return torch.where(usable, ratio, torch.ones_like(ratio)), tested


def is_mutual(far: Tensor, index: Tensor) -> Tensor:
    """Whether each descriptor of the first set has a nearest one, at index, and is the nearest to that."""
    return points_back(two_smallest(far, False)[..., 0], index)


def points_back(back: Tensor, index: Tensor) -> Tensor:
    """Whether each entry of the first set has a partner, at index (B, N1), whose partner in ``back`` (B, N2)
    is this entry."""
    return (index >= 0) & (
        back.gather(-1, index.clamp(min=0)) == torch.arange(index.size(-1), device=index.device)
    )


def one_is_empty(far: Tensor) -> bool:
    """Whether one of the sets whose dissimilarities are ``far`` (B, N1, N2) has no descriptor."""
    return far.size(1) == 0 or far.size(2) == 0


def no_matches(far: Tensor, desc1: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The results where no descriptor has a match."""
    nothing = torch.full([far.size(0), far.size(1)], -1, dtype=torch.int64, device=desc1.device)
    return result_rows(nothing.to(desc1.dtype), nothing, nothing >= 0, desc1)


def result_rows(
    distance: Tensor, index: Tensor, valid: Tensor, desc1: Tensor
) -> Tuple[Tensor, Tensor, Tensor]:
    """The results, with the batch that desc1 has."""
    own = torch.arange(index.size(-1), device=index.device).expand_as(index)
    pairs = torch.stack([own, index], -1)
    pairs = torch.where(valid[..., None], pairs, torch.full_like(pairs, -1))
    distance = torch.where(valid, distance, torch.zeros_like(distance))[..., None]
    if desc1.dim() == 2:
        return distance[0], pairs[0], valid[0]
    return distance, pairs, valid
