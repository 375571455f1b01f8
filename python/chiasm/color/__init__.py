"""Colour spaces."""

from .gray import RgbToGrayscale, rgb_to_grayscale
from .hsv import RgbToHsv, rgb_to_hsv
from .rgb import bgr_to_rgb

__all__ = ["RgbToGrayscale", "RgbToHsv", "bgr_to_rgb", "rgb_to_grayscale", "rgb_to_hsv"]
