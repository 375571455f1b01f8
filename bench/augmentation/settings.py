"""What all contenders do. No imports of theirs: this is read in each one's environment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

#: in the order in which they are applied
STEPS = ("flip", "crop", "affine", "jitter", "blur", "normalise")

#: a batch of bytes to what it became: an array (B, 3, H, W), or a tensor
Call = Callable[[], Any]
#: makes a contender's call: of images (B, 3, H, W), uint8; of some of the steps; on so many threads
Make = Callable[[np.ndarray, Sequence[str], int], Call]


@dataclass(frozen=True)
class Settings:
    """The ranges are uniform, of each image on its own."""

    batch: int = 32
    #: of the images, before and after
    side: int = 224
    #: probability of a mirror image
    flip: float = 0.5
    #: of the box that is cut out: its share of the area, and its width / height, uniform in the logarithm
    area: tuple[float, float] = (0.08, 1.0)
    ratio: tuple[float, float] = (3 / 4, 4 / 3)
    #: of the affine map: angle to either side, shift to either side as part of the side, factor
    degrees: float = 15.0
    shift: float = 0.1
    scale: tuple[float, float] = (0.9, 1.1)
    #: brightness, contrast and saturation: how far from 1; hue: how far from 0, in turns
    colours: float = 0.4
    hue: float = 0.1
    #: of the Gaussian
    taps: int = 5
    sigma: tuple[float, float] = (0.1, 2.0)
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)


SETTINGS = Settings()


def shares(count: int, threads: int) -> list[range]:
    """The numbers below ``count`` in as many neighbouring parts."""
    edges = [count * i // threads for i in range(threads + 1)]
    return [range(a, b) for a, b in pairwise(edges)]
