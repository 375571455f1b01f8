"""All settings of the training, in one place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """train: how many of scikit-learn's digits are learned from; the others are what accuracy is measured on.
    side: of the images, which are enlarged and grey in three channels. steps, batch, lr: of the training by
    Adam, whose rate falls to zero along a cosine. seeds: each a split, a network's beginning and what is
    drawn. degrees, shift, scale: of the affine map, to either side. area, ratio: of the box that is cut out,
    parts of the image's area, and width / height. jitter: how far from 1 the factors of brightness and
    contrast are at most. erased: the part of the image's area that is filled with black, with a probability
    of erase. threads: of torch. limit: how many standard errors of their difference two means may be apart.
    """

    train: int = 100
    side: int = 24
    steps: int = 300
    batch: int = 32
    lr: float = 0.003
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    degrees: float = 10.0
    shift: float = 0.1
    scale: tuple[float, float] = (0.9, 1.1)
    area: tuple[float, float] = (0.8, 1.0)
    ratio: tuple[float, float] = (3 / 4, 4 / 3)
    jitter: float = 0.4
    erased: tuple[float, float] = (0.02, 0.1)
    erase: float = 0.5
    threads: int = 1
    limit: float = 2.0


#: For tests.
SMALL = Settings(train=400, side=16, steps=40, seeds=(0, 1))
