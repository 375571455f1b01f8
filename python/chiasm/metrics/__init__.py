"""Image quality."""

from ..primitives.twin import lazy_twins
from .psnr import psnr
from .ssim import ssim, ssim3d

__all__ = ["psnr", "ssim", "ssim3d"]

__getattr__ = lazy_twins(__name__, globals())
