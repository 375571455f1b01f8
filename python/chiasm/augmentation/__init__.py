"""Random changes of images for training, as functions of seeds, which export like every op."""

from . import values
from .affine import RandomAffine, RandomShear, RandomTranslate, random_affine
from .base import (
    AugmentationBase2D,
    AugmentationBase3D,
    GeometricAugmentationBase2D,
    IntensityAugmentationBase2D,
)
from .container import AugmentationSequential
from .crop import RandomResizedCrop, random_resized_crop
from .erasing import RandomErasing, random_erasing
from .flip import RandomHorizontalFlip, RandomVerticalFlip, random_horizontal_flip, random_vertical_flip
from .perspective import RandomPerspective, random_perspective
from .rotation import RandomRotation, random_rotation

__all__ = [
    "AugmentationBase2D",
    "AugmentationBase3D",
    "AugmentationSequential",
    "GeometricAugmentationBase2D",
    "IntensityAugmentationBase2D",
    "RandomAffine",
    "RandomErasing",
    "RandomHorizontalFlip",
    "RandomPerspective",
    "RandomResizedCrop",
    "RandomRotation",
    "RandomShear",
    "RandomTranslate",
    "RandomVerticalFlip",
    "random_affine",
    "random_erasing",
    "random_horizontal_flip",
    "random_perspective",
    "random_resized_crop",
    "random_rotation",
    "random_vertical_flip",
]

# Functions and classes that change values, or mix images.
globals().update(values.PUBLIC)
__all__ += [*values.PUBLIC]
