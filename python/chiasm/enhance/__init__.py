"""Intensity transforms."""

from ..primitives.twin import lazy_twins
from .adjust import (
    adjust_brightness,
    adjust_brightness_accumulative,
    adjust_contrast,
    adjust_contrast_with_mean_subtraction,
    adjust_gamma,
    adjust_log,
    adjust_saturation_with_gray_subtraction,
    adjust_sigmoid,
)
from .arithmetic import add_weighted, invert, shift_rgb
from .integral import integral_image, integral_tensor
from .normalize import denormalize, normalize, normalize_min_max
from .sharp import sharpness
from .tone import posterize, solarize, threshold

__all__ = [
    "add_weighted",
    "adjust_brightness",
    "adjust_brightness_accumulative",
    "adjust_contrast",
    "adjust_contrast_with_mean_subtraction",
    "adjust_gamma",
    "adjust_log",
    "adjust_saturation_with_gray_subtraction",
    "adjust_sigmoid",
    "denormalize",
    "integral_image",
    "integral_tensor",
    "invert",
    "normalize",
    "normalize_min_max",
    "posterize",
    "sharpness",
    "shift_rgb",
    "solarize",
    "threshold",
]

__getattr__ = lazy_twins(__name__, globals())
