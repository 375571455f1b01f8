"""Distances to the nearest pixel of a shape."""

import math
from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_not_empty, check_pixels
from ..primitives.features.distances import euclidean_distances, grown_distances, grown_distances3d


def distance_transform_edt(image: Tensor) -> Tensor:
    """The Euclidean distance from each set pixel to the nearest unset one, like SciPy's
    ``distance_transform_edt``.

    Not in Kornia. The squared distance is a minimum over rows of a minimum over columns (P. Felzenszwalb, D.
    Huttenlocher, Distance transforms of sampled functions, Theory of Computing 8, 2012).

    Args:
        image: (B, C, H, W), floating point or uint8; pixels above 0 are set.

    Returns:
        (B, C, H, W), float32 for uint8; exact except for the rounding of the result (in float32, also of the
        squares for distances above 4096): 0 for pixels that are not set, infinity in a plane where all pixels
        are set.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D.

    Example:
        >>> distance_transform_edt(torch.tensor([[[[0.0, 1.0, 1.0, 1.0, 1.0, 0.0]]]]))
        tensor([[[[0., 1., 2., 2., 1., 0.]]]])
    """
    check_pixels(image, "image")
    dtype = torch.float64 if image.dtype == torch.float64 else torch.float32
    found = euclidean_distances(image.to(dtype))
    return found.to(image.dtype) if image.is_floating_point() else found


def distance_transform(image: Tensor, kernel_size: int = 3, h: float = 0.35) -> Tensor:
    """Approximate distance to the nearest pixel or voxel of a shape, by convolutions.

    C. Karam, K. Sugimoto, K. Hirakawa, Fast convolutional distance transform, IEEE SPL 26(6), 2019. The shape
    grows by half a kernel in each step; the distance of a pixel that is reached in step k is k (kernel_size
    // 2) - h log(sum of exp(-d / h)) over the shape's pixels in the kernel, at distances d.
    ``distance_transform_edt`` is exact.

    Args:
        image: (B, C, H, W) or (B, C, D, H, W), floating point, 1 on the shape and 0 elsewhere. For values
            outside [0, 1] the result is meaningless, but the loop still ends.
        kernel_size: odd size of the kernel, at least 3.
        h: the smoothness of the minimum, > 0; smaller values are more exact until exp(-d / h) underflows.

    Returns:
        Tensor of the image's shape, 0 on the shape and in a plane or volume without one.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is neither 4-D nor 5-D, or kernel_size or h is not as above.

    Example:
        >>> line = torch.tensor([[[[1.0, 0.0, 0.0, 0.0]]]])
        >>> distance_transform(line, h=0.01).round()
        tensor([[[[0., 1., 2., 3.]]]])
    """
    check_floating(image, "image")
    if image.dim() != 4 and image.dim() != 5:
        raise ValueError(f"image: expected shape (B, C, H, W) or (B, C, D, H, W), got {list(image.shape)}")
    check_not_empty(image, image.dim() - 1, "image")
    if kernel_size < 3 or kernel_size % 2 == 0:
        raise ValueError(f"kernel_size: expected an odd size of at least 3, got {kernel_size}")
    if not h > 0.0:
        raise ValueError(f"h: expected a positive number, got {h}")
    # A shape grows by at least a pixel in each step, along each axis; negative values could make it shrink
    # and grow for ever.
    if image.dim() == 5:
        limit = image.size(2) + image.size(3) + image.size(4)
        return grown_distances3d(image, limit, _taps(kernel_size, h, True), kernel_size, h)
    return grown_distances(image, image.size(2) + image.size(3), _taps(kernel_size, h, False), kernel_size, h)


def _taps(kernel_size: int, h: float, is_volume: bool) -> List[float]:
    """exp(-d / h) of the distances d from the middle of a kernel, of two or three axes."""
    radius = kernel_size // 2
    squares: List[int] = []
    for depth in range(kernel_size if is_volume else 1):
        for i in range(kernel_size):
            for j in range(kernel_size):
                along = depth - radius if is_volume else 0
                squares.append(along * along + (i - radius) * (i - radius) + (j - radius) * (j - radius))
    return [math.exp(-math.sqrt(float(square)) / h) for square in squares]
