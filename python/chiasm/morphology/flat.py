"""Maxima and minima over rectangles of a fixed size."""

from typing import Tuple, Union

from torch import Tensor

from ..primitives.core.checks import check_pixels, odd_pair
from ..primitives.filters.minmax import minmax_filter


def max_filter2d(
    input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate"
) -> Tensor:
    """The largest value in a rectangle around each pixel: dilation by a flat rectangle, in two passes.

    Not in Kornia. The element of ``dilation`` is a run-time input and can have any shape; with a fixed size,
    the maxima are computed along columns, then along rows, by doubling the window's length. Like SciPy's
    ``maximum_filter`` and OpenCV's ``dilate``.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8, int16 or uint16; planes or a permuted
            frame.
        kernel_size: odd size, one for both axes or (rows, columns).
        border_type: "replicate" (pixels outside the image are ignored), "reflect", "circular" or "constant"
            (zeros).

    Returns:
        (B, C, H, W), of input's dtype.

    Raises:
        TypeError: if input is of another dtype.
        ValueError: if input is not 4-D, or the kernel size or the border is not as above.

    Example:
        >>> max_filter2d(torch.tensor([[[[0.0, 3.0, 1.0, 2.0, 0.0]]]]), (1, 3))
        tensor([[[[3., 3., 3., 2., 2.]]]])
    """
    return _filter(input, kernel_size, border_type, True)


def min_filter2d(
    input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate"
) -> Tensor:
    """The smallest value in a rectangle around each pixel: erosion by a flat rectangle, in two passes.

    Not in Kornia; see ``max_filter2d``. Like SciPy's ``minimum_filter`` and OpenCV's ``erode``.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8, int16 or uint16; planes or a permuted
            frame.
        kernel_size: odd size, one for both axes or (rows, columns).
        border_type: "replicate" (pixels outside the image are ignored), "reflect", "circular" or "constant"
            (zeros).

    Returns:
        (B, C, H, W), of input's dtype.

    Raises:
        TypeError: if input is of another dtype.
        ValueError: if input is not 4-D, or the kernel size or the border is not as above.

    Example:
        >>> min_filter2d(torch.tensor([[[[0.0, 3.0, 1.0, 2.0, 0.0]]]]), (1, 3))
        tensor([[[[0., 0., 1., 0., 0.]]]])
    """
    return _filter(input, kernel_size, border_type, False)


def _filter(
    input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str, largest: bool
) -> Tensor:
    check_pixels(input, "input", True)
    ky, kx = odd_pair(kernel_size, "kernel_size")
    return minmax_filter(input, ky, kx, border_type, largest)
