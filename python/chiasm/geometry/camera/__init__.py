"""Camera models: between points in a camera's frame, the plane z = 1 in front of it, and pixels."""

from ...primitives.core.modules import lazy_modules
from .affine import distort_points_affine, dx_distort_points_affine, undistort_points_affine
from .kannala_brandt import (
    distort_points_kannala_brandt,
    dx_distort_points_kannala_brandt,
    undistort_points_kannala_brandt,
)
from .models import (
    BrownConradyModel,
    CameraModel,
    CameraModelBase,
    CameraModelType,
    KannalaBrandtK3,
    Orthographic,
    PinholeModel,
)
from .pinhole import PinholeCamera, cam2pixel, pixel2cam, project_points, unproject_points
from .planes import (
    dx_project_points_orthographic,
    dx_project_points_z1,
    project_points_orthographic,
    project_points_z1,
    unproject_points_orthographic,
    unproject_points_z1,
)
from .stereo import StereoCamera

__all__ = [
    "BrownConradyModel",
    "CameraModel",
    "CameraModelBase",
    "CameraModelType",
    "KannalaBrandtK3",
    "Orthographic",
    "PinholeCamera",
    "PinholeModel",
    "StereoCamera",
    "cam2pixel",
    "distort_points_affine",
    "distort_points_kannala_brandt",
    "dx_distort_points_affine",
    "dx_distort_points_kannala_brandt",
    "dx_project_points_orthographic",
    "dx_project_points_z1",
    "pixel2cam",
    "project_points",
    "project_points_orthographic",
    "project_points_z1",
    "undistort_points_affine",
    "undistort_points_kannala_brandt",
    "unproject_points",
    "unproject_points_orthographic",
    "unproject_points_z1",
]

__getattr__, __dir__ = lazy_modules(__name__, globals())
