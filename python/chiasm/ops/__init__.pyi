# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

from torch import Tensor, nn

from .assignment import linear_assignment as linear_assignment
from .boxes import box_area as box_area
from .boxes import box_convert as box_convert
from .boxes import box_iou as box_iou
from .boxes import clip_boxes_to_image as clip_boxes_to_image
from .boxes import complete_box_iou as complete_box_iou
from .boxes import distance_box_iou as distance_box_iou
from .boxes import generalized_box_iou as generalized_box_iou
from .boxes import remove_small_boxes as remove_small_boxes
from .ctc import ctc_beam_decode as ctc_beam_decode
from .ctc import ctc_greedy_decode as ctc_greedy_decode
from .decoding import decode_detr as decode_detr
from .decoding import decode_yolov5 as decode_yolov5
from .decoding import decode_yolov8 as decode_yolov8
from .deformable import deform_conv2d as deform_conv2d
from .kalman import kalman_predict as kalman_predict
from .kalman import kalman_update as kalman_update
from .keypoints import decode_heatmaps as decode_heatmaps
from .keypoints import decode_simcc as decode_simcc
from .losses import complete_box_iou_loss as complete_box_iou_loss
from .losses import distance_box_iou_loss as distance_box_iou_loss
from .losses import generalized_box_iou_loss as generalized_box_iou_loss
from .masks import masks_from_prototypes as masks_from_prototypes
from .masks import masks_to_boxes as masks_to_boxes
from .masks import paste_masks as paste_masks
from .polygons import masks_to_polygons as masks_to_polygons
from .roi_align import ps_roi_align as ps_roi_align
from .roi_align import roi_align as roi_align
from .roi_pool import ps_roi_pool as ps_roi_pool
from .roi_pool import roi_pool as roi_pool
from .rotated import rotated_iou as rotated_iou
from .rotated import rotated_nms_fixed as rotated_nms_fixed
from .soft_suppression import soft_nms as soft_nms
from .ssd import decode_ssd as decode_ssd
from .suppression import batched_nms as batched_nms
from .suppression import batched_nms_fixed as batched_nms_fixed
from .suppression import nms as nms
from .text_boxes import decode_db as decode_db
from .tiles import merge as merge
from .tiles import merge_detections as merge_detections
from .tiles import tile as tile
from .tracking import byte_track as byte_track
from .tracking import sort_track as sort_track

