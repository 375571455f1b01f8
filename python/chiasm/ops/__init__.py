"""Postprocessing of networks: the box functions of torchvision.ops, non-maximum suppression with a fixed
number of slots, decoders, trackers."""

from ..primitives.core.modules import lazy_modules
from .assignment import linear_assignment
from .boxes import (
    box_area,
    box_convert,
    box_iou,
    clip_boxes_to_image,
    complete_box_iou,
    distance_box_iou,
    generalized_box_iou,
    remove_small_boxes,
)
from .ctc import ctc_beam_decode, ctc_greedy_decode
from .decoding import decode_detr, decode_yolov5, decode_yolov8
from .deformable import deform_conv2d
from .kalman import kalman_predict, kalman_update
from .keypoints import decode_heatmaps, decode_simcc
from .losses import complete_box_iou_loss, distance_box_iou_loss, generalized_box_iou_loss
from .masks import masks_from_prototypes, masks_to_boxes, paste_masks
from .polygons import masks_to_polygons
from .roi_align import ps_roi_align, roi_align
from .roi_pool import ps_roi_pool, roi_pool
from .rotated import rotated_iou, rotated_nms_fixed
from .soft_suppression import soft_nms
from .ssd import decode_ssd
from .suppression import batched_nms, batched_nms_fixed, nms
from .text_boxes import decode_db
from .tiles import merge, merge_detections, tile
from .tracking import byte_track, sort_track

__all__ = [
    "batched_nms",
    "batched_nms_fixed",
    "box_area",
    "box_convert",
    "box_iou",
    "byte_track",
    "clip_boxes_to_image",
    "complete_box_iou",
    "complete_box_iou_loss",
    "ctc_beam_decode",
    "ctc_greedy_decode",
    "decode_db",
    "decode_detr",
    "decode_heatmaps",
    "decode_simcc",
    "decode_ssd",
    "decode_yolov5",
    "decode_yolov8",
    "deform_conv2d",
    "distance_box_iou",
    "distance_box_iou_loss",
    "generalized_box_iou",
    "generalized_box_iou_loss",
    "kalman_predict",
    "kalman_update",
    "linear_assignment",
    "masks_from_prototypes",
    "masks_to_boxes",
    "masks_to_polygons",
    "merge",
    "merge_detections",
    "nms",
    "paste_masks",
    "ps_roi_align",
    "ps_roi_pool",
    "remove_small_boxes",
    "roi_align",
    "roi_pool",
    "rotated_iou",
    "rotated_nms_fixed",
    "soft_nms",
    "sort_track",
    "tile",
]

__getattr__, __dir__ = lazy_modules(__name__, globals())
