"""Median filter."""

from typing import List, Tuple, Union

from torch import Tensor

from ..primitives.checks import check_image, odd_pair
from ..primitives.padding import join_columns, padded_parts
from ..primitives.selection import median_candidates, select_ranks


def median_blur(input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect") -> Tensor:
    """Replace each pixel by the median of its neighbourhood, by a network of minima and maxima.

    Kornia's median pads with zeros, which is ``border_type="constant"`` here; OpenCV's replicates.
    The gradient goes to the median element; equal elements share it.

    Args:
        input: (B, C, H, W), floating point, without NaN.
        kernel_size: odd size, one for both axes or (rows, columns). The network grows faster than the area: sizes above
            7 are slow and their exported graphs large.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the kernel size or border is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 5, 5)
        >>> x[0, 0, 2, 2] = 9.0
        >>> median_blur(x, 3).max()
        tensor(0.)
    """
    check_image(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    parts = padded_parts(input, ky // 2, ky // 2, kx // 2, kx // 2, border_type)
    return join_columns([_median_valid(p, ky, kx) for p in parts])


def _median_valid(p: Tensor, ky: int, kx: int) -> Tensor:
    # Neighbouring windows share columns: sort each column once, then, for each rank, sort the ranks across the
    # window's columns. The window is then a matrix with sorted rows and columns, of which few entries can be the median.
    height = p.size(2) - ky + 1
    width = p.size(3) - kx + 1
    columns = select_ranks([p[:, :, i : i + height] for i in range(ky)], [i for i in range(ky)])
    keep = median_candidates(ky, kx)
    candidates: List[Tensor] = []
    for i in range(ky):
        if len(keep[i]) > 0:
            candidates += select_ranks([columns[i][..., j : j + width] for j in range(kx)], keep[i])
    return select_ranks(candidates, [len(candidates) // 2])[0]
