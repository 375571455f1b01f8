"""Epipolar geometry: two views of points in space."""

from ...primitives.core.modules import lazy_modules
from .essential import (
    decompose_essential_matrix,
    decompose_essential_matrix_no_svd,
    essential_from_fundamental,
    essential_from_Rt,
    motion_from_essential,
    motion_from_essential_choose_solution,
    project_to_essential,
    relative_camera_motion,
)
from .five_point import find_essential, find_essential_5point
from .fundamental import (
    find_fundamental,
    find_fundamental_7point,
    fundamental_from_essential,
    fundamental_from_projections,
    normalize_points,
    normalize_transformation,
)
from .lines import (
    compute_correspond_epilines,
    cross_product_matrix,
    get_closest_point_on_epipolar_line,
    get_perpendicular,
)
from .metrics import (
    left_to_right_epipolar_distance,
    right_to_left_epipolar_distance,
    sampson_epipolar_distance,
    symmetrical_epipolar_distance,
)
from .projection import (
    KRt_from_projection,
    depth_from_point,
    intrinsics_like,
    projection_from_KRt,
    projections_from_fundamental,
    scale_intrinsics,
)
from .scene import generate_scene as generate_scene
from .scene import random_intrinsics as random_intrinsics
from .triangulation import triangulate_points

__all__ = [
    "KRt_from_projection",
    "compute_correspond_epilines",
    "cross_product_matrix",
    "decompose_essential_matrix",
    "decompose_essential_matrix_no_svd",
    "depth_from_point",
    "essential_from_Rt",
    "essential_from_fundamental",
    "find_essential",
    "find_essential_5point",
    "find_fundamental",
    "find_fundamental_7point",
    "fundamental_from_essential",
    "fundamental_from_projections",
    "get_closest_point_on_epipolar_line",
    "get_perpendicular",
    "intrinsics_like",
    "left_to_right_epipolar_distance",
    "motion_from_essential",
    "motion_from_essential_choose_solution",
    "normalize_points",
    "normalize_transformation",
    "project_to_essential",
    "projection_from_KRt",
    "projections_from_fundamental",
    "relative_camera_motion",
    "right_to_left_epipolar_distance",
    "sampson_epipolar_distance",
    "scale_intrinsics",
    "symmetrical_epipolar_distance",
    "triangulate_points",
]

__getattr__, __dir__ = lazy_modules(__name__, globals())
