"""Geometric image transforms."""

from .resize import Resize, resize
from .warp import warp_perspective

__all__ = ["Resize", "resize", "warp_perspective"]
