"""Formats of cameras and video decoders: luma and chroma as uint8, the chroma at a lower resolution. A buffer
of NV12 holds H x W luma and then (H + 1) // 2 x (W + 1) // 2 pairs of chroma; one of I420 has two planes
instead of the pairs. Each op takes these parts as tensors that can share the buffer's memory, without a copy.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_not_empty, check_tensor
from ..primitives.images.color_planes import check_channels
from ..primitives.images.subsampled import packed_to_rgb, planar_to_rgb, rgb_to_subsampled, subsampled_to_rgb


def nv12_to_rgb(y: Tensor, uv: Tensor, standard: str = "bt601") -> Tensor:
    """RGB from luma and pairs U, V (4:2:0), the format of hardware decoders and V4L2 cameras.

    ITU-R BT.601-7 and BT.709-6. A pixel uses the nearest chroma pair, so the chroma can have any resolution,
    for example that of NV16 (4:2:2) or NV24 (4:4:4). The factors are multiples of 1/2^20; sums are rounded
    (halves up) and saturated. For "bt601" the factors are OpenCV's, and the result is identical to that of
    cvtColorTwoPlane.

    Args:
        y: luma (B, 1, H, W), uint8.
        uv: chroma (B, 2, h, w), uint8: U and V around 128. A frame (B, h, w, 2) must be permuted to this
            shape.
        standard: "bt601" (standard definition, webcams) or "bt709" (high definition), in which black is 16
            and white 235; or "jpeg": BT.601's factors with the full range from 0 to 255.

    Returns:
        (B, 3, H, W), uint8: red, green, blue.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape is not as above, or standard is none of these.

    Example:
        >>> y = torch.full((1, 1, 4, 6), 235, dtype=torch.uint8)
        >>> nv12_to_rgb(y, torch.full((1, 2, 2, 3), 128, dtype=torch.uint8))[0, :, 0, 0]
        tensor([255, 255, 255], dtype=torch.uint8)
    """
    _check_part(y, 1, "y")
    _check_part(uv, 2, "uv")
    _check_batch(uv, y, "uv")
    return subsampled_to_rgb(y, uv, _weights(standard), False)


def nv21_to_rgb(y: Tensor, vu: Tensor, standard: str = "bt601") -> Tensor:
    """RGB from luma and pairs V, U (4:2:0), the format of Android's cameras. Otherwise as ``nv12_to_rgb``.

    Args:
        y: luma (B, 1, H, W), uint8.
        vu: chroma (B, 2, h, w), uint8: V and U around 128.
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, H, W), uint8: red, green, blue.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape is not as above, or standard is none of these.

    Example:
        >>> y = torch.full((1, 1, 4, 6), 16, dtype=torch.uint8)
        >>> nv21_to_rgb(y, torch.full((1, 2, 2, 3), 128, dtype=torch.uint8))[0, :, 0, 0]
        tensor([0, 0, 0], dtype=torch.uint8)
    """
    _check_part(y, 1, "y")
    _check_part(vu, 2, "vu")
    _check_batch(vu, y, "vu")
    return subsampled_to_rgb(y, vu, _weights(standard), True)


def i420_to_rgb(y: Tensor, u: Tensor, v: Tensor, standard: str = "bt601") -> Tensor:
    """RGB from three planes (4:2:0), the format of video codecs; otherwise as ``nv12_to_rgb``. YV12 is the
    same format with V before U.

    Args:
        y: luma (B, 1, H, W), uint8.
        u: chroma (B, 1, h, w), uint8, around 128.
        v: chroma (B, 1, h, w), uint8, around 128.
        standard: "bt601", "bt709" or "jpeg".

    Returns:
        (B, 3, H, W), uint8: red, green, blue.

    Raises:
        TypeError: if a part is not uint8.
        ValueError: if a shape is not as above, or standard is none of these.

    Example:
        >>> y, grey = torch.full((1, 1, 4, 6), 235, dtype=torch.uint8), torch.full((1, 1, 2, 3), 128)
        >>> i420_to_rgb(y, grey.to(torch.uint8), grey.to(torch.uint8))[0, :, 0, 0]
        tensor([255, 255, 255], dtype=torch.uint8)
    """
    _check_part(y, 1, "y")
    _check_part(u, 1, "u")
    _check_part(v, 1, "v")
    _check_batch(u, y, "u")
    if v.shape != u.shape:
        raise ValueError(f"v: expected the shape {list(u.shape)} of u, got {list(v.shape)}")
    return planar_to_rgb(y, u, v, _weights(standard))


def yuyv_to_rgb(image: Tensor, standard: str = "bt601") -> Tensor:
    """RGB from packed pixels Y, U, Y, V (4:2:2), the format of USB cameras; YUY2 is the same.

    The factors and rounding are those of ``nv12_to_rgb``; for "bt601" the result is identical to that of
    OpenCV's COLOR_YUV2RGB_YUYV. OpenCV stores the buffer with two channels and W columns; ``mat.reshape(4)``
    has this op's layout and shares the memory.

    Args:
        image: (B, 4, H, W / 2), uint8; the four channels are two neighbouring pixels.
        standard: "bt601", "bt709" or "jpeg", as in ``nv12_to_rgb``.

    Returns:
        (B, 3, H, W), uint8: red, green, blue.

    Raises:
        TypeError: if image is not uint8.
        ValueError: if image is not (B, 4, H, W / 2), or standard is none of these.

    Example:
        >>> yuyv_to_rgb(torch.full((1, 4, 2, 3), 128, dtype=torch.uint8)).shape
        torch.Size([1, 3, 2, 6])
    """
    _check_part(image, 4, "image")
    return packed_to_rgb(image, _weights(standard), True)


def uyvy_to_rgb(image: Tensor, standard: str = "bt601") -> Tensor:
    """RGB from packed pixels U, Y, V, Y (4:2:2), the format of frame grabbers. Otherwise as ``yuyv_to_rgb``.

    Args:
        image: (B, 4, H, W / 2), uint8; the four channels are two neighbouring pixels.
        standard: "bt601", "bt709" or "jpeg", as in ``nv12_to_rgb``.

    Returns:
        (B, 3, H, W), uint8: red, green, blue.

    Raises:
        TypeError: if image is not uint8.
        ValueError: if image is not (B, 4, H, W / 2), or standard is none of these.

    Example:
        >>> uyvy_to_rgb(torch.full((1, 4, 2, 3), 128, dtype=torch.uint8)).shape
        torch.Size([1, 3, 2, 6])
    """
    _check_part(image, 4, "image")
    return packed_to_rgb(image, _weights(standard), False)


def rgb_to_nv12(image: Tensor, standard: str = "bt601") -> Tuple[Tensor, Tensor]:
    """Luma and pairs U, V at half the width and height (4:2:0), the format of hardware encoders.

    The inverse of ``nv12_to_rgb``: ITU-R BT.601-7 and BT.709-6. A pair is computed from the mean of 2 x 2
    pixels; for an odd size, the last row or column counts twice. The factors are multiples of 1/2^20, and
    sums are rounded (halves up). For "bt601" the luma is identical to that of OpenCV's COLOR_RGB2YUV_I420;
    OpenCV uses the pair of the upper left pixel instead of the mean.

    Args:
        image: RGB image (B, 3, H, W), uint8.
        standard: "bt601", "bt709" or "jpeg", as in ``nv12_to_rgb``.

    Returns:
        Luma (B, 1, H, W), and U, V (B, 2, (H + 1) // 2, (W + 1) // 2) around 128, uint8. With frames (B, H,
        W, C), the pairs are (B, h, w, 2), the memory layout of an NV12 buffer.

    Raises:
        TypeError: if image is not uint8.
        ValueError: if image is not (B, 3, H, W), or standard is none of these.

    Example:
        >>> y, uv = rgb_to_nv12(torch.full((1, 3, 4, 6), 255, dtype=torch.uint8))
        >>> y[0, 0, 0, 0], uv[0, :, 0, 0], list(uv.shape)
        (tensor(235, dtype=torch.uint8), tensor([128, 128], dtype=torch.uint8), [1, 2, 2, 3])
    """
    _check_part(image, 3, "image")
    return rgb_to_subsampled(image, _factors(standard))


def _factors(standard: str) -> List[int]:
    """Factors in 1/2^20 and the luma of black, as `rgb_to_subsampled` takes them."""
    check_choice(standard, ["bt601", "bt709", "jpeg"], "standard")
    if standard == "bt601":
        # OpenCV's: those of the standard to three digits
        return [269484, 528482, 102760, -155188, -305135, 460324, 460324, -385875, -74448, 16]
    if standard == "bt709":
        # 219 / 255 times 0.2126, 0.7152, 0.0722; 224 / 255 times the differences to luma, over twice 0.9278
        # and 0.7874
        return [191455, 644067, 65019, -105533, -355018, 460551, 460551, -418321, -42230, 16]
    return [313524, 615514, 119538, -176932, -347356, 524288, 524288, -439026, -85262, 0]


def _check_part(part: Tensor, channels: int, name: str) -> None:
    check_tensor(part, name)
    if part.dtype != torch.uint8:
        raise TypeError(f"{name}: expected dtype uint8, got {part.dtype}")
    if part.dim() != 4:
        raise ValueError(f"{name}: expected shape (B, {channels}, H, W), got {list(part.shape)}")
    check_channels(part, channels, name)
    check_not_empty(part, 2, name)


def _check_batch(part: Tensor, y: Tensor, name: str) -> None:
    if part.size(0) != y.size(0):
        raise ValueError(f"{name}: expected the batch size {y.size(0)} of y, got {part.size(0)}")


def _weights(standard: str) -> List[int]:
    """Factors in 1/2^20, as `subsampled_to_rgb` takes them."""
    check_choice(standard, ["bt601", "bt709", "jpeg"], "standard")
    if standard == "bt601":
        # OpenCV's: the standard's, 1.164, 1.596, -0.391, -0.813, 2.018, to three digits
        return [1220542, 1673527, -409993, -852492, 2116026, 16]
    if standard == "bt709":
        # With the luma of red 0.2126 and of blue 0.0722: 255 / 219, and 255 / 224 times 2 (1 - 0.2126) for
        # red, 2 (1 - 0.0722) for blue, and for green what these leave.
        return [1220945, 1879825, -223607, -558796, 2215014, 16]
    # With the luma of red 0.299 and of blue 0.114
    return [1048576, 1470104, -360853, -748826, 1858077, 0]
