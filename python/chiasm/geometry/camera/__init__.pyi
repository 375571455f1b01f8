# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional

from torch import Tensor, nn

from .affine import distort_points_affine as distort_points_affine
from .affine import dx_distort_points_affine as dx_distort_points_affine
from .affine import undistort_points_affine as undistort_points_affine
from .kannala_brandt import distort_points_kannala_brandt as distort_points_kannala_brandt
from .kannala_brandt import dx_distort_points_kannala_brandt as dx_distort_points_kannala_brandt
from .kannala_brandt import undistort_points_kannala_brandt as undistort_points_kannala_brandt
from .models import BrownConradyModel as BrownConradyModel
from .models import CameraModel as CameraModel
from .models import CameraModelBase as CameraModelBase
from .models import CameraModelType as CameraModelType
from .models import KannalaBrandtK3 as KannalaBrandtK3
from .models import Orthographic as Orthographic
from .models import PinholeModel as PinholeModel
from .pinhole import PinholeCamera as PinholeCamera
from .pinhole import cam2pixel as cam2pixel
from .pinhole import pixel2cam as pixel2cam
from .pinhole import project_points as project_points
from .pinhole import unproject_points as unproject_points
from .planes import dx_project_points_orthographic as dx_project_points_orthographic
from .planes import dx_project_points_z1 as dx_project_points_z1
from .planes import project_points_orthographic as project_points_orthographic
from .planes import project_points_z1 as project_points_z1
from .planes import unproject_points_orthographic as unproject_points_orthographic
from .planes import unproject_points_z1 as unproject_points_z1
from .stereo import StereoCamera as StereoCamera

class Cam2pixel(nn.Module):
    """`cam2pixel` as a module: Project points of one camera's frame to pixels of another camera."""

    eps: float
    def __init__(self, eps: float = 1e-12) -> None: ...
    def forward(self, cam_coords_src: Tensor, dst_proj_src: Tensor) -> Tensor: ...
    def __call__(self, cam_coords_src: Tensor, dst_proj_src: Tensor) -> Tensor: ...

