"""Cumulative sums and summed-area tables."""

from typing import List, Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_values
from ..primitives.filters.integral import integral, integral_of_bytes, whole_sums


def integral_tensor(input: Tensor, dim: Optional[List[int]] = None) -> Tensor:
    """Cumulative sum along one or more dimensions.

    Unlike in Kornia, dim is a list (in Python, a tuple works too), since TorchScript has no tuples of
    variable length. For uint8, sums are exact.

    Args:
        input: (*), floating point or uint8.
        dim: dimensions to sum along, the last by default.

    Returns:
        Tensor of the input's shape and dtype; for uint8 int32, saturated (from 8421505 values of 255 on).

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if dim is empty or names a dimension that input does not have.

    Example:
        >>> integral_tensor(torch.ones(2, 3), [0, 1])
        tensor([[1., 2., 3.],
                [2., 4., 6.]])
    """
    check_values(input, "input")
    dims = [-1] if dim is None else dim
    if len(dims) == 0:
        raise ValueError("dim: expected at least one dimension, got none")
    out = input.to(torch.float64) if input.dtype == torch.uint8 else input
    for d in dims:
        if d < -input.dim() or d >= input.dim():
            raise ValueError(f"dim: expected dimensions of a tensor with {input.dim()}, got {d}")
        out = out.cumsum(d)
    return whole_sums(out) if input.dtype == torch.uint8 else out


def integral_image(image: Tensor) -> Tensor:
    """Summed-area table: each pixel becomes the sum of all values above and to the left, including its own.

    F. C. Crow, Summed-area tables for texture mapping, SIGGRAPH 1984. OpenCV's ``integral`` puts a row and a
    column of zeros before this. For uint8, the sums are exact, like OpenCV's CV_32S sums.

    Args:
        image: (*, H, W), floating point or uint8.

    Returns:
        Tensor of the image's shape and dtype; for uint8 int32, saturated (from 8421505 pixels of 255 on).

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image has fewer than two dimensions.

    Example:
        >>> integral_image(torch.ones(2, 3))
        tensor([[1., 2., 3.],
                [2., 4., 6.]])
    """
    check_values(image, "image")
    if image.dim() < 2:
        raise ValueError(f"image: expected shape (*, H, W), got {list(image.shape)}")
    if image.dtype == torch.uint8:
        return integral_of_bytes(image)
    return integral(image)
