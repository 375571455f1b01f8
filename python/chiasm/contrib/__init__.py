"""Ops that fit no other family."""

from ..primitives.core.modules import ModuleForm, lazy_modules
from .connected_components import (
    connected_components,
    connected_components_union_find,
    connected_components_with_stats,
)
from .diamond_square import diamond_square
from .distance_transform import distance_transform, distance_transform_edt
from .histogram import histogram_matching, interp
from .image_stitcher import ImageStitcher
from .kmeans import KMeans, kmeans
from .patches import combine_tensor_patches, compute_padding, extract_tensor_patches

__all__ = [
    "ImageStitcher",
    "KMeans",
    "combine_tensor_patches",
    "compute_padding",
    "connected_components",
    "connected_components_union_find",
    "connected_components_with_stats",
    "diamond_square",
    "distance_transform",
    "distance_transform_edt",
    "extract_tensor_patches",
    "histogram_matching",
    "interp",
    "kmeans",
]

_FORMS = {"combine_tensor_patches": ModuleForm(last=["allow_auto_unpadding", "eps"])}  # Kornia's order

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
