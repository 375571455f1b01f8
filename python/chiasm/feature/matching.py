"""Matching of descriptors by their Euclidean distances.

Every function returns one row for each descriptor of the first set, and a mask. Kornia returns only the
matches, whose number depends on the data: this is ``only_matches(*match_nn(desc1, desc2))``, which
``DescriptorMatcher`` calls. Rows without a match have distance 0 and indices -1. As in Kornia, the returned
distance is the ratio for functions with a ratio test. Of descriptors at the same distance the first one
counts as the nearest, so that every backend finds the same.

Descriptors are (N1, D) and (N2, D), or (B, N1, D) and (B, N2, D); results have a batch dimension if the
inputs have one. ``mask1`` and ``mask2`` say which slots of a fixed capacity hold a descriptor.
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_tensor
from ..primitives.features.matching import two_smallest
from .laf import check_laf, get_laf_center
from .pairing import (
    batched,
    dissimilarities,
    distances_to,
    is_mutual,
    no_matches,
    one_is_empty,
    points_back,
    ratios_to,
    result_rows,
)


def only_matches(distances: Tensor, indices: Tensor, valid: Tensor) -> Tuple[Tensor, Tensor]:
    """Select the rows that hold a match, which is what Kornia's functions return. For eager code: the number
    of rows depends on the data (it can be scripted, but not exported).

    Args:
        distances: (N1, 1).
        indices: (N1, 2).
        valid: (N1,), bool; all three as ``match_nn`` and the other functions return them.

    Returns:
        distances (M, 1) and indices (M, 2).

    Raises:
        ValueError: if there is a batch, whose pairs have different numbers of matches.

    Example:
        >>> found = match_snn(torch.tensor([[0.0], [5.0]]), torch.tensor([[4.0], [1.0], [6.0]]))
        >>> only_matches(*found)
        (tensor([[0.2500]]), tensor([[0, 1]]))
    """
    if valid.dim() != 1:
        raise ValueError(f"valid: expected shape (N1,), without a batch, got {list(valid.shape)}")
    return distances[valid], indices[valid]


def match_nn(
    desc1: Tensor,
    desc2: Tensor,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Find the nearest descriptor of the second set for each descriptor of the first set.

    Args:
        desc1: ([B,] N1, D), floating point.
        desc2: ([B,] N2, D). If either set has no descriptor, there are no matches.
        dm: ([B,] N1, N2), distances to use instead of those of the descriptors.
        mask1, mask2: ([B,] N1) and ([B,] N2), bool, masks of the descriptors to use; None means all.

    Returns:
        distances ([B,] N1, 1); indices ([B,] N1, 2), int64, into the first and the second set; valid ([B,]
        N1), bool. Differentiable in the descriptors and in dm; the derivative is 0 where a distance is 0.

    Raises:
        TypeError: if descriptors or dm are not floating point, or a mask not bool.
        ValueError: if a shape is not as above.

    Example:
        >>> distances, indices, valid = match_nn(
        ...     torch.tensor([[0.0], [5.0]]), torch.tensor([[4.0], [1.0], [8.0]])
        ... )
        >>> distances.flatten(), indices, valid
        (tensor([1., 1.]), tensor([[0, 1],
                [1, 0]]), tensor([True, True]))
    """
    first, second, given = batched(desc1, desc2, dm)
    far = dissimilarities(first, second, given, mask1, mask2)
    if one_is_empty(far):
        return no_matches(far, desc1)
    index = two_smallest(far, True)[..., 0]
    return result_rows(distances_to(first, second, given, index), index, index >= 0, desc1)


