# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple

import torch
from torch import Tensor, nn

from .depth_smoothness import inverse_depth_smoothness_loss as inverse_depth_smoothness_loss
from .divergence import js_div_loss_2d as js_div_loss_2d
from .divergence import kl_div_loss_2d as kl_div_loss_2d
from .focal import binary_focal_loss_with_logits as binary_focal_loss_with_logits
from .focal import focal_loss as focal_loss
from .hausdorff import hausdorff_er_loss as hausdorff_er_loss
from .hausdorff import hausdorff_er_loss3d as hausdorff_er_loss3d
from .labels import one_hot as one_hot
from .lovasz import lovasz_hinge_loss as lovasz_hinge_loss
from .lovasz import lovasz_softmax_loss as lovasz_softmax_loss
from .ms_ssim import ms_ssim_loss as ms_ssim_loss
from .mutual_information import mutual_information_loss as mutual_information_loss
from .mutual_information import mutual_information_loss_2d as mutual_information_loss_2d
from .mutual_information import mutual_information_loss_3d as mutual_information_loss_3d
from .mutual_information import normalized_mutual_information_loss as normalized_mutual_information_loss
from .mutual_information import normalized_mutual_information_loss_2d as normalized_mutual_information_loss_2d
from .mutual_information import normalized_mutual_information_loss_3d as normalized_mutual_information_loss_3d
from .overlap import dice_loss as dice_loss
from .overlap import tversky_loss as tversky_loss
from .psnr import psnr_loss as psnr_loss
from .references import MIKernel as MIKernel
from .references import MILossFromRef as MILossFromRef
from .references import MILossFromRef2D as MILossFromRef2D
from .references import MILossFromRef3D as MILossFromRef3D
from .references import NMILossFromRef as NMILossFromRef
from .references import NMILossFromRef2D as NMILossFromRef2D
from .references import NMILossFromRef3D as NMILossFromRef3D
from .robust import cauchy_loss as cauchy_loss
from .robust import charbonnier_loss as charbonnier_loss
from .robust import geman_mcclure_loss as geman_mcclure_loss
from .robust import welsch_loss as welsch_loss
from .ssim import ssim3d_loss as ssim3d_loss
from .ssim import ssim_loss as ssim_loss
from .total_variation import total_variation as total_variation

class BinaryFocalLossWithLogits(nn.Module):
    """`binary_focal_loss_with_logits` as a module: Binary focal loss, where p is the sigmoid of pred and
    y is the target. The loss is -alpha (1 - p)^gamma y log(p) - (1 - alpha) p^gamma (1 - y) log(1 - p).
    T.-Y. Lin et al., Focal loss for dense object detection, ICCV 2017."""

    alpha: Optional[float]
    gamma: float
    reduction: str
    pos_weight: Optional[Tensor]
    weight: Optional[Tensor]
    ignore_index: Optional[int]
    def __init__(
        self,
        alpha: Optional[float] = 0.25,
        gamma: float = 2.0,
        reduction: str = "none",
        pos_weight: Optional[Tensor] = None,
        weight: Optional[Tensor] = None,
        ignore_index: Optional[int] = -100,
    ) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class CauchyLoss(nn.Module):
    """`cauchy_loss` as a module: log(d^2 / 2 + 1) of the difference d (Barron's alpha = 0, also called
    Lorentzian)."""

    reduction: Optional[str]
    def __init__(self, reduction: Optional[str] = "none") -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class CharbonnierLoss(nn.Module):
    """`charbonnier_loss` as a module: sqrt(d^2 + 1) - 1 of the difference d (Barron's alpha = 1, also
    called pseudo-Huber)."""

    reduction: Optional[str]
    def __init__(self, reduction: Optional[str] = "none") -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class DiceLoss(nn.Module):
    """`dice_loss` as a module: Dice loss: 1 - 2 sum(p g) / (sum(p) + sum(g) + eps), with the softmax p
    of pred and one-hot labels g."""

    average: str
    eps: float
    weight: Optional[Tensor]
    ignore_index: Optional[int]
    def __init__(
        self,
        average: str = "micro",
        eps: float = 1e-08,
        weight: Optional[Tensor] = None,
        ignore_index: Optional[int] = -100,
    ) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class FocalLoss(nn.Module):
    """`focal_loss` as a module: Focal loss -alpha_t (1 - p_t)^gamma log(p_t), where p_t is the softmax
    of a pixel's true class."""

    alpha: Optional[float]
    gamma: float
    reduction: str
    weight: Optional[Tensor]
    ignore_index: Optional[int]
    def __init__(
        self,
        alpha: Optional[float],
        gamma: float = 2.0,
        reduction: str = "none",
        weight: Optional[Tensor] = None,
        ignore_index: Optional[int] = -100,
    ) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class GemanMcclureLoss(nn.Module):
    """`geman_mcclure_loss` as a module: 2 d^2 / (d^2 + 4) of the difference d (Barron's alpha = -2)."""

    reduction: Optional[str]
    def __init__(self, reduction: Optional[str] = "none") -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class HausdorffERLoss(nn.Module):
    """`hausdorff_er_loss` as a module: Hausdorff loss by erosion: the sum over i = 1..k of i^alpha times
    (pred - target)^2 eroded i times."""

    alpha: float
    k: int
    reduction: str
    def __init__(self, alpha: float = 2.0, k: int = 10, reduction: str = "mean") -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class HausdorffERLoss3D(nn.Module):
    """`hausdorff_er_loss3d` as a module: ``hausdorff_er_loss`` for volumes; an erosion averages a voxel
    and its six neighbours."""

    alpha: float
    k: int
    reduction: str
    def __init__(self, alpha: float = 2.0, k: int = 10, reduction: str = "mean") -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class InverseDepthSmoothnessLoss(nn.Module):
    """`inverse_depth_smoothness_loss` as a module: Smoothness of inverse depth d except at edges of an
    image I: the mean of \|dx d\| exp(-\|dx I\|) plus the mean of \|dy d\| exp(-\|dy I\|)."""
    def __init__(self) -> None: ...
    def forward(self, idepth: Tensor, image: Tensor) -> Tensor: ...
    def __call__(self, idepth: Tensor, image: Tensor) -> Tensor: ...

