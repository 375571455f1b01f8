"""The paper's figure: one column per level, from coarse to fine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from chiasm.geometry.conversions import normalize_homography
from chiasm.geometry.transform import homography_warp
from chiasm.image import tensor_to_frames
from gallery.layout import GAP, row_of
from gallery.panels import Panel

from .descent import in_pixels
from .pairs import Pair, corner_error
from .settings import Settings
from .step import pyramid

WIDTH = 800
#: absolute difference drawn as white
WHITE = 0.05


def figure(pair: Pair, levels: list[np.ndarray], settings: Settings, path: Path) -> None:
    """Write the figure: source, destination, the source warped by each level's result, and its difference
    from the source warped by the truth."""
    sources, targets = (
        pyramid(torch.from_numpy(frame), settings.levels)[::-1] for frame in (pair.src, pair.dst)
    )
    size = (settings.height, settings.width)
    truth = normalize_homography(
        torch.from_numpy(np.linalg.inv(pair.homography))[None], size, size, align_corners=False
    ).float()
    rows: list[list[Panel]] = [[], [], [], []]
    for source, target, found in zip(sources, targets, levels, strict=True):
        warped, right = (
            homography_warp(source, h, (target.size(2), target.size(3)))
            for h in (torch.from_numpy(found)[None], truth)
        )
        error = corner_error(pair, in_pixels(found, settings))
        difference = (warped - right).abs().mean(1, keepdim=True).expand(-1, 3, -1, -1)
        rows[0].append(Panel(f"source, {source.size(3)} x {source.size(2)}", _rgb(source), given=True))
        rows[1].append(Panel("destination", _rgb(target), given=True))
        rows[2].append(Panel(f"warped; corners: {error:.2g} pixels", _rgb(warped)))
        rows[3].append(Panel(f"from the truth, {difference.mean():.2g}", _rgb(difference / WHITE)))
    images = [row_of(row, len(row), WIDTH) for row in rows]
    canvas = Image.new("RGB", (WIDTH, sum(i.height + GAP for i in images) - GAP), "white")
    top = 0
    for image in images:
        canvas.paste(image, (0, top))
        top += image.height + GAP
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.save(path, optimize=True)


def _rgb(bgr: Tensor) -> np.ndarray:
    return tensor_to_frames(bgr)[0].numpy()[..., ::-1]
