"""Frames placed in an image of one size, and that image as a network takes it: what letterboxes and crops
have in common."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_integer, check_pair, check_tensor, check_triple
from ..primitives.core.layout import in_frames, in_planes
from ..primitives.images.color_planes import arranged
from ..primitives.resampling.placing import placed_bytes, placed_filtered, scaled_bytes

Numbers = Tuple[float, float, float]


def check_frame(frame: Tensor, color: str, words: bool) -> None:
    """Raise unless ``frame`` is (B, H, W, C) with the channels of ``color``: bytes, or with ``words`` also
    uint16."""
    check_tensor(frame, "frame")
    if frame.dtype != torch.uint8 and not (words and frame.dtype == torch.uint16):
        expected = "torch.uint8 or torch.uint16" if words else "torch.uint8"
        raise TypeError(f"frame: expected dtype {expected}, got {frame.dtype}")
    check_choice(color, ["bgr", "rgb", "bgra", "rgba", "gray"], "color")
    channels = 1 if color == "gray" else len(color)
    if frame.dim() != 4 or frame.size(3) != channels:
        raise ValueError(f"frame: expected shape (B, H, W, {channels}), got {list(frame.shape)}")
    if frame.size(1) < 1 or frame.size(2) < 1:
        raise ValueError(f"frame: expected at least one pixel, got {list(frame.shape)}")


def check_size(size: Tuple[int, int]) -> None:
    check_pair(size, "size")
    if size[0] < 1 or size[1] < 1:
        raise ValueError(f"size: expected positive numbers, got ({size[0]}, {size[1]})")


def check_value(value: int) -> None:
    check_integer(value, "value")
    if not (value >= 0 and value <= 255 and value % 1 == 0):
        raise ValueError(f"value: expected a whole number from 0 to 255, got {value}")


def check_filter(interpolation: str, antialias: bool) -> None:
    check_choice(interpolation, ["bilinear", "bicubic", "area", "lanczos"], "interpolation")
    if antialias and interpolation == "area":
        raise ValueError("antialias: expected False for interpolation 'area', got True")
    if not antialias and (interpolation == "bicubic" or interpolation == "lanczos"):
        raise ValueError(f"antialias: expected True for interpolation '{interpolation}', got False")


def sides(frame: Tensor) -> Tuple[Tensor, Tensor]:
    """Height and width as tensors, so that computations with them do not fix a size in exports."""
    one = torch.ones([1], dtype=torch.float64, device=frame.device)
    return one * frame.size(1), one * frame.size(2)


def placed_frames(
    frame: Tensor,
    to: List[Tensor],
    least: Tuple[int, int],
    size: Tuple[int, int],
    value: int,
    interpolation: str = "bilinear",
    antialias: bool = False,
) -> Tuple[Tensor, Tensor]:
    """All of each frame, resized and placed in (B, C, height, width), and the transform (B, 3, 3) back.

    ``to``: left, top, width and height of the place, (1,) each. ``least``: numbers that its height and width
    are not below.
    """
    height, width = sides(frame)
    zero = torch.zeros_like(height)
    box = torch.cat([zero, zero, width, height] + to).to(torch.int64)
    boxes = box[None].expand(frame.size(0), -1)
    x = frame.permute(0, 3, 1, 2)
    if frame.dtype == torch.uint8 and interpolation == "bilinear" and not antialias:
        images = torch.arange(frame.size(0), device=frame.device)
        placed = placed_bytes(x, images, boxes, size[0], size[1], value)
    else:
        pad = float(value if frame.dtype == torch.uint8 else 257 * value)
        placed = placed_filtered(x, box[4:], least, size[0], size[1], pad, interpolation, antialias)
    return placed, _to_frame(boxes)


def _to_frame(boxes: Tensor) -> Tensor:
    """(B, 3, 3): the transform from the places back to the boxes that are read."""
    numbers = boxes.to(torch.float64)
    across, down = numbers[:, 2] / numbers[:, 6], numbers[:, 3] / numbers[:, 7]
    zero, one = torch.zeros_like(across), torch.ones_like(across)
    left, top = numbers[:, 0] - numbers[:, 4] * across, numbers[:, 1] - numbers[:, 5] * down
    rows = torch.stack([across, zero, left, zero, down, top, zero, zero, one], 1)
    return rows.reshape(-1, 3, 3).to(torch.float32)


def network_input(placed: Tensor, mean: Numbers, std: Numbers, color: str, dtype: str, layout: str) -> Tensor:
    """Placed frames (B, C, h, w), bytes or levels of 16 bits in float32, as red, green and blue of the dtype,
    in the layout."""
    check_triple(mean, "mean")
    check_triple(std, "std")
    check_choice(dtype, ["float32", "float16", "uint8"], "dtype")
    check_choice(layout, ["NCHW", "NHWC"], "layout")
    order = [0, 1, 2] if color.startswith("rgb") else [2, 1, 0]
    if color == "gray":
        order = [0, 0, 0]
    if dtype == "uint8":
        if placed.dtype != torch.uint8:
            raise ValueError(
                "dtype: expected 'float32' or 'float16' for a frame of torch.uint16, got 'uint8'"
            )
        for m, s in zip(mean, std):
            if m != 0.0:
                raise ValueError(f"mean: expected zeros for dtype 'uint8', got {mean}")
            if s != 1.0:
                raise ValueError(f"std: expected ones for dtype 'uint8', got {std}")
        image = arranged(placed, order, 0.0)
        return in_frames(image) if layout == "NHWC" else in_planes(image).contiguous()
    peak = 255.0 if placed.dtype == torch.uint8 else 65535.0
    scale: List[float] = []
    offset: List[float] = []
    for m, s in zip(mean, std):
        if not s > 0.0:
            raise ValueError(f"std: expected numbers above 0, got {std}")
        scale.append(1.0 / (peak * s))
        offset.append(-m / s)
    scaled = scaled_bytes(placed, order, scale, offset)
    if layout == "NHWC":
        scaled = in_frames(scaled)
    return scaled.to(torch.float16) if dtype == "float16" else scaled
