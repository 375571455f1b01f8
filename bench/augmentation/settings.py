"""The settings of all contenders. Imports no contender's library, because this module is used in every
contender's environment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

#: the steps, in the order in which they are applied
STEPS = ("flip", "crop", "affine", "jitter", "blur", "normalise")

#: processes a batch of bytes and returns the result: an array or a tensor (B, 3, H, W)
Call = Callable[[], Any]
#: makes a contender's call from images (B, 3, H, W), uint8, the names of the steps, and the number of threads
Make = Callable[[np.ndarray, Sequence[str], int], Call]


@dataclass(frozen=True)
class Settings:
    """The distributions are uniform in these ranges, and each image has its own draws."""

    batch: int = 32
    #: height and width of the images, before and after
    side: int = 224
    #: probability of a horizontal flip
    flip: float = 0.5
    #: the box to crop: its share of the area, and its width / height, uniform in the logarithm
    area: tuple[float, float] = (0.08, 1.0)
    ratio: tuple[float, float] = (3 / 4, 4 / 3)
    #: the affine map: largest angle, largest shift as a fraction of the side, range of the scale
    degrees: float = 15.0
    shift: float = 0.1
    scale: tuple[float, float] = (0.9, 1.1)
    #: largest difference of the factors of brightness, contrast and saturation from 1, and of the hue from 0,
    #: in turns
    colours: float = 0.4
    hue: float = 0.1
    #: the Gaussian blur
    taps: int = 5
    sigma: tuple[float, float] = (0.1, 2.0)
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)


SETTINGS = Settings()


def shares(count: int, threads: int) -> list[range]:
    """The numbers below ``count``, split into ``threads`` contiguous ranges."""
    edges = [count * i // threads for i in range(threads + 1)]
    return [range(a, b) for a, b in pairwise(edges)]
