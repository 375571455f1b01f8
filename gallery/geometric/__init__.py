"""Inputs that show geometry ops at work better than their spec's example inputs."""

from __future__ import annotations

from collections.abc import Callable

from torch import Tensor

from chiasm.export.spec import Spec

from .cameras import bent_photo, cameras, depths, lenses
from .motorcycle import stereo_pair
from .plane import lattice, planar, splines, whole_box
from .points import (
    affine_matrices,
    affine_pairs,
    bent_boxes,
    moved_points,
    one_turn,
    pixel_homographies,
    pixels_of,
    slerp,
    straight_boxes,
    tangents,
)
from .setting import Inputs, Setting, made_by
from .space import scale_space, solid, spatial, volume_sizes

__all__ = ["WARPED", "counts", "geometric", "lattice", "scale_space", "solid", "volume_sizes"]

#: By the beginning of an op's name, its sizes: the number of points, samples, boxes.
COUNTS = {
    "geometry.bbox": {"B": 4},
    "geometry.bbox.transform_bbox": {"B": 1, "N": 4},
    "geometry.calibration.distort_points": {"N": 15 * 12},
    "geometry.calibration.undistort_points": {"N": 15 * 12},
    "geometry.camera.cam2pixel": {"H": 12, "W": 16},
    "geometry.camera.distort_points": {"N": 15 * 12},
    "geometry.camera.pixel2cam": {"H": 12, "W": 16},
    "geometry.camera.undistort_points": {"N": 15 * 12},
    "geometry.conversions.convert_points": {"D": 2},
    "geometry.depth.unproject_meshgrid": {"H": 12, "W": 16},
    "geometry.depth.depth_from_plane": {"N": 15 * 12},
    "geometry.epipolar": {"N": 10},
    "geometry.epipolar.find_fundamental": {"N": 20},
    "geometry.epipolar.find_fundamental_7point": {"N": 1},
    "geometry.homography": {"N": 10},
    "geometry.homography.sample_is_valid": {"N": 3},
    "geometry.linalg": {"N": 12},
    "geometry.linalg.transform_points.plane": {"N": 9 * 9},
    "geometry.quaternion.quaternion_slerp": {"N": 3},
    "geometry.ransac.ransac_fundamental": {"P": 1, "N": 40, "S": 500},
    "geometry.solvers": {"N": 3, "K": 1},
    "geometry.solvers.find_affine": {"N": 24},
    "geometry.transform.warp_grid": {"H": 9, "W": 12},
    "geometry.transform.warp_grid3d": {"D": 4, "H": 5, "W": 6},
    "geometry.transform.warp_points_tps": {"N": 11 * 11},
}
#: Ops whose photographs get a lattice.
WARPED = tuple(
    f"geometry.{name}"
    for name in (
        "depth.depth_warp",
        "depth.warp_frame_depth",
        "transform.affine",
        "transform.crop_by_transform_mat",
        "transform.elastic",
        "transform.homography_warp",
        "transform.remap",
        "transform.rotate",
        "transform.scale",
        "transform.shear",
        "transform.translate",
        "transform.warp",
    )
)
#: By the beginning of an op's name; longer names take precedence.
MAKERS: dict[str, Callable[[Setting], Inputs]] = {
    "geometry.bbox.bbox_to_mask": straight_boxes,
    "geometry.bbox.infer_bbox": straight_boxes,
    "geometry.bbox.is_bbox": bent_boxes,
    "geometry.calibration.distort_points": lenses,
    "geometry.calibration.undistort_image": bent_photo,
    "geometry.calibration.undistort_points": lenses,
    "geometry.camera": cameras,
    "geometry.conversions.convert_affinematrix": affine_matrices,
    "geometry.conversions.denormalize_homography": pixel_homographies,
    "geometry.conversions.denormalize_pixel": pixels_of,
    "geometry.conversions.normalize_homography": pixel_homographies,
    "geometry.conversions.normalize_pixel": pixels_of,
    "geometry.depth": depths,
    "geometry.epipolar.find_fundamental": stereo_pair,
    "geometry.epipolar.scale_intrinsics": cameras,
    **{f"geometry.lie.{group}_vee": tangents for group in ("so2", "so3", "se2", "se3")},
    "geometry.linalg.transform_points": moved_points,
    "geometry.quaternion.quaternion_rotate": one_turn,
    "geometry.quaternion.quaternion_slerp": slerp,
    "geometry.ransac.ransac_fundamental": stereo_pair,
    "geometry.solvers.find_affine": affine_pairs,
    "geometry.transform": planar,
    "geometry.transform.crop_by_indices": whole_box,
    "geometry.transform.get_tps": splines,
    "geometry.transform.warp_image_tps": splines,
    "geometry.transform.warp_points_tps": splines,
    **{
        f"geometry.transform.{name}": spatial
        for name in (
            "affine3d",
            "center_crop3d",
            "crop_and_resize3d",
            "crop_by_boxes3d",
            "crop_by_transform_mat3d",
            "get_affine_matrix3d",
            "get_perspective_transform3d",
            "get_projective_transform",
            "get_shear_matrix3d",
            "homography_warp3d",
            "rotate3d",
            "warp_affine3d",
            "warp_grid3d",
            "warp_perspective3d",
        )
    },
}


def counts(spec: Spec) -> dict[str, int]:
    """An op's sizes in the table; longer names take precedence."""
    known = [name for name in COUNTS if spec.name.startswith(name)]
    return {symbol: size for name in sorted(known, key=len) for symbol, size in COUNTS[name].items()}


def geometric(spec: Spec, sizes: dict[str, int], rgb: Tensor) -> Inputs:
    """Inputs of an op, for those that replace the spec's example inputs."""
    return made_by(MAKERS, Setting(spec, sizes, rgb))
