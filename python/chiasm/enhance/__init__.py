"""Intensity transforms."""

from ..primitives.core.modules import ModuleForm, lazy_modules
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
from .arithmetic import Rescale, add_weighted, invert, shift_rgb
from .clahe import clahe, equalize_clahe
from .counting import count_histogram
from .density import histogram, histogram2d, image_histogram2d
from .equalization import autocontrast, equalize, equalize3d
from .hue import adjust_hue, adjust_hue_raw, adjust_saturation, adjust_saturation_raw
from .integral import integral_image, integral_tensor
from .jpeg import jpeg_codec_differentiable
from .lookup import lut
from .names import ThresholdType
from .normalize import denormalize, normalize, normalize_min_max
from .sharp import sharpness
from .statistics import mean_std_dev, min_max_loc
from .tone import posterize, solarize, threshold
from .whitening import linear_transform, zca_mean, zca_whiten
from .zca import ZCAWhitening

__all__ = [
    "Rescale",
    "ThresholdType",
    "ZCAWhitening",
    "add_weighted",
    "adjust_brightness",
    "adjust_brightness_accumulative",
    "adjust_contrast",
    "adjust_contrast_with_mean_subtraction",
    "adjust_gamma",
    "adjust_hue",
    "adjust_hue_raw",
    "adjust_log",
    "adjust_saturation",
    "adjust_saturation_raw",
    "adjust_saturation_with_gray_subtraction",
    "adjust_sigmoid",
    "autocontrast",
    "clahe",
    "count_histogram",
    "denormalize",
    "equalize",
    "equalize3d",
    "equalize_clahe",
    "histogram",
    "histogram2d",
    "image_histogram2d",
    "integral_image",
    "integral_tensor",
    "invert",
    "jpeg_codec_differentiable",
    "linear_transform",
    "lut",
    "mean_std_dev",
    "min_max_loc",
    "normalize",
    "normalize_min_max",
    "posterize",
    "sharpness",
    "shift_rgb",
    "solarize",
    "threshold",
    "zca_mean",
    "zca_whiten",
]

# As Kornia's classes name them.
_FORMS = {
    "adjust_brightness": ModuleForm(names={"factor": "brightness_factor"}),
    "adjust_brightness_accumulative": ModuleForm(names={"factor": "brightness_factor"}),
    "adjust_contrast": ModuleForm(names={"factor": "contrast_factor"}),
    "adjust_contrast_with_mean_subtraction": ModuleForm(names={"factor": "contrast_factor"}),
    "adjust_hue": ModuleForm(names={"factor": "hue_factor"}),
    "adjust_saturation": ModuleForm(names={"factor": "saturation_factor"}),
    "adjust_saturation_with_gray_subtraction": ModuleForm(names={"factor": "saturation_factor"}),
    "jpeg_codec_differentiable": ModuleForm(also=["JPEGCodecDifferentiable"]),
}

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
