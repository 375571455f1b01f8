# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor, nn

from .bilateral import bilateral_blur as bilateral_blur
from .bilateral import joint_bilateral_blur as joint_bilateral_blur
from .box import box_blur as box_blur
from .box import laplacian as laplacian
from .canny import canny as canny
from .correlation import convolve2d as convolve2d
from .correlation import convolve3d as convolve3d
from .correlation import correlate2d as correlate2d
from .correlation import correlate3d as correlate3d
from .correlation import fft_conv as fft_conv
from .correlation import filter2d as filter2d
from .correlation import filter2d_separable as filter2d_separable
from .correlation import filter3d as filter3d
from .edges import prewitt as prewitt
from .edges import roberts as roberts
from .edges import scharr as scharr
from .gabor import gabor as gabor
from .gabor import get_gabor_kernel2d as get_gabor_kernel2d
from .gaussian import gaussian_blur2d as gaussian_blur2d
from .gaussian import get_gaussian_kernel1d as get_gaussian_kernel1d
from .gaussian_kernels import gaussian as gaussian
from .gaussian_kernels import get_gaussian_discrete_kernel1d as get_gaussian_discrete_kernel1d
from .gaussian_kernels import get_gaussian_erf_kernel1d as get_gaussian_erf_kernel1d
from .gaussian_kernels import get_gaussian_kernel2d as get_gaussian_kernel2d
from .gaussian_kernels import get_gaussian_kernel3d as get_gaussian_kernel3d
from .gradient import sobel as sobel
from .gradient import spatial_gradient as spatial_gradient
from .gradient3d import spatial_gradient3d as spatial_gradient3d
from .guided import guided_blur as guided_blur
from .kernels import get_binary_kernel2d as get_binary_kernel2d
from .kernels import get_box_kernel1d as get_box_kernel1d
from .kernels import get_box_kernel2d as get_box_kernel2d
from .kernels import get_diff_kernel2d as get_diff_kernel2d
from .kernels import get_hanning_kernel1d as get_hanning_kernel1d
from .kernels import get_hanning_kernel2d as get_hanning_kernel2d
from .kernels import get_laplacian_kernel1d as get_laplacian_kernel1d
from .kernels import get_laplacian_kernel2d as get_laplacian_kernel2d
from .kernels import get_sobel_kernel2d as get_sobel_kernel2d
from .kernels import get_spatial_gradient_kernel2d as get_spatial_gradient_kernel2d
from .kernels import get_spatial_gradient_kernel3d as get_spatial_gradient_kernel3d
from .kernels import laplacian_1d as laplacian_1d
from .median import median_blur as median_blur
from .motion import get_motion_kernel2d as get_motion_kernel2d
from .motion import get_motion_kernel3d as get_motion_kernel3d
from .motion import motion_blur as motion_blur
from .motion import motion_blur3d as motion_blur3d
from .non_local_means import non_local_means as non_local_means
from .pooling import blur_pool2d as blur_pool2d
from .pooling import edge_aware_blur_pool2d as edge_aware_blur_pool2d
from .pooling import max_blur_pool2d as max_blur_pool2d
from .rank import percentile_filter as percentile_filter
from .rank import rank_filter as rank_filter
from .sharpen import difference_of_gaussians as difference_of_gaussians
from .sharpen import unsharp_mask as unsharp_mask
from .threshold import adaptive_threshold as adaptive_threshold
from .threshold import in_range as in_range
from .threshold import otsu_threshold as otsu_threshold

