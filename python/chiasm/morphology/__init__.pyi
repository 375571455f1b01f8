# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

from torch import Tensor, nn

from .dilation import dilation as dilation
from .erosion import erosion as erosion
from .flat import max_filter2d as max_filter2d
from .flat import min_filter2d as min_filter2d
from .hit_or_miss import hit_or_miss as hit_or_miss
from .opening import bottom_hat as bottom_hat
from .opening import closing as closing
from .opening import gradient as gradient
from .opening import opening as opening
from .opening import top_hat as top_hat
from .reconstruction import reconstruction as reconstruction
from .thinning import skeletonize as skeletonize
from .thinning import thin as thin

class BottomHat(nn.Module):
    """`bottom_hat` as a module: Bottom hat: closing - tensor, the dark details that the closing fills.
    Like SciPy's ``black_tophat``."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class Closing(nn.Module):
    """`closing` as a module: Close: dilation, then erosion, which removes dark details smaller than the
    element. Like SciPy's ``grey_closing``. The dilation counts the origin from the element's other end,
    so that the result is never below tensor for any origin."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class Dilation(nn.Module):
    """`dilation` as a module: Dilate: out(p) = max over the kernel's nonzero offsets b of tensor(p - b)
    + height(b)."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class Erosion(nn.Module):
    """`erosion` as a module: Erode: out(p) = min over the kernel's nonzero offsets b of tensor(p + b) -
    height(b)."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class Gradient(nn.Module):
    """`gradient` as a module: Morphological gradient: dilation minus erosion, bright along edges. Like
    SciPy's ``morphological_gradient`` for centred elements of odd size."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class HitOrMiss(nn.Module):
    """`hit_or_miss` as a module: Find a pattern: 1 where all pixels under ``hit`` are set and no pixel
    under ``miss`` is set."""

    miss: Optional[Tensor]
    def __init__(self, miss: Optional[Tensor] = None) -> None: ...
    def forward(self, input: Tensor, hit: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, hit: Tensor) -> Tensor: ...

class MaxFilter2d(nn.Module):
    """`max_filter2d` as a module: The largest value in a rectangle around each pixel: dilation by a flat
    rectangle, in two passes."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate") -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class MinFilter2d(nn.Module):
    """`min_filter2d` as a module: The smallest value in a rectangle around each pixel: erosion by a flat
    rectangle, in two passes."""

    kernel_size: Union[int, Tuple[int, int]]
    border_type: str
    def __init__(self, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate") -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Opening(nn.Module):
    """`opening` as a module: Open: erosion, then dilation, which removes bright details smaller than the
    element. Like SciPy's ``grey_opening``. The dilation counts the origin from the element's other end,
    so that the result never exceeds tensor for any origin."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

class Reconstruction(nn.Module):
    """`reconstruction` as a module: Dilate a seed image repeatedly, limited by a mask image, until
    nothing changes."""

    kernel: Optional[Tensor]
    method: str
    num_iters: Optional[int]
    def __init__(
        self, kernel: Optional[Tensor] = None, method: str = "dilation", num_iters: Optional[int] = None
    ) -> None: ...
    def forward(self, seed: Tensor, mask: Tensor) -> Tensor: ...
    def __call__(self, seed: Tensor, mask: Tensor) -> Tensor: ...

class Skeletonize(nn.Module):
    """`skeletonize` as a module: Thin shapes to lines one pixel wide, by peeling their outlines until
    nothing changes."""

    num_iters: int
    def __init__(self, num_iters: int = 10000) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Thin(nn.Module):
    """`thin` as a module: Thin shapes to lines one pixel wide, keeping every connected shape."""

    num_iters: int
    def __init__(self, num_iters: int = 10000) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class TopHat(nn.Module):
    """`top_hat` as a module: Top hat: tensor - opening, the bright details that the opening removes.
    Like SciPy's ``white_tophat``."""

    structuring_element: Optional[Tensor]
    origin: Optional[List[int]]
    border_type: str
    border_value: float
    max_val: float
    engine: str
    def __init__(
        self,
        structuring_element: Optional[Tensor] = None,
        origin: Optional[List[int]] = None,
        border_type: str = "geodesic",
        border_value: float = 0.0,
        max_val: float = 10000.0,
        engine: str = "auto",
    ) -> None: ...
    def forward(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, kernel: Tensor) -> Tensor: ...

__all__ = [
    "BottomHat",
    "Closing",
    "Dilation",
    "Erosion",
    "Gradient",
    "HitOrMiss",
    "MaxFilter2d",
    "MinFilter2d",
    "Opening",
    "Reconstruction",
    "Skeletonize",
    "Thin",
    "TopHat",
    "bottom_hat",
    "closing",
    "dilation",
    "erosion",
    "gradient",
    "hit_or_miss",
    "max_filter2d",
    "min_filter2d",
    "opening",
    "reconstruction",
    "skeletonize",
    "thin",
    "top_hat",
]
