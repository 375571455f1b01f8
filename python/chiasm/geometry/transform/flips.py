"""Flips, the rotation by 180 degrees, and the transpose."""

from torch import Tensor

from ...primitives.core.checks import check_rank, check_tensor
from ...primitives.resampling.flips import flip, transposed


def hflip(input: Tensor) -> Tensor:
    """Flip images horizontally (left to right).

    Args:
        input: (*, H, W), of any dtype.

    Returns:
        (*, H, W).

    Raises:
        ValueError: if input has fewer than two dimensions.

    Example:
        >>> hflip(torch.tensor([[1, 2], [3, 4]]))
        tensor([[2, 1],
                [4, 3]])
    """
    _check_planes(input)
    return flip(input, True, False)


def vflip(input: Tensor) -> Tensor:
    """Flip images vertically (top to bottom).

    Args:
        input: (*, H, W), of any dtype.

    Returns:
        (*, H, W).

    Raises:
        ValueError: if input has fewer than two dimensions.

    Example:
        >>> vflip(torch.tensor([[1, 2], [3, 4]]))
        tensor([[3, 4],
                [1, 2]])
    """
    _check_planes(input)
    return flip(input, False, True)


def rot180(input: Tensor) -> Tensor:
    """Rotate images by 180 degrees.

    Args:
        input: (*, H, W), of any dtype.

    Returns:
        (*, H, W).

    Raises:
        ValueError: if input has fewer than two dimensions.

    Example:
        >>> rot180(torch.tensor([[1, 2], [3, 4]]))
        tensor([[4, 3],
                [2, 1]])
    """
    _check_planes(input)
    return flip(input, True, True)


def transpose(input: Tensor) -> Tensor:
    """Swap the axes of images, like ``cv2.transpose``: pixel (i, j) of the output is pixel (j, i) of input.
    After ``hflip`` it is a rotation by 90 degrees counterclockwise, before it one clockwise.

    Args:
        input: (*, H, W), of any dtype.

    Returns:
        (*, W, H).

    Raises:
        ValueError: if input has fewer than two dimensions.

    Example:
        >>> transpose(torch.tensor([[1, 2, 3], [4, 5, 6]]))
        tensor([[1, 4],
                [2, 5],
                [3, 6]])
    """
    _check_planes(input)
    return transposed(input)


def _check_planes(input: Tensor) -> None:
    check_tensor(input, "input")
    if input.dim() < 2:
        check_rank(input, 2, "(*, H, W)", "input")
