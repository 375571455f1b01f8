"""Rank filters: the output is the neighbour of a given rank."""

from typing import Tuple, Union

from torch import Tensor

from ..primitives.core.checks import check_pixels, odd_pair
from ..primitives.filters.rank import window_rank


def rank_filter(
    input: Tensor, rank: int, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
) -> Tensor:
    """Replace each pixel by the value of a given rank in its neighbourhood, like SciPy's ``rank_filter``. A
    sorting network of minima and maxima selects the value. The gradient goes to the selected element; equal
    elements share it.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8, int16 or uint16; planes or a permuted
            frame.
        rank: 0 is the smallest, -1 the largest.
        kernel_size: odd size, one for both axes or (rows, columns). The sorting network grows faster than the
            area: sizes above 7 are slow and their exported graphs large, except for uint8 in native code,
            where large windows are as fast as small ones.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W), of input's dtype.

    Raises:
        TypeError: if input is of another dtype.
        ValueError: if input is not 4-D, or the rank, the kernel size or the border is not as above.

    Example:
        >>> rank_filter(torch.arange(5.0).reshape(1, 1, 1, 5), -1, (1, 3))
        tensor([[[[1., 2., 3., 4., 4.]]]])
    """
    check_pixels(input, "input", True)
    ky, kx = odd_pair(kernel_size, "kernel_size")
    count = ky * kx
    if rank < -count or rank >= count:
        raise ValueError(f"rank: expected {-count} to {count - 1} for a ({ky}, {kx}) window, got {rank}")
    return window_rank(input, ky, kx, rank % count, border_type)


def percentile_filter(
    input: Tensor, percentile: float, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
) -> Tensor:
    """Replace each pixel by a percentile of its neighbourhood, like SciPy's ``percentile_filter``. For n
    pixels this is the value of rank floor(n * percentile / 100), without interpolation between ranks. The
    gradient goes to the selected element.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8, int16 or uint16; planes or a permuted
            frame.
        percentile: 0 (minimum) to 100 (maximum).
        kernel_size: odd size, as for ``rank_filter``.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W), of input's dtype.

    Raises:
        TypeError: if input is of another dtype.
        ValueError: if input is not 4-D, or the percentile, the kernel size or the border is not as above.

    Example:
        >>> percentile_filter(torch.arange(5.0).reshape(1, 1, 1, 5), 50.0, (1, 3), "replicate")
        tensor([[[[0., 1., 2., 3., 4.]]]])
    """
    if not (percentile >= 0.0 and percentile <= 100.0):
        raise ValueError(f"percentile: expected 0 to 100, got {percentile}")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    return rank_filter(input, min(int(ky * kx * percentile / 100.0), ky * kx - 1), (ky, kx), border_type)
