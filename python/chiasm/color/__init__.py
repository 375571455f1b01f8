"""Colour spaces."""

from ..primitives.core.modules import ModuleForm, lazy_modules
from .camera import i420_to_rgb, nv12_to_rgb, nv21_to_rgb, rgb_to_nv12, uyvy_to_rgb, yuyv_to_rgb
from .colormap import apply_colormap
from .gray import bgr_to_grayscale, grayscale_to_rgb, rgb_to_grayscale
from .hls import hls_to_rgb, hsl_to_rgb, rgb_to_hls, rgb_to_hsl
from .hsv import hsv_to_rgb, rgb_to_hsv
from .lab import lab_to_rgb, rgb_to_lab
from .linear import linear_rgb_to_rgb, rgb_to_linear_rgb
from .luv import luv_to_rgb, rgb_to_luv
from .names import CFA, ColorMapType
from .raw import raw_to_rgb, raw_to_rgb_2x2_downscaled, rgb_to_raw
from .rgb import bgr_to_rgb, rgb_to_bgr
from .rgb255 import normals_to_rgb255, rgb255_to_normals, rgb255_to_rgb, rgb_to_rgb255
from .rgba import bgr_to_rgba, rgb_to_rgba, rgba_to_bgr, rgba_to_rgb
from .sepia import sepia
from .xyz import rgb_to_xyz, xyz_to_rgb
from .ycbcr import rgb_to_y, rgb_to_ycbcr, ycbcr_to_rgb
from .yuv import (
    planar_yuv_to_rgb,
    rgb_to_yuv,
    rgb_to_yuv420,
    rgb_to_yuv422,
    yuv420_to_rgb,
    yuv422_to_rgb,
    yuv_to_rgb,
)

__all__ = [
    "CFA",
    "ColorMapType",
    "apply_colormap",
    "bgr_to_grayscale",
    "bgr_to_rgb",
    "bgr_to_rgba",
    "grayscale_to_rgb",
    "hls_to_rgb",
    "hsl_to_rgb",
    "hsv_to_rgb",
    "i420_to_rgb",
    "lab_to_rgb",
    "linear_rgb_to_rgb",
    "luv_to_rgb",
    "normals_to_rgb255",
    "nv12_to_rgb",
    "nv21_to_rgb",
    "planar_yuv_to_rgb",
    "raw_to_rgb",
    "raw_to_rgb_2x2_downscaled",
    "rgb255_to_normals",
    "rgb255_to_rgb",
    "rgb_to_bgr",
    "rgb_to_grayscale",
    "rgb_to_hls",
    "rgb_to_hsl",
    "rgb_to_hsv",
    "rgb_to_lab",
    "rgb_to_linear_rgb",
    "rgb_to_luv",
    "rgb_to_nv12",
    "rgb_to_raw",
    "rgb_to_rgb255",
    "rgb_to_rgba",
    "rgb_to_xyz",
    "rgb_to_y",
    "rgb_to_ycbcr",
    "rgb_to_yuv",
    "rgb_to_yuv420",
    "rgb_to_yuv422",
    "rgba_to_bgr",
    "rgba_to_rgb",
    "sepia",
    "uyvy_to_rgb",
    "xyz_to_rgb",
    "ycbcr_to_rgb",
    "yuv420_to_rgb",
    "yuv422_to_rgb",
    "yuv_to_rgb",
    "yuyv_to_rgb",
]

_FORMS = {"apply_colormap": ModuleForm(also=["ApplyColorMap"])}  # as Kornia spells it

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