class DistortPointsAffine(nn.Module):
    """`distort_points_affine` as a module: Pixels of points of the plane z = 1: (fx x + cx, fy y +
    cy)."""
    def __init__(self) -> None: ...
    def forward(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...

class DistortPointsKannalaBrandt(nn.Module):
    """`distort_points_kannala_brandt` as a module: Pixels at which a fisheye camera sees points of the
    plane z = 1."""
    def __init__(self) -> None: ...
    def forward(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...

class DxDistortPointsAffine(nn.Module):
    """`dx_distort_points_affine` as a module: Derivative of :func:`distort_points_affine` with respect
    to the point: diag(fx, fy)."""
    def __init__(self) -> None: ...
    def forward(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...

class DxDistortPointsKannalaBrandt(nn.Module):
    """`dx_distort_points_kannala_brandt` as a module: Derivative of
    :func:`distort_points_kannala_brandt` with respect to the point."""
    def __init__(self) -> None: ...
    def forward(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, projected_points_in_camera_z1_plane: Tensor, params: Tensor) -> Tensor: ...

class DxProjectPointsOrthographic(nn.Module):
    """`dx_project_points_orthographic` as a module: Derivative of the projected x with respect to x, and
    of the projected y with respect to y: ones."""
    def __init__(self) -> None: ...
    def forward(self, points_in_camera: Tensor) -> Tensor: ...
    def __call__(self, points_in_camera: Tensor) -> Tensor: ...

class DxProjectPointsZ1(nn.Module):
    """`dx_project_points_z1` as a module: Derivative of :func:`project_points_z1` with respect to the
    point."""
    def __init__(self) -> None: ...
    def forward(self, points_in_camera: Tensor) -> Tensor: ...
    def __call__(self, points_in_camera: Tensor) -> Tensor: ...

class Pixel2cam(nn.Module):
    """`pixel2cam` as a module: Points in a camera's frame from pixels and depths."""
    def __init__(self) -> None: ...
    def forward(self, depth: Tensor, intrinsics_inv: Tensor, pixel_coords: Tensor) -> Tensor: ...
    def __call__(self, depth: Tensor, intrinsics_inv: Tensor, pixel_coords: Tensor) -> Tensor: ...

class ProjectPoints(nn.Module):
    """`project_points` as a module: Project points in a camera's frame to pixels: (fx x / z + cx, fy y /
    z + cy)."""
    def __init__(self) -> None: ...
    def forward(self, point_3d: Tensor, camera_matrix: Tensor) -> Tensor: ...
    def __call__(self, point_3d: Tensor, camera_matrix: Tensor) -> Tensor: ...

class ProjectPointsOrthographic(nn.Module):
    """`project_points_orthographic` as a module: Project points along the z axis: (x, y)."""
    def __init__(self) -> None: ...
    def forward(self, points_in_camera: Tensor) -> Tensor: ...
    def __call__(self, points_in_camera: Tensor) -> Tensor: ...

class ProjectPointsZ1(nn.Module):
    """`project_points_z1` as a module: Project points onto the plane z = 1: (x / z, y / z)."""
    def __init__(self) -> None: ...
    def forward(self, points_in_camera: Tensor) -> Tensor: ...
    def __call__(self, points_in_camera: Tensor) -> Tensor: ...

class UndistortPointsAffine(nn.Module):
    """`undistort_points_affine` as a module: Points of the plane z = 1 from pixels; the inverse of
    :func:`distort_points_affine`."""
    def __init__(self) -> None: ...
    def forward(self, distorted_points_in_camera: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, distorted_points_in_camera: Tensor, params: Tensor) -> Tensor: ...

class UndistortPointsKannalaBrandt(nn.Module):
    """`undistort_points_kannala_brandt` as a module: Points of the plane z = 1 that a fisheye camera
    sees at given pixels. The inverse of :func:`distort_points_kannala_brandt`. The angle is computed by
    Newton's method; its last step carries the gradient."""

    num_iters: int
    def __init__(self, num_iters: int = 10) -> None: ...
    def forward(self, distorted_points_in_camera: Tensor, params: Tensor) -> Tensor: ...
    def __call__(self, distorted_points_in_camera: Tensor, params: Tensor) -> Tensor: ...

class UnprojectPoints(nn.Module):
    """`unproject_points` as a module: Points in a camera's frame from pixels and depths; the inverse of
    :func:`project_points`."""

    normalize: bool
    def __init__(self, normalize: bool = False) -> None: ...
    def forward(self, point_2d: Tensor, depth: Tensor, camera_matrix: Tensor) -> Tensor: ...
    def __call__(self, point_2d: Tensor, depth: Tensor, camera_matrix: Tensor) -> Tensor: ...

class UnprojectPointsOrthographic(nn.Module):
    """`unproject_points_orthographic` as a module: Points at given depths behind points of an
    orthographic image: (x, y, z)."""
    def __init__(self) -> None: ...
    def forward(self, points_in_camera: Tensor, extension: Tensor) -> Tensor: ...
    def __call__(self, points_in_camera: Tensor, extension: Tensor) -> Tensor: ...

class UnprojectPointsZ1(nn.Module):
    """`unproject_points_z1` as a module: Points at given depths on the rays through points of the plane
    z = 1: (x z, y z, z)."""

    extension: Optional[Tensor]
    def __init__(self, extension: Optional[Tensor] = None) -> None: ...
    def forward(self, points_in_cam_canonical: Tensor) -> Tensor: ...
    def __call__(self, points_in_cam_canonical: Tensor) -> Tensor: ...

__all__ = [
    "BrownConradyModel",
    "Cam2pixel",
    "CameraModel",
    "CameraModelBase",
    "CameraModelType",
    "DistortPointsAffine",
    "DistortPointsKannalaBrandt",
    "DxDistortPointsAffine",
    "DxDistortPointsKannalaBrandt",
    "DxProjectPointsOrthographic",
    "DxProjectPointsZ1",
    "KannalaBrandtK3",
    "Orthographic",
    "PinholeCamera",
    "PinholeModel",
    "Pixel2cam",
    "ProjectPoints",
    "ProjectPointsOrthographic",
    "ProjectPointsZ1",
    "StereoCamera",
    "UndistortPointsAffine",
    "UndistortPointsKannalaBrandt",
    "UnprojectPoints",
    "UnprojectPointsOrthographic",
    "UnprojectPointsZ1",
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
