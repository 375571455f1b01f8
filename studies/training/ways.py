"""The same augmentation by three libraries: functions of a batch (B, 3, H, W), float32 in [0, 1]."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from chiasm.augmentation import (
    CLASSES,
    AugmentationSequential,
    RandomAffine,
    RandomErasing,
    RandomResizedCrop,
)
from studies.batch.kornias import module

from .settings import Settings

Way = Callable[[Tensor], Tensor]


def none(settings: Settings) -> Way:
    return lambda images: images


def chiasm(settings: Settings) -> Way:
    """Seeds come from torch's generator, like the draws of the other libraries."""
    s = settings
    return AugmentationSequential(
        RandomAffine(s.degrees, (s.shift, s.shift), s.scale, p=1.0),
        RandomResizedCrop(s.side, s.area, s.ratio),
        CLASSES["ColorJitter"](s.jitter, s.jitter),
        RandomErasing(s.erased, p=s.erase),
    )


def kornia(settings: Settings) -> Way:
    s, augmentation = settings, module("kornia.augmentation")
    return augmentation.AugmentationSequential(
        augmentation.RandomAffine(s.degrees, (s.shift, s.shift), s.scale, p=1.0),
        augmentation.RandomResizedCrop((s.side, s.side), s.area, s.ratio),
        augmentation.ColorJitter(s.jitter, s.jitter),
        augmentation.RandomErasing(s.erased, p=s.erase),
        data_keys=["input"],
    )


def torchvision(settings: Settings) -> Way:
    """Each image in its own call: a batch would get one set of parameters."""
    from torchvision.transforms import InterpolationMode, v2

    s, bilinear = settings, InterpolationMode.BILINEAR
    pipeline = v2.Compose(
        [
            v2.RandomAffine((-s.degrees, s.degrees), (s.shift, s.shift), s.scale, interpolation=bilinear),
            v2.RandomResizedCrop(s.side, s.area, s.ratio, bilinear),
            v2.ColorJitter(s.jitter, s.jitter),
            v2.RandomErasing(s.erase, s.erased),
        ]
    )
    return lambda images: torch.stack([pipeline(image) for image in images])


WAYS: dict[str, Callable[[Settings], Way]] = {
    "none": none,
    "Kornia": kornia,
    "torchvision v2": torchvision,
    "chiasm": chiasm,
}
