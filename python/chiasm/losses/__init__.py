"""Losses."""

from ..primitives.twin import lazy_twins
from .ssim import ssim_loss

__all__ = ["ssim_loss"]

__getattr__ = lazy_twins(__name__, globals())
