"""Geometry of images and points."""

from . import calibration, camera, conversions, depth, homography, subpix, transform

__all__ = ["calibration", "camera", "conversions", "depth", "homography", "subpix", "transform"]
