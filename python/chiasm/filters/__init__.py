"""Smoothing and derivatives."""

from .bilateral import BilateralBlur, bilateral_blur, joint_bilateral_blur
from .canny import canny
from .gaussian import GaussianBlur2d, gaussian_blur2d, get_gaussian_kernel1d
from .gradient import Sobel, sobel, spatial_gradient
from .guided import guided_blur
from .median import MedianBlur, median_blur
from .non_local_means import non_local_means
from .rank import percentile_filter, rank_filter

__all__ = [
    "BilateralBlur",
    "GaussianBlur2d",
    "MedianBlur",
    "Sobel",
    "bilateral_blur",
    "canny",
    "gaussian_blur2d",
    "get_gaussian_kernel1d",
    "guided_blur",
    "joint_bilateral_blur",
    "median_blur",
    "non_local_means",
    "percentile_filter",
    "rank_filter",
    "sobel",
    "spatial_gradient",
]
