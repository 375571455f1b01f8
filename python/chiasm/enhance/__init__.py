"""Intensity transforms."""

from ..primitives.twin import lazy_twins
from .normalize import normalize

__all__ = ["normalize"]

__getattr__ = lazy_twins(__name__, globals())
