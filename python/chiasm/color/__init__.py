"""Colour spaces."""

from ..primitives.twin import lazy_twins
from .gray import rgb_to_grayscale
from .hsv import rgb_to_hsv
from .rgb import bgr_to_rgb

__all__ = ["bgr_to_rgb", "rgb_to_grayscale", "rgb_to_hsv"]

__getattr__ = lazy_twins(__name__, globals())
