"""Geometric image transforms."""

from ...primitives.twin import lazy_twins
from .affine import affine, rotate, scale, shear, translate, warp_affine
from .crop import center_crop, crop_and_resize, crop_by_boxes, crop_by_indices, crop_by_transform_mat
from .elastic import elastic_transform2d
from .flips import hflip, rot180, vflip
from .homography_warp import homography_warp, warp_grid
from .matrices import (
    get_affine_matrix2d,
    get_perspective_transform,
    get_rotation_matrix2d,
    get_shear_matrix2d,
    get_translation_matrix2d,
    invert_affine_transform,
    projection_from_Rt,
)
from .polar import warp_polar
from .pyramid import build_laplacian_pyramid, build_pyramid, pyrdown, pyrup
from .remap import remap
from .rescale import rescale, resize_to_be_divisible
from .resize import resize
from .warp import warp_perspective

__all__ = [
    "affine", "build_laplacian_pyramid", "build_pyramid", "center_crop", "crop_and_resize", "crop_by_boxes", "crop_by_indices",
    "crop_by_transform_mat", "elastic_transform2d", "get_affine_matrix2d", "get_perspective_transform", "get_rotation_matrix2d",
    "get_shear_matrix2d", "get_translation_matrix2d", "hflip", "homography_warp", "invert_affine_transform", "projection_from_Rt",
    "pyrdown", "pyrup", "remap", "rescale", "resize", "resize_to_be_divisible", "rot180", "rotate", "scale", "shear", "translate",
    "vflip", "warp_affine", "warp_grid", "warp_perspective", "warp_polar",
]

__getattr__ = lazy_twins(__name__, globals())
