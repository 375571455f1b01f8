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
    pnp,
    quaternion,
    ransac,
    registration,
    solvers,
    stereo,
    subpix,
    transform,
)

__all__ = [
    "bbox",
    "calibration",
    "camera",
    "conversions",
    "depth",
    "epipolar",
    "grid",
    "homography",
    "lie",
    "linalg",
    "line",
    "plane",
    "pnp",
    "quaternion",
    "ransac",
    "registration",
    "solvers",
    "stereo",
    "subpix",
    "transform",
]


def __dir__() -> list[str]:
    return __all__
