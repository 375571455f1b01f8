"""Geometry of images and points."""

from . import (
    bbox,
    calibration,
    camera,
    conversions,
    depth,
    epipolar,
    grid,
    homography,
    lie,
    linalg,
    line,
    plane,
    quaternion,
    solvers,
    subpix,
    transfer_error,
    transform,
)

__all__ = ["bbox", "calibration", "camera", "conversions", "depth", "epipolar", "grid", "homography", "lie", "linalg", "line", "plane", "quaternion", "solvers", "subpix", "transfer_error", "transform"]
