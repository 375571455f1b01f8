# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional, Tuple, Union

from torch import Tensor, nn

from .heatmaps import render_gaussian2d as render_gaussian2d
from .heatmaps import spatial_expectation2d as spatial_expectation2d
from .heatmaps import spatial_soft_argmax2d as spatial_soft_argmax2d
from .heatmaps import spatial_softmax2d as spatial_softmax2d
from .modules import NonMaximaSuppression2d as NonMaximaSuppression2d
from .modules import NonMaximaSuppression3d as NonMaximaSuppression3d
from .quadratic import conv_quad_interp3d as conv_quad_interp3d
from .quadratic import iterative_quad_interp3d as iterative_quad_interp3d
from .suppression import nms2d as nms2d
from .suppression import nms3d as nms3d
from .suppression import nms3d_minmax as nms3d_minmax
from .windows import conv_soft_argmax2d as conv_soft_argmax2d
from .windows import conv_soft_argmax3d as conv_soft_argmax3d

class ConvQuadInterp3d(nn.Module):
    """`conv_quad_interp3d` as a module: Refine the strict maxima of volumes like
    ``iterative_quad_interp3d``, but only within their neighbourhood."""

    n_iters: int
    strict_maxima_bonus: Optional[float]
    max_subpixel_shift: float
    dilation_radius: int
    allow_scale_steps: bool
    precomputed_nms_mask: Optional[Tensor]
    def __init__(
        self,
        n_iters: int = 5,
        strict_maxima_bonus: Optional[float] = None,
        max_subpixel_shift: float = 0.6,
        dilation_radius: int = 1,
        allow_scale_steps: bool = True,
        precomputed_nms_mask: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...

class ConvSoftArgmax2d(nn.Module):
    """`conv_soft_argmax2d` as a module: The mean position of each window under the softmax over its
    pixels, and the mean value."""

    kernel_size: Tuple[int, int]
    stride: Tuple[int, int]
    padding: Tuple[int, int]
    temperature: Union[Tensor, float]
    normalized_coordinates: bool
    eps: float
    output_value: bool
    def __init__(
        self,
        kernel_size: Tuple[int, int] = (3, 3),
        stride: Tuple[int, int] = (1, 1),
        padding: Tuple[int, int] = (1, 1),
        temperature: Union[Tensor, float] = 1.0,
        normalized_coordinates: bool = True,
        eps: float = 1e-08,
        output_value: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Union[Tensor, Tuple[Tensor, Tensor]]: ...
    def __call__(self, input: Tensor) -> Union[Tensor, Tuple[Tensor, Tensor]]: ...

class ConvSoftArgmax3d(nn.Module):
    """`conv_soft_argmax3d` as a module: The mean position of each window of a volume under the softmax
    over its voxels, and the mean value."""

    kernel_size: Tuple[int, int, int]
    stride: Tuple[int, int, int]
    padding: Tuple[int, int, int]
    temperature: Union[Tensor, float]
    normalized_coordinates: bool
    eps: float
    output_value: bool
    strict_maxima_bonus: Optional[float]
    def __init__(
        self,
        kernel_size: Tuple[int, int, int] = (3, 3, 3),
        stride: Tuple[int, int, int] = (1, 1, 1),
        padding: Tuple[int, int, int] = (1, 1, 1),
        temperature: Union[Tensor, float] = 1.0,
        normalized_coordinates: bool = False,
        eps: float = 1e-08,
        output_value: bool = True,
        strict_maxima_bonus: Optional[float] = None,
    ) -> None: ...
    def forward(self, input: Tensor) -> Union[Tensor, Tuple[Tensor, Tensor]]: ...
    def __call__(self, input: Tensor) -> Union[Tensor, Tuple[Tensor, Tensor]]: ...

class IterativeQuadInterp3d(nn.Module):
    """`iterative_quad_interp3d` as a module: Refine the strict maxima of volumes to a fraction of a
    voxel."""

    n_iters: int
    strict_maxima_bonus: Optional[float]
    max_subpixel_shift: float
    allow_scale_steps: bool
    max_candidates: Optional[int]
    precomputed_nms_mask: Optional[Tensor]
    def __init__(
        self,
        n_iters: int = 5,
        strict_maxima_bonus: Optional[float] = None,
        max_subpixel_shift: float = 0.6,
        allow_scale_steps: bool = True,
        max_candidates: Optional[int] = None,
        precomputed_nms_mask: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...

class Nms2d(nn.Module):
    """`nms2d` as a module: Keep strict local maxima and set all other pixels to zero. A pixel is kept if
    it exceeds every other pixel of the window around it and the window lies inside the image: pixels
    near the border are never kept. A window of k pixels reaches (k - 1) // 2 before its centre and k //
    2 after it."""

    kernel_size: Union[int, Tuple[int, int]]
    mask_only: bool
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], mask_only: bool = False) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Nms3d(nn.Module):
    """`nms3d` as a module: ``nms2d`` for volumes. A voxel is kept if it exceeds every other voxel of the
    window around it and the window lies inside the volume: voxels near the border are never kept. A
    window of k voxels reaches (k - 1) // 2 before its centre and k // 2 after it."""

    kernel_size: Union[int, Tuple[int, int, int]]
    mask_only: bool
    def __init__(self, kernel_size: Union[int, Tuple[int, int, int]], mask_only: bool = False) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Nms3dMinmax(nn.Module):
    """`nms3d_minmax` as a module: Masks of the strict maxima and minima of 3x3x3 neighbourhoods, by the
    rules of ``nms3d``."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor]: ...

class RenderGaussian2d(nn.Module):
    """`render_gaussian2d` as a module: Images of normal distributions with independent x and y; each
    image sums to 1. Each axis sums to 1 over the pixels. So a mean outside the image gives the part
    inside the image, scaled up; if the mean is far outside, this part is at the nearest border."""

    size: Tuple[int, int]
    normalized_coordinates: bool
    def __init__(self, size: Tuple[int, int], normalized_coordinates: bool = True) -> None: ...
    def forward(self, mean: Tensor, std: Tensor) -> Tensor: ...
    def __call__(self, mean: Tensor, std: Tensor) -> Tensor: ...

class SpatialExpectation2d(nn.Module):
    """`spatial_expectation2d` as a module: The mean position of each channel, weighted by its values."""

    normalized_coordinates: bool
    def __init__(self, normalized_coordinates: bool = True) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class SpatialSoftArgmax2d(nn.Module):
    """`spatial_soft_argmax2d` as a module: The mean position of each channel under the softmax over its
    pixels: ``spatial_expectation2d`` of ``spatial_softmax2d``."""

    temperature: Union[float, Tensor, None]
    normalized_coordinates: bool
    def __init__(
        self, temperature: Union[float, Tensor, None] = None, normalized_coordinates: bool = True
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class SpatialSoftmax2d(nn.Module):
    """`spatial_softmax2d` as a module: The softmax of each channel over its pixels: exp(v /
    temperature), divided by its sum."""

    temperature: Union[float, Tensor, None]
    def __init__(self, temperature: Union[float, Tensor, None] = None) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

__all__ = [
    "ConvQuadInterp3d",
    "ConvSoftArgmax2d",
    "ConvSoftArgmax3d",
    "IterativeQuadInterp3d",
    "Nms2d",
    "Nms3d",
    "Nms3dMinmax",
    "NonMaximaSuppression2d",
    "NonMaximaSuppression3d",
    "RenderGaussian2d",
    "SpatialExpectation2d",
    "SpatialSoftArgmax2d",
    "SpatialSoftmax2d",
    "conv_quad_interp3d",
    "conv_soft_argmax2d",
    "conv_soft_argmax3d",
    "iterative_quad_interp3d",
    "nms2d",
    "nms3d",
    "nms3d_minmax",
    "render_gaussian2d",
    "spatial_expectation2d",
    "spatial_soft_argmax2d",
    "spatial_softmax2d",
]
