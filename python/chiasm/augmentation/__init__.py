"""Random changes of images for training, as functions of seeds, which export like every op."""

from .base import (
    AugmentationBase2D,
    AugmentationBase3D,
    GeometricAugmentationBase2D,
    IntensityAugmentationBase2D,
)
from .flip import RandomHorizontalFlip, RandomVerticalFlip, random_horizontal_flip, random_vertical_flip

__all__ = [
    "AugmentationBase2D",
    "AugmentationBase3D",
    "GeometricAugmentationBase2D",
    "IntensityAugmentationBase2D",
    "RandomHorizontalFlip",
    "RandomVerticalFlip",
    "random_horizontal_flip",
    "random_vertical_flip",
]
