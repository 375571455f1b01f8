"""Rectangles and polygons, drawn into a copy of the image."""

import math
from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_rank, check_tensor
from ..primitives.images.drawing import rectangles_over, spans_over
from ..primitives.numbers.rounding import known_or
from .draw import whole_pixels


def draw_rectangle(
    image: Tensor,
    rectangle: Tensor,
    color: Optional[Tensor] = None,
    fill: Optional[bool] = None,
    line_width: int = 1,
) -> Tensor:
    """Draw rectangles, later ones over earlier ones.

    Unlike Kornia, this op does not change its input, and wide lines are centred on the edges, as in OpenCV.

    Args:
        image: (B, C, H, W), any dtype.
        rectangle: (B, N, 4): x1, y1, x2, y2 in pixels, rounded to the nearest; both corners belong to the
            rectangle, which is empty if x2 < x1 or y2 < y1. It may extend outside the image.
        color: (1,), (C,), (B, N, 1) or (B, N, C), in the image's range; 0 by default.
        fill: True fills the rectangles; False draws their edges.
        line_width: width of the edges in pixels, centred (an even width has one pixel more towards the top
            left).

    Returns:
        (B, C, H, W).

    Raises:
        ValueError: if a shape is not as above, or line_width is not positive.

    Example:
        >>> draw_rectangle(torch.zeros(1, 1, 3, 4), torch.tensor([[[1, 0, 3, 2]]]), torch.tensor([1.0]))[0, 0]
        tensor([[0., 1., 1., 1.],
                [0., 1., 0., 1.],
                [0., 1., 1., 1.]])
    """
    check_rank(image, 4, "(B, C, H, W)", "image")
    batch = image.size(0)
    check_tensor(rectangle, "rectangle")
    if rectangle.dim() != 3 or rectangle.size(2) != 4 or rectangle.size(0) != batch:
        raise ValueError(
            f"rectangle: expected shape (B, N, 4) for images {list(image.shape)}, got {list(rectangle.shape)}"
        )
    if line_width < 1:
        raise ValueError(f"line_width: expected a positive number, got {line_width}")
    count = rectangle.size(1)
    if count == 0:
        return image.clone()
    before = line_width // 2
    after = line_width - before - 1
    colors = _per_rectangle(color, image, count)
    return rectangles_over(image, whole_pixels(rectangle), colors, before, after, fill is not None and fill)


def _per_rectangle(color: Optional[Tensor], image: Tensor, count: int) -> Tensor:
    """Colours as (B, C, N)."""
    batch, channels = image.size(0), image.size(1)
    if color is None:
        return torch.zeros([batch, channels, count], dtype=image.dtype, device=image.device)
    check_tensor(color, "color")
    known = color.to(image.dtype)
    if known.dim() == 1 and (known.size(0) == 1 or known.size(0) == channels):
        return known[None, :, None].expand(batch, channels, count)
    if (
        known.dim() == 3
        and known.size(0) == batch
        and known.size(1) == count
        and (known.size(2) == 1 or known.size(2) == channels)
    ):
        return known.transpose(1, 2).expand(batch, channels, count)
    expected = f"(1,), (C,), (B, N, 1) or (B, N, C) for B = {batch}, N = {count}, C = {channels}"
    raise ValueError(f"color: expected shape {expected}, got {list(color.shape)}")


