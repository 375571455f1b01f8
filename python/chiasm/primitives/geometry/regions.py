"""Regions of images, each a row of image number, x1, y1, x2, y2: their bins, and the values read in them."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..core.checks import check_floating, check_image, check_last, check_rank
from ..core.lowering import primitive
from ..numbers.rounding import to_index
from ..resampling.warping import position_dtype


def checked_regions(input: Tensor, boxes: Union[Tensor, List[Tensor]]) -> Tensor:
    """The regions (K, 5) of ``boxes``, which may be the boxes (L, 4) of each image; raise unless ``input`` is
    an image batch and these are regions of it.

    >>> checked_regions(torch.zeros(2, 1, 4, 4), [torch.zeros(0, 4), torch.ones(1, 4)])
    tensor([[1., 1., 1., 1., 1.]])
    """
    check_image(input, "input")
    if isinstance(boxes, Tensor):
        if boxes.dim() != 2 or boxes.size(1) != 5:
            raise ValueError(f"boxes: expected shape (K, 5), got {list(boxes.shape)}")
        check_floating(boxes, "boxes")
        if isinstance(input.size(0), int) and input.size(0) == 0 and boxes.size(0) > 0:
            raise ValueError(f"input: expected an image for {boxes.size(0)} boxes, got {list(input.shape)}")
        return boxes
    if not torch.jit.is_scripting():
        _check_list(boxes)
    if len(boxes) == 0 or len(boxes) != input.size(0):
        raise ValueError(f"boxes: expected boxes of each of {input.size(0)} images, got {len(boxes)}")
    rows: List[Tensor] = []
    for i, each in enumerate(boxes):
        check_rank(each, 2, "(L, 4)", "boxes")
        check_last(each, 4, "boxes")
        number = torch.full([each.size(0), 1], float(i), dtype=each.dtype, device=each.device)
        rows.append(torch.cat([number, each], 1))
    return torch.cat(rows)


def _check_list(boxes: object) -> None:
    if not isinstance(boxes, (list, tuple)):
        raise TypeError(f"boxes: expected a tensor or a list of tensors, got {type(boxes).__name__}")


def check_bin_channels(input: Tensor, rows: int, columns: int) -> None:
    """Raise ValueError unless each bin has channels of its own."""
    if input.size(1) % (rows * columns) != 0:
        raise ValueError(
            f"input: expected a multiple of {rows} * {columns} channels, got {list(input.shape)}"
        )


def image_numbers(input: Tensor, boxes: Tensor) -> Tensor:
    """The image numbers (K,), int64, always in range."""
    return to_index(boxes[:, 0].detach(), input.size(0))


def scaled_sides(input: Tensor, boxes: Tensor, spatial_scale: float) -> Tuple[Tensor, Tensor]:
    """Left and right (K, 2), and top and bottom (K, 2), in the input's pixels, without gradient."""
    scaled = boxes[:, 1:].detach().to(position_dtype(input.dtype)) * spatial_scale
    return scaled[:, 0::2], scaled[:, 1::2]


def whole(x: Tensor) -> Tensor:
    """x rounded, half away from zero, like C's ``round``.

    >>> whole(torch.tensor([-0.5, 0.5, 1.5, 0.49999997]))
    tensor([-1.,  1.,  2.,  0.])
    """
    size = x.abs()
    below = torch.floor(size)
    # The difference is exact; adding a half would round.
    return torch.where(size - below >= 0.5, below + 1.0, below) * torch.sign(x)


@primitive
def window_maxima(rows: Tensor, image: Tensor, first: Tensor, last: Tensor) -> Tensor:
    """The maxima (M, D) of the rows from ``first`` (M,) up to, but without, ``last`` (M,) of ``rows`` (B, H,
    D), each in the image ``image`` (M,): all int64, 0 <= first < last <= H.

    A table holds the maxima of 1, 2, 4, ... rows from each row on; two of these windows, which may overlap,
    cover any window (M. Bender, M. Farach-Colton, The LCA Problem Revisited, LATIN 2000).

    >>> x = torch.tensor([[[3.0], [1.0], [4.0], [1.0], [5.0]]])
    >>> of = torch.zeros(2, dtype=torch.int64)
    >>> window_maxima(x, of, torch.tensor([0, 1]), torch.tensor([2, 5]))
    tensor([[3.],
            [5.]])
    """
    doublings, span = 0, 1
    while span * 2 <= rows.size(1):
        doublings, span = doublings + 1, span * 2
    return _window_maxima(rows, image, first, last, doublings)


@window_maxima.lowering("onnx", "native", "vjp")
def _for_any_height(rows: Tensor, image: Tensor, first: Tensor, last: Tensor) -> Tensor:
    # No image of a spec is higher than 2^15.
    return _window_maxima(rows, image, first, last, 15)


def _window_maxima(rows: Tensor, image: Tensor, first: Tensor, last: Tensor, doublings: int) -> Tensor:
    batch, height = rows.size(0), rows.size(1)
    place = torch.arange(height, device=rows.device)
    table: List[Tensor] = [rows]
    level, span = torch.zeros_like(first), torch.ones_like(first)
    step = 1
    for _ in range(doublings):
        below = table[-1].index_select(1, (place + step).clamp(max=height - 1))
        table.append(torch.maximum(table[-1], below))
        step = step * 2
        longer = last - first >= step
        level = level + longer.to(torch.int64)
        span = torch.where(longer, torch.full_like(span, step), span)
    flat = torch.stack(table).flatten(0, 2)
    start = (level * batch + image) * height
    upper = flat.index_select(0, start + first)
    return torch.maximum(upper, flat.index_select(0, start + (last - span).clamp(min=0)))
