"""Connected component labelling."""

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_pixels
from ..primitives.features.connected_components import numbered_components


def connected_components(image: Tensor, num_iterations: int = 100) -> Tensor:
    """Label the 8-connected components of a binary image. In Kornia, labels move by one pixel in each
    iteration. Here, trees of pixels are joined and flattened (see
    ``primitives.features.connected_components``), so that a spiral of one pixel width over a whole 1080p
    frame needs fewer than ten iterations. The loop ends when nothing changes.

    Args:
        image: (B, C, H, W), (C, H, W) or (H, W), floating point or uint8; pixels above 0 are set. Every plane
            is labelled separately.
        num_iterations: the maximum number of iterations.

    Returns:
        (B, C, H, W) int64: 0 for pixels that are not set, otherwise 1 + the index (row by row) of the
        component's first pixel. Kornia's labels have the image's dtype; float32 can represent only 2^24
        different pixels.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D or num_iterations is negative.

    Example:
        >>> connected_components(torch.tensor([[[[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]]))[0, 0]
        tensor([[1, 0, 3],
                [1, 0, 3]])
    """
    return like_given(_connected_components_of_batch(in_batch(image, "image"), num_iterations), image)


def _connected_components_of_batch(image: Tensor, num_iterations: int) -> Tensor:
    check_pixels(image, "image")
    if num_iterations < 0:
        raise ValueError(f"num_iterations: expected at least 0, got {num_iterations}")
    known = image.to(torch.float32) if image.dtype == torch.uint8 else image
    return numbered_components(known, num_iterations)


def connected_components_union_find(image: Tensor) -> Tensor:
    """``connected_components`` without a limit on the iterations.

    Args:
        image: (B, C, H, W), floating point or uint8; pixels above 0 are set. Every plane is labelled
            separately.

    Returns:
        (B, C, H, W) int64, as from ``connected_components``.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D.

    Example:
        >>> connected_components_union_find(torch.eye(3)[None, None]).max()
        tensor(1)
    """
    return connected_components(image, 2147483647)
