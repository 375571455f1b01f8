"""Shapes painted over images."""

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..core.pixels import ordered
from ..kernels import operators as kernels


@primitive
def rectangles_over(
    image: Tensor, corners: Tensor, colors: Tensor, before: int, after: int, fill: bool
) -> Tensor:
    """Rectangles with corners x1, y1, x2, y2 (B, N, 4), int64, and colours (B, C, N) over an image (B, C, H,
    W), later ones over earlier ones: filled, or edges that reach from ``before`` pixels above and left of the
    corners to ``after`` pixels below and right of them.

    >>> corners = torch.tensor([[[1, 0, 3, 2]]])
    >>> rectangles_over(torch.zeros(1, 1, 3, 4), corners, torch.ones(1, 1, 1), 0, 0, False)[0, 0]
    tensor([[0., 1., 1., 1.],
            [0., 1., 0., 1.],
            [0., 1., 1., 1.]])
    """
    batch, channels, height, width = image.shape
    corner = corners[..., None]
    x1, y1, x2, y2 = corner[:, :, 0], corner[:, :, 1], corner[:, :, 2], corner[:, :, 3]
    x, y = torch.arange(width, device=image.device), torch.arange(height, device=image.device)
    if fill:
        covered = ((x >= x1) & (x <= x2))[:, :, None] & ((y >= y1) & (y <= y2))[..., None]
    else:
        outer_x, outer_y = (x >= x1 - before) & (x <= x2 + after), (y >= y1 - before) & (y <= y2 + after)
        inner_x, inner_y = (x > x1 + after) & (x < x2 - before), (y > y1 + after) & (y < y2 - before)
        real = ((x2 >= x1) & (y2 >= y1))[..., None]
        covered = (
            real & outer_x[:, :, None] & outer_y[..., None] & ~(inner_x[:, :, None] & inner_y[..., None])
        )
    # The last rectangle that covers a pixel is visible.
    number = torch.arange(1, corners.size(1) + 1, device=image.device)[:, None, None]
    top = torch.where(covered, number, torch.zeros_like(number)).amax(1)
    index = (top - 1).clamp(min=0).reshape(batch, 1, height * width).expand(batch, channels, height * width)
    paint = ordered(colors).gather(2, index).reshape(batch, channels, height, width)
    drawn = torch.where((top > 0)[:, None], paint, ordered(image))
    return drawn if drawn.dtype == image.dtype else drawn.to(image.dtype)


@rectangles_over.lowering("native", when=kernels.has_pixel_kernel)
def _rectangles_over_kernel(
    image: Tensor, corners: Tensor, colors: Tensor, before: int, after: int, fill: bool
) -> Tensor:
    return kernels.draw_rectangles(image, corners, colors.contiguous(), before, after, fill)


@primitive
def spans_over(image: Tensor, first: Tensor, end: Tensor, colors: Tensor) -> Tensor:
    """An image (B, C, H, W) in which pixels first..end-1 of each row have the colours (B, C). ``first`` and
    ``end`` are (B, S, H) int64, for S spans in each row.

    >>> first, end = torch.tensor([[[1, 0]]]), torch.tensor([[[3, -5]]])
    >>> spans_over(torch.zeros(1, 1, 2, 4), first, end, torch.ones(1, 1))
    tensor([[[[0., 1., 1., 0.],
              [0., 0., 0., 0.]]]])
    """
    x = torch.arange(image.size(3), device=image.device)
    inside = ((x >= first[..., None]) & (x < end[..., None])).any(1)
    return torch.where(inside[:, None], colors[:, :, None, None], image)


@spans_over.lowering("native", when=kernels.has_pixel_kernel)
def _spans_over_kernel(image: Tensor, first: Tensor, end: Tensor, colors: Tensor) -> Tensor:
    colors = colors.expand(image.size(0), image.size(1)).contiguous()
    return kernels.fill_spans(image, first, end, colors)
