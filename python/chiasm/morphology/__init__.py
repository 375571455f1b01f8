"""Mathematical morphology."""

from ..primitives.core.modules import lazy_modules
from .dilation import dilation
from .erosion import erosion
from .flat import max_filter2d, min_filter2d
from .hit_or_miss import hit_or_miss
from .opening import bottom_hat, closing, gradient, opening, top_hat
from .reconstruction import reconstruction
from .thinning import skeletonize, thin

__all__ = [
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

__getattr__, __dir__ = lazy_modules(__name__, globals())
