"""Pairs of images to compare."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor
from torch.nn import functional

from chiasm import color, filters
from gallery.geometric.setting import Inputs, Setting, mesh
from gallery.photographs import DATA, photograph


def noise(shape: tuple[int, ...], spread: float, seed: int = 2) -> Tensor:
    return spread * torch.randn(shape, generator=torch.Generator().manual_seed(seed))


def differing(s: Setting) -> Inputs:
    """The photograph, and a noisy copy with an additional object."""
    copy = (s.rgb + noise(tuple(s.rgb.shape), 0.06)).clamp(0, 1)
    left, top, side = s.width // 10, s.height // 8, s.height // 3
    cup = (
        torch.from_numpy(photograph("coffee.png")[60:360, 150:450].copy()).permute(2, 0, 1)[None].float()
        / 255
    )
    copy[:, :, top : top + side, left : left + side] = functional.interpolate(cup, (side, side), mode="area")
    return {"img1": s.rgb, "image": copy, "img2": copy, "target": s.rgb}


def rougher(s: Setting) -> Inputs:
    """The photograph, blurred, as it is, and with noise."""
    blurred = filters.gaussian_blur2d(s.rgb, (11, 11), (2.5, 2.5))
    return {
        "img": color.rgb_to_grayscale(
            torch.cat([blurred, s.rgb, (s.rgb + noise(tuple(s.rgb.shape), 0.08)).clamp(0, 1)])
        )
    }


def related(s: Setting) -> Inputs:
    """Three copies of the photograph's brightness, and images that correlate with it exactly, roughly and not
    at all; masks exclude a corner."""
    gray = color.rgb_to_grayscale(s.rgb)[:, 0]
    other = (
        torch.from_numpy(photograph("coffee.png").copy()).permute(2, 0, 1)[None].float().mean(1, keepdim=True)
        / 255
    )
    other = functional.interpolate(other, gray.shape[-2:], mode="area")[:, 0]
    made = torch.cat([1 - gray**2, (1 - gray**2 + noise(tuple(gray.shape), 0.12)).clamp(0, 1), other])
    input, target = gray.expand_as(made), made
    x, y = mesh(s.width, s.height).unbind(-1)
    masks = (x + y > -0.6).expand_as(made), (x - y < 0.7).expand_as(made)
    if len(s.shape("input")) == 2:  # some of the pixels
        return {
            n: t.flatten(1)[:, ::97].contiguous()
            for n, t in zip(
                ("input", "target", "input_mask", "target_mask"), (input, target, *masks), strict=True
            )
        }
    return {
        n: t[None].contiguous()
        for n, t in zip(
            ("input", "target", "input_mask", "target_mask"), (input, target, *masks), strict=True
        )
    }


# --- disparity and flow -------------------------------------------------------------------------------------


@cache
def motorcycle_disparity() -> Tensor:
    """(500, 741) in pixels of the left photograph; NaN where it is not known."""
    with np.load(DATA / "motorcycle_disp.npz") as data:
        known = data["arr_0"].astype(np.float32)
    return torch.from_numpy(np.where(np.isfinite(known), known, np.nan))


def disparities(s: Setting) -> Inputs:
    """The motorcycle's known disparity, and an estimate that is smooth, noisy and partly wrong."""
    true = motorcycle_disparity()[::2, ::2]
    valid = torch.isfinite(true)
    found = filters.median_blur(filled(true)[None, None], (7, 7)) + noise((1, 1, *true.shape), 0.5)
    found[..., 40:90, 60:130] += 12
    return {
        "input": found.clamp(min=0),
        "target": true.nan_to_num(0.0)[None, None],
        "valid_mask": valid[None, None],
    }


def filled(values: Tensor) -> Tensor:
    """``values`` with the nearest value in place of NaN."""
    where = ndimage.distance_transform_edt(
        torch.isnan(values).numpy(), return_distances=False, return_indices=True
    )
    return values[torch.from_numpy(where[0]), torch.from_numpy(where[1])]


def inverse_depth(s: Setting) -> Inputs:
    """The motorcycle, and its disparity, which is proportional to inverse depth."""
    left = (
        torch.from_numpy(photograph("motorcycle_left.png")[::2, ::2].copy()).permute(2, 0, 1)[None].float()
        / 255
    )
    return {"idepth": filled(motorcycle_disparity()[::2, ::2])[None, None] / 60, "image": left}


def flows(s: Setting) -> Inputs:
    """The flow of a scene that rotates and comes nearer; the estimate has noise, and zeros in a part."""
    grid = mesh(s.width, s.height)
    x, y = grid.unbind(-1)
    true = torch.stack([8 * x - 10 * y, 10 * x + 6 * y], -1)
    coarse = noise((1, 2, 6, 8), 2.0)
    found = true + functional.interpolate(coarse, (s.height, s.width), mode="bicubic")[0].permute(1, 2, 0)
    found[((grid - torch.tensor([0.4, 0.3])) ** 2).sum(-1) < 0.08] = 0
    return {"input": found[None].contiguous(), "target": true[None].contiguous()}