def draw_convex_polygon(images: Tensor, polygons: Tensor, colors: Tensor) -> Tensor:
    """Fill one convex polygon in each image: all pixels whose centre lies in it or on its edge.

    Unlike Kornia, this op does not change its input and does not take a list: if polygons have different
    numbers of vertices, repeat a vertex. OpenCV's ``fillConvexPoly`` also colours pixels that the edge only
    touches.

    Args:
        images: (B, C, H, W), any dtype.
        polygons: vertices (B, N, 2), x and y in pixels, clockwise or counterclockwise; they are not rounded.
            Pixels outside of any edge are not filled, so that only the core of a non-convex polygon is
            filled.
        colors: (B, C), (C,) or (1,), in the image's range.

    Returns:
        (B, C, H, W).

    Raises:
        ValueError: if a shape is not as above.

    Example:
        >>> triangle = torch.tensor([[[0, 0], [3, 0], [0, 3]]])
        >>> draw_convex_polygon(torch.zeros(1, 1, 4, 4), triangle, torch.tensor([1.0]))[0, 0]
        tensor([[1., 1., 1., 1.],
                [1., 1., 1., 0.],
                [1., 1., 0., 0.],
                [1., 0., 0., 0.]])
    """
    check_rank(images, 4, "(B, C, H, W)", "images")
    batch, channels, height = images.size(0), images.size(1), images.size(2)
    check_tensor(polygons, "polygons")
    if polygons.dim() != 3 or polygons.size(2) != 2 or polygons.size(0) != batch:
        raise ValueError(
            f"polygons: expected shape (B, N, 2) for images {list(images.shape)}, got {list(polygons.shape)}"
        )
    if polygons.size(1) < 1:
        raise ValueError(f"polygons: expected at least one vertex, got {list(polygons.shape)}")
    check_tensor(colors, "colors")
    paint = colors.to(images.dtype)
    if paint.dim() == 1 and (paint.size(0) == 1 or paint.size(0) == channels):
        paint = paint.unsqueeze(0)
    elif paint.dim() != 2 or paint.size(0) != batch or paint.size(1) != channels:
        raise ValueError(
            f"colors: expected shape (B, C), (C,) or (1,) for images {list(images.shape)}, got"
            f" {list(colors.shape)}"
        )
    # In float64 the products of whole coordinates are exact, so that pixels on an edge are found exactly.
    vertex = polygons.detach().to(torch.float64)[..., None]
    x0, y0 = vertex[:, :, 0], vertex[:, :, 1]
    dx, dy = torch.cat([x0[:, 1:], x0[:, :1]], 1) - x0, torch.cat([y0[:, 1:], y0[:, :1]], 1) - y0
    y = torch.arange(height, device=images.device).to(torch.float64)
    first, last = _span(x0, y0, dx, dy, y)
    first_back, last_back = _span(x0, y0, -dx, -dy, y)  # the other way round
    # If all vertices are on one line, no side exists; their extent is the limit.
    in_rows = (y >= y0.amin(1)) & (y <= y0.amax(1))
    return spans_over(
        images,
        torch.stack(
            [_column(torch.ceil(torch.maximum(c, x0.amin(1))), in_rows) for c in [first, first_back]], 1
        ),
        torch.stack(
            [_column(torch.floor(torch.minimum(c, x0.amax(1))) + 1.0, in_rows) for c in [last, last_back]], 1
        ),
        paint,
    )


def _column(x: Tensor, real: Tensor) -> Tensor:
    """Whole numbers as int64, and 0 where they are not ``real`` or no numbers."""
    return torch.where(real, known_or(x, 0.0).clamp(-1.0, 2147483647.0), torch.zeros_like(x)).to(torch.int64)


def _span(x0: Tensor, y0: Tensor, dx: Tensor, dy: Tensor, y: Tensor) -> Tuple[Tensor, Tensor]:
    """The first and the last column (B, H) of each row that lie on the inner side of all edges, (x - x0)
    dy - (y - y0) dx >= 0.

    Edges begin at x0, y0 and go by dx, dy (B, N, 1). Where an edge meets a row is rounded; what decides is
    the side of the three columns there.
    """
    lag = (y - y0) * dx
    meets = torch.round(x0 + lag / torch.where(dy == 0, torch.ones_like(dy), dy))
    before, here, after = (
        (meets - 1.0 - x0) * dy - lag >= 0,
        (meets - x0) * dy - lag >= 0,
        (meets + 1.0 - x0) * dy - lag >= 0,
    )
    first = torch.where(before, meets - 1.0, torch.where(here, meets, meets + 1.0))
    last = torch.where(after, meets + 1.0, torch.where(here, meets, meets - 1.0))
    everywhere = torch.full_like(meets, math.inf)
    first = torch.where(dy > 0, first, -everywhere)
    last = torch.where(dy < 0, last, everywhere)
    # A level edge has the whole row on one side. NaN has no side.
    outside = ~(lag * dy == lag * dy) | ((dy == 0) & (lag > 0))
    return torch.where(outside, everywhere, first).amax(1), last.amin(1)
