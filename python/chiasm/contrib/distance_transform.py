"""Distances to the nearest pixel of a shape."""

import math
from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.features.distances import euclidean_distances, grown_distances


def distance_transform_edt(image: Tensor) -> Tensor:
    """The Euclidean distance from each pixel that is set to the nearest that is not; SciPy's
    ``distance_transform_edt``.

    Not in Kornia. The squared distance is a minimum over rows of a minimum over columns (P. Felzenszwalb, D.
    Huttenlocher, Distance transforms of sampled functions, Theory of Computing 8, 2012).

    Args:
        image: (B, C, H, W), floating point; pixels above 0 are set.

    Returns:
        (B, C, H, W), exact but for the rounding of the result (of squares, in float32, for distances above
        4096): 0 for what is not set, infinity in a plane where everything is.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not 4-D.

    Example:
        >>> distance_transform_edt(torch.tensor([[[[0.0, 1.0, 1.0, 1.0, 1.0, 0.0]]]]))
        tensor([[[[0., 1., 2., 2., 1., 0.]]]])
    """
    check_image(image, "image")
    dtype = torch.float64 if image.dtype == torch.float64 else torch.float32
    return euclidean_distances(image.to(dtype)).to(image.dtype)


def distance_transform(image: Tensor, kernel_size: int = 3, h: float = 0.35) -> Tensor:
    """Approximate distance to the nearest pixel of a shape, by convolutions.

    C. Karam, K. Sugimoto, K. Hirakawa, Fast convolutional distance transform, IEEE SPL 26(6), 2019. The shape
    grows by half a kernel a step; a pixel that is reached in step k is at k (kernel_size // 2) - h log(sum of
    exp(-d / h)) over the shape's pixels in the kernel, at distances d. ``distance_transform_edt`` is exact.

    Args:
        image: (B, C, H, W), floating point, 1 on the shape and 0 elsewhere. Of values outside [0, 1] no
            distances come out, but it ends.
        kernel_size: odd size of the kernel, at least 3.
        h: how sharp the minimum is, > 0; small values are more exact until exp(-d / h) underflows.

    Returns:
        (B, C, H, W), 0 on the shape and in a plane without one.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not 4-D, or kernel_size or h is not as above.

    Example:
        >>> line = torch.tensor([[[[1.0, 0.0, 0.0, 0.0]]]])
        >>> distance_transform(line, h=0.01).round()
        tensor([[[[0., 1., 2., 3.]]]])
    """
    check_image(image, "image")
    if kernel_size < 3 or kernel_size % 2 == 0:
        raise ValueError(f"kernel_size: expected an odd size of at least 3, got {kernel_size}")
    if h <= 0.0:
        raise ValueError(f"h: expected a positive number, got {h}")
    radius = kernel_size // 2
    taps: List[float] = []
    for i in range(kernel_size):
        for j in range(kernel_size):
            taps.append(
                math.exp(-math.sqrt(float((i - radius) * (i - radius) + (j - radius) * (j - radius))) / h)
            )
    # A shape grows by a pixel a step at least, along rows and columns; negative values could make it shrink
    # and grow for ever.
    limit = image.size(2) + image.size(3)
    return grown_distances(image, limit, taps, kernel_size, h)
