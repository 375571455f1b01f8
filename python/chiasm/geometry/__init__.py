"""Geometry of images and points."""

from . import bbox, conversions, grid, homography, lie, linalg, line, plane, quaternion, solvers, subpix, transform

__all__ = ["bbox", "conversions", "grid", "homography", "lie", "linalg", "line", "plane", "quaternion", "solvers", "subpix", "transform"]