def match_mnn(
    desc1: Tensor,
    desc2: Tensor,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Mutual nearest neighbours: pairs whose descriptors are each nearest to the other one.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``.

    Returns:
        distances ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> distances, indices, valid = match_mnn(
        ...     torch.tensor([[0.0], [5.0], [6.0]]), torch.tensor([[4.0], [1.0]])
        ... )
        >>> indices[valid]
        tensor([[0, 1],
                [1, 0]])
    """
    first, second, given = batched(desc1, desc2, dm)
    far = dissimilarities(first, second, given, mask1, mask2)
    if one_is_empty(far):
        return no_matches(far, desc1)
    index = two_smallest(far, True)[..., 0]
    return result_rows(distances_to(first, second, given, index), index, is_mutual(far, index), desc1)


def match_snn(
    desc1: Tensor,
    desc2: Tensor,
    th: float = 0.8,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Nearest neighbours that pass the ratio test: the second nearest is clearly farther.

    D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. If the second set has only one descriptor, there are
            no matches.
        th: the largest ratio of the distance of the nearest to that of the second nearest. (0 / 0 counts as
            1.)

    Returns:
        ratios ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> ratios, indices, valid = match_snn(
        ...     torch.tensor([[0.0], [5.0]]), torch.tensor([[4.0], [1.0], [6.0]])
        ... )
        >>> ratios[valid], indices[valid]
        (tensor([[0.2500]]), tensor([[0, 1]]))
    """
    first, second, given = batched(desc1, desc2, dm)
    far = dissimilarities(first, second, given, mask1, mask2)
    if one_is_empty(far):
        return no_matches(far, desc1)
    least = two_smallest(far, True)
    ratio, tested = ratios_to(first, second, given, least[..., 0], least[..., 1])
    return result_rows(ratio, least[..., 0], tested & (ratio <= th), desc1)


def match_smnn(
    desc1: Tensor,
    desc2: Tensor,
    th: float = 0.95,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Mutual nearest neighbours that pass the ratio test both ways.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. If either set has only one descriptor, there are no
            matches.
        th: see ``match_snn``.

    Returns:
        the larger of both ratios ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool.

    Raises:
        TypeError, ValueError: see ``match_nn``.

    Example:
        >>> ratios, indices, valid = match_smnn(
        ...     torch.tensor([[0.0], [5.0], [9.0]]), torch.tensor([[4.0], [1.0], [5.5]])
        ... )
        >>> ratios[valid], indices[valid]
        (tensor([[0.2500],
                [0.5000]]), tensor([[0, 1],
                [1, 2]]))
    """
    first, second, given = batched(desc1, desc2, dm)
    far = dissimilarities(first, second, given, mask1, mask2)
    if one_is_empty(far):
        return no_matches(far, desc1)
    there, back = two_smallest(far, True), two_smallest(far, False)
    index = there[..., 0]
    ratio, tested = ratios_to(first, second, given, index, there[..., 1])
    ratio_back, tested_back = ratios_to(
        second, first, None if given is None else given.transpose(-1, -2), back[..., 0], back[..., 1]
    )
    partner = index.clamp(min=0)
    passed = (ratio_back <= th) & tested_back
    largest = torch.maximum(ratio, ratio_back.gather(-1, partner))
    valid = tested & (ratio <= th) & passed.gather(-1, partner) & points_back(back[..., 0], index)
    return result_rows(largest, index, valid, desc1)


def match_smnn_batched(
    desc1: Tensor,
    desc2: Tensor,
    th: float = 0.95,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
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
    check_tensor(desc1, "desc1")
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
    """Ratio test against the first geometrically inconsistent neighbour (FGINN): the second nearest must be
    elsewhere.

    D. Mishkin, J. Matas, M. Perdoch, MODS: Fast and robust method for two-view matching, CVIU 141, 2015. All
    descriptors are searched; Kornia searches the ten nearest.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. If no descriptor is far enough from the nearest one,
            there is no match.
        lafs1: (B, N1, 2, 3), floating point, the frames of the first set (B = 1 if descriptors have no
            batch); they are not used.
        lafs2: (B, N2, 2, 3), the frames of the second set.
        th: see ``match_snn``.
        spatial_th: the centre of the second nearest must be more than this many pixels from that of the
            nearest.
        mutual: True requires mutual nearest neighbours, too.

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
    first, second, given = batched(desc1, desc2, dm)
    check_laf(lafs1, "lafs1")
    check_laf(lafs2, "lafs2")
    if lafs2.size(1) != second.size(1):
        raise ValueError(
            f"lafs2: expected a frame for each of {second.size(1)} descriptors, got {list(lafs2.shape)}"
        )
    far = dissimilarities(first, second, given, mask1, mask2)
    if lafs2.size(0) != far.size(0):
        raise ValueError(f"lafs2: expected a batch of {far.size(0)}, got {list(lafs2.shape)}")
    if one_is_empty(far):
        return no_matches(far, desc1)
    index = two_smallest(far, True)[..., 0]
    centre = get_laf_center(lafs2).detach()
    nearest = centre.gather(1, index.clamp(min=0)[..., None].expand(-1, -1, 2))
    across, down = (
        nearest[:, :, None, 0] - centre[:, None, :, 0],
        nearest[:, :, None, 1] - centre[:, None, :, 1],
    )
    near = across * across + down * down <= spatial_th * spatial_th
    elsewhere = two_smallest(torch.where(near, torch.full_like(far, float("inf")), far), True)[..., 0]
    ratio, tested = ratios_to(first, second, given, index, elsewhere)
    valid = tested & (ratio <= th)
    if mutual:
        valid = valid & is_mutual(far, index)
    return result_rows(ratio, index, valid, desc1)
