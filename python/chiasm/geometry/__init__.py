"""Geometry of images and points."""

from . import bbox, conversions, grid, homography, lie, line, plane, quaternion, subpix, transform

__all__ = ["bbox", "conversions", "grid", "homography", "lie", "line", "plane", "quaternion", "subpix", "transform"]
