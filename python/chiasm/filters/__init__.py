"""Smoothing and derivatives."""

from .bilateral import BilateralBlur, bilateral_blur
from .canny import canny
from .gaussian import GaussianBlur2d, gaussian_blur2d, get_gaussian_kernel1d
from .gradient import Sobel, sobel, spatial_gradient
from .median import MedianBlur, median_blur

__all__ = [
    "BilateralBlur",
    "GaussianBlur2d",
    "MedianBlur",
    "Sobel",
    "bilateral_blur",
    "canny",
    "gaussian_blur2d",
    "get_gaussian_kernel1d",
    "median_blur",
    "sobel",
    "spatial_gradient",
]
