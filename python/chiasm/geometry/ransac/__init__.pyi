# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional, Tuple

from torch import Tensor, nn

from .essential import ransac_essential as ransac_essential
from .estimator import RANSAC as RANSAC
from .fundamental import ransac_fundamental as ransac_fundamental
from .homography import ransac_homography as ransac_homography

class RansacEssential(nn.Module):
    """`ransac_essential` as a module: Essential matrix from five or more correspondences with
    outliers."""

    inl_th: float
    refinements: int
    def __init__(self, inl_th: float = 1.0, refinements: int = 5) -> None: ...
    def forward(
        self, points1: Tensor, points2: Tensor, K1: Tensor, K2: Tensor, uniforms: Tensor
    ) -> Tuple[Tensor, Tensor]: ...
    def __call__(
        self, points1: Tensor, points2: Tensor, K1: Tensor, K2: Tensor, uniforms: Tensor
    ) -> Tuple[Tensor, Tensor]: ...

class RansacFundamental(nn.Module):
    """`ransac_fundamental` as a module: Fundamental matrix from eight or more correspondences with
    outliers."""

    inl_th: float
    refinements: int
    def __init__(self, inl_th: float = 1.0, refinements: int = 3) -> None: ...
    def forward(self, points1: Tensor, points2: Tensor, uniforms: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points1: Tensor, points2: Tensor, uniforms: Tensor) -> Tuple[Tensor, Tensor]: ...

class RansacHomography(nn.Module):
    """`ransac_homography` as a module: Homography from four or more correspondences with outliers."""

    inl_th: float
    refinements: int
    mask: Optional[Tensor]
    def __init__(self, inl_th: float = 3.0, refinements: int = 3, mask: Optional[Tensor] = None) -> None: ...
    def forward(self, points1: Tensor, points2: Tensor, uniforms: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points1: Tensor, points2: Tensor, uniforms: Tensor) -> Tuple[Tensor, Tensor]: ...

__all__ = [
    "RANSAC",
    "RansacEssential",
    "RansacFundamental",
    "RansacHomography",
    "ransac_essential",
    "ransac_fundamental",
    "ransac_homography",
]
