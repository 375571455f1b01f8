"""Images in pieces, clusters of colours, random heights."""

from __future__ import annotations

import torch
from torch.nn import functional

from chiasm import contrib
from gallery.geometric.setting import Inputs, Setting


def windows(s: Setting) -> Inputs:
    """Windows of the photograph, as the op takes them."""
    config = s.spec.config
    small = functional.interpolate(s.rgb, config["original_size"], mode="bilinear", antialias=True).clamp(
        0, 1
    )
    top, bottom, left, right = config["unpadding"]
    cut = contrib.extract_tensor_patches(
        functional.pad(small, (left, right, top, bottom)), config["window_size"], config["stride"]
    )
    return {"patches": cut.contiguous()}


def terrain(s: Setting) -> Inputs:
    """The same random numbers, once or for three degrees of roughness."""
    roughness = torch.tensor([0.3, 0.5, 0.8])
    count = len(roughness) if s.shape("roughness") else 1
    random = torch.rand((1, 1, 129, 172), generator=torch.Generator().manual_seed(8))
    return {"random": random.expand(count, -1, -1, -1).contiguous(), "roughness": roughness}


def clusters(s: Setting) -> Inputs:
    """The photograph's pixels; six of them are the first centres."""
    pixels = s.rgb[0].flatten(1).T.contiguous()
    return {"x": pixels, "centers": pixels[torch.linspace(0, len(pixels) - 1, 6).long()].contiguous()}
