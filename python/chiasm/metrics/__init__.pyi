# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple

from torch import Tensor, nn

from .average_meter import AverageMeter as AverageMeter
from .boxes import mean_average_precision as mean_average_precision
from .boxes import mean_iou_bbox as mean_iou_bbox
from .classification import accuracy as accuracy
from .classification import confusion_matrix as confusion_matrix
from .classification import mean_iou as mean_iou
from .disparity import kitti_d1_error as kitti_d1_error
from .disparity import mean_absolute_disparity_error as mean_absolute_disparity_error
from .disparity import mean_bad_pixel_error as mean_bad_pixel_error
from .disparity import root_mean_squared_disparity_error as root_mean_squared_disparity_error
from .flow import aepe as aepe
from .flow import average_endpoint_error as average_endpoint_error
from .pose import angle_error_mat as angle_error_mat
from .pose import angle_error_vec as angle_error_vec
from .pose import auc_from_errors as auc_from_errors
from .pose import pose_errors as pose_errors
from .pose import translation_ate as translation_ate
from .psnr import psnr as psnr
from .ssim import ssim as ssim
from .ssim import ssim3d as ssim3d

class Accuracy(nn.Module):
    """`accuracy` as a module: Top-k accuracy: the percentage of samples whose true class is among the k
    highest scores. Of equal scores the one with the lower class index is ranked higher, as in a stable
    sort. NaN is ranked highest, but not for the true class."""

    topk: List[int]
    def __init__(self, topk: List[int] = ...) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class AEPE(nn.Module):
    """`aepe` as a module: Average end-point error: the mean distance between the ends of two fields of
    flow vectors."""

    reduction: str
    def __init__(self, reduction: str = "mean") -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class AngleErrorMat(nn.Module):
    """`angle_error_mat` as a module: Angle of the rotation between two rotations, in degrees."""
    def __init__(self) -> None: ...
    def forward(self, R1: Tensor, R2: Tensor) -> Tensor: ...
    def __call__(self, R1: Tensor, R2: Tensor) -> Tensor: ...

class AngleErrorVec(nn.Module):
    """`angle_error_vec` as a module: Angle between the directions of two vectors, in degrees."""
    def __init__(self) -> None: ...
    def forward(self, v1: Tensor, v2: Tensor) -> Tensor: ...
    def __call__(self, v1: Tensor, v2: Tensor) -> Tensor: ...

class AucFromErrors(nn.Module):
    """`auc_from_errors` as a module: Area under the curve (AUC) of recall, the share of errors up to e,
    for e from 0 to a threshold."""

    thresholds: List[float]
    def __init__(self, thresholds: List[float] = ...) -> None: ...
    def forward(self, errors: Tensor) -> Tensor: ...
    def __call__(self, errors: Tensor) -> Tensor: ...

