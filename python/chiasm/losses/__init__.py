"""Losses."""

from ..primitives.core.modules import lazy_modules
from .depth_smoothness import inverse_depth_smoothness_loss
from .divergence import js_div_loss_2d, kl_div_loss_2d
from .focal import binary_focal_loss_with_logits, focal_loss
from .hausdorff import hausdorff_er_loss, hausdorff_er_loss3d
from .labels import one_hot
from .lovasz import lovasz_hinge_loss, lovasz_softmax_loss
from .ms_ssim import ms_ssim_loss
from .mutual_information import (
    mutual_information_loss,
    mutual_information_loss_2d,
    mutual_information_loss_3d,
    normalized_mutual_information_loss,
    normalized_mutual_information_loss_2d,
    normalized_mutual_information_loss_3d,
)
from .overlap import dice_loss, tversky_loss
from .psnr import psnr_loss
from .references import (
    MIKernel,
    MILossFromRef,
    MILossFromRef2D,
    MILossFromRef3D,
    NMILossFromRef,
    NMILossFromRef2D,
    NMILossFromRef3D,
)
from .robust import cauchy_loss, charbonnier_loss, geman_mcclure_loss, welsch_loss
from .ssim import ssim3d_loss, ssim_loss
from .total_variation import total_variation

__all__ = [
    "MIKernel",
    "MILossFromRef",
    "MILossFromRef2D",
    "MILossFromRef3D",
    "NMILossFromRef",
    "NMILossFromRef2D",
    "NMILossFromRef3D",
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

__getattr__, __dir__ = lazy_modules(__name__, globals())
