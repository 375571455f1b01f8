"""Mathematical morphology."""

from ..primitives.twin import lazy_twins
from .dilation import dilation

__all__ = ["dilation"]

__getattr__ = lazy_twins(__name__, globals())