class JsDivLoss2d(nn.Module):
    """`js_div_loss_2d` as a module: Jensen-Shannon divergence of heatmaps: the mean of their Kullback-
    Leibler divergences from their mean, at most log 2."""

    reduction: str
    def __init__(self, reduction: str = "mean") -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class KlDivLoss2d(nn.Module):
    """`kl_div_loss_2d` as a module: Kullback-Leibler divergence of pred from target: the sum of target
    log(target / pred) over each heatmap."""

    reduction: str
    def __init__(self, reduction: str = "mean") -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class LovaszHingeLoss(nn.Module):
    """`lovasz_hinge_loss` as a module: Lovász extension of 1 - Jaccard index at the hinge errors max(0,
    1 - s pred), s = 1 in the foreground and -1 elsewhere."""
    def __init__(self) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class LovaszSoftmaxLoss(nn.Module):
    """`lovasz_softmax_loss` as a module: Lovász extension of 1 - Jaccard index for each class, at the
    errors \|y - p\| of the softmax p; the mean over classes and images."""

    weight: Optional[Tensor]
    def __init__(self, weight: Optional[Tensor] = None) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class MS_SSIMLoss(nn.Module):
    """`ms_ssim_loss` as a module: compensation (alpha (1 - MS-SSIM) + (1 - alpha) G \|img1 - img2\| /
    data_range), G the widest of the Gaussians."""

    sigmas: Optional[List[float]]
    data_range: float
    K: Tuple[float, float]
    alpha: float
    compensation: float
    reduction: str
    def __init__(
        self,
        sigmas: Optional[List[float]] = None,
        data_range: float = 1.0,
        K: Tuple[float, float] = (0.01, 0.03),
        alpha: float = 0.025,
        compensation: float = 200.0,
        reduction: str = "mean",
    ) -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class MutualInformationLoss(nn.Module):
    """`mutual_information_loss` as a module: Negative mutual information of two signals: -(H(input) +
    H(target) - H(input, target)), in nats."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class MutualInformationLoss2d(nn.Module):
    """`mutual_information_loss_2d` as a module: ``mutual_information_loss`` for the planes of images."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class MutualInformationLoss3d(nn.Module):
    """`mutual_information_loss_3d` as a module: ``mutual_information_loss`` for volumes."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class NormalizedMutualInformationLoss(nn.Module):
    """`normalized_mutual_information_loss` as a module: Negative normalized mutual information,
    -(H(input) + H(target)) / H(input, target). It is from -1 (independent) to -2 (one signal determines
    the other)."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class NormalizedMutualInformationLoss2d(nn.Module):
    """`normalized_mutual_information_loss_2d` as a module: ``normalized_mutual_information_loss`` for
    the planes of images."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class NormalizedMutualInformationLoss3d(nn.Module):
    """`normalized_mutual_information_loss_3d` as a module: ``normalized_mutual_information_loss`` for
    volumes."""

    input_mask: Optional[Tensor]
    target_mask: Optional[Tensor]
    kernel_function: str
    num_bins: int
    window_radius: float
    def __init__(
        self,
        input_mask: Optional[Tensor] = None,
        target_mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None: ...
    def forward(self, input: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, target: Tensor) -> Tensor: ...

class OneHot(nn.Module):
    """`one_hot` as a module: One-hot encoding: a plane for each class with 1 + eps where the label is
    this class, eps elsewhere."""

    num_classes: int
    device: Optional[torch.device]
    dtype: torch.dtype
    eps: float
    def __init__(
        self,
        num_classes: int,
        device: Optional[torch.device] = None,
        dtype: torch.dtype = ...,
        eps: float = 0.0,
    ) -> None: ...
    def forward(self, labels: Tensor) -> Tensor: ...
    def __call__(self, labels: Tensor) -> Tensor: ...

class PSNRLoss(nn.Module):
    """`psnr_loss` as a module: Negative peak signal-to-noise ratio in decibels; see
    ``chiasm.metrics.psnr``."""

    max_val: float
    def __init__(self, max_val: float) -> None: ...
    def forward(self, image: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, target: Tensor) -> Tensor: ...

class SSIM3DLoss(nn.Module):
    """`ssim3d_loss` as a module: (1 - SSIM) / 2 of volumes, clamped to [0, 1]; see
    ``chiasm.metrics.ssim3d``."""

    window_size: int
    max_val: float
    eps: float
    reduction: str
    padding: str
    def __init__(
        self,
        window_size: int,
        max_val: float = 1.0,
        eps: float = 1e-12,
        reduction: str = "mean",
        padding: str = "same",
    ) -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class SSIMLoss(nn.Module):
    """`ssim_loss` as a module: (1 - SSIM) / 2, clamped to [0, 1]; see ``chiasm.metrics.ssim``."""

    window_size: int
    max_val: float
    eps: float
    reduction: str
    padding: str
    def __init__(
        self,
        window_size: int,
        max_val: float = 1.0,
        eps: float = 1e-12,
        reduction: str = "mean",
        padding: str = "same",
    ) -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

class TotalVariation(nn.Module):
    """`total_variation` as a module: Anisotropic total variation: the sum of absolute differences of
    neighbours along rows and columns."""

    reduction: str
    def __init__(self, reduction: str = "sum") -> None: ...
    def forward(self, img: Tensor) -> Tensor: ...
    def __call__(self, img: Tensor) -> Tensor: ...

class TverskyLoss(nn.Module):
    """`tversky_loss` as a module: Tversky loss: 1 - TP / (TP + alpha FP + beta FN + eps), with soft
    counts from the softmax of pred."""

    alpha: float
    beta: float
    eps: float
    ignore_index: Optional[int]
    average: str
    def __init__(
        self,
        alpha: float,
        beta: float,
        eps: float = 1e-08,
        ignore_index: Optional[int] = -100,
        average: str = "macro",
    ) -> None: ...
    def forward(self, pred: Tensor, target: Tensor) -> Tensor: ...
    def __call__(self, pred: Tensor, target: Tensor) -> Tensor: ...

class WelschLoss(nn.Module):
    """`welsch_loss` as a module: 1 - exp(-d^2 / 2) of the difference d (Barron's alpha = -infinity, also
    called Leclerc)."""

    reduction: Optional[str]
    def __init__(self, reduction: Optional[str] = "none") -> None: ...
    def forward(self, img1: Tensor, img2: Tensor) -> Tensor: ...
    def __call__(self, img1: Tensor, img2: Tensor) -> Tensor: ...

__all__ = [
    "BinaryFocalLossWithLogits",
    "CauchyLoss",
    "CharbonnierLoss",
    "DiceLoss",
    "FocalLoss",
    "GemanMcclureLoss",
    "HausdorffERLoss",
    "HausdorffERLoss3D",
    "InverseDepthSmoothnessLoss",
    "JsDivLoss2d",
    "KlDivLoss2d",
    "LovaszHingeLoss",
    "LovaszSoftmaxLoss",
    "MIKernel",
    "MILossFromRef",
    "MILossFromRef2D",
    "MILossFromRef3D",
    "MS_SSIMLoss",
    "MutualInformationLoss",
    "MutualInformationLoss2d",
    "MutualInformationLoss3d",
    "NMILossFromRef",
    "NMILossFromRef2D",
    "NMILossFromRef3D",
    "NormalizedMutualInformationLoss",
    "NormalizedMutualInformationLoss2d",
    "NormalizedMutualInformationLoss3d",
    "OneHot",
    "PSNRLoss",
    "SSIM3DLoss",
    "SSIMLoss",
    "TotalVariation",
    "TverskyLoss",
    "WelschLoss",
    "binary_focal_loss_with_logits",
    "cauchy_loss",
    "charbonnier_loss",
    "dice_loss",
    "focal_loss",
    "geman_mcclure_loss",
    "hausdorff_er_loss",
    "hausdorff_er_loss3d",
    "inverse_depth_smoothness_loss",
    "js_div_loss_2d",
    "kl_div_loss_2d",
    "lovasz_hinge_loss",
    "lovasz_softmax_loss",
    "ms_ssim_loss",
    "mutual_information_loss",
    "mutual_information_loss_2d",
    "mutual_information_loss_3d",
    "normalized_mutual_information_loss",
    "normalized_mutual_information_loss_2d",
    "normalized_mutual_information_loss_3d",
    "one_hot",
    "psnr_loss",
    "ssim3d_loss",
    "ssim_loss",
    "total_variation",
    "tversky_loss",
    "welsch_loss",
]
