"""What fits no other family."""

from .connected_components import connected_components, connected_components_union_find
from .distance_transform import distance_transform, distance_transform_edt

__all__ = [
    "connected_components",
    "connected_components_union_find",
    "distance_transform",
    "distance_transform_edt",
]
