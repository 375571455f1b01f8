"""Median filter."""

from typing import Tuple, Union

from torch import Tensor

from ..primitives.core.checks import check_pixels, odd_pair
from ..primitives.filters.rank import window_rank


def median_blur(
    input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "reflect"
) -> Tensor:
    """Replace each pixel by the median of its neighbourhood.

    OpenCV replicates the border. The gradient goes to the median element; equal elements share it.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8, int16 or uint16; planes or a permuted
            frame.
        kernel_size: odd size, one for both axes or (rows, columns). The sorting network grows faster than the
            area: sizes above 7 are slow and their exported graphs large, except for uint8 in native code,
            where large windows are as fast as small ones.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W), of input's dtype.

    Raises:
        TypeError: if input is of another dtype.
        ValueError: if input is not 4-D, or the kernel size or border is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 5, 5)
        >>> x[0, 0, 2, 2] = 9.0
        >>> median_blur(x, 3).max()
        tensor(0.)
    """
    check_pixels(input, "input", True)
    ky, kx = odd_pair(kernel_size, "kernel_size")
    return window_rank(input, ky, kx, ky * kx // 2, border_type)
