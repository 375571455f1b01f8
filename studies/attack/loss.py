"""The loss of the attack, in three parts: E. Riba et al., Kornia, WACV 2020, section 4.4.

    loss = L_loc + alpha L_desc + beta L_reg L_loc  = mean of |H p1 - p2|^2                     p1, p2: a pair
    of key points, in pixels of the second image L_desc = mean of 1 + d(D1, D2) - d(D1, D2neg)      D:
    descriptors, d: Euclidean distance, neg: the hardest negative in the batch L_reg  = mean of (I - I_init)^2
    over the values of both images

About pairs of key points, the paper says only that p2 is the nearest. Here the points of a pair are each
other's nearest, and close enough in position and in scale, because distant points could not be brought
together. The hardest negative is that of A. Mishchuk et al. (Working hard to know your neighbor's margins,
NIPS 2017): the nearest wrong descriptor to either descriptor of the pair, at another position.

Orientations are not differentiable where another peak of the histogram becomes the highest. So both
descriptors of a pair use one orientation: that of the first image's key point, mapped to the second by the
homography. Once both patches look alike, the second key point's own orientation is the same. (If each key
point used its own orientation, neighbours would pull the same pixels towards different rotations.)
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from chiasm.color import rgb_to_grayscale
from chiasm.feature import (
    detect_keypoints,
    get_laf_center,
    get_laf_orientation,
    get_laf_scale,
    orient_laf,
    perspective_transform_lafs,
    set_laf_orientation,
)
from chiasm.feature.described import sift_laf_descriptors

from .settings import Settings


class Loss(NamedTuple):
    """Scalars, and the number of pairs."""

    total: Tensor
    loc: Tensor
    desc: Tensor
    reg: Tensor
    pairs: int


def attack_loss(images: Tensor, originals: Tensor, homography: Tensor, settings: Settings) -> Loss:
    """The loss of two images (2, 3, H, W), RGB in [0, 1], whose key points should match by homography (1, 3,
    3), from the first to the second.

    Raises:
        RuntimeError: if fewer than two key points have a partner.
    """
    grey = rgb_to_grayscale(images)
    lafs, _, valid = detect_keypoints(grey, **settings.detection())
    first, second = partners(
        perspective_transform_lafs(homography, lafs[:1])[0], lafs[1], valid[0], valid[1], settings
    )
    if len(first) < 2:
        raise RuntimeError(
            f"{len(first)} key points of the first image have one of the second within {settings.near} pixels"
            " of where the homography takes them"
        )
    lafs = torch.stack([lafs[0, first], lafs[1, second]])
    places = get_laf_center(lafs[1:])
    loc = (get_laf_center(perspective_transform_lafs(homography, lafs[:1])) - places).square().sum(-1).mean()
    with torch.no_grad():
        oriented = orient_laf(lafs[:1], grey[:1])
        angles = torch.cat(
            [
                get_laf_orientation(oriented),
                get_laf_orientation(perspective_transform_lafs(homography, oriented)),
            ]
        )
    described = sift_laf_descriptors(grey, set_laf_orientation(lafs, angles))
    distances = torch.cdist(described[0], described[1])
    desc = (1.0 + distances.diagonal() - hardest(distances, places[0], settings.near)).mean()
    reg = (images - originals).square().mean()
    return Loss(loc + settings.alpha * desc + settings.beta * reg, loc, desc, reg, len(first))


@torch.no_grad()
def partners(
    moved: Tensor, lafs: Tensor, there1: Tensor, there2: Tensor, settings: Settings
) -> tuple[Tensor, Tensor]:
    """The indices (n,) of the moved frames (K, 2, 3) and of the other frames (K, 2, 3) that are each other's
    nearest; only valid frames (K,) count."""
    distances = torch.cdist(moved[..., 2], lafs[..., 2])
    octaves = (
        get_laf_scale(moved[None]).flatten().log2()[:, None] - get_laf_scale(lafs[None]).flatten().log2()
    )
    alike = (distances < settings.near) & (octaves.abs() < settings.octaves) & there1[:, None] & there2
    distances = distances.where(alike, torch.inf)
    least, nearest = distances.min(1)
    mutual = distances.argmin(0)[nearest] == torch.arange(len(nearest))
    first = (mutual & least.isfinite()).nonzero()[:, 0]
    return first, nearest[first]


def hardest(distances: Tensor, places: Tensor, near: float) -> Tensor:
    """The smallest wrong distance (n,) in row or column k of distances (n, n), whose diagonal has the pairs.
    Only positions (n, 2) that are not near the right one count."""
    wrong = distances.where(torch.cdist(places, places) >= near, torch.inf)
    return torch.minimum(wrong.min(0).values, wrong.min(1).values)
