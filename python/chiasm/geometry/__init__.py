"""Geometry of images and points. The names of its modules are also names of the package: `resize` of
`transform` is `geometry.resize`."""

from typing import Any

from . import (
    bbox,
    boxes,
    calibration,
    camera,
    conversions,
    depth,
    epipolar,
    grid,
    homography,
    keypoints,
    lie,
    liegroup,
    linalg,
    line,
    plane,
    pnp,
    pose,
    quaternion,
    ransac,
    registration,
    solvers,
    stereo,
    subpix,
    transform,
    vector,
)
from .epipolar import generate_scene as generate_scene
from .epipolar import random_intrinsics as random_intrinsics

__all__ = [
    "bbox",
    "boxes",
    "calibration",
    "camera",
    "conversions",
    "depth",
    "epipolar",
    "grid",
    "homography",
    "keypoints",
    "lie",
    "liegroup",
    "linalg",
    "line",
    "plane",
    "pnp",
    "pose",
    "quaternion",
    "ransac",
    "registration",
    "solvers",
    "stereo",
    "subpix",
    "transform",
    "vector",
]


#: The modules whose names the package has too.
_FLAT = [globals()[name] for name in __all__]


def __getattr__(name: str) -> Any:
    """A public name of one of the modules, as Kornia's users write it."""
    for module in _FLAT:
        if name in dir(module):
            return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
