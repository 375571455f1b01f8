"""All settings of the training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """train: the number of scikit-learn's digits for training; accuracy is measured on the others. side:
    height and width of the images, which are enlarged and have three grey channels. steps, batch, lr: for the
    training by Adam, whose rate falls to zero along a cosine. seeds: each determines the split, the network's
    initialisation and all random draws. degrees, shift, scale: ranges of the affine map. area, ratio: for the
    box to crop: parts of the image's area, and width / height. jitter: the largest difference from 1 of the
    factors of brightness and contrast. erased: the part of the image's area that is filled with black, with a
    probability of erase. threads: for torch. limit: the largest difference of two means, in standard errors
    of this difference.
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
