"""AdaLAM: matches that agree with the matches around them on a local affine map.

L. Cavalli, V. Larsson, M. Oswald, T. Sattler, M. Pollefeys, AdaLAM: Revisiting Handcrafted Outlier Detection,
arXiv 2006.04250, 2020. Nothing is random: the samples are the pairs of a seed's neighbours with the highest
confidence, in the order of PROSAC (O. Chum, J. Matas, Matching with PROSAC, CVPR 2005). All decisions are
made in float64 and without a gradient.
"""

import math
from typing import List, Optional, Tuple, Union

import torch
import torch.nn.functional as F
from torch import Tensor

from ..primitives.core.checks import check_pair
from ..primitives.features.matching import two_smallest
from ..primitives.numbers.ranking import stable_topk
from .laf import check_laf, determinants
from .pairing import (
    batched,
    dissimilarities,
    distances_to,
    is_mutual,
    no_matches,
    one_is_empty,
    ratios_to,
    result_rows,
)


def match_adalam(
    desc1: Tensor,
    desc2: Tensor,
    lafs1: Tensor,
    lafs2: Tensor,
    area_ratio: float = 100.0,
    search_expansion: float = 4.0,
    ransac_iters: int = 128,
    min_inliers: int = 6,
    min_confidence: float = 200.0,
    orientation_difference_threshold: float = 30.0,
    scale_rate_threshold: float = 1.5,
    detected_scale_rate_threshold: float = 5.0,
    num_seeds: int = 128,
    num_neighbors: int = 128,
    mutual: bool = False,
    hw1: Optional[Union[Tensor, Tuple[int, int]]] = None,
    hw2: Optional[Union[Tensor, Tuple[int, int]]] = None,
    dm: Optional[Tensor] = None,
    mask1: Optional[Tensor] = None,
    mask2: Optional[Tensor] = None,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Nearest neighbours that are consistent with a local affine map (AdaLAM); this gives many more and fewer
    wrong matches than a ratio test.

    1. Each descriptor of the first set and its nearest one of the second set are a putative match. Its
    confidence is 1 minus its ratio (``match_snn``). 2. Seeds are mutual nearest neighbours with a higher
    confidence than all other mutual nearest neighbours within R1 = sqrt(H W / (pi area_ratio)) in the first
    image. 3. The neighbours of a seed are the matches within search_expansion R1 in the first image and
    search_expansion R2 in the second image, whose rotation and scale change between the images are similar to
    those of the seed's frames. 4. Two neighbours and the seed define an affine map. Residuals of wrong
    matches would be uniform over the disk of radius search_expansion R2. The inliers are the matches up to
    the largest residual within which there are min_confidence times as many matches as for such a uniform
    distribution. The map with the most inliers of all samples is fitted to its inliers by least squares. If
    at least min_inliers agree with this map, then the inliers, the seed, and all neighbours that fit as well
    are matches.

    Args:
        desc1, desc2, dm, mask1, mask2: see ``match_nn``. If the second set has only one
            descriptor, all confidences are 0.
        lafs1, lafs2: (B, N1, 2, 3) and (B, N2, 2, 3), floating point, the oriented frames of the descriptors
            in pixels (B = 1 if descriptors have no batch).
        area_ratio: the image area divided by the area of a disk of radius R1.
        search_expansion: the radius of a seed's neighbourhood divided by R1 (by R2 in the second image).
        ransac_iters: samples for each seed, at most num_neighbors (num_neighbors - 1) / 2.
        min_inliers: how many matches must agree with a seed, without the seed itself; at least 3, since two
            define the map.
        min_confidence: see above; positive.
        orientation_difference_threshold: in degrees; use 180 or more if frames have no orientation.
        scale_rate_threshold: the largest factor between the scale changes of a match and of the seed; at
            least 1.
        detected_scale_rate_threshold: the largest factor between the scale of a map and the scale change of
            the seed's frames; at least 1.
        num_seeds: the maximum number of seeds; those with the highest confidence are used.
        num_neighbors: the maximum number of neighbours of a seed for the samples, those with the highest
            confidence; at least 2.
        mutual: True requires that all matches, not only seeds, are mutual nearest neighbours.
        hw1, hw2: heights and widths of the images, (2,) or (B, 2) or two numbers; None uses the bounding
            rectangle of the frames' centres.

    Returns:
        distances ([B,] N1, 1); indices ([B,] N1, 2), int64; valid ([B,] N1), bool. Distances are
        differentiable, as in ``match_nn``.

    Raises:
        TypeError: if descriptors, frames or dm are not floating point, or a mask not bool.
        ValueError: if a shape or a number is not as above.

    Example:
        >>> generator = torch.Generator().manual_seed(0)
        >>> desc, centre = (
        ...     torch.rand(40, 16, generator=generator),
        ...     100 * torch.rand(1, 40, 2, 1, generator=generator),
        ... )
        >>> lafs1 = torch.cat([torch.eye(2).expand(1, 40, 2, 2), centre], -1)
        >>> lafs2 = lafs1 + torch.tensor([[0.0, 0.0, 7.0], [0.0, 0.0, 5.0]])
        >>> lafs2[0, :10, :, 2] = lafs2[0, :10, :, 2].flip(0)  # in wrong places
        >>> match_adalam(desc, desc, lafs1, lafs2, 20.0, hw1=(100, 100), hw2=(110, 110))[2].flatten().equal(
        ...     torch.arange(40) >= 10
        ... )
        True
    """
    _check_numbers(
        area_ratio, search_expansion, ransac_iters, min_inliers, min_confidence, num_seeds, num_neighbors
    )
    _check_factors(orientation_difference_threshold, scale_rate_threshold, detected_scale_rate_threshold)
    first, second, given = batched(desc1, desc2, dm)
    far = dissimilarities(first, second, given, mask1, mask2)
    if one_is_empty(far):
        return no_matches(far, desc1)
    least = two_smallest(far, True)
    index = least[..., 0]
    putative, both = index >= 0, is_mutual(far, index)
    if mutual:
        putative = both
    ratio = ratios_to(first, second, given, index, least[..., 1])[0].detach().to(torch.float64)
    sure = torch.where(putative, 1.0 - ratio, torch.full_like(ratio, -1.0))
    frames1, frames2 = (
        _present_frames(lafs1, first, mask1, "lafs1"),
        _present_frames(lafs2, second, mask2, "lafs2"),
    )
    # Squares of radii, (B, 1).
    radius1, radius2 = (
        _area(hw1, frames1, mask1, "hw1") / (math.pi * area_ratio),
        _area(hw2, frames2, mask2, "hw2") / (math.pi * area_ratio),
    )
    reach1, reach2 = (
        radius1 * (search_expansion * search_expansion),
        radius2 * (search_expansion * search_expansion),
    )
    moves = _moves(frames1, frames2.gather(1, index.clamp(min=0)[..., None, None].expand(-1, -1, 2, 3)))
    seed, seeded = _surest(_peaks(sure, both, moves, radius1), num_seeds)
    seeds = moves.gather(2, seed[:, None].expand(-1, moves.size(1), -1))
    places = moves[:, :4, None] - seeds[:, :4, :, None]
    alike = _alike(moves, seeds, orientation_difference_threshold, scale_rate_threshold)
    around = alike & _within(places, reach1, reach2) & putative[:, None] & seeded[..., None]
    own = seed[..., None] == torch.arange(index.size(1), device=index.device)
    near, there = _surest(
        torch.where(around & ~own, sure[:, None], torch.full_like(sure[:, None], -1.0)), num_neighbors
    )
    neighbors = places.gather(3, near[:, None].expand(-1, 4, -1, -1))
    fit, limit, count = _affinities(
        neighbors, there, seeds, reach2 / min_confidence, ransac_iters, detected_scale_rate_threshold
    )
    accepted = (
        around
        & (count >= min_inliers)[..., None]
        & (_residuals(fit[:, :, None], places)[:, :, 0] <= limit[..., None])
    )
    return result_rows(distances_to(first, second, given, index), index, accepted.any(1), desc1)


def _check_numbers(
    area_ratio: float,
    search_expansion: float,
    ransac_iters: int,
    min_inliers: int,
    min_confidence: float,
    num_seeds: int,
    num_neighbors: int,
) -> None:
    if not (area_ratio > 0.0 and search_expansion > 0.0 and min_confidence > 0.0):
        raise ValueError(
            f"area_ratio, search_expansion, min_confidence: expected positive numbers, got {area_ratio},"
            f" {search_expansion} and {min_confidence}"
        )
    if num_seeds < 1 or num_neighbors < 2 or min_inliers < 3:
        raise ValueError(
            f"num_seeds, num_neighbors, min_inliers: expected at least 1, 2 and 3, got {num_seeds},"
            f" {num_neighbors} and {min_inliers}"
        )
    if ransac_iters < 1 or ransac_iters > num_neighbors * (num_neighbors - 1) // 2:
        raise ValueError(
            f"ransac_iters: expected from 1 to {num_neighbors * (num_neighbors - 1) // 2}, got {ransac_iters}"
        )


def _check_factors(orientation: float, scale: float, detected_scale: float) -> None:
    if not orientation > 0.0:
        raise ValueError(f"orientation_difference_threshold: expected a positive number, got {orientation}")
    if not (scale >= 1.0 and detected_scale >= 1.0):
        raise ValueError(
            f"scale_rate_threshold, detected_scale_rate_threshold: expected at least 1, got {scale} and"
            f" {detected_scale}"
        )


def _present_frames(lafs: Tensor, desc: Tensor, mask: Optional[Tensor], name: str) -> Tensor:
    """The frames in float64; zeros where the mask is False."""
    check_laf(lafs, name)
    if lafs.size(0) != desc.size(0) or lafs.size(1) != desc.size(1):
        raise ValueError(
            f"{name}: expected a frame for each of {desc.size(0)} x {desc.size(1)} descriptors, got"
            f" {list(lafs.shape)}"
        )
    frames = lafs.detach().to(torch.float64)
    return frames if mask is None else torch.where(mask[..., None, None], frames, torch.zeros_like(frames))


def _area(
    hw: Optional[Union[Tensor, Tuple[int, int]]], frames: Tensor, mask: Optional[Tensor], name: str
) -> Tensor:
    """The image area (B, 1), float64: as given, or of the bounding rectangle of all centres."""
    centre = frames[..., 2]
    if hw is None:
        nowhere = torch.full_like(centre, float("inf"))
        there = torch.ones_like(centre, dtype=torch.bool) if mask is None else mask[..., None]
        size = torch.amax(torch.where(there, centre, -nowhere), 1) - torch.amin(
            torch.where(there, centre, nowhere), 1
        )
        size = torch.clamp(size, min=0.0)
        return size[:, :1] * size[:, 1:]
    if isinstance(hw, Tensor):
        if hw.dim() < 1 or hw.dim() > 2 or hw.size(-1) != 2:
            raise ValueError(f"{name}: expected shape (2,) or (B, 2), got {list(hw.shape)}")
        if hw.dim() == 2 and hw.size(0) != centre.size(0) and hw.size(0) != 1:
            raise ValueError(f"{name}: expected a batch of {centre.size(0)}, or 1, got {list(hw.shape)}")
        size = hw.detach().to(torch.float64) + torch.zeros_like(centre[:, 0])
        return size[:, :1] * size[:, 1:]
    check_pair(hw, name)
    return torch.ones_like(centre[:, 0, :1]) * (hw[0] * hw[1])


def _moves(frames1: Tensor, frames2: Tensor) -> Tensor:
    """The motion of each pair of frames (B, N, 2, 3), as (B, 8, N): x and y in both images; cosine and sine
    of the rotation; the logarithm of the scale change; -1 if one frame is mirrored, otherwise 1."""
    a, b, c, d = frames1[..., 0, 0], frames1[..., 0, 1], frames2[..., 0, 0], frames2[..., 0, 1]
    cosine, sine = a * c + b * d, a * d - b * c
    length = torch.sqrt(cosine * cosine + sine * sine)
    length = torch.where(length > 0, length, torch.ones_like(length))
    area1, area2 = determinants(frames1), determinants(frames2)
    sign = torch.where((area1 < 0) == (area2 < 0), torch.ones_like(area1), torch.full_like(area1, -1.0))
    area1, area2 = area1.abs(), area2.abs()
    proper = (area1 > 0) & (area2 > 0)
    one = torch.ones_like(area1)
    scale = 0.5 * torch.log(torch.where(proper, area2, one) / torch.where(proper, area1, one))
    centre1, centre2 = frames1[..., 2], frames2[..., 2]
    return torch.stack(
        [
            centre1[..., 0],
            centre1[..., 1],
            centre2[..., 0],
            centre2[..., 1],
            cosine / length,
            sine / length,
            scale,
            sign,
        ],
        1,
    )


def _peaks(sure: Tensor, mutual: Tensor, moves: Tensor, radius: Tensor) -> Tensor:
    """The confidence (B, N) of mutual matches that exceed all other mutual matches near them (of equal ones
    the first); -1 for other matches."""
    value = torch.where(mutual, sure, torch.full_like(sure, -1.0))
    across, down = moves[:, 0, :, None] - moves[:, 0, None], moves[:, 1, :, None] - moves[:, 1, None]
    near = across * across + down * down <= radius[..., None]
    place = torch.arange(sure.size(1), device=sure.device)
    before = (value[:, None] > value[..., None]) | (
        (value[:, None] == value[..., None]) & (place < place[:, None])
    )
    return torch.where((near & before).any(2), torch.full_like(value, -1.0), value)


def _surest(value: Tensor, count: int) -> Tuple[Tensor, Tensor]:
    """The indices of the largest values along the last axis, and which of these values are 0 or more; the
    index is the first one otherwise."""
    best, index = stable_topk(F.pad(value, [0, count], "constant", -1.0), count)
    there = best >= 0
    return torch.where(there, index, torch.zeros_like(index)), there


def _alike(moves: Tensor, seeds: Tensor, degrees: float, factor: float) -> Tensor:
    """(B, S, N): which matches have a rotation and a scale change similar to those of the seeds."""
    turned = seeds[:, 4, :, None] * moves[:, 4, None] + seeds[:, 5, :, None] * moves[:, 5, None]
    grown = (seeds[:, 6, :, None] - moves[:, 6, None]).abs() <= math.log(factor) + 1e-9
    return grown & (turned >= math.cos(math.radians(min(degrees, 180.0))) - 1e-9)


def _within(places: Tensor, reach1: Tensor, reach2: Tensor) -> Tensor:
    """(B, S, N): which matches are near the seed in both images."""
    squared = places * places
    return (squared[:, 0] + squared[:, 1] <= reach1[..., None]) & (
        squared[:, 2] + squared[:, 3] <= reach2[..., None]
    )


def _affinities(
    places: Tensor, there: Tensor, seeds: Tensor, bound: Tensor, samples: int, factor: float
) -> Tuple[Tensor, Tensor, Tensor]:
    """The maps (B, S, 4) with the most inliers among neighbours (B, 4, S, K), the largest squared residual of
    an inlier, and the number of inliers (B, S)."""
    first, second = _pairs(places.size(3), samples)
    first, second = first.to(places.device), second.to(places.device)
    both = there.index_select(2, first) & there.index_select(2, second)
    maps, proper = _fitted(
        torch.stack([places.index_select(3, first), places.index_select(3, second)], -1),
        both[..., None].expand(-1, -1, -1, 2),
    )
    usable = both & proper & _plausible(maps, seeds, factor)
    limit, count = _inliers(_residuals(maps, places), there, bound)
    # Among maps with equal numbers of inliers, the one with the smaller residuals.
    score = count - 0.5 * limit / torch.where(bound > 0, bound, torch.ones_like(bound))[..., None]
    best = torch.argmax(torch.where(usable, score, torch.full_like(score, -1.0)), 2, keepdim=True)
    found, usable = maps.gather(2, best[..., None].expand(-1, -1, -1, 4)), usable.gather(2, best)
    within = there & usable & (_residuals(found, places)[:, :, 0] <= limit.gather(2, best))
    fit, proper = _fitted(places, within)
    fit = torch.where(proper[..., None], fit, found[:, :, 0])
    limit, count = _inliers(_residuals(fit[:, :, None], places), there & usable, bound)
    return fit, limit[..., 0], count[..., 0]


def _pairs(count: int, samples: int) -> Tuple[Tensor, Tensor]:
    """The first pairs of ``count`` elements, in the order of the sum of their ranks."""
    first: List[int] = []
    second: List[int] = []
    total = 0
    while len(first) < samples:
        total += 1
        for i in range(max(0, total - count + 1), (total + 1) // 2):
            first.append(i)
            second.append(total - i)
    return torch.tensor(first[:samples]), torch.tensor(second[:samples])


def _fitted(places: Tensor, within: Tensor) -> Tuple[Tensor, Tensor]:
    """Linear maps (B, ..., 4), row by row, from the first image's x and y in places (B, 4, ..., K) to the
    second image's, by least squares over the places in ``within``; and which of the maps are determined."""
    weight = within.to(places.dtype)
    x, y, u, v = places.unbind(1)
    xx, xy, yy = (weight * x * x).sum(-1), (weight * x * y).sum(-1), (weight * y * y).sum(-1)
    ux, uy, vx, vy = (
        (weight * u * x).sum(-1),
        (weight * u * y).sum(-1),
        (weight * v * x).sum(-1),
        (weight * v * y).sum(-1),
    )
    area = xx * yy - xy * xy
    proper = area > 1e-9 * (xx + yy) * (xx + yy)
    area = torch.where(proper, area, torch.ones_like(area))
    rows = [ux * yy - uy * xy, uy * xx - ux * xy, vx * yy - vy * xy, vy * xx - vx * xy]
    return torch.stack(rows, -1) / area[..., None], proper


def _plausible(maps: Tensor, seeds: Tensor, factor: float) -> Tensor:
    """(B, S, T): which maps have a scale similar to that of the seeds' frames, and mirror only if these do.
    Without this test, many matches to one place would fit a map to a single point."""
    area = (maps[..., 0] * maps[..., 3] - maps[..., 1] * maps[..., 2]) * seeds[:, 7, :, None]
    wanted = torch.exp(2.0 * seeds[:, 6])[..., None]
    return (area <= wanted * (factor * factor)) & (area * (factor * factor) >= wanted)


def _residuals(maps: Tensor, places: Tensor) -> Tensor:
    """(B, S, T, K): squared distances in the second image between places (B, 4, S, K) and the results of maps
    (B, S, T, 4)."""
    x, y, u, v = places[:, :, :, None].unbind(1)
    across = maps[..., 0:1] * x + maps[..., 1:2] * y - u
    down = maps[..., 2:3] * x + maps[..., 3:4] * y - v
    return across * across + down * down


def _inliers(residual: Tensor, there: Tensor, bound: Tensor) -> Tuple[Tensor, Tensor]:
    """The largest squared residual (B, S, T) of the inliers, and their number; -1 and 0 if there are none.

    ``bound`` (B, 1) is the disk's squared radius divided by min_confidence: of n uniformly distributed
    neighbours, n r^2 / radius^2 would lie within r.
    """
    count = torch.clamp(there.sum(-1, keepdim=True), min=1).to(residual.dtype)[:, :, None]
    far = torch.where(there[:, :, None], residual, torch.full_like(residual, float("inf")))
    size = residual.size(3)
    ordered = -stable_topk(-far, size)[0]
    rank = torch.arange(size, device=residual.device).to(residual.dtype) + 1.0
    dense = ordered * count <= rank * bound[..., None, None]
    limit = torch.amax(torch.where(dense, ordered, torch.full_like(ordered, -1.0)), -1)
    return limit, torch.amax(torch.where(dense, rank, torch.zeros_like(ordered)), -1)
