"""Conversion of frames of any size to the input of a network: letterboxes, centre crops, and crops of
boxes."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_choice,
    check_integer,
    check_last,
    check_pair,
    check_rank,
    check_tensor,
    check_triple,
)
from ..primitives.resampling.placing import placed_bytes, scaled_bytes

Numbers = Tuple[float, float, float]


def letterbox(
    frame: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    color: str = "bgr",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a detector: resize into ``size`` with the aspect ratio kept, fill the
    rest. The result is RGB, in [0, 1], normalized. The shorter side of the resized image is round(ratio *
    side), halves to even, and half of the rest, rounded down, lies before the image: the method of YOLO's
    authors (resize, copyMakeBorder). Pixels are resized by bilinear interpolation with weights in multiples
    of 1/256 and rounded, as in OpenCV's INTER_LINEAR_EXACT.

    Args:
        frame: (B, H, W, 3), uint8; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255.
        anchor: the position of the image: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr" as in OpenCV, "rgb", "bgra" or "rgba", of which alpha
            is not read, or "gray".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32: the transform from coordinates in the result
        to coordinates in the frame, in pixels, where (0, 0) is the outer corner of the first pixel. Use it
        with ``geometry.bbox.transform_bbox`` and ``geometry.linalg.transform_points``.

    Raises:
        TypeError: if frame is not uint8.
        ValueError: if frame is not of the shape above or has no pixels, a size is not positive, value is no
            byte, a standard deviation is not above 0, or a choice is not as above.

    Example:
        >>> image, to_frame = letterbox(torch.zeros(1, 720, 1280, 3, dtype=torch.uint8))
        >>> image.shape, to_frame[0, 1]
        (torch.Size([1, 3, 640, 640]), tensor([   0.,    2., -280.]))
    """
    _check_frame(frame, size, value, color)
    check_choice(anchor, ["center", "top_left"], "anchor")
    height, width = _sides(frame)
    target_height, target_width = float(size[0]), float(size[1])
    ratio = torch.minimum(target_height / height, target_width / width)
    resized_height = torch.round(height * ratio).clamp(min=1.0)
    resized_width = torch.round(width * ratio).clamp(min=1.0)
    top, left = torch.zeros_like(height), torch.zeros_like(width)
    if anchor == "center":
        top = torch.floor((target_height - resized_height) * 0.5)
        left = torch.floor((target_width - resized_width) * 0.5)
    boxes = _whole_frames(frame, [left, top, resized_width, resized_height])
    images = torch.arange(frame.size(0), device=frame.device)
    return _network_input(frame, images, boxes, size, value, mean, std, color), _to_frame(boxes)


