"""Points and lines, drawn into a copy of the image."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_tensor
from ..primitives.images.histograms import whole_quotient
from ..primitives.numbers.rounding import known_or


def draw_point2d(image: Tensor, points: Tensor, color: Tensor) -> Tensor:
    """Draw points of one pixel. Unlike Kornia, this op does not change its input, rounds coordinates instead
    of truncating them, ignores points outside the image, and takes a batch.

    Args:
        image: (H, W), (C, H, W) or (B, C, H, W), any dtype.
        points: (x, y) in pixels, (N, 2) or, with a batch, (B, N, 2); rounded to the nearest pixel.
        color: (C,) or (1,), in the image's range.

    Returns:
        The image with its points in that colour, of the same shape.

    Raises:
        ValueError: if a shape is not as above.

    Example:
        >>> draw_point2d(torch.zeros(1, 2, 3), torch.tensor([[2, 0]]), torch.tensor([1.0]))
        tensor([[[0., 0., 1.],
                 [0., 0., 0.]]])
    """
    check_tensor(image, "image")
    channels = image.unsqueeze(0) if image.dim() == 2 else image
    _check_points(channels, points, "points")
    at = whole_pixels(points)
    batch = at if channels.dim() == 4 else at.unsqueeze(0)
    painted = _painted(channels, batch[..., 0], batch[..., 1], color)
    return painted.squeeze(0) if image.dim() == 2 else painted


def draw_line(image: Tensor, p1: Tensor, p2: Tensor, color: Tensor) -> Tensor:
    """Draw straight lines one pixel wide, 8-connected, both ends included.

    J. E. Bresenham, Algorithm for computer control of a digital plotter, IBM Systems Journal 4(1), 1965, in
    closed form: for each step along the longer axis, the other coordinate is the nearest one; of two equally
    near ones, the one nearer to the line's left end (OpenCV's rule). Unlike Kornia, this op does not change
    its input, and takes a batch and lines that extend outside the image.

    Args:
        image: (C, H, W) or (B, C, H, W), any dtype.
        p1: start (x, y) in pixels, (2,) or (N, 2); with a batch (B, N, 2). Rounded to the nearest pixel.
        p2: end, like p1.
        color: (C,) or (1,), in the image's range.

    Returns:
        The image with its lines in that colour, of the same shape.

    Raises:
        ValueError: if a shape is not as above.

    Example:
        >>> draw_line(torch.zeros(1, 3, 4), torch.tensor([0, 0]), torch.tensor([3, 2]), torch.tensor([1.0]))[
        ...     0
        ... ]
        tensor([[1., 0., 0., 0.],
                [0., 1., 1., 0.],
                [0., 0., 0., 1.]])
    """
    check_tensor(p1, "p1")
    start = p1.unsqueeze(0) if p1.dim() == 1 else p1
    check_tensor(p2, "p2")
    end = p2.unsqueeze(0) if p2.dim() == 1 else p2
    _check_points(image, start, "p1")
    _check_points(image, end, "p2")
    if start.size(-2) != end.size(-2):
        raise ValueError(f"p2: expected as many points as p1 has, {start.size(-2)}, got {end.size(-2)}")
    first, second = whole_pixels(start), whole_pixels(end)
    if image.dim() == 3:
        first, second = first.unsqueeze(0), second.unsqueeze(0)
    x, y = _line_pixels(first, second, image.size(-2), image.size(-1))
    return _painted(image, x, y, color)


def whole_pixels(points: Tensor) -> Tensor:
    """Coordinates as int64, rounded; they saturate at 2^20 pixels from the origin, which keeps products
    exact. NaN becomes the least coordinate."""
    if points.is_floating_point():
        # Half precision has no number as large as 2^20.
        points = points if points.dtype == torch.float64 else points.to(torch.float32)
        return known_or(torch.round(points), -1048576.0).clamp(-1048576.0, 1048576.0).to(torch.int64)
    return points.to(torch.int64).clamp(-1048576, 1048576)


def _line_pixels(first: Tensor, second: Tensor, height: int, width: int) -> Tuple[Tensor, Tensor]:
    """x and y (B, N * (W + H)) of the lines' pixels: one for each column of a flat line, for each row of a
    steep one.

    Pixels that belong to no line are -1. All arithmetic is in integers, so every backend draws the same.
    """
    leftward = (second[..., :1] < first[..., :1]).expand_as(first)
    left, right = torch.where(leftward, second, first), torch.where(leftward, first, second)
    x0, y0 = left[..., :1], left[..., 1:]
    across, along = right[..., :1] - x0, right[..., 1:] - y0
    up = along < 0
    down = along.abs()
    steep = down > across
    nowhere = torch.full([1], -1, dtype=torch.int64, device=first.device)

    column = torch.arange(width, device=first.device)
    step = (column - x0).clamp(min=0)
    offset = _minor_offset(step, down, across)
    here = ~steep & (column >= x0) & (step <= across)
    x_flat = torch.where(here, column, nowhere)
    y_flat = torch.where(here, y0 + torch.where(up, -offset, offset), nowhere)

    row = torch.arange(height, device=first.device)
    step = torch.where(up, y0 - row, row - y0)
    here = steep & (step >= 0) & (step <= down)
    x_steep = torch.where(here, x0 + _minor_offset(step.clamp(min=0), across, down), nowhere)
    y_steep = torch.where(here, row, nowhere)
    return torch.cat([x_flat, x_steep], -1).flatten(1), torch.cat([y_flat, y_steep], -1).flatten(1)


def _minor_offset(step: Tensor, minor: Tensor, major: Tensor) -> Tensor:
    """ceil(step * minor / major - 1/2), of nonnegative integers."""
    safe = major.clamp(min=1)
    return whole_quotient(2 * minor * step + safe - 1, 2 * safe)


def _painted(image: Tensor, x: Tensor, y: Tensor, color: Tensor) -> Tensor:
    """The image with the pixels x, y (B, K) in one colour."""
    height, width = image.size(-2), image.size(-1)
    check_tensor(color, "color")
    if color.dim() != 1 or (color.size(0) != 1 and color.size(0) != image.size(-3)):
        raise ValueError(
            f"color: expected shape (C,) or (1,) for C = {image.size(-3)}, got {list(color.shape)}"
        )
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    # One extra element after the pixels takes the points outside the image.
    place = torch.where(inside, y * width + x, torch.full_like(x, 0) + height * width)
    hits = torch.zeros([x.size(0), height * width + 1], dtype=torch.float32, device=image.device)
    hits = hits.scatter_add(1, place, torch.ones_like(place, dtype=torch.float32))
    mask = hits[:, : height * width].reshape(x.size(0), 1, height, width) > 0
    if image.dim() == 3:
        mask = mask[0]
    return torch.where(mask, color.to(image.dtype)[:, None, None], image)


def _check_points(image: Tensor, points: Tensor, name: str) -> None:
    check_tensor(image, "image")
    check_tensor(points, name)
    if image.dim() != 3 and image.dim() != 4:
        raise ValueError(f"image: expected shape (C, H, W) or (B, C, H, W), got {list(image.shape)}")
    if image.dim() == 3 and (points.dim() != 2 or points.size(-1) != 2):
        raise ValueError(f"{name}: expected shape (N, 2) for an image (C, H, W), got {list(points.shape)}")
    if image.dim() == 4 and (points.dim() != 3 or points.size(-1) != 2 or points.size(0) != image.size(0)):
        raise ValueError(
            f"{name}: expected shape (B, N, 2) for images {list(image.shape)}, got {list(points.shape)}"
        )
