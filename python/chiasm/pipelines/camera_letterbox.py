"""Letterboxes for the formats of cameras and video decoders: luma and chroma as uint8, as in
``color.nv12_to_rgb``. Each op is the colour conversion followed by `letterbox`, so that its values equal
OpenCV's for "bt601"."""

from typing import Tuple

import torch
from torch import Tensor

from ..color.camera import i420_to_rgb, nv12_to_rgb, nv21_to_rgb, yuyv_to_rgb
from ..primitives.core.checks import check_not_empty, check_tensor
from .letterbox import letterbox
from .network_input import Numbers


def letterbox_nv12(
    y: Tensor,
    uv: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    standard: str = "bt601",
) -> Tuple[Tensor, Tensor]:
    """``letterbox`` for frames in NV12, the format of hardware decoders.

    Args:
        y: luma (B, H, W, 1), uint8.
        uv: chroma (B, h, w, 2), uint8: pairs U, V.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255, after the conversion.
        anchor: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32, as from ``letterbox``.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape or a value is not as above.

    Example:
        >>> y = torch.zeros(1, 720, 1280, 1, dtype=torch.uint8)
        >>> uv = torch.zeros(1, 360, 640, 2, dtype=torch.uint8)
        >>> letterbox_nv12(y, uv)[0].shape
        torch.Size([1, 3, 640, 640])
    """
    rgb = nv12_to_rgb(_planes(y, 1, "y"), _planes(uv, 2, "uv"), standard)
    return _letterbox_rgb(rgb, size, value, anchor, mean, std)


def letterbox_nv21(
    y: Tensor,
    vu: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    standard: str = "bt601",
) -> Tuple[Tensor, Tensor]:
    """``letterbox`` for frames in NV21, the format of Android's cameras.

    Args:
        y: luma (B, H, W, 1), uint8.
        vu: chroma (B, h, w, 2), uint8: pairs V, U.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255, after the conversion.
        anchor: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32, as from ``letterbox``.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape or a value is not as above.

    Example:
        >>> y = torch.zeros(1, 480, 640, 1, dtype=torch.uint8)
        >>> vu = torch.zeros(1, 240, 320, 2, dtype=torch.uint8)
        >>> letterbox_nv21(y, vu, (320, 320))[1][0, 0]
        tensor([2., 0., 0.])
    """
    rgb = nv21_to_rgb(_planes(y, 1, "y"), _planes(vu, 2, "vu"), standard)
    return _letterbox_rgb(rgb, size, value, anchor, mean, std)


def letterbox_i420(
    y: Tensor,
    u: Tensor,
    v: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    standard: str = "bt601",
) -> Tuple[Tensor, Tensor]:
    """``letterbox`` for frames in I420, the format of video codecs.

    Args:
        y: luma (B, H, W, 1), uint8.
        u: chroma (B, h, w, 1), uint8.
        v: chroma (B, h, w, 1), uint8.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255, after the conversion.
        anchor: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32, as from ``letterbox``.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape or a value is not as above.

    Example:
        >>> y = torch.zeros(1, 480, 640, 1, dtype=torch.uint8)
        >>> u = torch.zeros(1, 240, 320, 1, dtype=torch.uint8)
        >>> letterbox_i420(y, u, u, (480, 480))[0].shape
        torch.Size([1, 3, 480, 480])
    """
    rgb = i420_to_rgb(_planes(y, 1, "y"), _planes(u, 1, "u"), _planes(v, 1, "v"), standard)
    return _letterbox_rgb(rgb, size, value, anchor, mean, std)


def letterbox_yuyv(
    frame: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    standard: str = "bt601",
) -> Tuple[Tensor, Tensor]:
    """``letterbox`` for frames in YUYV (YUY2), the format of cameras on USB.

    Args:
        frame: pairs of pixels (B, H, W / 2, 4), uint8: luma, U, luma, V.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255, after the conversion.
        anchor: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32, as from ``letterbox``.

    Raises:
        TypeError: if frame is not uint8.
        ValueError: if a shape or a value is not as above.

    Example:
        >>> letterbox_yuyv(torch.zeros(1, 480, 320, 4, dtype=torch.uint8))[0].shape
        torch.Size([1, 3, 640, 640])
    """
    check_tensor(frame, "frame")
    if frame.dtype != torch.uint8:
        raise TypeError(f"frame: expected dtype torch.uint8, got {frame.dtype}")
    rgb = yuyv_to_rgb(_planes(frame, 4, "frame"), standard)
    return _letterbox_rgb(rgb, size, value, anchor, mean, std)


def _planes(part: Tensor, channels: int, name: str) -> Tensor:
    """A part of frames as the ops of images take it."""
    check_tensor(part, name)
    if part.dim() != 4 or part.size(3) != channels:
        raise ValueError(f"{name}: expected shape (B, H, W, {channels}), got {list(part.shape)}")
    check_not_empty(part, 3, name)
    return part.permute(0, 3, 1, 2)


def _letterbox_rgb(
    rgb: Tensor, size: Tuple[int, int], value: int, anchor: str, mean: Numbers, std: Numbers
) -> Tuple[Tensor, Tensor]:
    return letterbox(rgb.permute(0, 2, 3, 1), size, value, anchor, mean, std, "rgb")
