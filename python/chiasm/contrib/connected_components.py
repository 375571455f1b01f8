"""Labels of connected shapes."""

from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_image
from ..primitives.features.connected_components import numbered_components


def connected_components(image: Tensor, num_iterations: int = 100) -> Tensor:
    """Number the 8-connected shapes of a binary image.

    Labels do not creep a pixel at a time, as in Kornia: trees of pixels are joined and flattened (see
    ``primitives.features.connected_components``), so that a spiral one pixel wide over a whole 1080p frame is
    done in fewer than ten of the iterations. The loop ends when nothing changes.

    Args:
        image: (B, C, H, W), (C, H, W) or (H, W), floating point; pixels above 0 are set. Every plane is
            numbered on its own.
        num_iterations: the most iterations.

    Returns:
        (B, C, H, W) int64: 0 for what is not set, else 1 + the index (row by row) of the shape's first pixel.
        Kornia's labels are of the image's dtype, which cannot tell more than 2^24 pixels apart in float32.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not 4-D or num_iterations is negative.

    Example:
        >>> connected_components(torch.tensor([[[[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]]))[0, 0]
        tensor([[1, 0, 3],
                [1, 0, 3]])
    """
    return like_given(_connected_components_of_batch(in_batch(image, "image"), num_iterations), image)


def _connected_components_of_batch(image: Tensor, num_iterations: int) -> Tensor:
    check_image(image, "image")
    if num_iterations < 0:
        raise ValueError(f"num_iterations: expected at least 0, got {num_iterations}")
    return numbered_components(image, num_iterations)


def connected_components_union_find(image: Tensor) -> Tensor:
    """``connected_components`` with as many iterations as it takes.

    Args:
        image: (B, C, H, W), floating point; pixels above 0 are set. Every plane is numbered on its own.

    Returns:
        (B, C, H, W) int64, as from ``connected_components``.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not 4-D.

    Example:
        >>> connected_components_union_find(torch.eye(3)[None, None]).max()
        tensor(1)
    """
    return connected_components(image, 2147483647)