class AdaptiveThreshold(nn.Module):
    """`adaptive_threshold` as a module: Compare each pixel with the mean of its neighbourhood, as
    OpenCV's ``adaptiveThreshold``; the border is replicated."""

    max_value: float
    adaptive_method: str
    threshold_type: str
    block_size: int
    c: float
    rounded: bool
    def __init__(
        self,
        max_value: float,
        adaptive_method: str = "mean",
        threshold_type: str = "binary",
        block_size: int = 3,
        c: float = 0.0,
        rounded: bool = True,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class BilateralBlur(nn.Module):
    """`bilateral_blur` as a module: Average over neighbours, weighted by closeness in space and in
    colour."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma_color: Union[float, Tensor]
    sigma_space: Union[Tuple[float, float], Tensor]
    border_type: str
    color_distance_type: str
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma_color: Union[float, Tensor],
        sigma_space: Union[Tuple[float, float], Tensor],
        border_type: str = "reflect",
        color_distance_type: str = "l1",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class BlurPool2d(nn.Module):
    """`blur_pool2d` as a module: Smooth by a binomial kernel and keep every stride-th row and column;
    beyond the border are zeros."""

    kernel_size: Union[int, Tuple[int, int]]
    stride: int
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], stride: int = 2) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

BlurPool2D = BlurPool2d

class BoxBlur(nn.Module):
    """`box_blur` as a module: Mean of each pixel's window."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    separable: bool
    def __init__(
        self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect", separable: bool = True
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Canny(nn.Module):
    """`canny` as a module: Thin edges: ridges of the gradient's magnitude above a low threshold that
    touch one above a high threshold."""

    low_threshold: float
    high_threshold: float
    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[Tuple[float, float], Tensor]
    hysteresis: bool
    eps: float
    num_iterations: int
    def __init__(
        self,
        low_threshold: float = 0.1,
        high_threshold: float = 0.2,
        kernel_size: Union[int, Tuple[int, int]] = ...,
        sigma: Union[Tuple[float, float], Tensor] = ...,
        hysteresis: bool = True,
        eps: float = 1e-06,
        num_iterations: int = 100,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...

class Convolve2d(nn.Module):
    """`convolve2d` as a module: ``filter2d`` with the kernel turned by half a turn."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Convolve3d(nn.Module):
    """`convolve3d` as a module: ``filter3d`` with the kernel reversed along its three axes."""

    border_type: str
    normalized: bool
    def __init__(self, border_type: str = "replicate", normalized: bool = False) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Correlate2d(nn.Module):
    """`correlate2d` as a module: ``filter2d`` as it is: the kernel is not turned."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Correlate3d(nn.Module):
    """`correlate3d` as a module: ``filter3d`` as it is: the kernel is not reversed."""

    border_type: str
    normalized: bool
    def __init__(self, border_type: str = "replicate", normalized: bool = False) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class DifferenceOfGaussians(nn.Module):
    """`difference_of_gaussians` as a module: Band-pass: the image smoothed a little minus the image
    smoothed more."""

    low_sigma: float
    high_sigma: Optional[float]
    border_type: str
    truncate: float
    def __init__(
        self,
        low_sigma: float,
        high_sigma: Optional[float] = None,
        border_type: str = "replicate",
        truncate: float = 4.0,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class EdgeAwareBlurPool2d(nn.Module):
    """`edge_aware_blur_pool2d` as a module: Smooth by a binomial kernel, but leave the surroundings of
    edges as they are. The size stays."""

    kernel_size: Union[int, Tuple[int, int]]
    edge_threshold: float
    edge_dilation_kernel_size: int
    epsilon: float
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        edge_threshold: float = 1.25,
        edge_dilation_kernel_size: int = 3,
        epsilon: float = 1e-06,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

EdgeAwareBlurPool2D = EdgeAwareBlurPool2d

class FftConv(nn.Module):
    """`fft_conv` as a module: ``filter2d`` under the name of Kornia's Fourier form."""

    border_type: str
    normalized: bool
    padding: str
    behaviour: str
    def __init__(
        self,
        border_type: str = "reflect",
        normalized: bool = False,
        padding: str = "same",
        behaviour: str = "corr",
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Filter2d(nn.Module):
    """`filter2d` as a module: Correlate every channel with a kernel: out(y, x) = sum over i, j of
    kernel(i, j) * input(y + i - ay, x + j - ax)."""

    border_type: str
    normalized: bool
    padding: str
    behaviour: str
    def __init__(
        self,
        border_type: str = "reflect",
        normalized: bool = False,
        padding: str = "same",
        behaviour: str = "corr",
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Filter2dSeparable(nn.Module):
    """`filter2d_separable` as a module: ``filter2d`` with the outer product of two one-dimensional
    kernels, in two passes; of bytes in one."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel_x: Tensor, kernel_y: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel_x: Tensor, kernel_y: Tensor) -> Tensor: ...

class Filter3d(nn.Module):
    """`filter3d` as a module: ``filter2d`` of volumes."""

    border_type: str
    normalized: bool
    behaviour: str
    def __init__(
        self, border_type: str = "replicate", normalized: bool = False, behaviour: str = "corr"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Gabor(nn.Module):
    """`gabor` as a module: Correlate with ``get_gabor_kernel2d``, one kernel for each sample where its
    arguments are tensors."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[float, Tensor]
    theta: Union[float, Tensor]
    lambd: Union[float, Tensor]
    gamma: Union[float, Tensor]
    psi: Union[float, Tensor]
    border_type: str
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma: Union[float, Tensor],
        theta: Union[float, Tensor],
        lambd: Union[float, Tensor],
        gamma: Union[float, Tensor] = 0.5,
        psi: Union[float, Tensor] = 0.0,
        border_type: str = "reflect",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Gaussian(nn.Module):
    """`gaussian` as a module: Sampled Gaussian that sums to 1, around any mean."""

    window_size: int
    sigma: Union[float, Tensor]
    mean: Union[float, Tensor, None]
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        window_size: int,
        sigma: Union[float, Tensor],
        mean: Union[float, Tensor, None] = None,
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GaussianBlur2d(nn.Module):
    """`gaussian_blur2d` as a module: Convolve with a normalised Gaussian."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[Tuple[float, float], Tensor]
    border_type: str
    separable: bool
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma: Union[Tuple[float, float], Tensor],
        border_type: str = "reflect",
        separable: bool = True,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class GetBinaryKernel2d(nn.Module):
    """`get_binary_kernel2d` as a module: One kernel for each pixel of a window, which picks that
    pixel."""

    window_size: Union[int, Tuple[int, int]]
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self,
        window_size: Union[int, Tuple[int, int]],
        device: Optional[torch.device] = None,
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetBoxKernel1d(nn.Module):
    """`get_box_kernel1d` as a module: Mean of kernel_size pixels."""

    kernel_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetBoxKernel2d(nn.Module):
    """`get_box_kernel2d` as a module: Mean of a rectangle."""

    kernel_size: Union[int, Tuple[int, int]]
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        device: Optional[torch.device] = None,
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetDiffKernel2d(nn.Module):
    """`get_diff_kernel2d` as a module: Differences of the two neighbours along x and along y, not
    normalised."""

    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(self, device: Optional[torch.device] = None, dtype: torch.dtype = ...) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaborKernel2d(nn.Module):
    """`get_gabor_kernel2d` as a module: A cosine wave under a Gaussian, exp(-(u^2 + gamma^2 v^2) / (2
    sigma^2)) cos(2 pi u / lambd + psi), as OpenCV's ``getGaborKernel``."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[float, Tensor]
    theta: Union[float, Tensor]
    lambd: Union[float, Tensor]
    gamma: Union[float, Tensor]
    psi: Union[float, Tensor]
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma: Union[float, Tensor],
        theta: Union[float, Tensor],
        lambd: Union[float, Tensor],
        gamma: Union[float, Tensor] = 0.5,
        psi: Union[float, Tensor] = 0.0,
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaussianDiscreteKernel1d(nn.Module):
    """`get_gaussian_discrete_kernel1d` as a module: The Gaussian's discrete analog exp(-t) I_n(t), t =
    sigma^2, with modified Bessel functions, normalised to sum 1."""

    kernel_size: int
    sigma: Union[float, Tensor]
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        kernel_size: int,
        sigma: Union[float, Tensor],
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaussianErfKernel1d(nn.Module):
    """`get_gaussian_erf_kernel1d` as a module: Gaussian integrated over each pixel, normalised to sum
    1."""

    kernel_size: int
    sigma: Union[float, Tensor]
    force_even: bool
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        kernel_size: int,
        sigma: Union[float, Tensor],
        force_even: bool = False,
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaussianKernel1d(nn.Module):
    """`get_gaussian_kernel1d` as a module: Sampled Gaussian that sums to 1."""

    kernel_size: int
    sigma: Union[float, Tensor]
    force_even: bool
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        kernel_size: int,
        sigma: Union[float, Tensor],
        force_even: bool = False,
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaussianKernel2d(nn.Module):
    """`get_gaussian_kernel2d` as a module: Outer product of two sampled Gaussians, which sums to 1."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[Tuple[float, float], Tensor]
    force_even: bool
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma: Union[Tuple[float, float], Tensor],
        force_even: bool = False,
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaussianKernel3d(nn.Module):
    """`get_gaussian_kernel3d` as a module: Outer product of three sampled Gaussians, which sums to 1."""

    kernel_size: Union[int, Tuple[int, int, int]]
    sigma: Union[Tuple[float, float, float], Tensor]
    force_even: bool
    dtype: torch.dtype
    device: Optional[torch.device]
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int, int]],
        sigma: Union[Tuple[float, float, float], Tensor],
        force_even: bool = False,
        dtype: torch.dtype = ...,
        device: Optional[torch.device] = None,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetHanningKernel1d(nn.Module):
    """`get_hanning_kernel1d` as a module: Hann window 0.5 - 0.5 cos(2 pi i / (kernel_size - 1)), as
    ``numpy.hanning``."""

    kernel_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetHanningKernel2d(nn.Module):
    """`get_hanning_kernel2d` as a module: Outer product of two Hann windows."""

    kernel_size: Union[int, Tuple[int, int]]
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        device: Optional[torch.device] = None,
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetLaplacianKernel1d(nn.Module):
    """`get_laplacian_kernel1d` as a module: ``laplacian_1d`` under its other name."""

    kernel_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetLaplacianKernel2d(nn.Module):
    """`get_laplacian_kernel2d` as a module: Ones around 1 - rows * columns."""

    kernel_size: Union[int, Tuple[int, int]]
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        device: Optional[torch.device] = None,
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetMotionKernel2d(nn.Module):
    """`get_motion_kernel2d` as a module: A line through the middle of a square, which sums to 1."""

    kernel_size: int
    angle: Union[float, Tensor]
    direction: Union[float, Tensor]
    mode: str
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: int,
        angle: Union[float, Tensor],
        direction: Union[float, Tensor] = 0.0,
        mode: str = "nearest",
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetMotionKernel3d(nn.Module):
    """`get_motion_kernel3d` as a module: A line through the middle of a cube, which sums to 1."""

    kernel_size: int
    angle: Union[Tuple[float, float, float], Tensor]
    direction: Union[float, Tensor]
    mode: str
    dtype: torch.dtype
    def __init__(
        self,
        kernel_size: int,
        angle: Union[Tuple[float, float, float], Tensor],
        direction: Union[float, Tensor] = 0.0,
        mode: str = "nearest",
        dtype: torch.dtype = ...,
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetSobelKernel2d(nn.Module):
    """`get_sobel_kernel2d` as a module: Sobel's 3x3 operators for d/dx and d/dy, not normalised."""

    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(self, device: Optional[torch.device] = None, dtype: torch.dtype = ...) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetSpatialGradientKernel2d(nn.Module):
    """`get_spatial_gradient_kernel2d` as a module: The kernels of ``spatial_gradient``, not
    normalised."""

    mode: str
    order: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, mode: str, order: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetSpatialGradientKernel3d(nn.Module):
    """`get_spatial_gradient_kernel3d` as a module: The kernels of ``spatial_gradient3d``."""

    mode: str
    order: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, mode: str, order: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GuidedBlur(nn.Module):
    """`guided_blur` as a module: Smooth by local linear models of another image: output = a . guidance +
    b, fitted in each window and averaged."""

    kernel_size: Union[int, Tuple[int, int]]
    eps: Union[float, Tensor]
    border_type: str
    subsample: int
    separable: bool
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        eps: Union[float, Tensor],
        border_type: str = "reflect",
        subsample: int = 1,
        separable: bool = False,
    ) -> None: ...
    def forward(self, guidance: Tensor, input: Tensor) -> Tensor: ...
    def __call__(self, guidance: Tensor, input: Tensor) -> Tensor: ...

class InRange(nn.Module):
    """`in_range` as a module: Keep the pixels whose channels are all between two bounds, as OpenCV's
    ``inRange``; the others become 0."""

    lower: Union[List[float], Tensor]
    upper: Union[List[float], Tensor]
    return_mask: bool
    def __init__(
        self, lower: Union[List[float], Tensor], upper: Union[List[float], Tensor], return_mask: bool = False
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class JointBilateralBlur(nn.Module):
    """`joint_bilateral_blur` as a module: Average over neighbours, weighted by closeness in space and in
    the colour of another image."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma_color: Union[float, Tensor]
    sigma_space: Union[Tuple[float, float], Tensor]
    border_type: str
    color_distance_type: str
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma_color: Union[float, Tensor],
        sigma_space: Union[Tuple[float, float], Tensor],
        border_type: str = "reflect",
        color_distance_type: str = "l1",
    ) -> None: ...
    def forward(self, input: Tensor, guidance: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, guidance: Tensor) -> Tensor: ...

class Laplacian(nn.Module):
    """`laplacian` as a module: Sum of the differences between a window's pixels and its middle one."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    normalized: bool
    def __init__(
        self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect", normalized: bool = True
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Laplacian1d(nn.Module):
    """`laplacian_1d` as a module: Ones around 1 - window_size."""

    window_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, window_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class MaxBlurPool2d(nn.Module):
    """`max_blur_pool2d` as a module: Maxima over squares at every pixel, then ``blur_pool2d``."""

    kernel_size: Union[int, Tuple[int, int]]
    stride: int
    max_pool_size: int
    ceil_mode: bool
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        stride: int = 2,
        max_pool_size: int = 2,
        ceil_mode: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

MaxBlurPool2D = MaxBlurPool2d

class MedianBlur(nn.Module):
    """`median_blur` as a module: Replace each pixel by the median of its neighbourhood."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect") -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class MotionBlur(nn.Module):
    """`motion_blur` as a module: Blur as if the camera had moved along a line."""

    kernel_size: int
    angle: Union[float, Tensor]
    direction: Union[float, Tensor]
    border_type: str
    mode: str
    def __init__(
        self,
        kernel_size: int,
        angle: Union[float, Tensor],
        direction: Union[float, Tensor],
        border_type: str = "reflect",
        mode: str = "nearest",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class MotionBlur3d(nn.Module):
    """`motion_blur3d` as a module: ``motion_blur`` of volumes."""

    kernel_size: int
    angle: Union[Tuple[float, float, float], Tensor]
    direction: Union[float, Tensor]
    border_type: str
    mode: str
    def __init__(
        self,
        kernel_size: int,
        angle: Union[Tuple[float, float, float], Tensor],
        direction: Union[float, Tensor],
        border_type: str = "replicate",
        mode: str = "nearest",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

MotionBlur3D = MotionBlur3d

class NonLocalMeans(nn.Module):
    """`non_local_means` as a module: Average over the pixels of a search window, weighted by how alike
    the patches around them are."""

    patch_size: int
    patch_distance: int
    h: float
    sigma: float
    border_type: str
    def __init__(
        self,
        patch_size: int = 7,
        patch_distance: int = 11,
        h: float = 0.1,
        sigma: float = 0.0,
        border_type: str = "reflect",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class OtsuThreshold(nn.Module):
    """`otsu_threshold` as a module: Keep what is above the threshold that separates each plane's values
    best into two classes; the rest becomes 0."""

    nbins: int
    slow_and_differentiable: bool
    return_mask: bool
    def __init__(
        self, nbins: int = 256, slow_and_differentiable: bool = False, return_mask: bool = False
    ) -> None: ...
    def forward(self, x: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, x: Tensor) -> Tuple[Tensor, Tensor]: ...

class PercentileFilter(nn.Module):
    """`percentile_filter` as a module: Replace each pixel by a percentile of its neighbourhood: the
    value of rank floor(n * percentile / 100) of n."""

    percentile: float
    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(
        self, percentile: float, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Prewitt(nn.Module):
    """`prewitt` as a module: Magnitude of the gradient by Prewitt's kernels, smoothed by 1, 1, 1; the
    border is replicated."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class RankFilter(nn.Module):
    """`rank_filter` as a module: Replace each pixel by the value of a given rank in its neighbourhood,
    by a network of minima and maxima."""

    rank: int
    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(
        self, rank: int, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Roberts(nn.Module):
    """`roberts` as a module: Magnitude of the gradient by Roberts' cross, the two diagonal differences
    of each 2x2 square; the border is replicated."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Scharr(nn.Module):
    """`scharr` as a module: Magnitude of the gradient by Scharr's kernels, smoothed by 3, 10, 3; the
    border is replicated."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Sobel(nn.Module):
    """`sobel` as a module: Magnitude of the Sobel gradient, sqrt(dx^2 + dy^2 + eps); the border is
    replicated."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class SpatialGradient(nn.Module):
    """`spatial_gradient` as a module: First or second derivatives; the border is replicated."""

    mode: str
    order: int
    normalized: bool
    def __init__(self, mode: str = "sobel", order: int = 1, normalized: bool = True) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class SpatialGradient3d(nn.Module):
    """`spatial_gradient3d` as a module: First or second derivatives of a volume by central differences;
    the border is replicated."""

    mode: str
    order: int
    def __init__(self, mode: str = "diff", order: int = 1) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class UnsharpMask(nn.Module):
    """`unsharp_mask` as a module: Sharpen: add what Gaussian smoothing takes away."""

    kernel_size: Union[int, Tuple[int, int]]
    sigma: Union[Tuple[float, float], Tensor]
    border_type: str
    def __init__(
        self,
        kernel_size: Union[int, Tuple[int, int]],
        sigma: Union[Tuple[float, float], Tensor],
        border_type: str = "reflect",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

__all__ = [
    "AdaptiveThreshold",
    "BilateralBlur",
    "BlurPool2D",
    "BlurPool2d",
    "BoxBlur",
    "Canny",
    "Convolve2d",
    "Convolve3d",
    "Correlate2d",
    "Correlate3d",
    "DifferenceOfGaussians",
    "EdgeAwareBlurPool2D",
    "EdgeAwareBlurPool2d",
    "FftConv",
    "Filter2d",
    "Filter2dSeparable",
    "Filter3d",
    "Gabor",
    "Gaussian",
    "GaussianBlur2d",
    "GetBinaryKernel2d",
    "GetBoxKernel1d",
    "GetBoxKernel2d",
    "GetDiffKernel2d",
    "GetGaborKernel2d",
    "GetGaussianDiscreteKernel1d",
    "GetGaussianErfKernel1d",
    "GetGaussianKernel1d",
    "GetGaussianKernel2d",
    "GetGaussianKernel3d",
    "GetHanningKernel1d",
    "GetHanningKernel2d",
    "GetLaplacianKernel1d",
    "GetLaplacianKernel2d",
    "GetMotionKernel2d",
    "GetMotionKernel3d",
    "GetSobelKernel2d",
    "GetSpatialGradientKernel2d",
    "GetSpatialGradientKernel3d",
    "GuidedBlur",
    "InRange",
    "JointBilateralBlur",
    "Laplacian",
    "Laplacian1d",
    "MaxBlurPool2D",
    "MaxBlurPool2d",
    "MedianBlur",
    "MotionBlur",
    "MotionBlur3D",
    "MotionBlur3d",
    "NonLocalMeans",
    "OtsuThreshold",
    "PercentileFilter",
    "Prewitt",
    "RankFilter",
    "Roberts",
    "Scharr",
    "Sobel",
    "SpatialGradient",
    "SpatialGradient3d",
    "UnsharpMask",
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
