"""Connected component labelling, and statistics of the components."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_pixels, check_tensor
from ..primitives.features.connected_components import (
    label_statistics,
    labelled_components,
    numbered_components,
)


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
    return numbered_components(image, num_iterations)


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


def connected_components_with_stats(
    image: Tensor, max_labels: int = 256
) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Label the 8-connected components of a binary image, and measure them, like OpenCV's
    ``connectedComponentsWithStats``: the same components, boxes, areas and centroids. Labels count from the
    background's, 0, in the order of the components' first pixels, row by row; OpenCV's order differs.

    The number of rows for components is fixed, since the sizes of an exported program's outputs must not
    depend on data. A component whose label is not below ``max_labels`` has no row.

    Args:
        image: (B, C, H, W), floating point, uint8 or bool; pixels above 0 are set. Every plane is labelled
            separately.
        max_labels: the number K of rows, the background's included, 1 to 32767.

    Returns:
        The labels (B, C, H, W), int64. The number of labels (B, C), int64, the background's included: it may
        be above K. For each label, (B, C, K, 5), int64: the left column, the top row, the width, the height
        and the number of pixels; and (B, C, K, 2), float64: the mean x and y of the pixels. Rows of labels
        without pixels are 0.

    Raises:
        TypeError: if image is not of a type as above.
        ValueError: if image is not 4-D, or max_labels is not in its range.

    Example:
        >>> x = torch.tensor([[[[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]])
        >>> labels, count, boxes, centroids = connected_components_with_stats(x, 4)
        >>> labels[0, 0]
        tensor([[1, 0, 2],
                [1, 0, 2]])
        >>> count.item(), boxes[0, 0, 2], centroids[0, 0, 2]
        (3, tensor([2, 0, 1, 2, 2]), tensor([2.0000, 0.5000], dtype=torch.float64))
    """
    check_tensor(image, "image")
    if image.dtype == torch.bool:
        image = image.to(torch.uint8)
    check_pixels(image, "image")
    if max_labels < 1 or max_labels > 32767:
        raise ValueError(f"max_labels: expected 1 to 32767, got {max_labels}")
    batch, channels, height, width = image.size(0), image.size(1), image.size(2), image.size(3)
    label = labelled_components(image).reshape(-1, height, width)
    measured = label_statistics(label, max_labels).reshape(batch, channels, max_labels, 7)
    area = measured[..., 4:5].clamp(min=1).to(torch.float64)
    return (
        label.reshape(batch, channels, height, width),
        (label.amax([1, 2]) + 1).reshape(batch, channels),
        measured[..., :5],
        measured[..., 5:].to(torch.float64) / area,
    )
