"""Smoothing and derivatives."""

from ..primitives.core.modules import ModuleForm, lazy_modules
from .bilateral import bilateral_blur, joint_bilateral_blur
from .box import box_blur, laplacian
from .canny import canny
from .correlation import (
    convolve2d,
    convolve3d,
    correlate2d,
    correlate3d,
    fft_conv,
    filter2d,
    filter2d_separable,
    filter3d,
)
from .edges import prewitt, roberts, scharr
from .gabor import gabor, get_gabor_kernel2d
from .gaussian import gaussian_blur2d, get_gaussian_kernel1d
from .gaussian_kernels import (
    gaussian,
    get_gaussian_discrete_kernel1d,
    get_gaussian_erf_kernel1d,
    get_gaussian_kernel2d,
    get_gaussian_kernel3d,
)
from .gradient import sobel, spatial_gradient
from .gradient3d import spatial_gradient3d
from .guided import guided_blur
from .kernels import (
    get_binary_kernel2d,
    get_box_kernel1d,
    get_box_kernel2d,
    get_diff_kernel2d,
    get_hanning_kernel1d,
    get_hanning_kernel2d,
    get_laplacian_kernel1d,
    get_laplacian_kernel2d,
    get_sobel_kernel2d,
    get_spatial_gradient_kernel2d,
    get_spatial_gradient_kernel3d,
    laplacian_1d,
)
from .median import median_blur
from .motion import get_motion_kernel2d, get_motion_kernel3d, motion_blur, motion_blur3d
from .non_local_means import non_local_means
from .pooling import blur_pool2d, edge_aware_blur_pool2d, max_blur_pool2d
from .rank import percentile_filter, rank_filter
from .sharpen import difference_of_gaussians, unsharp_mask
from .threshold import adaptive_threshold, in_range, otsu_threshold

__all__ = [
    "adaptive_threshold",
    "bilateral_blur",
    "blur_pool2d",
    "box_blur",
    "canny",
    "convolve2d",
    "convolve3d",
    "correlate2d",
    "correlate3d",
    "difference_of_gaussians",
    "edge_aware_blur_pool2d",
    "fft_conv",
    "filter2d",
    "filter2d_separable",
    "filter3d",
    "gabor",
    "gaussian",
    "gaussian_blur2d",
    "get_binary_kernel2d",
    "get_box_kernel1d",
    "get_box_kernel2d",
    "get_diff_kernel2d",
    "get_gabor_kernel2d",
    "get_gaussian_discrete_kernel1d",
    "get_gaussian_erf_kernel1d",
    "get_gaussian_kernel1d",
    "get_gaussian_kernel2d",
    "get_gaussian_kernel3d",
    "get_hanning_kernel1d",
    "get_hanning_kernel2d",
    "get_laplacian_kernel1d",
    "get_laplacian_kernel2d",
    "get_motion_kernel2d",
    "get_motion_kernel3d",
    "get_sobel_kernel2d",
    "get_spatial_gradient_kernel2d",
    "get_spatial_gradient_kernel3d",
    "guided_blur",
    "in_range",
    "joint_bilateral_blur",
    "laplacian",
    "laplacian_1d",
    "max_blur_pool2d",
    "median_blur",
    "motion_blur",
    "motion_blur3d",
    "non_local_means",
    "otsu_threshold",
    "percentile_filter",
    "prewitt",
    "rank_filter",
    "roberts",
    "scharr",
    "sobel",
    "spatial_gradient",
    "spatial_gradient3d",
    "unsharp_mask",
]

# As Kornia spells them.
_FORMS = {
    "blur_pool2d": ModuleForm(also=["BlurPool2D"]),
    "edge_aware_blur_pool2d": ModuleForm(also=["EdgeAwareBlurPool2D"]),
    "max_blur_pool2d": ModuleForm(also=["MaxBlurPool2D"]),
    "motion_blur3d": ModuleForm(also=["MotionBlur3D"]),
}

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
