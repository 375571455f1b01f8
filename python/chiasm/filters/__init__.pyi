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
    """`adaptive_threshold` as a module: Compare each pixel with the mean of its neighbourhood, like
    OpenCV's ``adaptiveThreshold``. The border is replicated."""

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
    the border is padded with zeros."""

    kernel_size: Union[int, Tuple[int, int]]
    stride: int
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], stride: int = 2) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

BlurPool2D = BlurPool2d

class BoxBlur(nn.Module):
    """`box_blur` as a module: Mean of each pixel's window. For uint8, the sums are exact, and the mean
    is rounded once (halves to even). If both sizes are odd, the result is identical to that of OpenCV's
    8-bit ``blur``."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    separable: bool
    def __init__(
        self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect", separable: bool = True
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Canny(nn.Module):
    """`canny` as a module: Detect thin edges: ridges of the gradient magnitude, with two thresholds and
    hysteresis."""

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
        kernel_size: Union[int, Tuple[int, int]] = (5, 5),
        sigma: Union[Tuple[float, float], Tensor] = (1.0, 1.0),
        hysteresis: bool = True,
        eps: float = 1e-06,
        num_iterations: int = 100,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...

class Convolve2d(nn.Module):
    """`convolve2d` as a module: ``filter2d`` with behaviour "conv": the kernel is rotated by 180
    degrees."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Convolve3d(nn.Module):
    """`convolve3d` as a module: ``filter3d`` with behaviour "conv": the kernel is reversed along its
    three axes."""

    border_type: str
    normalized: bool
    def __init__(self, border_type: str = "replicate", normalized: bool = False) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Correlate2d(nn.Module):
    """`correlate2d` as a module: ``filter2d`` with behaviour "corr": the kernel is not rotated."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Correlate3d(nn.Module):
    """`correlate3d` as a module: ``filter3d`` with behaviour "corr": the kernel is not reversed."""

    border_type: str
    normalized: bool
    def __init__(self, border_type: str = "replicate", normalized: bool = False) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class DifferenceOfGaussians(nn.Module):
    """`difference_of_gaussians` as a module: Band-pass filter: the image smoothed with low_sigma minus
    the image smoothed with high_sigma."""

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
    """`edge_aware_blur_pool2d` as a module: Smooth by a binomial kernel, but not near edges; the output
    has the input's size."""

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
    """`fft_conv` as a module: ``filter2d`` under the name of Kornia's convolution by Fourier transforms.
    This op uses no Fourier transform: not every runtime has one, and the direct sum is exact. Its time
    grows with the kernel's area."""

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
    """`filter2d` as a module: Correlate every channel with a kernel. out(y, x) = sum over i, j of
    kernel(i, j) * input(y + i - ay, x + j - ax). The anchor (ay, ax) is the kernel's centre; for an even
    size it is (size - 1) // 2, in OpenCV and SciPy size // 2."""

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
    kernels, in two passes (for uint8 in one)."""

    border_type: str
    normalized: bool
    padding: str
    def __init__(
        self, border_type: str = "reflect", normalized: bool = False, padding: str = "same"
    ) -> None: ...
    def forward(self, input: Tensor, kernel_x: Tensor, kernel_y: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel_x: Tensor, kernel_y: Tensor) -> Tensor: ...

class Filter3d(nn.Module):
    """`filter3d` as a module: ``filter2d`` for volumes."""

    border_type: str
    normalized: bool
    behaviour: str
    def __init__(
        self, border_type: str = "replicate", normalized: bool = False, behaviour: str = "corr"
    ) -> None: ...
    def forward(self, input: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, kernel: Tensor) -> Tensor: ...

class Gabor(nn.Module):
    """`gabor` as a module: Correlate with ``get_gabor_kernel2d``, with one kernel for each sample if its
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
    """`gaussian` as a module: Sampled Gaussian that sums to 1, with any mean."""

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
    """`get_binary_kernel2d` as a module: One kernel for each pixel of a window; each kernel selects its
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
    """`get_box_kernel1d` as a module: Box kernel, the mean of kernel_size pixels."""

    kernel_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetBoxKernel2d(nn.Module):
    """`get_box_kernel2d` as a module: Box kernel, the mean of a rectangle of pixels."""

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
    """`get_diff_kernel2d` as a module: The differences of the two neighbours along x and along y, not
    normalized."""

    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(self, device: Optional[torch.device] = None, dtype: torch.dtype = ...) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetGaborKernel2d(nn.Module):
    """`get_gabor_kernel2d` as a module: A cosine wave times a Gaussian, like OpenCV's
    ``getGaborKernel``. The kernel is exp(-(u^2 + gamma^2 v^2) / (2 sigma^2)) cos(2 pi u / lambd +
    psi)."""

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
    """`get_gaussian_discrete_kernel1d` as a module: The discrete analog of the Gaussian, exp(-t) I_n(t),
    t = sigma^2, normalized to sum 1."""

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

class GetGaussianErfKernel1d(nn.Module):
    """`get_gaussian_erf_kernel1d` as a module: Gaussian integrated over each pixel, normalized to sum 1.
    Unlike in Kornia, an even kernel is symmetric, the device is that of ``sigma`` (CPU for a float), and
    ``dtype`` is used only for a float sigma."""

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
    """`get_hanning_kernel1d` as a module: Hann window 0.5 - 0.5 cos(2 pi i / (kernel_size - 1)), like
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
    """`get_laplacian_kernel1d` as a module: The same as ``laplacian_1d``."""

    kernel_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, kernel_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetLaplacianKernel2d(nn.Module):
    """`get_laplacian_kernel2d` as a module: Laplacian kernel: the centre is 1 - rows * columns, all
    other taps are 1."""

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
    """`get_motion_kernel2d` as a module: Motion blur kernel: a line through the centre of a square,
    which sums to 1. The horizontal line is rotated about the centre and resampled, like OpenCV's
    ``warpAffine`` with ``getRotationMatrix2D``. If two pixels across the line are equally near, neither
    is used."""

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
    """`get_motion_kernel3d` as a module: Motion blur kernel: a line through the centre of a cube, which
    sums to 1. The line along x is rotated about the centre by the rotation vector ``angle`` and
    resampled. If two voxels across the line are equally near, neither is used."""

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
    """`get_sobel_kernel2d` as a module: The 3x3 Sobel operators for d/dx and d/dy, not normalized."""

    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(self, device: Optional[torch.device] = None, dtype: torch.dtype = ...) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class GetSpatialGradientKernel2d(nn.Module):
    """`get_spatial_gradient_kernel2d` as a module: The kernels of ``spatial_gradient``, not
    normalized."""

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
    """`guided_blur` as a module: Smooth by local linear models of a guidance image: output = a .
    guidance + b."""

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
    """`in_range` as a module: Keep the pixels whose channels are all between two bounds, like OpenCV's
    ``inRange``. Other pixels become 0."""

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
    """`laplacian` as a module: Sum of the differences between a window's pixels and its centre pixel.
    This is the correlation with ``get_laplacian_kernel2d``. OpenCV's ``Laplacian`` uses other kernels.
    For uint8, the sums (not normalized) are int16."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    normalized: bool
    def __init__(
        self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect", normalized: bool = True
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Laplacian1d(nn.Module):
    """`laplacian_1d` as a module: Laplacian kernel: the centre is 1 - window_size, all other taps are
    1."""

    window_size: int
    device: Optional[torch.device]
    dtype: torch.dtype
    def __init__(
        self, window_size: int, device: Optional[torch.device] = None, dtype: torch.dtype = ...
    ) -> None: ...
    def forward(self) -> Tensor: ...
    def __call__(self) -> Tensor: ...

class MaxBlurPool2d(nn.Module):
    """`max_blur_pool2d` as a module: Max pooling with stride 1, then ``blur_pool2d``."""

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
    """`motion_blur3d` as a module: ``motion_blur`` for volumes."""

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
    """`non_local_means` as a module: Average over the pixels of a search window, weighted by the
    similarity of the patches around them."""

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
    """`otsu_threshold` as a module: Threshold each plane by Otsu's method; values that are not above the
    threshold become 0."""

    nbins: int
    slow_and_differentiable: bool
    return_mask: bool
    def __init__(
        self, nbins: int = 256, slow_and_differentiable: bool = False, return_mask: bool = False
    ) -> None: ...
    def forward(self, x: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, x: Tensor) -> Tuple[Tensor, Tensor]: ...

class PercentileFilter(nn.Module):
    """`percentile_filter` as a module: Replace each pixel by a percentile of its neighbourhood, like
    SciPy's ``percentile_filter``. For n pixels this is the value of rank floor(n * percentile / 100),
    without interpolation between ranks. The gradient goes to the selected element."""

    percentile: float
    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(
        self, percentile: float, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Prewitt(nn.Module):
    """`prewitt` as a module: Gradient magnitude by Prewitt's kernels, with the smoothing 1, 1, 1; the
    border is replicated."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class RankFilter(nn.Module):
    """`rank_filter` as a module: Replace each pixel by the value of a given rank in its neighbourhood,
    like SciPy's ``rank_filter``. A sorting network of minima and maxima selects the value. The gradient
    goes to the selected element; equal elements share it."""

    rank: int
    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(
        self, rank: int, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Roberts(nn.Module):
    """`roberts` as a module: Gradient magnitude by Roberts' cross, the two diagonal differences of each
    2x2 square."""

    normalized: bool
    eps: float
    def __init__(self, normalized: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Scharr(nn.Module):
    """`scharr` as a module: Gradient magnitude by Scharr's kernels, with the smoothing 3, 10, 3; the
    border is replicated. H. Scharr, Optimale Operatoren in der digitalen Bildverarbeitung, 2000. The
    magnitude is nearly independent of the edge direction."""

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
    """`unsharp_mask` as a module: Sharpen: add the difference between the image and its Gaussian
    blur."""

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
