"""Geometry of images and points."""

from . import conversions, homography, linalg, solvers, subpix, transform

__all__ = ["conversions", "homography", "linalg", "solvers", "subpix", "transform"]
