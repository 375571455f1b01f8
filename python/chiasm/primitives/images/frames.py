"""Camera frames (uint8, H x W x BGR) as images."""

from typing import Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..filters.stencil import join_channels
from ..kernels import operators as kernels
from ..resampling.resizing import resized
from .color_planes import mix_channels


def _has_kernel(frame: Tensor, *_: object) -> bool:
    """Whether the kernels take a frame: bytes, in rows of at least two pixels."""
    width = frame.size(1)
    return (
        kernels.available(frame) and frame.dtype == torch.uint8 and not (isinstance(width, int) and width < 2)
    )


@primitive
def frame_to_grey(frame: Tensor) -> Tensor:
    """(1, 1, H, W), float32, in [0, 255]: the luma of a frame."""
    return mix_channels(_rgb(frame), [0.299, 0.587, 0.114], 0.0, "frame")


frame_to_grey.lowering("native", when=_has_kernel)(kernels.frame_to_grey)


@primitive
def resize_frame(frame: Tensor, height: int, width: int) -> Tensor:
    """(1, 3, height, width), float32, RGB, in [0, 255]: a frame, resized bilinearly."""
    return resized(_rgb(frame), height, width, "bilinear", False, False)


resize_frame.lowering("native", when=_has_kernel)(kernels.resize_frame)


def _rgb(frame: Tensor) -> Tensor:
    """(1, 3, H, W), float32, RGB, in [0, 255]: a frame."""
    return frame.permute(2, 0, 1)[None].to(torch.float32).flip([-3])


def normalized_levels(
    image: Tensor, mean: Tuple[float, float, float], std: Tuple[float, float, float]
) -> Tensor:
    """(image / 255 - mean) / std of levels (B, 3, H, W): one product and one sum for each plane, with numbers
    that native code keeps in its loop."""
    planes = [image[:, c : c + 1] * (1.0 / (255.0 * s)) - m / s for c, (m, s) in enumerate(zip(mean, std))]
    return join_channels(planes)
