"""Maxima and minima over rectangles of a size that is known beforehand."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.checks import check_image, odd_pair
from ..primitives.padding import join_columns, padded_parts


def max_filter2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate") -> Tensor:
    """The largest value in a rectangle around each pixel: dilation by a flat rectangle, in two passes.

    Not in Kornia. The element of ``dilation`` is a run-time input, of which nothing may be assumed; with the size fixed, the
    maxima are taken along columns, then along rows, by doubling the window's length. SciPy's ``maximum_filter``, OpenCV's ``dilate``.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd size, one for both axes or (rows, columns).
        border_type: "replicate" (the outside never wins), "reflect", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the kernel size or the border is not as above.

    Example:
        >>> max_filter2d(torch.tensor([[[[0.0, 3.0, 1.0, 2.0, 0.0]]]]), (1, 3))
        tensor([[[[3., 3., 3., 2., 2.]]]])
    """
    return _filter(input, kernel_size, border_type, True)


def min_filter2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str = "replicate") -> Tensor:
    """The smallest value in a rectangle around each pixel: erosion by a flat rectangle, in two passes.

    Not in Kornia; see ``max_filter2d``. SciPy's ``minimum_filter``, OpenCV's ``erode``.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd size, one for both axes or (rows, columns).
        border_type: "replicate" (the outside never wins), "reflect", "circular" or "constant" (zeros).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or the kernel size or the border is not as above.

    Example:
        >>> min_filter2d(torch.tensor([[[[0.0, 3.0, 1.0, 2.0, 0.0]]]]), (1, 3))
        tensor([[[[0., 0., 1., 0., 0.]]]])
    """
    return _filter(input, kernel_size, border_type, False)


def _filter(input: Tensor, kernel_size: Union[int, Tuple[int, int]], border_type: str, largest: bool) -> Tensor:
    check_image(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    tall = join_columns([_run(p, 2, ky, largest) for p in padded_parts(input, ky // 2, ky // 2, 0, 0, border_type)])
    return join_columns([_run(p, 3, kx, largest) for p in padded_parts(tall, 0, 0, kx // 2, kx // 2, border_type)])


def _run(p: Tensor, dim: int, count: int, largest: bool) -> Tensor:
    """The extreme of each ``count`` successive entries along ``dim``."""
    size = p.size(dim) - count + 1
    length = 1
    while length < count:
        # Two windows of this length make one of up to twice the length; what they share does no harm.
        step = min(length, count - length)
        left, right = p.narrow(dim, 0, p.size(dim) - step), p.narrow(dim, step, p.size(dim) - step)
        p = torch.maximum(left, right) if largest else torch.minimum(left, right)
        length = length + step
    return p.narrow(dim, 0, size)
