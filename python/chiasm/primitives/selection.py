"""Selection networks: order statistics by minimum and maximum only, which vectorise and export everywhere."""

from typing import List, Tuple

import torch
from torch import Tensor


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


def median_candidates(rows: int, columns: int) -> List[List[int]]:
    """Which entries of a rows x columns matrix with sorted rows and sorted columns can be its median.

    Entry (i, j) has (i+1)(j+1)-1 entries known not to exceed it and (rows-i)(columns-j)-1 known not to be below it;
    it is out as soon as either count passes half of the others. As many fall out below as above, so the median of
    what remains is the median of all. Returns, for each i, the js.

    >>> median_candidates(3, 3)
    [[2], [1], [0]]
    """
    half = (rows * columns) // 2
    keep: List[List[int]] = []
    for i in range(rows):
        js: List[int] = []
        for j in range(columns):
            if (i + 1) * (j + 1) - 1 <= half and (rows - i) * (columns - j) - 1 <= half:
                js.append(j)
        keep.append(js)
    return keep
