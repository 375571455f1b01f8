"""Geometry of images and points."""

from . import calibration, camera, conversions, depth, epipolar, homography, linalg, solvers, subpix, transform

__all__ = ["calibration", "camera", "conversions", "depth", "epipolar", "homography", "linalg", "solvers", "subpix", "transform"]
