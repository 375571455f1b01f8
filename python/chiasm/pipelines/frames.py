"""Pipelines for camera frames (uint8, H x W x BGR, OpenCV's format)."""

from typing import Tuple

import torch
from torch import Tensor

from ..filters.gaussian import gaussian_blur2d
from ..filters.gradient import sobel
from ..primitives.core.checks import check_not_empty, check_tensor
from ..primitives.filters.padding import check_margins
from ..primitives.images.frames import frame_to_grey, normalized_levels, resize_frame


def preprocess(
    frame: Tensor,
    mean: Tuple[float, float, float] = (0.485, 0.456, 0.406),
    std: Tuple[float, float, float] = (0.229, 0.224, 0.225),
) -> Tensor:
    """Convert a frame to the input of a classifier: RGB, 224 x 224 (bilinear), in [0, 1], then normalized.
    The aspect ratio is not kept.

    Args:
        frame: (H, W, 3), uint8, BGR.
        mean: the means of R, G, B; those of ImageNet by default.
        std: the standard deviations of R, G, B; those of ImageNet by default.

    Returns:
        (1, 3, 224, 224), float32.

    Raises:
        TypeError: if frame is not uint8.
        ValueError: if frame is not (H, W, 3), or a standard deviation is not above 0.

    Example:
        >>> preprocess(torch.zeros(480, 640, 3, dtype=torch.uint8)).shape
        torch.Size([1, 3, 224, 224])
    """
    _check(frame)
    for s in std:
        if not s > 0.0:
            raise ValueError(f"std: expected numbers above 0, got {std}")
    return normalized_levels(resize_frame(frame, 224, 224), mean, std)


def edges(frame: Tensor) -> Tensor:
    """Edge strength of a frame: grey, Gaussian blur 5x5 of sigma 1, Sobel magnitude.

    The magnitude is sqrt(gx^2 + gy^2) of the unnormalised 3x3 Sobel derivatives (``cv2.Sobel``'s scale: a
    step of one grey level per pixel gives 8) of grey levels in [0, 255], rounded to the nearest integer and
    saturated at 255.

    Args:
        frame: (H, W, 3), uint8, BGR, H and W at least 3.

    Returns:
        (H, W), uint8.

    Raises:
        TypeError: if frame is not uint8.
        ValueError: if frame is not (H, W, 3), or too small.

    Example:
        >>> edges(torch.full((48, 64, 3), 7, dtype=torch.uint8)).max()
        tensor(0, dtype=torch.uint8)
    """
    _check(frame)
    check_margins(frame.select(2, 0), (2, 2), (2, 2), "reflect", "frame")
    strength = sobel(gaussian_blur2d(frame_to_grey(frame), (5, 5), (1.0, 1.0)), normalized=False)
    return torch.round(strength).clamp(0.0, 255.0).to(torch.uint8)[0, 0]


def _check(frame: Tensor) -> None:
    check_tensor(frame, "frame")
    if frame.dtype != torch.uint8:
        raise TypeError(f"frame: expected dtype torch.uint8, got {frame.dtype}")
    if frame.dim() != 3 or frame.size(2) != 3:
        raise ValueError(f"frame: expected shape (H, W, 3), got {list(frame.shape)}")
    check_not_empty(frame, 3, "frame")