class BatchedNms(nn.Module):
    """`batched_nms` as a module: Non-maximum suppression for each class separately. The number of kept
    boxes depends on the data, so this function cannot be exported; `batched_nms_fixed` can."""

    iou_threshold: float
    def __init__(self, iou_threshold: float) -> None: ...
    def forward(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tensor: ...

class BatchedNmsFixed(nn.Module):
    """`batched_nms_fixed` as a module: `batched_nms` for a batch of images, with a fixed number of slots
    for the kept boxes. Native code compares each box with the kept boxes of its class; its memory grows
    with N. Other engines compare all pairs at once, which takes N * N bytes."""

    iou_threshold: float
    max_output: int
    score_threshold: float
    def __init__(self, iou_threshold: float, max_output: int, score_threshold: float = 0.0) -> None: ...
    def forward(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tuple[Tensor, Tensor]: ...

class BoxArea(nn.Module):
    """`box_area` as a module: The areas of boxes."""
    def __init__(self) -> None: ...
    def forward(self, boxes: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor) -> Tensor: ...

class BoxConvert(nn.Module):
    """`box_convert` as a module: Convert boxes between formats."""

    in_fmt: str
    out_fmt: str
    def __init__(self, in_fmt: str, out_fmt: str) -> None: ...
    def forward(self, boxes: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor) -> Tensor: ...

class BoxIou(nn.Module):
    """`box_iou` as a module: Intersection over union (IoU) of each box of one set with each box of
    another set."""
    def __init__(self) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class ByteTrack(nn.Module):
    """`byte_track` as a module: One frame of the tracker BYTE: Y. Zhang et al., ByteTrack, ECCV 2022,
    algorithm 1."""

    high_score: float
    low_score: float
    new_score: float
    iou_threshold: float
    max_age: int
    min_hits: int
    def __init__(
        self,
        high_score: float = 0.6,
        low_score: float = 0.1,
        new_score: float = 0.7,
        iou_threshold: float = 0.2,
        max_age: int = 30,
        min_hits: int = 2,
    ) -> None: ...
    def forward(
        self,
        mean: Tensor,
        covariance: Tensor,
        counters: Tensor,
        last_id: Tensor,
        boxes: Tensor,
        scores: Tensor,
        found: Tensor,
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(
        self,
        mean: Tensor,
        covariance: Tensor,
        counters: Tensor,
        last_id: Tensor,
        boxes: Tensor,
        scores: Tensor,
        found: Tensor,
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]: ...

class ClipBoxesToImage(nn.Module):
    """`clip_boxes_to_image` as a module: Clip the corners of boxes to an image."""

    size: Tuple[int, int]
    def __init__(self, size: Tuple[int, int]) -> None: ...
    def forward(self, boxes: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor) -> Tensor: ...

class CompleteBoxIou(nn.Module):
    """`complete_box_iou` as a module: Complete IoU: ``distance_box_iou`` minus a penalty for different
    aspect ratios. The weight of the penalty has no gradient."""

    eps: float
    def __init__(self, eps: float = 1e-07) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class CompleteBoxIouLoss(nn.Module):
    """`complete_box_iou_loss` as a module: Complete IoU loss: ``distance_box_iou_loss`` plus a penalty
    for different aspect ratios. The weight of the penalty has no gradient."""

    reduction: str
    eps: float
    def __init__(self, reduction: str = "none", eps: float = 1e-07) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class CtcBeamDecode(nn.Module):
    """`ctc_beam_decode` as a module: CTC beam search: the most likely label sequences, summed over all
    their alignments."""

    beam: int
    blank: int
    def __init__(self, beam: int = 10, blank: int = 0) -> None: ...
    def forward(self, log_probs: Tensor, lengths: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, log_probs: Tensor, lengths: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class CtcGreedyDecode(nn.Module):
    """`ctc_greedy_decode` as a module: Greedy CTC decoding: take the best class of each step, merge
    repetitions, remove blanks."""

    blank: int
    def __init__(self, blank: int = 0) -> None: ...
    def forward(self, log_probs: Tensor, lengths: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, log_probs: Tensor, lengths: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class DecodeDb(nn.Module):
    """`decode_db` as a module: Decode the probability map of a DB network to boxes of text lines:
    enlarged minimum-area rectangles."""

    threshold: float
    box_threshold: float
    unclip_ratio: float
    max_candidates: int
    min_size: float
    def __init__(
        self,
        threshold: float = 0.3,
        box_threshold: float = 0.6,
        unclip_ratio: float = 1.5,
        max_candidates: int = 100,
        min_size: float = 3.0,
    ) -> None: ...
    def forward(self, probability: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, probability: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class DecodeDetr(nn.Module):
    """`decode_detr` as a module: Decode the output of RT-DETR or Deformable DETR: the highest scores
    over all queries and classes."""

    size: Tuple[int, int]
    score_threshold: float
    max_output: int
    def __init__(
        self, size: Tuple[int, int], score_threshold: float = 0.5, max_output: int = 300
    ) -> None: ...
    def forward(self, logits: Tensor, pred_boxes: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(self, logits: Tensor, pred_boxes: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class DecodeHeatmaps(nn.Module):
    """`decode_heatmaps` as a module: Decode heat maps to keypoints: the subpixel position of the largest
    value of each map."""

    refinement: str
    kernel_size: int
    def __init__(self, refinement: str = "none", kernel_size: int = 11) -> None: ...
    def forward(self, heatmaps: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, heatmaps: Tensor) -> Tuple[Tensor, Tensor]: ...

class DecodeSimcc(nn.Module):
    """`decode_simcc` as a module: Decode SimCC outputs to keypoints: the positions of the largest values
    along x and along y."""

    split_ratio: float
    def __init__(self, split_ratio: float = 2.0) -> None: ...
    def forward(self, simcc_x: Tensor, simcc_y: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, simcc_x: Tensor, simcc_y: Tensor) -> Tuple[Tensor, Tensor]: ...

class DecodeSsd(nn.Module):
    """`decode_ssd` as a module: Decode the output of SSD: softmax, boxes from anchors, every class of
    every anchor, suppression."""

    size: Tuple[int, int]
    score_threshold: float
    iou_threshold: float
    max_output: int
    candidates: int
    def __init__(
        self,
        size: Tuple[int, int],
        score_threshold: float = 0.01,
        iou_threshold: float = 0.45,
        max_output: int = 200,
        candidates: int = 1000,
    ) -> None: ...
    def forward(
        self, logits: Tensor, deltas: Tensor, anchors: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(
        self, logits: Tensor, deltas: Tensor, anchors: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class DecodeYolov5(nn.Module):
    """`decode_yolov5` as a module: Decode the output of YOLO v5, v6 or v7. Otherwise as
    ``decode_yolov8``."""

    score_threshold: float
    iou_threshold: float
    max_output: int
    candidates: int
    def __init__(
        self,
        score_threshold: float = 0.25,
        iou_threshold: float = 0.45,
        max_output: int = 300,
        candidates: int = 1000,
    ) -> None: ...
    def forward(self, output: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(self, output: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class DecodeYolov8(nn.Module):
    """`decode_yolov8` as a module: Decode the output of YOLO v8, v9 or v11: best class of each place,
    score threshold, suppression."""

    score_threshold: float
    iou_threshold: float
    max_output: int
    candidates: int
    def __init__(
        self,
        score_threshold: float = 0.25,
        iou_threshold: float = 0.45,
        max_output: int = 300,
        candidates: int = 1000,
    ) -> None: ...
    def forward(self, output: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(self, output: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class DeformConv2d(nn.Module):
    """`deform_conv2d` as a module: Deformable convolution: taps are shifted by offsets and, with a mask,
    weighted at each place."""

    bias: Optional[Tensor]
    stride: Union[int, Tuple[int, int]]
    padding: Union[int, Tuple[int, int]]
    dilation: Union[int, Tuple[int, int]]
    mask: Optional[Tensor]
    def __init__(
        self,
        bias: Optional[Tensor] = None,
        stride: Union[int, Tuple[int, int]] = (1, 1),
        padding: Union[int, Tuple[int, int]] = (0, 0),
        dilation: Union[int, Tuple[int, int]] = (1, 1),
        mask: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, input: Tensor, offset: Tensor, weight: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, offset: Tensor, weight: Tensor) -> Tensor: ...

class DistanceBoxIou(nn.Module):
    """`distance_box_iou` as a module: Distance IoU: ``box_iou`` minus (distance of the centres /
    diagonal of the enclosing box)^2."""

    eps: float
    def __init__(self, eps: float = 1e-07) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class DistanceBoxIouLoss(nn.Module):
    """`distance_box_iou_loss` as a module: Distance IoU loss: 1 minus IoU, plus (distance of the centres
    / diagonal of the enclosing box)^2."""

    reduction: str
    eps: float
    def __init__(self, reduction: str = "none", eps: float = 1e-07) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class GeneralizedBoxIou(nn.Module):
    """`generalized_box_iou` as a module: Generalized IoU: ``box_iou`` minus the fraction of the smallest
    enclosing box that neither box covers."""
    def __init__(self) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class GeneralizedBoxIouLoss(nn.Module):
    """`generalized_box_iou_loss` as a module: Generalized IoU loss: 1 minus the generalized intersection
    over union of each box with its target."""

    reduction: str
    eps: float
    def __init__(self, reduction: str = "none", eps: float = 1e-07) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class KalmanPredict(nn.Module):
    """`kalman_predict` as a module: Predict a state after one time step: F x, with the covariance F P F'
    + Q. Computed in float64."""
    def __init__(self) -> None: ...
    def forward(
        self, mean: Tensor, covariance: Tensor, transition: Tensor, process_noise: Tensor
    ) -> Tuple[Tensor, Tensor]: ...
    def __call__(
        self, mean: Tensor, covariance: Tensor, transition: Tensor, process_noise: Tensor
    ) -> Tuple[Tensor, Tensor]: ...

class KalmanUpdate(nn.Module):
    """`kalman_update` as a module: Update a state by a measurement z of H x: x + K (z - H x), with the
    gain K = P H' (H P H' + R)^-1."""
    def __init__(self) -> None: ...
    def forward(
        self,
        mean: Tensor,
        covariance: Tensor,
        measurement: Tensor,
        observation: Tensor,
        measurement_noise: Tensor,
    ) -> Tuple[Tensor, Tensor]: ...
    def __call__(
        self,
        mean: Tensor,
        covariance: Tensor,
        measurement: Tensor,
        observation: Tensor,
        measurement_noise: Tensor,
    ) -> Tuple[Tensor, Tensor]: ...

class LinearAssignment(nn.Module):
    """`linear_assignment` as a module: Assign to each row a different column with the least sum of
    costs, like SciPy's ``linear_sum_assignment``."""

    rows: Optional[Tensor]
    columns: Optional[Tensor]
    max_cost: Optional[float]
    def __init__(
        self,
        rows: Optional[Tensor] = None,
        columns: Optional[Tensor] = None,
        max_cost: Optional[float] = None,
    ) -> None: ...
    def forward(self, cost: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, cost: Tensor) -> Tuple[Tensor, Tensor]: ...

class MasksFromPrototypes(nn.Module):
    """`masks_from_prototypes` as a module: Compute masks of detections from an image's prototypes, as in
    YOLACT and in YOLO segmentation."""

    size: Tuple[int, int]
    def __init__(self, size: Tuple[int, int]) -> None: ...
    def forward(self, prototypes: Tensor, coefficients: Tensor, boxes: Tensor) -> Tensor: ...
    def __call__(self, prototypes: Tensor, coefficients: Tensor, boxes: Tensor) -> Tensor: ...

class MasksToBoxes(nn.Module):
    """`masks_to_boxes` as a module: The bounding boxes of masks, as indices of their corner pixels. As
    in torchvision, the corner x2, y2 is the last pixel of the mask, not the one after it."""
    def __init__(self) -> None: ...
    def forward(self, masks: Tensor) -> Tensor: ...
    def __call__(self, masks: Tensor) -> Tensor: ...

class MasksToPolygons(nn.Module):
    """`masks_to_polygons` as a module: The outlines of 8-connected shapes in masks and of their holes,
    as polygons, the largest first."""

    max_polygons: int
    max_points: int
    def __init__(self, max_polygons: int = 16, max_points: int = 256) -> None: ...
    def forward(self, masks: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, masks: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class Merge(nn.Module):
    """`merge` as a module: Merge tiles, as cut by ``tile``, into an image, and blend the seams. Each
    pixel is a weighted mean of the tiles that contain it. Along each axis a tile's weight falls towards
    its ends, over ``overlap`` pixels in equal steps to 1 / (overlap + 1); the weights of a pixel are
    divided by their sum. So equal pixels of overlapping tiles stay unchanged, within rounding."""

    image_size: Tuple[int, int]
    overlap: Union[int, Tuple[int, int]]
    def __init__(self, image_size: Tuple[int, int], overlap: Union[int, Tuple[int, int]] = 0) -> None: ...
    def forward(self, tiles: Tensor) -> Tensor: ...
    def __call__(self, tiles: Tensor) -> Tensor: ...

class MergeDetections(nn.Module):
    """`merge_detections` as a module: Merge the detections of tiles into the detections of the large
    image. Boxes are shifted by the positions of their tiles. Then non-maximum suppression for each class
    keeps the highest score of overlapping boxes, from any tile. At the border of a tile only a part of
    an object is detected: so the overlap of tiles should be as large as the objects."""

    iou_threshold: float
    max_output: int
    def __init__(self, iou_threshold: float = 0.45, max_output: int = 300) -> None: ...
    def forward(
        self, boxes: Tensor, scores: Tensor, labels: Tensor, found: Tensor, origins: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(
        self, boxes: Tensor, scores: Tensor, labels: Tensor, found: Tensor, origins: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class Nms(nn.Module):
    """`nms` as a module: Non-maximum suppression: in descending order of score, drop every box that
    overlaps a kept box. The number of kept boxes depends on the data, so this function cannot be
    exported; `batched_nms_fixed` and `geometry.bbox.nms_fixed` can."""

    iou_threshold: float
    def __init__(self, iou_threshold: float) -> None: ...
    def forward(self, boxes: Tensor, scores: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor, scores: Tensor) -> Tensor: ...

class PasteMasks(nn.Module):
    """`paste_masks` as a module: Paste masks that were predicted for boxes into the image: the last step
    of Mask R-CNN."""

    size: Tuple[int, int]
    def __init__(self, size: Tuple[int, int]) -> None: ...
    def forward(self, masks: Tensor, boxes: Tensor) -> Tensor: ...
    def __call__(self, masks: Tensor, boxes: Tensor) -> Tensor: ...

class PsRoiAlign(nn.Module):
    """`ps_roi_align` as a module: Position-sensitive RoIAlign: each bin has its own channels."""

    output_size: Union[int, Tuple[int, int]]
    spatial_scale: float
    sampling_ratio: int
    def __init__(
        self, output_size: Union[int, Tuple[int, int]], spatial_scale: float = 1.0, sampling_ratio: int = -1
    ) -> None: ...
    def forward(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...
    def __call__(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...

class PsRoiPool(nn.Module):
    """`ps_roi_pool` as a module: Position-sensitive RoIPool: the means of the pixels in the bins of
    boxes; each bin has its own channels."""

    output_size: Union[int, Tuple[int, int]]
    spatial_scale: float
    def __init__(self, output_size: Union[int, Tuple[int, int]], spatial_scale: float = 1.0) -> None: ...
    def forward(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...
    def __call__(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...

class RemoveSmallBoxes(nn.Module):
    """`remove_small_boxes` as a module: The indices of the boxes whose sides are both at least
    ``min_size``. Their number depends on the data, so this function cannot be exported."""

    min_size: float
    def __init__(self, min_size: float) -> None: ...
    def forward(self, boxes: Tensor) -> Tensor: ...
    def __call__(self, boxes: Tensor) -> Tensor: ...

class RoiAlign(nn.Module):
    """`roi_align` as a module: RoIAlign: the means of points in the bins of boxes; each point is read by
    bilinear interpolation."""

    output_size: Union[int, Tuple[int, int]]
    spatial_scale: float
    sampling_ratio: int
    aligned: bool
    def __init__(
        self,
        output_size: Union[int, Tuple[int, int]],
        spatial_scale: float = 1.0,
        sampling_ratio: int = -1,
        aligned: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...
    def __call__(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...

class RoiPool(nn.Module):
    """`roi_pool` as a module: RoIPool: the maxima of the pixels in the bins of boxes."""

    output_size: Union[int, Tuple[int, int]]
    spatial_scale: float
    def __init__(self, output_size: Union[int, Tuple[int, int]], spatial_scale: float = 1.0) -> None: ...
    def forward(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...
    def __call__(self, input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor: ...

class RotatedIou(nn.Module):
    """`rotated_iou` as a module: Intersection over union of each rotated box of one set with each
    rotated box of another set. One box is clipped by the sides of the other (I. Sutherland, G. Hodgman,
    Reentrant Polygon Clipping, CACM 17(1), 1974). This takes memory for about 50 * N * M values."""
    def __init__(self) -> None: ...
    def forward(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...
    def __call__(self, boxes1: Tensor, boxes2: Tensor) -> Tensor: ...

class RotatedNmsFixed(nn.Module):
    """`rotated_nms_fixed` as a module: `batched_nms_fixed` for rotated boxes. Each step keeps the box
    with the highest score and drops the boxes of its class that overlap it. There is one step for each
    filled slot, in float64; memory grows with N."""

    iou_threshold: float
    max_output: int
    score_threshold: float
    def __init__(self, iou_threshold: float, max_output: int, score_threshold: float = 0.0) -> None: ...
    def forward(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, boxes: Tensor, scores: Tensor, idxs: Tensor) -> Tuple[Tensor, Tensor]: ...

class SoftNms(nn.Module):
    """`soft_nms` as a module: Soft non-maximum suppression of a batch of images, with a fixed number of
    slots for the kept boxes. N. Bodla et al., Soft-NMS, ICCV 2017. Each step takes the box with the
    highest score (of equal scores the first one) and multiplies the scores of the remaining boxes by a
    factor of their IoU o with this box: "gaussian" exp(-o^2 / sigma), "linear" 1 - o if o is at least
    ``iou_threshold``. Computed in float64, with one step for each filled slot; memory grows with N +
    K."""

    max_output: int
    method: str
    sigma: float
    iou_threshold: float
    score_threshold: float
    def __init__(
        self,
        max_output: int,
        method: str = "gaussian",
        sigma: float = 0.5,
        iou_threshold: float = 0.3,
        score_threshold: float = 0.001,
    ) -> None: ...
    def forward(self, boxes: Tensor, scores: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, boxes: Tensor, scores: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class SortTrack(nn.Module):
    """`sort_track` as a module: One frame of the tracker SORT: A. Bewley et al., Simple Online and
    Realtime Tracking, ICIP 2016."""

    iou_threshold: float
    max_age: int
    min_hits: int
    def __init__(self, iou_threshold: float = 0.3, max_age: int = 30, min_hits: int = 3) -> None: ...
    def forward(
        self,
        mean: Tensor,
        covariance: Tensor,
        counters: Tensor,
        last_id: Tensor,
        boxes: Tensor,
        found: Tensor,
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(
        self,
        mean: Tensor,
        covariance: Tensor,
        counters: Tensor,
        last_id: Tensor,
        boxes: Tensor,
        found: Tensor,
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]: ...

class Tile(nn.Module):
    """`tile` as a module: Cut an image into tiles of one size, row by row, which cover it. The last tile
    of a row or column is shifted into the image, so that it overlaps the one before by more."""

    size: Union[int, Tuple[int, int]]
    overlap: Union[int, Tuple[int, int]]
    def __init__(
        self, size: Union[int, Tuple[int, int]], overlap: Union[int, Tuple[int, int]] = 0
    ) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

__all__ = [
    "BatchedNms",
    "BatchedNmsFixed",
    "BoxArea",
    "BoxConvert",
    "BoxIou",
    "ByteTrack",
    "ClipBoxesToImage",
    "CompleteBoxIou",
    "CompleteBoxIouLoss",
    "CtcBeamDecode",
    "CtcGreedyDecode",
    "DecodeDb",
    "DecodeDetr",
    "DecodeHeatmaps",
    "DecodeSimcc",
    "DecodeSsd",
    "DecodeYolov5",
    "DecodeYolov8",
    "DeformConv2d",
    "DistanceBoxIou",
    "DistanceBoxIouLoss",
    "GeneralizedBoxIou",
    "GeneralizedBoxIouLoss",
    "KalmanPredict",
    "KalmanUpdate",
    "LinearAssignment",
    "MasksFromPrototypes",
    "MasksToBoxes",
    "MasksToPolygons",
    "Merge",
    "MergeDetections",
    "Nms",
    "PasteMasks",
    "PsRoiAlign",
    "PsRoiPool",
    "RemoveSmallBoxes",
    "RoiAlign",
    "RoiPool",
    "RotatedIou",
    "RotatedNmsFixed",
    "SoftNms",
    "SortTrack",
    "Tile",
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
