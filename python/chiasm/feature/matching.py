"""Matching of descriptors by their Euclidean distances.

Every function returns one row for each descriptor of the first set, and a mask, where Kornia returns the matches alone, whose number
depends on the data: ``distances[valid]`` and ``indices[valid]`` are Kornia's. Rows without a match have distance 0 and indices -1.
What Kornia calls a distance is kept: with a ratio test it is the ratio. Of descriptors at the same distance the first one is the nearest,
so that every backend finds the same.

Descriptors are (N1, D) and (N2, D), or (B, N1, D) and (B, N2, D); results have the batch that the inputs have. Detections of fixed capacity say by
``mask1`` and ``mask2`` which of them are there.

Which descriptor is nearest is decided by ``nearest.squared_distances``. The distances of the pairs that were chosen are computed anew from their
differences; they alone carry gradients.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.checks import check_floating
from ..primitives.nearest import squared_distances, two_least
from .laf import check_laf, get_laf_center


def match_nn(
    desc1: Tensor, desc2: Tensor, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor]:
    """For each descriptor of the first set the nearest of the second.

    Args:
        desc1: ([B,] N1, D), floating point.
        desc2: ([B,] N2, D), N2 at least 1.
        dm: ([B,] N1, N2), distances to go by instead of the descriptors' own.
        mask1, mask2: ([B,] N1) and ([B,] N2), bool, which descriptors are there; all where None.

    Returns:
        distances ([B,] N1, 1); indices ([B,] N1, 2), int64, into the first and the second set; valid ([B,] N1), bool. Differentiable in the
        descriptors and in dm, with derivative 0 where a distance is.

    Raises:
        TypeError: if descriptors or dm are not floating point, or a mask not bool.
        ValueError: if a shape is not as above.

    Example:
        >>> distances, indices, valid = match_nn(torch.tensor([[0.0], [5.0]]), torch.tensor([[4.0], [1.0], [8.0]]))
        >>> distances.flatten(), indices, valid
        (tensor([1., 1.]), tensor([[0, 1],
                [1, 0]]), tensor([True, True]))
    """
    first, second, given = _batched(desc1, desc2, dm)
    index = two_least(_dissimilarities(first, second, given, mask1, mask2), True)[..., 0]
    return _rows(_distances(first, second, given, index), index, index >= 0, desc1)


def match_mnn(
    desc1: Tensor, desc2: Tensor, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor]:
    """Mutual nearest neighbours: pairs of which each is nearest to the other.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``; N1 at least 1.

    Returns:
        distances ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> distances, indices, valid = match_mnn(torch.tensor([[0.0], [5.0], [6.0]]), torch.tensor([[4.0], [1.0]]))
        >>> indices[valid]
        tensor([[0, 1],
                [1, 0]])
    """
    first, second, given = _batched(desc1, desc2, dm)
    far = _dissimilarities(first, second, given, mask1, mask2)
    index = two_least(far, True)[..., 0]
    return _rows(_distances(first, second, given, index), index, _is_mutual(far, index), desc1)


def match_snn(
    desc1: Tensor, desc2: Tensor, th: float = 0.8, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor]:
    """Nearest neighbours that pass the ratio test: the second nearest is clearly farther.

    D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. Where there is no second descriptor in the second set, nothing matches.
        th: the most that the distance of the nearest may be of that of the second nearest. (0 / 0 counts as 1.)

    Returns:
        ratios ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> ratios, indices, valid = match_snn(torch.tensor([[0.0], [5.0]]), torch.tensor([[4.0], [1.0], [6.0]]))
        >>> ratios[valid], indices[valid]
        (tensor([[0.2500]]), tensor([[0, 1]]))
    """
    first, second, given = _batched(desc1, desc2, dm)
    least = two_least(_dissimilarities(first, second, given, mask1, mask2), True)
    ratio, tested = _ratios(first, second, given, least[..., 0], least[..., 1])
    return _rows(ratio, least[..., 0], tested & (ratio <= th), desc1)


def match_smnn(
    desc1: Tensor, desc2: Tensor, th: float = 0.95, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor]:
    """Mutual nearest neighbours that pass the ratio test both ways.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. Where either set has no second descriptor, nothing matches.
        th: see ``match_snn``.

    Returns:
        the larger of both ratios ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> ratios, indices, valid = match_smnn(torch.tensor([[0.0], [5.0], [9.0]]), torch.tensor([[4.0], [1.0], [5.5]]))
        >>> ratios[valid], indices[valid]
        (tensor([[0.2500],
                [0.5000]]), tensor([[0, 1],
                [1, 2]]))
    """
    first, second, given = _batched(desc1, desc2, dm)
    far = _dissimilarities(first, second, given, mask1, mask2)
    there, back = two_least(far, True), two_least(far, False)
    index = there[..., 0]
    ratio, tested = _ratios(first, second, given, index, there[..., 1])
    ratio_back, tested_back = _ratios(second, first, None if given is None else given.transpose(-1, -2), back[..., 0], back[..., 1])
    partner = index.clamp(min=0)
    passed = (ratio_back <= th) & tested_back
    largest = torch.maximum(ratio, ratio_back.gather(-1, partner))
    valid = tested & (ratio <= th) & passed.gather(-1, partner) & _points_back(back[..., 0], index)
    return _rows(largest, index, valid, desc1)


def match_smnn_batched(
    desc1: Tensor, desc2: Tensor, th: float = 0.95, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor]:
    """``match_smnn`` of batches only.

    Args:
        desc1: (B, N1, D), floating point.
        desc2: (B, N2, D).
        th, dm, mask1, mask2: see ``match_smnn``.

    Returns:
        the larger of both ratios (B, N1, 1); indices (B, N1, 2), int64; valid (B, N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> first, second = torch.tensor([[[0.0], [5.0]]]), torch.tensor([[[5.5], [1.0]]])
        >>> match_smnn_batched(first, second, mask2=torch.tensor([[True, False]]))[2]
        tensor([[False, False]])
    """
    if desc1.dim() != 3:
        raise ValueError(f"desc1: expected shape (B, N1, D), got {list(desc1.shape)}")
    return match_smnn(desc1, desc2, th, dm, mask1, mask2)


def match_fginn(
    desc1: Tensor,
    desc2: Tensor,
    lafs1: Tensor,
    lafs2: Tensor,
    th: float = 0.8,
    spatial_th: float = 10.0,
    mutual: bool = False,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """The ratio test against the first geometrically inconsistent neighbour: the second nearest is looked for in other places.

    D. Mishkin, J. Matas, M. Perdoch, MODS: Fast and robust method for two-view matching, CVIU 141, 2015. All descriptors are looked at, where
    Kornia looks at the ten nearest.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. Where no descriptor is far enough from the nearest, nothing matches.
        lafs1: (B, N1, 2, 3), floating point, the frames of the first set (B = 1 where descriptors have no batch), which do not matter.
        lafs2: (B, N2, 2, 3), those of the second set.
        th: see ``match_snn``.
        spatial_th: how many pixels more than which the centre of the second must be from that of the nearest.
        mutual: whether matches must be mutual nearest neighbours, too.

    Returns:
        ratios ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> first, second = torch.tensor([[0.0]]), torch.tensor([[1.0], [1.1], [4.0]])
        >>> frames = torch.eye(2, 3).repeat(1, 3, 1, 1)
        >>> frames[0, 2, :, 2] = 50.0
        >>> match_fginn(first, second, frames[:, :1], frames)[0], match_snn(first, second)[2]
        (tensor([[0.2500]]), tensor([False]))
    """
    first, second, given = _batched(desc1, desc2, dm)
    check_laf(lafs1, "lafs1")
    check_laf(lafs2, "lafs2")
    if lafs2.size(1) != second.size(1):
        raise ValueError(f"lafs2: expected a frame for each of {second.size(1)} descriptors, got {list(lafs2.shape)}")
    far = _dissimilarities(first, second, given, mask1, mask2)
    index = two_least(far, True)[..., 0]
    centre = get_laf_center(lafs2).detach()
    nearest = centre.gather(1, index.clamp(min=0)[..., None].expand(-1, -1, 2))
    across, down = nearest[:, :, None, 0] - centre[:, None, :, 0], nearest[:, :, None, 1] - centre[:, None, :, 1]
    near = across * across + down * down <= spatial_th * spatial_th
    elsewhere = two_least(torch.where(near, torch.full_like(far, float("inf")), far), True)[..., 0]
    ratio, tested = _ratios(first, second, given, index, elsewhere)
    valid = tested & (ratio <= th)
    if mutual:
        valid = valid & _is_mutual(far, index)
    return _rows(ratio, index, valid, desc1)


def _batched(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor]) -> Tuple[Tensor, Tensor, Optional[Tensor]]:
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


def _dissimilarities(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], mask1: Optional[Tensor], mask2: Optional[Tensor]) -> Tensor:
    """(B, N1, N2) to compare by: squared distances or what is given; infinite where a mask says so. Without a gradient."""
    far = squared_distances(desc1, desc2) if dm is None else dm.detach()
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


def _distances(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], index: Tensor) -> Tensor:
    """(B, N1): how far the descriptors of the first set are from those of index (B, N1), where that is not negative."""
    index = index.clamp(min=0)
    if dm is not None:
        return dm.gather(-1, index[..., None])[..., 0]
    chosen = desc2.gather(1, index[..., None].expand(-1, -1, desc2.size(2)))
    difference = desc1.to(torch.float64) - chosen.to(torch.float64)
    squared = (difference * difference).sum(-1)
    same = squared == 0
    distance = torch.sqrt(torch.where(same, torch.ones_like(squared), squared))
    return torch.where(same, torch.zeros_like(squared), distance).to(desc1.dtype)


def _ratios(desc1: Tensor, desc2: Tensor, dm: Optional[Tensor], index: Tensor, second_index: Tensor) -> Tuple[Tensor, Tensor]:
    """Distance at index over that at second_index, and whether there are both: (B, N1) each."""
    nearest, second = _distances(desc1, desc2, dm, index), _distances(desc1, desc2, dm, second_index)
    tested = (index >= 0) & (second_index >= 0)
    usable = tested & (second > 0)
    ratio = nearest / torch.where(usable, second, torch.ones_like(second))
    return torch.where(usable, ratio, torch.ones_like(ratio)), tested


def _is_mutual(far: Tensor, index: Tensor) -> Tensor:
    """Whether each descriptor of the first set has a nearest one, at index, and is the nearest to that."""
    return _points_back(two_least(far, False)[..., 0], index)


def _points_back(back: Tensor, index: Tensor) -> Tensor:
    return (index >= 0) & (back.gather(-1, index.clamp(min=0)) == torch.arange(index.size(-1), device=index.device))


def _rows(distance: Tensor, index: Tensor, valid: Tensor, desc1: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The results, with the batch that desc1 has."""
    own = torch.arange(index.size(-1), device=index.device).expand_as(index)
    pairs = torch.stack([own, index], -1)
    pairs = torch.where(valid[..., None], pairs, torch.full_like(pairs, -1))
    distance = torch.where(valid, distance, torch.zeros_like(distance))[..., None]
    if desc1.dim() == 2:
        return distance[0], pairs[0], valid[0]
    return distance, pairs, valid
