"""Inputs for ops on things found in images (classes, key points, matches), and for losses and metrics, which
judge these."""

from __future__ import annotations

from collections.abc import Callable

from torch import Tensor

from chiasm.export import example_inputs
from chiasm.export.spec import Spec
from gallery.geometric.setting import Inputs, Setting, made_by

from .boxes import boxes, detections
from .classes import classes, heat_maps, scores, silhouettes
from .frames import frames, patches, response
from .matched import described, two_images
from .pairs import differing, disparities, flows, inverse_depth, related, rougher
from .pieces import clusters, terrain, windows
from .poses import positions, rotations, vectors
from .volumes import balls, noisy_volumes, related_volumes

__all__ = ["judged"]

DISPARITY = (
    "kitti_d1_error",
    "mean_absolute_disparity_error",
    "mean_bad_pixel_error",
    "root_mean_squared_disparity_error",
)
#: Ops on the outputs of networks, which no photograph stands for.
OUTPUTS = (
    "decode_simcc",
    "deform_conv2d",
    "masks_from_prototypes",
    "paste_masks",
    "ps_roi_align",
    "ps_roi_pool",
)


def examples(s: Setting) -> Inputs:
    """The spec's example inputs."""
    return example_inputs.make(
        s.spec, example_inputs.fit(s.spec, example_inputs.GOLDEN), s.spec.variants()[0]
    )


#: By the beginning of an op's name; longer names take precedence.
MAKERS: dict[str, Callable[[Setting], Inputs]] = {
    "contrib.combine_tensor_patches": windows,
    "contrib.diamond_square": terrain,
    "contrib.kmeans": clusters,
    "feature": frames,
    "feature.affine_shape": patches,
    "feature.convert_sift": patches,
    "feature.dominant_orientation": patches,
    "feature.index_proposal": response,
    "feature.match_": described,
    "feature.mean_patch": patches,
    "feature.mkd_describe": patches,
    "feature.multi_scale_index_proposal": response,
    "feature.sift_describe": patches,
    "losses": classes,
    **{
        f"losses.{name}": differing
        for name in ("cauchy", "charbonnier", "geman", "ms_ssim", "psnr", "ssim_loss", "welsch")
    },
    "losses.hausdorff": silhouettes,
    "losses.hausdorff_er_loss3d": balls,
    "losses.inverse_depth": inverse_depth,
    "losses.js_div": heat_maps,
    "losses.kl_div": heat_maps,
    "losses.mutual_information_loss": related,
    "losses.mutual_information_loss_3d": related_volumes,
    "losses.normalized_mutual_information_loss": related,
    "losses.normalized_mutual_information_loss_3d": related_volumes,
    "losses.ssim3d": noisy_volumes,
    "losses.total_variation": rougher,
    "metrics": classes,
    "metrics.accuracy": scores,
    "metrics.aepe": flows,
    "metrics.angle_error_mat": rotations,
    "metrics.angle_error_vec": vectors,
    "metrics.auc_from_errors": positions,
    "metrics.mean_average_precision": detections,
    "metrics.mean_iou_bbox": boxes,
    "metrics.pose_errors": rotations,
    "metrics.psnr": differing,
    "metrics.ssim": differing,
    "metrics.ssim3d": noisy_volumes,
    "metrics.translation_ate": positions,
    **{f"metrics.{name}": disparities for name in DISPARITY},
    **{f"ops.{name}": examples for name in OUTPUTS},
    "pipelines.two_view_homography": two_images,
}


def judged(spec: Spec, sizes: dict[str, int], rgb: Tensor) -> Inputs:
    """Inputs of an op, for those that replace the spec's example inputs."""
    return made_by(MAKERS, Setting(spec, sizes, rgb))
