"""The paper's figure of a scene: one column per scale; rows with the views, the views warped to the
reference, the depth and its error.

The true depth is at the lower left.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch
from PIL import Image, ImageDraw

from chiasm.geometry.depth import depth_warp
from gallery.plots import FONT, INK

from .descent import Level
from .scenes import Scene, pixels
from .score import depth_at_full_size

CELL, GAP, STRIP = 150, 4, 15
#: errors from this one on are white
WORST = 0.25
UNKNOWN = (150, 150, 150)


def figure(scene: Scene, levels: list[Level]) -> Image.Image:
    """The figure of a scene."""
    results = (
        "views, warped to the reference by its depth",
        "depth",
        f"error: black 0, white {WORST:.0%} and more",
    )
    rows: dict[str, list[np.ndarray]] = {label: [] for label in (*_view_labels(scene), *results)}
    for level in levels:
        depth = depth_at_full_size(level.inverse_depth, scene)
        # The reference is in the second row, as in the paper's figure.
        images = [pixels(image) for image in level.images]
        own = 1 / level.inverse_depth[0, 0].numpy()
        made = [
            images[1],
            images[0],
            *images[2:],
            warped(level, scene),
            depth_colors(own, scene),
            error_colors(depth, scene),
        ]
        for row, cell in zip(rows.values(), made, strict=True):
            row.append(cell)
    rows["true depth, grey where unknown"] = [depth_colors(scene.depth, scene)]
    height = round(CELL * scene.depth.shape[0] / scene.depth.shape[1])
    canvas = Image.new(
        "RGB", (len(levels) * (CELL + GAP) - GAP, STRIP + len(rows) * (height + STRIP + GAP)), "white"
    )
    pen = ImageDraw.Draw(canvas)
    for r, (label, cells) in enumerate(rows.items()):
        top = STRIP + r * (height + STRIP + GAP)
        pen.text((0, top), label, fill=INK, font=FONT)
        for c, cell in enumerate(cells):
            canvas.paste(_resized(cell, height), (c * (CELL + GAP), top + STRIP))
    for c, level in enumerate(levels):
        pen.text(
            (c * (CELL + GAP) + CELL // 2, 0),
            f"{level.images.shape[-1]} x {level.images.shape[-2]}",
            fill=INK,
            font=FONT,
            anchor="ma",
        )
    return canvas


def warped(level: Level, scene: Scene) -> np.ndarray:
    """The mean (h, w, 3) of the views, warped by the reference's depth; black where no view has a pixel."""
    views, still = level.images[1:], torch.eye(4)[None]
    cameras = level.cameras[1:], scene.motions[1:], level.cameras[:1], still
    colors, counts = (
        depth_warp(*cameras, 1 / level.inverse_depth, image).sum(0)
        for image in (views, torch.ones_like(views))
    )
    return pixels(colors / counts.clamp(min=1))


def depth_colors(depth: np.ndarray, scene: Scene) -> np.ndarray:
    """A depth map (h, w) in colours of its inverse, from red (near) to blue (far), over the range of the
    truth."""
    far, near = 1 / np.nanmax(scene.depth), 1 / np.nanmin(scene.depth)
    return _colors((1 / depth - far) / (near - far), cv2.COLORMAP_TURBO)


def error_colors(depth: np.ndarray, scene: Scene) -> np.ndarray:
    """Relative errors of a depth map (H, W) in colours."""
    return _colors(np.abs(depth - scene.depth) / scene.depth / WORST, cv2.COLORMAP_HOT)


def _colors(values: np.ndarray, colormap: int) -> np.ndarray:
    known = np.isfinite(values)
    levels = (np.where(known, values, 0).clip(0, 1) * 255).round().astype(np.uint8)
    return np.where(known[..., None], cv2.applyColorMap(levels, colormap)[..., ::-1], UNKNOWN).astype(
        np.uint8
    )


def _view_labels(scene: Scene) -> list[str]:
    others = [f"view {i}" for i in range(1, len(scene.images))]
    return [others[0], "reference", *others[1:]]


def _resized(cell: np.ndarray, height: int) -> Image.Image:
    smaller = cell.shape[1] > CELL
    return Image.fromarray(cell).resize(
        (CELL, height), Image.Resampling.LANCZOS if smaller else Image.Resampling.NEAREST
    )
