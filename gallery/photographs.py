"""Photographs that ship inside scikit-image."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import skimage
from PIL import Image

DATA = Path(skimage.__file__).parent / "data"


@cache
def photograph(name: str) -> np.ndarray:
    """An RGB uint8 array (H, W, 3)."""
    array = np.asarray(Image.open(DATA / name).convert("RGB"))
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class View:
    """A part of a photograph.

    box: left, top, right, bottom; None takes all of it.
    size: width and height to which the part is reduced; None keeps its size.
    noise: standard deviation of the added noise, in levels.
    specks: share of the pixels that are made black or white.
    """

    file: str
    box: tuple[int, int, int, int] | None = None
    size: tuple[int, int] | None = None
    noise: float = 0.0
    specks: float = 0.0

    def pixels(self) -> np.ndarray:
        """An RGB uint8 array (H, W, 3)."""
        part = (
            Image.fromarray(photograph(self.file)).crop(self.box)
            if self.box
            else Image.fromarray(photograph(self.file))
        )
        array = np.asarray(part.resize(self.size, Image.Resampling.LANCZOS) if self.size else part)
        random = np.random.default_rng(1)
        if self.noise:
            array = (array + random.normal(0, self.noise, array.shape)).round().clip(0, 255).astype(np.uint8)
        if self.specks:
            speck = random.random(array.shape[:2])[..., None]
            array = np.where(
                speck < self.specks / 2, 0, np.where(speck > 1 - self.specks / 2, 255, array)
            ).astype(np.uint8)
        return array
