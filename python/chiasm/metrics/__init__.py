"""Image quality."""

from .ssim import ssim

__all__ = ["ssim"]
