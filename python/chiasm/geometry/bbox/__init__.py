"""Boxes in images and volumes."""

from ...ops.suppression import nms
from .boxes import (
    bbox_generator,
    bbox_generator3d,
    bbox_to_mask,
    bbox_to_mask3d,
    infer_bbox_shape,
    infer_bbox_shape3d,
    is_bbox,
    is_bbox3d,
    transform_bbox,
    validate_bbox,
    validate_bbox3d,
)
from .suppression import nms_fixed

__all__ = [
    "bbox_generator",
    "bbox_generator3d",
    "bbox_to_mask",
    "bbox_to_mask3d",
    "infer_bbox_shape",
    "infer_bbox_shape3d",
    "is_bbox",
    "is_bbox3d",
    "nms",
    "nms_fixed",
    "transform_bbox",
    "validate_bbox",
    "validate_bbox3d",
]


def __dir__() -> list[str]:
    return __all__
