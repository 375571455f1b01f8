"""Local affine frames on a photograph, its patches, and their descriptors."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from chiasm import color, feature, filters
from gallery.geometric.setting import Inputs, Setting

#: Frames made by hand: centres relative to the image's size, radii, degrees, stretch along and across.
PLACES = (
    (0.16, 0.25),
    (0.4, 0.2),
    (0.64, 0.27),
    (0.87, 0.22),
    (0.13, 0.74),
    (0.38, 0.75),
    (0.62, 0.7),
    (0.85, 0.76),
)
RADII = (12.0, 20.0, 15.0, 22.0, 17.0, 24.0, 13.0, 20.0)
DEGREES = (0.0, 40.0, 90.0, 135.0, 180.0, -30.0, -80.0, 60.0)
STRETCH = (1.0, 1.4, 0.7, 1.5, 1.2, 0.7, 1.5, 1.0)
#: Ops that read the image inside the frames get frames of key points.
LOOKING = ("adapt_laf", "extract", "get_laf_descriptors", "orient_laf")


def by_hand(s: Setting) -> Tensor:
    """(1, 8, 2, 3): ellipses of many shapes, in pixels."""
    xy = torch.tensor(PLACES) * torch.tensor([s.width, s.height])
    disks = feature.laf_from_center_scale_ori(
        xy[None], torch.tensor(RADII).view(1, -1, 1, 1), torch.tensor(DEGREES).view(1, -1, 1)
    )
    stretch = torch.tensor([[a, 1 / a, 1.0] for a in STRETCH])[:, None]
    return disks * stretch


def found(gray: Tensor, count: int, octaves: int = 2, apart: float = 0.0, size: float = 3.0) -> Tensor:
    """(1, at most `count`, 2, 3): the strongest blobs, whose centres are at least a multiple `apart` of their
    radii away from each other."""
    lafs, _, valid = feature.detect_keypoints(
        gray, 40 * count if apart else count, "dog", num_octaves=octaves, mr_size=size
    )
    chosen: list[Tensor] = []
    for laf in lafs[0][valid[0]]:
        if len(chosen) < count and all(
            math.dist(laf[:, 2].tolist(), c[:, 2].tolist()) > apart * float(laf[0, 0] + c[0, 0])
            for c in chosen
        ):
            chosen.append(laf)
    return torch.stack(chosen)[None]


def away(s: Setting) -> Tensor:
    """Frames by hand that are at the border, flat or missing, depending on what the op tests."""
    lafs = by_hand(s)
    if "inside" in s.spec.name:
        lafs[0, [0, 3, 5], :, 2] += torch.tensor([[-28.0, 0.0], [24.0, 0.0], [0.0, 30.0]])
    if "valid" in s.spec.name:
        # A half is exact, so the determinant is exactly 0
        lafs[0, [1, 4, 6], 1, :2] = 0.5 * lafs[0, [1, 4, 6], 0, :2]
    if "filled" in s.spec.name:
        lafs[0, 5:] = 0
    return lafs


def frames(s: Setting) -> Inputs:
    """Frames in pixels, and the op's other inputs, with angles and factors that differ from frame to
    frame."""
    gray = color.rgb_to_grayscale(s.rgb)
    lafs = away(s)
    if any(word in s.spec.name for word in LOOKING):
        lafs = found(gray, 8, apart=1.0, size=7.0)
    given = feature.normalize_laf(lafs, gray) if "denormalize" in s.spec.name else lafs
    count = lafs.shape[1]
    ellipses = torch.cat([lafs[..., 2], forms(lafs)], -1)
    made = dict.fromkeys(("laf", "LAF", "lafs", "lafs_1"), given) | {
        "xy": lafs[..., 2],
        "scale": feature.get_laf_scale(lafs),
        "ori": feature.get_laf_orientation(lafs),
        "threepts": feature.laf_to_three_points(lafs),
        "ells": ellipses,
        "angles_degrees": torch.linspace(-60, 150, count).view(1, -1, 1),
        "scale_coef": torch.linspace(0.5, 1.4, count).view(1, -1, 1, 1),
        "trans_01": torch.tensor([[[0.85, -0.15, 40.0], [0.1, 0.8, 10.0], [1.2e-3, -4e-4, 1.0]]]),
        "sigmas": s.repeated(torch.ones(())),
    }
    return {name: value.float().contiguous() for name, value in made.items()} | scale_space(s, gray)


def forms(lafs: Tensor) -> Tensor:
    """(1, N, 3): a, b, c of a dx^2 + 2 b dx dy + c dy^2 = 1."""
    inverse = (
        torch.linalg.inv(lafs[..., :2])
        if bool((torch.linalg.det(lafs[..., :2]) != 0).all())
        else torch.zeros_like(lafs[..., :2])
    )
    form = inverse.mT @ inverse
    return torch.stack([form[..., 0, 0], form[..., 0, 1], form[..., 1, 1]], -1)


def scale_space(s: Setting, gray: Tensor) -> Inputs:
    """Levels with increasing blur."""
    if s.shape("input")[2:] != ("D", "H", "W"):
        return {}
    return {
        "input": (
            torch.stack(
                [filters.gaussian_blur2d(gray, (41, 41), (r, r)) for r in (1.0, 1.6, 2.5, 4.0)], 2
            ).contiguous()
        )
    }


def patches(s: Setting) -> Inputs:
    """Patches around key points, and their SIFT descriptors."""
    picture = (
        color.rgb_to_grayscale(s.rgb) if s.shape("patches")[1:2] == (1,) or not s.shape("patches") else s.rgb
    )
    lafs = found(color.rgb_to_grayscale(s.rgb), 8, apart=1.0, size=7.0)
    made = feature.extract_patches_from_pyramid(picture, lafs, 16)[0]
    if not s.shape("descriptors"):
        return {"patches": made.contiguous()}
    described = feature.sift_describe(made, rootsift=False)
    config = s.spec.config
    return {
        "descriptors": feature.convert_sift_descriptor_layout(described, config["target"], config["source"])
    }


def response(s: Setting) -> Inputs:
    """The blob response of the photograph, at most 1."""
    found = feature.hessian_response(
        filters.gaussian_blur2d(color.rgb_to_grayscale(s.rgb), (17, 17), (2.0, 2.0))
    ).clamp(min=0)
    return {"response": (found / found.amax()).contiguous()}
