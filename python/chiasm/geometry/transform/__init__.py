"""Geometric image transforms."""

from ...primitives.core.modules import ModuleForm, lazy_modules
from .affine import Affine, affine, rotate, scale, shear, translate, warp_affine
from .border import copy_make_border
from .crop import (
    CenterCrop2D,
    center_crop,
    crop_and_resize,
    crop_by_boxes,
    crop_by_indices,
    crop_by_transform_mat,
)
from .crop3d import center_crop3d, crop_and_resize3d, crop_by_boxes3d
from .elastic import elastic_transform2d
from .flips import hflip, rot180, transpose, vflip
from .homography_warp import HomographyWarper, homography_warp, warp_grid
from .matrices import (
    get_affine_matrix2d,
    get_perspective_transform,
    get_rotation_matrix2d,
    get_shear_matrix2d,
    get_translation_matrix2d,
    invert_affine_transform,
    projection_from_Rt,
)
from .matrices3d import (
    get_affine_matrix3d,
    get_perspective_transform3d,
    get_projective_transform,
    get_shear_matrix3d,
)
from .polar import warp_polar
from .pyramid import ScalePyramid, build_laplacian_pyramid, build_pyramid, pyrdown, pyrup
from .registrator import Homography, ImageRegistrator, Similarity
from .remap import remap
from .rescale import rescale, resize_to_be_divisible
from .resize import resize
from .thin_plate import get_tps_transform, warp_image_tps, warp_points_tps
from .volume import (
    affine3d,
    crop_by_transform_mat3d,
    homography_warp3d,
    rotate3d,
    warp_affine3d,
    warp_grid3d,
    warp_perspective3d,
)
from .warp import warp_perspective

__all__ = [
    "Affine",
    "CenterCrop2D",
    "Homography",
    "HomographyWarper",
    "ImageRegistrator",
    "ScalePyramid",
    "Similarity",
    "affine",
    "affine3d",
    "build_laplacian_pyramid",
    "build_pyramid",
    "center_crop",
    "center_crop3d",
    "copy_make_border",
    "crop_and_resize",
    "crop_and_resize3d",
    "crop_by_boxes",
    "crop_by_boxes3d",
    "crop_by_indices",
    "crop_by_transform_mat",
    "crop_by_transform_mat3d",
    "elastic_transform2d",
    "get_affine_matrix2d",
    "get_affine_matrix3d",
    "get_perspective_transform",
    "get_perspective_transform3d",
    "get_projective_transform",
    "get_rotation_matrix2d",
    "get_shear_matrix2d",
    "get_shear_matrix3d",
    "get_tps_transform",
    "get_translation_matrix2d",
    "hflip",
    "homography_warp",
    "homography_warp3d",
    "invert_affine_transform",
    "projection_from_Rt",
    "pyrdown",
    "pyrup",
    "remap",
    "rescale",
    "resize",
    "resize_to_be_divisible",
    "rot180",
    "rotate",
    "rotate3d",
    "scale",
    "shear",
    "translate",
    "transpose",
    "vflip",
    "warp_affine",
    "warp_affine3d",
    "warp_grid",
    "warp_grid3d",
    "warp_image_tps",
    "warp_perspective",
    "warp_perspective3d",
    "warp_points_tps",
    "warp_polar",
]

# Modules as in Kornia: they move every image in the same way, and some defaults differ from the functions.
_FORMS = {
    "rescale": ModuleForm(defaults={"align_corners": True}),
    "rotate": ModuleForm(held=["angle"]),
    "scale": ModuleForm(held=["scale_factor"]),
    "shear": ModuleForm(held=["shear"], defaults={"align_corners": True}),
    "translate": ModuleForm(held=["translation"]),
}

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
