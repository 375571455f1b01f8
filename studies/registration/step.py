"""The exported functions of tensors: one source for eager Python, ONNX Runtime and native code."""

from __future__ import annotations

from typing import List, Tuple

import torch
from torch import Tensor

from chiasm.geometry.conversions import denormalize_homography
from chiasm.geometry.transform import build_pyramid, homography_warp
from chiasm.geometry.transform.registrator import mean_over_covered
from chiasm.image import frames_to_tensor, tensor_to_frames
from studies.optimizers import adam


def pyramid(frame: Tensor, levels: int) -> List[Tensor]:
    """A frame (H, W, 3), uint8, as images (1, 3, H, W), (1, 3, H // 2, W // 2), ..., float32 in [0, 1]."""
    return build_pyramid(frames_to_tensor(frame), levels)


def registration_step(
    src: Tensor, dst: Tensor, homography: Tensor, mean: Tensor, square: Tensor, step: Tensor, lr: Tensor
) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """One step of Adam that reduces the mean absolute difference between warped images and others, over the
    pixels that the warped images cover.

    Args:
        src: (B, C, H, W), the images to warp, floating point in [0, 1].
        dst: (B, C, H, W), the target images.
        homography: (B, 3, 3), from dst to src in normalised coordinates, up to scale, one per image. mean,
        square, step, lr: as in :func:`studies.optimizers.adam`.

    Returns:
        homography, mean and square after the step, and the loss before it, (B,).
    """
    at = homography.detach().requires_grad_(True)
    losses = photometric_losses(src, dst, at / at[:, 2:, 2:])
    gradient = torch.autograd.grad([losses.sum()], [at])[0]
    assert gradient is not None
    homography, mean, square = adam(homography, gradient, mean, square, step, lr)
    return homography, mean, square, losses.detach()


def photometric_losses(src: Tensor, dst: Tensor, homography: Tensor) -> Tensor:
    """The loss (B,) of ImageRegistrator, for each image."""
    size = (dst.size(2), dst.size(3))
    difference = (homography_warp(src, homography, size) - dst).abs().mean(1)
    coverage = homography_warp(torch.ones_like(src[:, :1]), homography.detach(), size)
    return mean_over_covered(difference, coverage[:, 0])


def warp(frame: Tensor, homography: Tensor) -> Tuple[Tensor, Tensor]:
    """Apply the learned homography, and convert it to pixels.

    Args:
        frame: (H, W, 3), uint8, the source.
        homography: (1, 3, 3), from the destination to the source in normalised coordinates, up to scale.

    Returns:
        The frame (H, W, 3), warped to the destination, black where it does not reach; the homography (1, 3,
        3) from the destination's pixels to the source's, with last entry 1.
    """
    size = (frame.size(0), frame.size(1))
    pixels = denormalize_homography(homography, size, size, align_corners=False)
    return (
        tensor_to_frames(homography_warp(frames_to_tensor(frame), homography, size))[0],
        pixels / pixels[:, 2:, 2:],
    )
