"""Flips and the rotation by 180 degrees."""

from torch import Tensor

from ...primitives.core.checks import check_rank, check_tensor
from ...primitives.resampling.flips import flip


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


def _check_planes(input: Tensor) -> None:
    check_tensor(input, "input")
    if input.dim() < 2:
        check_rank(input, 2, "(*, H, W)", "input")
