"""Metrics of image quality, and errors of results against ground truth."""

from ..primitives.core.modules import lazy_modules
from .average_meter import AverageMeter
from .boxes import mean_average_precision, mean_iou_bbox
from .classification import accuracy, confusion_matrix, mean_iou
from .disparity import (
    kitti_d1_error,
    mean_absolute_disparity_error,
    mean_bad_pixel_error,
    root_mean_squared_disparity_error,
)
from .flow import aepe
from .flow import average_endpoint_error as average_endpoint_error
from .pose import angle_error_mat, angle_error_vec, auc_from_errors, pose_errors, translation_ate
from .psnr import psnr
from .ssim import ssim, ssim3d

__all__ = [
    "AverageMeter",
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

__getattr__, __dir__ = lazy_modules(__name__, globals())
