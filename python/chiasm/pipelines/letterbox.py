"""Conversion of frames of any size to the input of a network: letterboxes, borders, centre crops, and crops
of boxes."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_integer, check_last, check_rank
from ..primitives.resampling.placing import placed_bytes
from ..primitives.resampling.taps import larger, smaller
from .network_input import (
    Numbers,
    check_filter,
    check_frame,
    check_size,
    check_value,
    network_input,
    placed_frames,
    sides,
)


def letterbox(
    frame: Tensor,
    size: Tuple[int, int] = (640, 640),
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    color: str = "bgr",
    fit: str = "pad",
    interpolation: str = "bilinear",
    antialias: bool = False,
    dtype: str = "float32",
    layout: str = "NCHW",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a detector: resize into ``size`` with the aspect ratio kept, fill the
    rest. The result is RGB, in [0, 1], normalized. The shorter side of the resized image is round(ratio *
    side), halves to even, and half of the rest, rounded down, lies before the image: the method of YOLO's
    authors (resize, copyMakeBorder). Pixels are resized by bilinear interpolation with weights in multiples
    of 1/256 and rounded, as in OpenCV's INTER_LINEAR_EXACT.

    With ``antialias``, or the interpolation "area", a pixel is a mean over all pixels that it stands for, as
    in ``geometry.transform.resize``: with weights in multiples of 1/2^22, and rounded after each axis.
    Frames of 16 bits are resized with weights in multiples of 1/2^18, and rounded once, to 16 bits.

    Args:
        frame: (B, H, W, 3), uint8 or uint16; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        size: height and width of the result.
        value: the value of the pixels beside the image, 0 to 255; with uint16, 257 times that.
        anchor: the position of the image: "center" or "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr" as in OpenCV, "rgb", "bgra" or "rgba", of which alpha
            is not read, or "gray".
        fit: "pad" as above, or "stretch": the image fills the result, the aspect ratio is not kept.
        interpolation: "bilinear" or "area"; with antialias "bilinear", "bicubic" or "lanczos", Pillow's.
        antialias: stretch the filter by the reduction factor (not for "area", which always does).
        dtype: that of the result: "float32", "float16", or "uint8" for levels, 0 to 255, that are not
            normalized: mean and std must then be zeros and ones, and frame uint8.
        layout: that of the result: "NCHW" or "NHWC".

    Returns:
        (B, 3, height, width), or (B, height, width, 3) for "NHWC", and (B, 3, 3), float32: the transform
        from coordinates in the result to coordinates in the frame, in pixels, where (0, 0) is the outer
        corner of the first pixel. Use it with ``geometry.bbox.transform_bbox`` and
        ``geometry.linalg.transform_points``.

    Raises:
        TypeError: if frame is neither uint8 nor uint16.
        ValueError: if frame is not of the shape above or has no pixels, a size is not positive, value is no
            byte, a standard deviation is not above 0, or a choice is not as above.

    Example:
        >>> image, to_frame = letterbox(torch.zeros(1, 720, 1280, 3, dtype=torch.uint8))
        >>> image.shape, to_frame[0, 1]
        (torch.Size([1, 3, 640, 640]), tensor([   0.,    2., -280.]))
    """
    check_frame(frame, color, True)
    check_size(size)
    check_value(value)
    check_choice(anchor, ["center", "top_left"], "anchor")
    check_choice(fit, ["pad", "stretch"], "fit")
    check_filter(interpolation, antialias)
    height, width = sides(frame)
    one = torch.ones_like(height)
    target_height, target_width = one * size[0], one * size[1]
    if fit == "stretch":
        least = size
        to = [torch.zeros_like(one), torch.zeros_like(one), target_width, target_height]
    else:
        ratio = torch.minimum(target_height / height, target_width / width)
        resized_height = torch.round(height * ratio).clamp(min=1.0)
        resized_width = torch.round(width * ratio).clamp(min=1.0)
        # The same, rounded down, in numbers.
        least = (
            larger(smaller(size[0], frame.size(1) * size[1] // frame.size(2)), 1),
            larger(smaller(size[1], frame.size(2) * size[0] // frame.size(1)), 1),
        )
        left, top = _before(anchor, size, resized_height, resized_width)
        to = [left, top, resized_width, resized_height]
    placed, to_frame = placed_frames(frame, to, least, size, value, interpolation, antialias)
    return network_input(placed, mean, std, color, dtype, layout), to_frame


def letterbox_longest(
    frame: Tensor,
    longest: int = 640,
    multiple: int = 32,
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    color: str = "bgr",
    interpolation: str = "bilinear",
    antialias: bool = False,
    dtype: str = "float32",
    layout: str = "NCHW",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a detector that takes any multiple of its stride: resize with the aspect
    ratio kept, until the longer side is ``longest``, then fill both sides up to the next multiples. A frame
    that is not square takes fewer pixels than in ``letterbox``: this is what YOLO's authors call rectangular
    inference. Otherwise as ``letterbox``.

    Args:
        frame: (B, H, W, 3), uint8 or uint16; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        longest: the longer side of the resized frame, in pixels.
        multiple: what height and width of the result are multiples of, an even number.
        value: the value of the pixels beside the image, 0 to 255; with uint16, 257 times that.
        anchor: the position of the image: "center" (half of the rest, rounded down, lies before it) or
            "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr", "rgb", "bgra", "rgba" or "gray".
        interpolation: as in ``letterbox``: "bilinear", "area", "bicubic" or "lanczos".
        antialias: stretch the filter by the reduction factor, as in ``letterbox``.
        dtype: that of the result, as in ``letterbox``: "float32", "float16" or "uint8".
        layout: that of the result: "NCHW" or "NHWC".

    Returns:
        (B, 3, height, width), or (B, height, width, 3) for "NHWC", and (B, 3, 3), float32: to the frame, as
        in ``letterbox``.

    Raises:
        TypeError: if frame is neither uint8 nor uint16.
        ValueError: if frame is not of the shape above or has no pixels, longest is not positive, multiple is
            not positive and even, value is no byte, a standard deviation is not above 0, or a choice is not
            as in ``letterbox``.

    Example:
        >>> letterbox_longest(torch.zeros(1, 720, 1280, 3, dtype=torch.uint8))[0].shape
        torch.Size([1, 3, 384, 640])
    """
    check_frame(frame, color, True)
    check_integer(longest, "longest")
    if not (longest >= 1 and longest % 1 == 0):
        raise ValueError(f"longest: expected a positive whole number, got {longest}")
    check_integer(multiple, "multiple")
    if not (multiple >= 2 and multiple % 2 == 0):
        raise ValueError(f"multiple: expected a positive even number, got {multiple}")
    check_value(value)
    check_choice(anchor, ["center", "top_left"], "anchor")
    check_filter(interpolation, antialias)
    size = (
        multiple * _multiples(frame.size(1), frame.size(2), longest, multiple),
        multiple * _multiples(frame.size(2), frame.size(1), longest, multiple),
    )
    height, width = sides(frame)
    longer = torch.maximum(height, width)
    resized_height = torch.round(height * longest / longer).clamp(min=1.0)
    resized_width = torch.round(width * longest / longer).clamp(min=1.0)
    left, top = _before(anchor, size, resized_height, resized_width)
    # The same, rounded down, in numbers.
    least = (
        larger(smaller(longest, frame.size(1) * longest // frame.size(2)), 1),
        larger(smaller(longest, frame.size(2) * longest // frame.size(1)), 1),
    )
    to = [left, top, resized_width, resized_height]
    placed, to_frame = placed_frames(frame, to, least, size, value, interpolation, antialias)
    return network_input(placed, mean, std, color, dtype, layout), to_frame


def _before(anchor: str, size: Tuple[int, int], height: Tensor, width: Tensor) -> Tuple[Tensor, Tensor]:
    """How much of a result of this size lies on the left of an image (height, width), and above it."""
    if anchor != "center":
        return torch.zeros_like(width), torch.zeros_like(height)
    one = torch.ones_like(height)
    return torch.floor((one * size[1] - width) * 0.5), torch.floor((one * size[0] - height) * 0.5)


def _multiples(side: int, other: int, longest: int, multiple: int) -> int:
    """How many times ``multiple`` it takes to hold a side of a frame that is resized until the longer one is
    ``longest``. It is written with + - * // alone, which is what a manifest states sizes with: 1 // (1 + x)
    is 1 if x is 0, and 0 if x is above 0."""
    # side / other * longest is rounded, halves to even, and so to an even multiple, which holds it: rounding
    # up what is more than a half above a multiple rounds both.
    count = (2 * longest * side + (2 * multiple - 1) * other - 1) // (2 * multiple * other)
    most = (longest + multiple - 1) // multiple  # of the longer side
    return most + (count - most) * (1 // (1 + count // most)) + 1 // (1 + count)


def pad_to_multiple(
    frame: Tensor,
    multiple: int = 32,
    value: int = 114,
    anchor: str = "center",
    mean: Numbers = (0.0, 0.0, 0.0),
    std: Numbers = (1.0, 1.0, 1.0),
    color: str = "bgr",
    dtype: str = "float32",
    layout: str = "NCHW",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a network that takes any multiple of its stride: no pixel is resized;
    the sides become the next multiples, and the rest is filled. The result is RGB, in [0, 1], normalized.

    Args:
        frame: (B, H, W, 3), uint8 or uint16; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        multiple: what height and width of the result are multiples of.
        value: the value of the pixels beside the image, 0 to 255; with uint16, 257 times that.
        anchor: the position of the image: "center" (half of the rest, rounded down, lies before it) or
            "top_left".
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr", "rgb", "bgra", "rgba" or "gray".
        dtype: that of the result, as in ``letterbox``: "float32", "float16" or "uint8".
        layout: that of the result: "NCHW" or "NHWC".

    Returns:
        (B, 3, height, width), or (B, height, width, 3) for "NHWC", and (B, 3, 3), float32: to the frame, as
        in ``letterbox``.

    Raises:
        TypeError: if frame is neither uint8 nor uint16.
        ValueError: if frame is not of the shape above or has no pixels, multiple is not positive, value is
            no byte, a standard deviation is not above 0, or a choice is not as in ``letterbox``.

    Example:
        >>> pad_to_multiple(torch.zeros(1, 427, 640, 3, dtype=torch.uint8))[0].shape
        torch.Size([1, 3, 448, 640])
    """
    check_frame(frame, color, True)
    check_integer(multiple, "multiple")
    if not (multiple >= 1 and multiple % 1 == 0):
        raise ValueError(f"multiple: expected a positive whole number, got {multiple}")
    check_value(value)
    check_choice(anchor, ["center", "top_left"], "anchor")
    size = (
        (frame.size(1) + multiple - 1) // multiple * multiple,
        (frame.size(2) + multiple - 1) // multiple * multiple,
    )
    height, width = sides(frame)
    left, top = _before(anchor, size, height, width)
    least = (frame.size(1), frame.size(2))
    placed, to_frame = placed_frames(frame, [left, top, width, height], least, size, value)
    return network_input(placed, mean, std, color, dtype, layout), to_frame


def center_crop(
    frame: Tensor,
    size: Tuple[int, int] = (224, 224),
    shortest: int = 256,
    mean: Numbers = (0.485, 0.456, 0.406),
    std: Numbers = (0.229, 0.224, 0.225),
    color: str = "bgr",
    interpolation: str = "bilinear",
    antialias: bool = False,
    dtype: str = "float32",
    layout: str = "NCHW",
) -> Tuple[Tensor, Tensor]:
    """Convert frames to the input of a classifier: resize the shorter side to ``shortest``, then crop the
    centre. The result is RGB, in [0, 1], normalized, by default with ImageNet's numbers.

    The longer side becomes shortest * longer / shorter, rounded down, and the crop begins at half of the
    remaining pixels, halves to even, as in torchvision's Resize and CenterCrop. Pixels are resized as in
    ``letterbox``, with ``antialias`` as torchvision does with images of Pillow; pixels outside a frame that
    is smaller than the crop are black.

    Args:
        frame: (B, H, W, 3), uint8 or uint16; (B, H, W, 4) or (B, H, W, 1) if ``color`` says so.
        size: height and width of the result.
        shortest: the shorter side of the resized frame, in pixels.
        mean: the means of red, green and blue, for values in [0, 1].
        std: the standard deviations of red, green and blue, for values in [0, 1].
        color: the order of a frame's channels: "bgr", "rgb", "bgra", "rgba" or "gray".
        interpolation: as in ``letterbox``: "bilinear", "area", "bicubic" or "lanczos".
        antialias: stretch the filter by the reduction factor, as in ``letterbox``.
        dtype: that of the result, as in ``letterbox``: "float32", "float16" or "uint8".
        layout: that of the result: "NCHW" or "NHWC".

    Returns:
        (B, 3, height, width), or (B, height, width, 3) for "NHWC", and (B, 3, 3), float32: to the frame, as
        in ``letterbox``.

    Raises:
        TypeError: if frame is neither uint8 nor uint16.
        ValueError: if frame is not of the shape above, a size is not positive, a standard deviation is not
            above 0, or a choice is not as in ``letterbox``.

    Example:
        >>> center_crop(torch.zeros(2, 480, 640, 3, dtype=torch.uint8))[0].shape
        torch.Size([2, 3, 224, 224])
    """
    check_frame(frame, color, True)
    check_size(size)
    if shortest < 1:
        raise ValueError(f"shortest: expected a positive number, got {shortest}")
    check_filter(interpolation, antialias)
    height, width = sides(frame)
    shorter = torch.minimum(height, width)
    resized_height = torch.floor(height * float(shortest) / shorter)
    resized_width = torch.floor(width * float(shortest) / shorter)
    top = torch.round((float(size[0]) - resized_height) * 0.5)
    left = torch.round((float(size[1]) - resized_width) * 0.5)
    to = [left, top, resized_width, resized_height]
    # The same in numbers.
    least_height = frame.size(1) * shortest // smaller(frame.size(1), frame.size(2))
    least_width = frame.size(2) * shortest // smaller(frame.size(1), frame.size(2))
    placed, to_frame = placed_frames(
        frame, to, (least_height, least_width), size, 0, interpolation, antialias
    )
    return network_input(placed, mean, std, color, dtype, layout), to_frame


def crop_boxes(
    frame: Tensor,
    boxes: Tensor,
    size: Tuple[int, int] = (224, 224),
    mean: Numbers = (0.485, 0.456, 0.406),
    std: Numbers = (0.229, 0.224, 0.225),
    color: str = "bgr",
    dtype: str = "float32",
    layout: str = "NCHW",
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
        dtype: that of the result, as in ``letterbox``: "float32", "float16" or "uint8".
        layout: that of the result: "NCHW" or "NHWC".

    Returns:
        (N, 3, height, width), or (N, height, width, 3) for "NHWC".

    Raises:
        TypeError: if frame is not uint8 or boxes is not floating point.
        ValueError: if frame is not of the shape above, boxes is not (N, 4), a size is not positive, a
            standard deviation is not above 0, or a choice is not as in ``letterbox``.

    Example:
        >>> frame = torch.zeros(480, 640, 3, dtype=torch.uint8)
        >>> crop_boxes(frame, torch.tensor([[10.0, 20.0, 110.0, 220.0]])).shape
        torch.Size([1, 3, 224, 224])
    """
    check_rank(frame, 3, "(H, W, 3)", "frame")
    check_frame(frame[None], color, False)
    check_size(size)
    check_rank(boxes, 2, "(N, 4)", "boxes")
    check_last(boxes, 4, "boxes")
    known = torch.where(boxes.abs() < float("inf"), boxes, torch.zeros_like(boxes))
    corners = torch.round(known.to(torch.float64)).clamp(-16777216.0, 16777216.0).to(torch.int64)
    first = corners[:, :2]
    extent = (corners[:, 2:] - first).clamp(min=1)
    target = torch.tensor([[0, 0, size[1], size[0]]], device=frame.device).expand(boxes.size(0), -1)
    images = torch.zeros_like(corners[:, 0])
    places = torch.cat([first, extent, target], 1)
    placed = placed_bytes(frame[None].permute(0, 3, 1, 2), images, places, size[0], size[1], 0)
    return network_input(placed, mean, std, color, dtype, layout)