class ConfusionMatrix(nn.Module):
    """`confusion_matrix` as a module: Confusion matrix of each sample of a batch: counts of (true class,
    predicted class)."""

    num_classes: int
    normalized: bool
    def __init__(self, num_classes: int, normalized: bool = False) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class KittiD1Error(nn.Module):
    """`kitti_d1_error` as a module: D1 error of KITTI: share of valid pixels with an error above 3
    pixels and above 5 % of the true disparity."""

    abs_threshold: float
    rel_threshold: float
    valid_mask: Optional[Tensor]
    reduction: str
    def __init__(
        self,
        abs_threshold: float = 3.0,
        rel_threshold: float = 0.05,
        valid_mask: Optional[Tensor] = None,
        reduction: str = "mean",
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class MeanAbsoluteDisparityError(nn.Module):
    """`mean_absolute_disparity_error` as a module: Mean of |input - target| over the valid pixels."""

    valid_mask: Optional[Tensor]
    reduction: str
    def __init__(self, valid_mask: Optional[Tensor] = None, reduction: str = "mean") -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class MeanAveragePrecision(nn.Module):
    """`mean_average_precision` as a module: Mean average precision of detected boxes over the classes,
    by Pascal VOC's rules."""

    n_classes: int
    threshold: float
    pred_mask: Optional[Tensor]
    gt_mask: Optional[Tensor]
    def __init__(
        self,
        n_classes: int,
        threshold: float = 0.5,
        pred_mask: Optional[Tensor] = None,
        gt_mask: Optional[Tensor] = None,
    ) -> None: ...
    def forward(
        self,
        pred_boxes: Tensor,
        pred_labels: Tensor,
        pred_scores: Tensor,
        gt_boxes: Tensor,
        gt_labels: Tensor,
    ) -> Tuple[Tensor, Tensor]: ...
    def __call__(
        self,
        pred_boxes: Tensor,
        pred_labels: Tensor,
        pred_scores: Tensor,
        gt_boxes: Tensor,
        gt_labels: Tensor,
    ) -> Tuple[Tensor, Tensor]: ...

class MeanBadPixelError(nn.Module):
    """`mean_bad_pixel_error` as a module: Share of the valid pixels whose disparity error is more than a
    threshold."""

    threshold: float
    valid_mask: Optional[Tensor]
    reduction: str
    def __init__(
        self, threshold: float = 3.0, valid_mask: Optional[Tensor] = None, reduction: str = "mean"
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class MeanIou(nn.Module):
    """`mean_iou` as a module: Intersection over union (IoU) of the pixels of each class, for each sample
    of a batch. As in Kornia, the caller computes their mean."""

    num_classes: int
    eps: float
    def __init__(self, num_classes: int, eps: float = 1e-06) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class MeanIouBbox(nn.Module):
    """`mean_iou_bbox` as a module: Intersection over union (IoU) of each box of one set with each box of
    another set. (The name is Kornia's; there is no mean.)"""

    box_format: str
    def __init__(self, box_format: str = "xyxy") -> None: ...
    def forward(self, boxes_1: Tensor, boxes_2: Tensor) -> Tensor: ...
    def __call__(self, boxes_1: Tensor, boxes_2: Tensor) -> Tensor: ...

class PoseErrors(nn.Module):
    """`pose_errors` as a module: Errors of poses [R | t] with unknown length of t: the angles between
    rotations and between translations, in degrees."""

    fold_translation: bool
    def __init__(self, fold_translation: bool = True) -> None: ...
    def forward(self, P: Tensor, P_gt: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, P: Tensor, P_gt: Tensor) -> Tuple[Tensor, Tensor]: ...

class Psnr(nn.Module):
    """`psnr` as a module: Peak signal-to-noise ratio in decibels, 10 log10(max_val^2 / mean of (image -
    target)^2)."""

    max_val: float
    def __init__(self, max_val: float) -> None: ...
    def forward(self, image: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, target: Tensor) -> Tensor: ...

class RootMeanSquaredDisparityError(nn.Module):
    """`root_mean_squared_disparity_error` as a module: Root of the mean of (input - target)^2 over the
    valid pixels."""

    valid_mask: Optional[Tensor]
    reduction: str
    def __init__(self, valid_mask: Optional[Tensor] = None, reduction: str = "mean") -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class SSIM(nn.Module):
    """`ssim` as a module: Structural similarity map with a Gaussian window of sigma 1.5."""

    window_size: int
    max_val: float
    eps: float
    padding: str
    def __init__(
        self, window_size: int, max_val: float = 1.0, eps: float = 1e-12, padding: str = "same"
    ) -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class SSIM3D(nn.Module):
    """`ssim3d` as a module: Structural similarity map of volumes: ``ssim`` with a window of three
    dimensions."""

    window_size: int
    max_val: float
    eps: float
    padding: str
    def __init__(
        self, window_size: int, max_val: float = 1.0, eps: float = 1e-12, padding: str = "same"
    ) -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class TranslationAte(nn.Module):
    """`translation_ate` as a module: Absolute translation error: the distance between two positions."""
    def __init__(self) -> None: ...
    def forward(self, t: Tensor, t_gt: Tensor) -> Tensor: ...
    def __call__(self, t: Tensor, t_gt: Tensor) -> Tensor: ...

__all__ = [
    "AEPE",
    "SSIM",
    "SSIM3D",
    "Accuracy",
    "AngleErrorMat",
    "AngleErrorVec",
    "AucFromErrors",
    "AverageMeter",
    "ConfusionMatrix",
    "KittiD1Error",
    "MeanAbsoluteDisparityError",
    "MeanAveragePrecision",
    "MeanBadPixelError",
    "MeanIou",
    "MeanIouBbox",
    "PoseErrors",
    "Psnr",
    "RootMeanSquaredDisparityError",
    "TranslationAte",
    "accuracy",
    "aepe",
    "angle_error_mat",
    "angle_error_vec",
    "auc_from_errors",
    "confusion_matrix",
    "kitti_d1_error",
    "mean_absolute_disparity_error",
    "mean_average_precision",
    "mean_bad_pixel_error",
    "mean_iou",
    "mean_iou_bbox",
    "pose_errors",
    "psnr",
    "root_mean_squared_disparity_error",
    "ssim",
    "ssim3d",
    "translation_ate",
]
