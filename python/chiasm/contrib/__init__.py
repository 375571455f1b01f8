"""Ops that fit no other family."""

from ..primitives.twin import lazy_twins
from .histogram import histogram_matching, interp

__all__ = [
    "histogram_matching",
    "interp",
]

__getattr__ = lazy_twins(__name__, globals())
