"""Conversion between images of cameras and files (uint8, channels last) and the tensors that ops take."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_tensor
from ..primitives.core.layout import in_frames
from ..primitives.numbers.rounding import known_or


def frames_to_tensor(image: Tensor, keepdim: bool = False) -> Tensor:
    """Convert uint8 with channels last to floating point in [0, 1] with channels first. The order of the
    channels is kept: OpenCV's images are BGR. ``image_to_tensor`` takes an array and does not scale.

    Args:
        image: (H, W, C) or (B, H, W, C), uint8.
        keepdim: True returns one image without a batch dimension.

    Returns:
        (B, C, H, W), float32 in [0, 1]; B is 1 for one image. With keepdim (C, H, W) for one image.

    Raises:
        TypeError: if image is not uint8.
        ValueError: if image has neither 3 nor 4 dimensions.

    Example:
        >>> frames_to_tensor(torch.full((4, 6, 3), 255, dtype=torch.uint8)).shape
        torch.Size([1, 3, 4, 6])
    """
    check_tensor(image, "image")
    if image.dtype != torch.uint8:
        raise TypeError(f"image: expected dtype torch.uint8, got {image.dtype}")
    if image.dim() != 3 and image.dim() != 4:
        raise ValueError(f"image: expected shape (H, W, C) or (B, H, W, C), got {list(image.shape)}")
    batch = image if image.dim() == 4 else image.unsqueeze(0)
    made = (batch.permute(0, 3, 1, 2).to(torch.float32) / 255.0).contiguous()
    return made[0] if keepdim and image.dim() == 3 else made


def tensor_to_frames(tensor: Tensor) -> Tensor:
    """Convert floating point in [0, 1] with channels first to uint8 with channels last.

    255 times the value is rounded to the nearest integer (ties to even) and saturated, like OpenCV's
    ``convertTo``. ``tensor_to_image`` makes an array and does not scale.

    Args:
        tensor: (C, H, W) or (B, C, H, W), floating point.

    Returns:
        (H, W, C) or (B, H, W, C), uint8.

    Raises:
        TypeError: if tensor is not floating point.
        ValueError: if tensor has neither 3 nor 4 dimensions.

    Example:
        >>> tensor_to_frames(torch.tensor([0.5, 1.5]).reshape(2, 1, 1))
        tensor([[[128, 255]]], dtype=torch.uint8)
    """
    check_floating(tensor, "tensor")
    if tensor.dim() != 3 and tensor.dim() != 4:
        raise ValueError(f"tensor: expected shape (C, H, W) or (B, C, H, W), got {list(tensor.shape)}")
    levels = known_or(torch.round(tensor * 255.0), 0.0).clamp(0.0, 255.0).to(torch.uint8)
    return in_frames(levels[None])[0] if tensor.dim() == 3 else in_frames(levels)
