"""Pictures of the attack: matches before and after, and the changes of the images."""

from __future__ import annotations

import numpy as np
from PIL import Image

from gallery.panels.matches import BAD, GOOD
from gallery.sheets import Photo
from studies.use_cases import PICTURES

from .report import GAIN, Look

GUTTER = 6


def write(first: Look, last: Look) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    before, after = _matches(first), _matches(last)
    _save(np.concatenate([before, np.full((GUTTER, *before.shape[1:]), 255, np.uint8), after]), "attack.png")
    change = 128 + GAIN * (last.state.images.astype(float) - first.state.images).mean(-1, keepdims=True)
    _save(
        np.concatenate(
            [_beside(last.state.images), _beside(change.clip(0, 255).astype(np.uint8).repeat(3, -1))]
        ),
        "attack_change.png",
    )


def _matches(look: Look) -> np.ndarray:
    """Both images side by side, all matches as lines, inliers green."""
    pixels = _beside(look.state.images)
    sheet, shift = Photo(pixels, pixels.shape[1]), np.array([look.state.images.shape[2] + GUTTER, 0])
    for k in np.argsort(look.match.inliers, kind="stable"):
        ends = look.match.matches[k].reshape(2, 2) + np.stack([0 * shift, shift])
        sheet.path(ends, GOOD if look.match.inliers[k] else BAD, 1.0 if look.match.inliers[k] else 0.5)
    return sheet.pixels()


def _beside(images: np.ndarray) -> np.ndarray:
    """Two images (2, H, W, 3) side by side."""
    return np.concatenate([images[0], np.full((images.shape[1], GUTTER, 3), 255, np.uint8), images[1]], 1)


def _save(pixels: np.ndarray, name: str) -> None:
    """Save with a palette, so that the file is small."""
    Image.fromarray(pixels).quantize(256).save(PICTURES / name, optimize=True)
