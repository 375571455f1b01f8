"""Image quality."""

from ..primitives.twin import lazy_twins
from .ssim import ssim

__all__ = ["ssim"]

__getattr__ = lazy_twins(__name__, globals())
