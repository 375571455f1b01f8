# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional, Tuple, Union

from torch import Tensor, nn

from .connected_components import connected_components as connected_components
from .connected_components import connected_components_union_find as connected_components_union_find
from .connected_components import connected_components_with_stats as connected_components_with_stats
from .diamond_square import diamond_square as diamond_square
from .distance_transform import distance_transform as distance_transform
from .distance_transform import distance_transform_edt as distance_transform_edt
from .histogram import histogram_matching as histogram_matching
from .histogram import interp as interp
from .image_stitcher import ImageStitcher as ImageStitcher
from .kmeans import KMeans as KMeans
from .kmeans import kmeans as kmeans
from .patches import combine_tensor_patches as combine_tensor_patches
from .patches import compute_padding as compute_padding
from .patches import extract_tensor_patches as extract_tensor_patches

class CombineTensorPatches(nn.Module):
    """`combine_tensor_patches` as a module: Combine windows into an image; each pixel is the mean over
    its windows. The inverse of `extract_tensor_patches`."""

    original_size: Union[int, Tuple[int, int]]
    window_size: Union[int, Tuple[int, int]]
    stride: Union[int, Tuple[int, int], None]
    unpadding: Union[int, Tuple[int, int], Tuple[int, int, int, int]]
    allow_auto_unpadding: bool
    eps: Optional[float]
    def __init__(
        self,
        original_size: Union[int, Tuple[int, int]],
        window_size: Union[int, Tuple[int, int]],
        stride: Union[int, Tuple[int, int], None] = None,
        unpadding: Union[int, Tuple[int, int], Tuple[int, int, int, int]] = 0,
        allow_auto_unpadding: bool = False,
        eps: Optional[float] = None,
    ) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

class ComputePadding(nn.Module):
    """`compute_padding` as a module: The padding by which the last windows end with the image, as
    ``allow_auto_padding`` adds it."""

    original_size: Union[int, Tuple[int, int]]
    window_size: Union[int, Tuple[int, int]]
    stride: Union[int, Tuple[int, int], None]
    def __init__(
        self,
        original_size: Union[int, Tuple[int, int]],
        window_size: Union[int, Tuple[int, int]],
        stride: Union[int, Tuple[int, int], None] = None,
    ) -> None: ...
    def forward(self) -> Tuple[int, int, int, int]: ...
    def __call__(self) -> Tuple[int, int, int, int]: ...

class ConnectedComponents(nn.Module):
    """`connected_components` as a module: Label the 8-connected components of a binary image. In Kornia,
    labels move by one pixel in each iteration. Here, trees of pixels are joined and flattened (see
    ``primitives.features.connected_components``), so that a spiral of one pixel width over a whole 1080p
    frame needs fewer than ten iterations. The loop ends when nothing changes."""

    num_iterations: int
    def __init__(self, num_iterations: int = 100) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class ConnectedComponentsUnionFind(nn.Module):
    """`connected_components_union_find` as a module: ``connected_components`` without a limit on the
    iterations."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class ConnectedComponentsWithStats(nn.Module):
    """`connected_components_with_stats` as a module: Label the 8-connected components of a binary image,
    and measure them, like OpenCV's ``connectedComponentsWithStats``: the same components, boxes, areas
    and centroids. Labels count from the background's, 0, in the order of the components' first pixels,
    row by row; OpenCV's order differs."""

    max_labels: int
    def __init__(self, max_labels: int = 256) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class DiamondSquare(nn.Module):
    """`diamond_square` as a module: Plasma noise by midpoint displacement: random heights on a coarse
    grid are refined step by step."""

    roughness: Union[float, Tensor]
    random_scale: Union[float, Tensor]
    normalize_range: Optional[Tuple[float, float]]
    def __init__(
        self,
        roughness: Union[float, Tensor] = 0.5,
        random_scale: Union[float, Tensor] = 1.0,
        normalize_range: Optional[Tuple[float, float]] = None,
    ) -> None: ...
    def forward(self, random: Tensor) -> Tensor: ...
    def __call__(self, random: Tensor) -> Tensor: ...

class DistanceTransform(nn.Module):
    """`distance_transform` as a module: Approximate distance to the nearest pixel or voxel of a shape,
    by convolutions."""

    kernel_size: int
    h: float
    def __init__(self, kernel_size: int = 3, h: float = 0.35) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class DistanceTransformEdt(nn.Module):
    """`distance_transform_edt` as a module: The Euclidean distance from each set pixel to the nearest
    unset one, like SciPy's ``distance_transform_edt``."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class ExtractTensorPatches(nn.Module):
    """`extract_tensor_patches` as a module: Cut an image into windows, row by row."""

    window_size: Union[int, Tuple[int, int]]
    stride: Union[int, Tuple[int, int]]
    padding: Union[int, Tuple[int, int], Tuple[int, int, int, int]]
    allow_auto_padding: bool
    def __init__(
        self,
        window_size: Union[int, Tuple[int, int]],
        stride: Union[int, Tuple[int, int]] = 1,
        padding: Union[int, Tuple[int, int], Tuple[int, int, int, int]] = 0,
        allow_auto_padding: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class HistogramMatching(nn.Module):
    """`histogram_matching` as a module: Change the levels of an image so that its histogram resembles
    that of another."""

    per_plane: bool
    def __init__(self, per_plane: bool = False) -> None: ...
    def forward(self, source: Tensor, template: Tensor) -> Tensor: ...
    def __call__(self, source: Tensor, template: Tensor) -> Tensor: ...

class Interp(nn.Module):
    """`interp` as a module: Piecewise linear interpolation through the points (xp, fp) at x, like
    ``numpy.interp``; constant beyond the ends, NaN at NaN."""
    def __init__(self) -> None: ...
    def forward(self, x: Tensor, xp: Tensor, fp: Tensor) -> Tensor: ...
    def __call__(self, x: Tensor, xp: Tensor, fp: Tensor) -> Tensor: ...

__all__ = [
    "CombineTensorPatches",
    "ComputePadding",
    "ConnectedComponents",
    "ConnectedComponentsUnionFind",
    "ConnectedComponentsWithStats",
    "DiamondSquare",
    "DistanceTransform",
    "DistanceTransformEdt",
    "ExtractTensorPatches",
    "HistogramMatching",
    "ImageStitcher",
    "Interp",
    "KMeans",
    "combine_tensor_patches",
    "compute_padding",
    "connected_components",
    "connected_components_union_find",
    "connected_components_with_stats",
    "diamond_square",
    "distance_transform",
    "distance_transform_edt",
    "extract_tensor_patches",
    "histogram_matching",
    "interp",
    "kmeans",
]