def center_crop(
    frame: Tensor,
    size: Tuple[int, int] = (224, 224),
    shortest: int = 256,
    mean: Numbers = (0.485, 0.456, 0.406),
    std: Numbers = (0.229, 0.224, 0.225),
    color: str = "bgr",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a classifier: resize the shorter side to ``shortest``, then crop the
    centre. The result is RGB, in [0, 1], normalized, by default with ImageNet's numbers.

    The longer side becomes shortest * longer / shorter, rounded down, and the crop begins at half of the
    remaining pixels, halves to even, as in torchvision's Resize and CenterCrop. Pixels are resized as in
    ``letterbox``; pixels outside a frame that is smaller than the crop are black.

    Args:
        frame: (B, H, W, 3), uint8; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        size: height and width of the result.
        shortest: the shorter side of the resized frame, in pixels.
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr", "rgb", "bgra", "rgba" or "gray".

    Returns:
        (B, 3, height, width), float32, and (B, 3, 3), float32: to the frame, as in ``letterbox``.

    Raises:
        TypeError: if frame is not uint8.
        ValueError: if frame is not of the shape above, a size is not positive, a standard deviation is not
            above 0, or color is none of these.

    Example:
        >>> center_crop(torch.zeros(2, 480, 640, 3, dtype=torch.uint8))[0].shape
        torch.Size([2, 3, 224, 224])
    """
    _check_frame(frame, size, 0, color)
    if shortest < 1:
        raise ValueError(f"shortest: expected a positive number, got {shortest}")
    height, width = _sides(frame)
    shorter = torch.minimum(height, width)
    resized_height = torch.floor(height * float(shortest) / shorter)
    resized_width = torch.floor(width * float(shortest) / shorter)
    top = torch.round((float(size[0]) - resized_height) * 0.5)
    left = torch.round((float(size[1]) - resized_width) * 0.5)
    boxes = _whole_frames(frame, [left, top, resized_width, resized_height])
    images = torch.arange(frame.size(0), device=frame.device)
    return _network_input(frame, images, boxes, size, 0, mean, std, color), _to_frame(boxes)


def crop_boxes(
    frame: Tensor,
    boxes: Tensor,
    size: Tuple[int, int] = (224, 224),
    mean: Numbers = (0.485, 0.456, 0.406),
    std: Numbers = (0.229, 0.224, 0.225),
    color: str = "bgr",
) -> Tensor:
    """Crop boxes of one frame and resize each to ``size``, as a batch for the next network. The aspect ratio
    is not kept. The result is RGB, in [0, 1], normalized, by default with ImageNet's numbers. Corners are
    rounded to pixels (halves to even); a box has at least one pixel, and the border of the frame is
    replicated outside. Pixels are resized as in ``letterbox``.

    Args:
        frame: (H, W, 3), uint8; (H, W, 4) or (H, W, 1) if ``color`` says so.
        boxes: (N, 4), floating point: x1, y1, x2, y2 in pixels. Coordinates that are not finite count as 0.
        size: height and width of the result.
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr", "rgb", "bgra", "rgba" or "gray".

    Returns:
        (N, 3, height, width), float32.

    Raises:
        TypeError: if frame is not uint8 or boxes is not floating point.
        ValueError: if frame is not of the shape above, boxes is not (N, 4), a size is not positive, a
            standard deviation is not above 0, or color is none of these.

    Example:
        >>> frame = torch.zeros(480, 640, 3, dtype=torch.uint8)
        >>> crop_boxes(frame, torch.tensor([[10.0, 20.0, 110.0, 220.0]])).shape
        torch.Size([1, 3, 224, 224])
    """
    check_rank(frame, 3, "(H, W, 3)", "frame")
    _check_frame(frame[None], size, 0, color)
    check_rank(boxes, 2, "(N, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    known = torch.where(boxes.abs() < float("inf"), boxes, torch.zeros_like(boxes))
    corners = torch.round(known.to(torch.float64)).clamp(-16777216.0, 16777216.0).to(torch.int64)
    first = corners[:, :2]
    extent = (corners[:, 2:] - first).clamp(min=1)
    target = torch.tensor([[0, 0, size[1], size[0]]], device=frame.device).expand(boxes.size(0), -1)
    images = torch.zeros_like(corners[:, 0])
    placed = torch.cat([first, extent, target], 1)
    return _network_input(frame[None], images, placed, size, 0, mean, std, color)


def _check_frame(frame: Tensor, size: Tuple[int, int], value: int, color: str) -> None:
    check_tensor(frame, "frame")
    if frame.dtype != torch.uint8:
        raise TypeError(f"frame: expected dtype torch.uint8, got {frame.dtype}")
    channels = _channels(color)
    if frame.dim() != 4 or frame.size(3) != channels:
        raise ValueError(f"frame: expected shape (B, H, W, {channels}), got {list(frame.shape)}")
    if frame.size(1) < 1 or frame.size(2) < 1:
        raise ValueError(f"frame: expected at least one pixel, got {list(frame.shape)}")
    check_pair(size, "size")
    if size[0] < 1 or size[1] < 1:
        raise ValueError(f"size: expected positive numbers, got ({size[0]}, {size[1]})")
    check_integer(value, "value")
    if not (value >= 0 and value <= 255 and value % 1 == 0):
        raise ValueError(f"value: expected a whole number from 0 to 255, got {value}")


def _channels(color: str) -> int:
    """The number of a frame's channels."""
    check_choice(color, ["bgr", "rgb", "bgra", "rgba", "gray"], "color")
    return 1 if color == "gray" else len(color)


def _sides(frame: Tensor) -> Tuple[Tensor, Tensor]:
    """Height and width as tensors, so that computations with them do not fix a size in exports."""
    one = torch.ones([1], dtype=torch.float64, device=frame.device)
    return one * frame.size(1), one * frame.size(2)


def _whole_frames(frame: Tensor, to: List[Tensor]) -> Tensor:
    """Boxes (B, 8), as `placed_bytes` takes them: all of each frame, which comes to left, top, width and
    height."""
    height, width = _sides(frame)
    zero = torch.zeros_like(height)
    box = torch.cat([zero, zero, width, height] + to)
    return box.to(torch.int64)[None].expand(frame.size(0), -1)


def _network_input(
    frame: Tensor,
    images: Tensor,
    boxes: Tensor,
    size: Tuple[int, int],
    value: int,
    mean: Numbers,
    std: Numbers,
    color: str,
) -> Tensor:
    check_triple(mean, "mean")
    check_triple(std, "std")
    scale: List[float] = []
    offset: List[float] = []
    for m, s in zip(mean, std):
        if not s > 0.0:
            raise ValueError(f"std: expected numbers above 0, got {std}")
        scale.append(1.0 / (255.0 * s))
        offset.append(-m / s)
    placed = placed_bytes(frame.permute(0, 3, 1, 2), images, boxes, size[0], size[1], value)
    order = [0, 1, 2] if color.startswith("rgb") else [2, 1, 0]
    return scaled_bytes(placed, [0, 0, 0] if color == "gray" else order, scale, offset)


def _to_frame(boxes: Tensor) -> Tensor:
    """(B, 3, 3): the transform from the placed boxes back to the boxes that are read."""
    numbers = boxes.to(torch.float64)
    across, down = numbers[:, 2] / numbers[:, 6], numbers[:, 3] / numbers[:, 7]
    zero, one = torch.zeros_like(across), torch.ones_like(across)
    left, top = numbers[:, 0] - numbers[:, 4] * across, numbers[:, 1] - numbers[:, 5] * down
    rows = torch.stack([across, zero, left, zero, down, top, zero, zero, one], 1)
    return rows.reshape(-1, 3, 3).to(torch.float32)
