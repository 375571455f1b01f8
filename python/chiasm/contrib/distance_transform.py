"""Distances to the nearest pixel of a shape."""

import math
from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.core.loops import until_stable
from ..primitives.filters.padding import padded


def distance_transform_edt(image: Tensor) -> Tensor:
    """The Euclidean distance from each pixel that is set to the nearest that is not; SciPy's
    ``distance_transform_edt``.

    Not in Kornia. The squared distance is a minimum over rows of a minimum over columns (P. Felzenszwalb, D.
    Huttenlocher, Distance transforms of sampled functions, Theory of Computing 8, 2012). Each is taken by
    erosions with (2k + 1, 0, 2k + 1), k = 0, 1, ..., whose sum is the parabola (F. Shih, O. Mitchell, A
    mathematical morphology approach to Euclidean distance transformation, IEEE TIP 1(2), 1992): the sum of
    the first d odd numbers is d^2. The loop takes as many steps as the largest distance.

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
    zeros = torch.zeros_like(image, dtype=dtype)
    squared = torch.where(image > 0, zeros + math.inf, zeros)
    for dim in [2, 3]:
        squared = _eroded_by_parabola(squared, 2147483647, dim)
    return torch.sqrt(squared).to(image.dtype)


@until_stable
def _eroded_by_parabola(x: Tensor, k: Tensor, dim: int) -> Tensor:
    size = x.size(dim)
    before = torch.cat([x.narrow(dim, 0, 1), x.narrow(dim, 0, size - 1)], dim)
    after = torch.cat([x.narrow(dim, 1, size - 1), x.narrow(dim, size - 1, 1)], dim)
    return torch.minimum(x, torch.minimum(before, after) + (2 * k + 1).to(x.dtype))


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
    state = torch.stack([torch.zeros_like(image), image])
    # A shape grows by a pixel a step at least, along rows and columns; negative values could make it shrink
    # and grow for ever.
    limit = image.size(2) + image.size(3)
    return _grown(state, limit, taps, kernel_size, h)[0]


@until_stable
def _grown(state: Tensor, k: Tensor, taps: List[float], kernel_size: int, h: float) -> Tensor:
    """The distances found so far and the shape they were found for, a step later."""
    distance, shape = state[0], state[1]
    radius = kernel_size // 2
    p = padded(shape, (radius, radius), (radius, radius), "replicate")
    height, width = p.size(2) - 2 * radius, p.size(3) - 2 * radius
    near = torch.zeros_like(p[:, :, :height, :width])
    for i in range(kernel_size):
        for j in range(kernel_size):
            near = near + p[:, :, i : i + height, j : j + width] * taps[i * kernel_size + j]
    # On the shape the sum is 1 or more, out of reach it is 0.
    reached = (near > 0) & (near < 1)
    beyond = -h * torch.log(torch.where(reached, near, torch.ones_like(near)))
    found = reached & (beyond > 0)
    offset = (k * radius).to(distance.dtype)
    return torch.stack(
        [
            torch.where(found, distance + offset + beyond, distance),
            torch.where(found, torch.ones_like(shape), shape),
        ]
    )
