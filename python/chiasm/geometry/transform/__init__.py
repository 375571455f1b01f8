"""Geometric image transforms."""

from ...primitives.twin import lazy_twins
from .resize import resize
from .warp import warp_perspective

__all__ = ["resize", "warp_perspective"]

__getattr__ = lazy_twins(__name__, globals())
