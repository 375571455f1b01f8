"""Smoothing and derivatives."""

from ..primitives.twin import lazy_twins
from .bilateral import bilateral_blur
from .canny import canny
from .gaussian import gaussian_blur2d, get_gaussian_kernel1d
from .gradient import sobel, spatial_gradient
from .median import median_blur

__all__ = [
    "bilateral_blur",
    "canny",
    "gaussian_blur2d",
    "get_gaussian_kernel1d",
    "median_blur",
    "sobel",
    "spatial_gradient",
]

__getattr__ = lazy_twins(__name__, globals())
