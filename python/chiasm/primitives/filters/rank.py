"""Selection networks: order statistics by minimum and maximum only, which vectorise and export everywhere."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows
from ..core.lowering import primitive
from ..core.pixels import narrow, ordered
from ..kernels import operators as kernels
from .padding import stencil


def sorting_network(size: int) -> List[Tuple[int, int]]:
    """Compare-exchange pairs (low, high) that sort ``size`` values: Batcher's odd-even merge sort.

    Knuth, The Art of Computer Programming, vol. 3, 5.2.2, algorithm M.

    >>> sorting_network(3)
    [(0, 2), (0, 1), (1, 2)]
    """
    pairs: List[Tuple[int, int]] = []
    top = 1
    while top * 2 < size:
        top = top * 2
    p = top
    while p > 0:
        q = top
        r = 0
        d = p
        more = True
        while more:
            for i in range(size - d):
                if (i & p) == r:
                    pairs.append((i, i + d))
            more = q != p
            if more:
                d = q - p
                q = q // 2
                r = p
        p = p // 2
    return pairs


def select_ranks(values: List[Tensor], ranks: List[int]) -> List[Tensor]:
    """The values of the given ranks (0 is the smallest) among equally shaped tensors, elementwise.

    >>> v = [torch.tensor(3.0), torch.tensor(1.0), torch.tensor(2.0)]
    >>> select_ranks(v, [1])
    [tensor(2.)]
    """
    pairs = sorting_network(len(values))
    live = [rank in ranks for rank in range(len(values))]
    keep_low: List[bool] = []
    keep_high: List[bool] = []
    for step in range(len(pairs)):
        low, high = pairs[len(pairs) - 1 - step]
        keep_low.append(live[low])
        keep_high.append(live[high])
        needed = live[low] or live[high]
        live[low] = needed
        live[high] = needed
    work = [value for value in values]
    for step in range(len(pairs)):
        low, high = pairs[step]
        a = work[low]
        b = work[high]
        if keep_low[len(pairs) - 1 - step]:
            work[low] = torch.minimum(a, b)
        if keep_high[len(pairs) - 1 - step]:
            work[high] = torch.maximum(a, b)
    return [work[rank] for rank in ranks]


def rank_candidates(rows: int, columns: int, rank: int) -> Tuple[List[List[int]], int]:
    """The entries of a rows x columns matrix with sorted rows and sorted columns that can have the given
    rank.

    Of the other entries, (i+1)(j+1)-1 are known not to exceed entry (i, j) and (rows-i)(columns-j)-1 not to
    be below it. The entry is excluded if either count is too large. Returns the js of each i, and how many
    entries are excluded as too small: the rank among the candidates is lower by this number.

    >>> rank_candidates(3, 3, 4)
    ([[2], [1], [0]], 3)
    """
    keep: List[List[int]] = []
    below = 0
    for i in range(rows):
        js: List[int] = []
        for j in range(columns):
            if (rows - i) * (columns - j) - 1 > rows * columns - 1 - rank:
                below += 1
            elif (i + 1) * (j + 1) - 1 <= rank:
                js.append(j)
        keep.append(js)
    return keep, below


@primitive
def window_rank(x: Tensor, rows: int, columns: int, rank: int, border_type: str) -> Tensor:
    """The value of a rank (0 is the smallest) in the centred window of odd size around each pixel of (B, C,
    H, W)."""
    margin_y, margin_x = (rows // 2, rows // 2), (columns // 2, columns // 2)
    return _ranked(ordered(x), margin_y, margin_x, border_type, rows, columns, rank).to(x.dtype)


@window_rank.lowering("onnx", when=narrow)
def _window_rank_in_int32(x: Tensor, rows: int, columns: int, rank: int, border_type: str) -> Tensor:
    """ONNX Runtime has no minima for these types."""
    return window_rank(x.to(torch.int32), rows, columns, rank, border_type).to(x.dtype)


@window_rank.lowering(
    "native",
    when=lambda x, rows, columns, rank, _: (
        kernels.has_pixel_kernel(x) and rows == columns and rows in (3, 5, 7) and rank == rows * columns // 2
    ),
)
def _median_filter(x: Tensor, rows: int, columns: int, rank: int, border_type: str) -> Tensor:
    values, step = as_rows(x)
    return from_rows(kernels.median_filter(values, step, rows, border_type), x)


@window_rank.lowering(
    "native",
    when=lambda x, rows, columns, rank, _: (
        kernels.available(x) and x.dtype == torch.uint8 and 25 < rows * columns <= 65535
    ),
)
def _rank_of_bytes(x: Tensor, rows: int, columns: int, rank: int, border_type: str) -> Tensor:
    """The cost of the network grows with the window, that of histograms of bytes does not."""
    values, step = as_rows(x)
    return from_rows(kernels.rank_of_bytes(values, step, rows, columns, rank, border_type), x)


@stencil
def _ranked(p: Tensor, rows: int, columns: int, rank: int) -> Tensor:
    # Neighbouring windows share columns: sort each column once, then, for each rank, sort the ranks across
    # the window's columns. The window is then a matrix with sorted rows and columns, in which few entries can
    # have the rank.
    height = p.size(2) - rows + 1
    width = p.size(3) - columns + 1
    keep, below = rank_candidates(rows, columns, rank)
    needed: List[int] = []
    for i in range(rows):
        if len(keep[i]) > 0:
            needed.append(i)
    sorted_columns = select_ranks([p[:, :, i : i + height] for i in range(rows)], needed)
    candidates: List[Tensor] = []
    for n in range(len(needed)):
        candidates += select_ranks(
            [sorted_columns[n][..., j : j + width] for j in range(columns)], keep[needed[n]]
        )
    return select_ranks(candidates, [rank - below])[0]
