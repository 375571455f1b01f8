"""Geometry of images and points."""

from . import conversions, homography, subpix, transform

__all__ = ["conversions", "homography", "subpix", "transform"]
