"""Regions of images, each a row of image number, x1, y1, x2, y2: their bins, and the values read in them."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..core.checks import check_floating, check_image, check_last, check_rank
from ..core.lowering import primitive
from ..filters.integral import integral
from ..kernels import operators as kernels
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
def box_maxima(x: Tensor, image: Tensor, top: Tensor, bottom: Tensor, left: Tensor, right: Tensor) -> Tensor:
    """The maxima (K, C, PH, PW) of the pixels in bins. Box k is in the image ``image`` (K,) of x (B, C, H,
    W); its bins have the rows from ``top`` to ``bottom`` (K, PH) and the columns from ``left`` to ``right``
    (K, PW), without the last. All are int64, 0 <= image < B, and corners are in the image. An empty bin is 0.

    >>> x, zero, two = torch.arange(4.0).reshape(1, 1, 1, 4), torch.tensor([[0]]), torch.tensor([[2]])
    >>> box_maxima(x, torch.tensor([0]), zero, zero + 1, zero, two)
    tensor([[[[1.]]]])
    """
    count, channels, height, width = top.size(0), x.size(1), x.size(2), x.size(3)
    bin_rows = top.size(1)
    # For an empty bin some row is read, and ignored below.
    first = top.clamp(max=height - 1).flatten()
    rows = window_maxima(
        x.permute(0, 2, 1, 3).flatten(2),
        image[:, None].expand(-1, bin_rows).flatten(),
        first,
        torch.maximum(bottom.flatten(), first + 1),
    )
    rows = rows.reshape(count, bin_rows, channels, width)
    column = torch.arange(width, device=x.device)
    lowest = torch.full_like(rows[:, :, :, :1], float("-inf"))
    maxima: List[Tensor] = []
    for q in range(left.size(1)):
        inside = (column >= left[:, q : q + 1]) & (column < right[:, q : q + 1])
        maxima.append(torch.where(inside[:, None, None], rows, lowest).amax(-1))
    filled = (bottom > top)[:, :, None] & (right > left)[:, None]
    pooled = torch.stack(maxima, -1).transpose(1, 2)
    return torch.where(filled[:, None], pooled, torch.zeros_like(pooled))


box_maxima.lowering("native", when=kernels.has_kernel)(kernels.box_maxima)


@primitive
def box_means(x: Tensor, image: Tensor, top: Tensor, bottom: Tensor, left: Tensor, right: Tensor) -> Tensor:
    """The means (K, C, PH, PW) of the pixels in bins, each of which has planes of its own: x is (B, C, PH *
    PW, H, W), the rest as in `box_maxima`. Sums are differences of a summed-area table in float64, so x must
    be finite, and no value 1e10 times as large as others. (Weights of 0 and 1 in a matrix product would need
    neither, but take a multiplication for every row of every image.)

    >>> x, zero, two = torch.arange(4.0).reshape(1, 1, 1, 1, 4), torch.tensor([[0]]), torch.tensor([[2]])
    >>> box_means(x, torch.tensor([0]), zero, zero + 1, zero, two)
    tensor([[[[0.5000]]]])
    """
    count, bin_rows, bin_columns = top.size(0), top.size(1), left.size(1)
    channels, bins, height, width = x.size(1), x.size(2), x.size(3), x.size(4)
    # A row and a column of zeros before the first, so that each sum is computed from four corners.
    padded = torch.nn.functional.pad(x.flatten(1, 2).to(torch.float64), [1, 0, 1, 0])
    table = integral(padded).unflatten(1, [channels, bins]).transpose(0, 1)
    flat = table.reshape(channels, x.size(0) * bins * (height + 1) * (width + 1))
    place = torch.arange(bin_rows * bin_columns, device=x.device).reshape(bin_rows, bin_columns)
    plane = image[:, None, None] * (bin_rows * bin_columns) + place
    top, bottom = top[:, :, None], bottom[:, :, None]
    left, right = left[:, None], right[:, None]
    total = torch.zeros([1], dtype=flat.dtype, device=flat.device)
    for y, column, sign in [(bottom, right, 1.0), (top, right, -1.0), (bottom, left, -1.0), (top, left, 1.0)]:
        index = (plane * (height + 1) + y) * (width + 1) + column
        total = total + sign * flat.gather(1, index.reshape(1, -1).expand(channels, -1))
    area = ((bottom - top) * (right - left)).clamp(min=0)
    filled = (bottom > top) & (right > left)
    mean = total.reshape(channels, count, bin_rows, bin_columns) / area.clamp(min=1)
    return torch.where(filled, mean, torch.zeros_like(mean)).transpose(0, 1).to(x.dtype)


box_means.lowering("native", when=kernels.has_kernel)(kernels.box_means)


@primitive
def bilinear_means(x: Tensor, image: Tensor, rows: Tensor, columns: Tensor, shared: int) -> Tensor:
    """The means (K, C, PH, PW) of points in bins, each read by bilinear interpolation. Box k is in the image
    ``image`` (K,), int64, of x (B, C, Q, H, W); its points are at ``rows`` (K, PH, N) and ``columns`` (K, PW,
    M). Each of the Q planes serves ``shared`` bins in turn: Q * shared = PH * PW. A point up to one pixel
    outside the centres of the border pixels reads the nearest pixel; a point further outside counts as 0.

    >>> x, half = torch.arange(4.0).reshape(1, 1, 1, 1, 4), torch.tensor([[[0.5, 1.5]]])
    >>> bilinear_means(x, torch.tensor([0]), torch.zeros(1, 1, 1), half, 1)
    tensor([[[[1.]]]])
    """
    channels, planes, height, width = x.size(1), x.size(2), x.size(3), x.size(4)
    bin_rows, bin_columns = rows.size(1), columns.size(1)
    flat = x.transpose(0, 1).reshape(channels, x.size(0) * planes * height * width)
    plane = image[:, None, None, None, None]
    if planes > 1:
        place = torch.arange(bin_rows * bin_columns, device=x.device).reshape(bin_rows, 1, bin_columns, 1)
        plane = plane * planes + place // shared
    row, down = _taps(rows, height)
    column, across = _taps(columns, width)
    shape = [channels, rows.size(0), bin_rows, rows.size(2), bin_columns, columns.size(2)]
    total = torch.zeros([1], dtype=flat.dtype, device=flat.device)
    for i in range(2):
        start = (plane * height + row[i][:, :, :, None, None]) * width
        for j in range(2):
            index = (start + column[j][:, None, None]).reshape(1, -1).expand(channels, -1)
            weight = (down[i][:, :, :, None, None] * across[j][:, None, None]).to(flat.dtype)
            total = total + flat.gather(1, index).reshape(shape) * weight
    return total.mean(5).mean(3).transpose(0, 1)


bilinear_means.lowering("native", when=kernels.has_kernel)(kernels.bilinear_means)


def _taps(position: Tensor, size: int) -> Tuple[List[Tensor], List[Tensor]]:
    """The two pixels of an axis around each position, and their weights."""
    inside = (position >= -1.0) & (position <= size)
    at = position.clamp(0, size - 1)
    low = to_index(at, size)
    part = at - low
    zero = torch.zeros_like(at)
    weights = [torch.where(inside, 1.0 - part, zero), torch.where(inside, part, zero)]
    return [low, (low + 1).clamp(max=size - 1)], weights


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
