"""Ops that fit no other family."""

from ..primitives.twin import lazy_twins
from .connected_components import connected_components, connected_components_union_find
from .distance_transform import distance_transform, distance_transform_edt
from .histogram import histogram_matching, interp

__all__ = [
    "connected_components",
    "connected_components_union_find",
    "distance_transform",
    "distance_transform_edt",
    "histogram_matching",
    "interp",
]

__getattr__ = lazy_twins(__name__, globals())
