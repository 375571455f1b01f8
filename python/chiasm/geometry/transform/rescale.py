"""Resizing by a factor, or to a multiple."""

from typing import Optional, Tuple, Union

from torch import Tensor

from ...primitives.core.broadcasting import in_batch, like_given
from ...primitives.core.checks import check_pixels
from ...primitives.core.window_sizes import as_ratio
from .resize import resize


def rescale(
    input: Tensor,
    factor: Union[float, Tuple[float, float]],
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    antialias: bool = False,
) -> Tensor:
    """Resize images by a factor; sizes are rounded down.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), of a type that :func:`resize` takes.
        factor: positive, one for both axes or (vertical, horizontal). It is replaced by the nearest ratio of
            integers up to 65536, so that 0.3 of 10 pixels are 3.
        interpolation, align_corners, antialias: as in :func:`resize`.

    Returns:
        (B, C, floor(factor * H), floor(factor * W)).

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D, a factor is not positive, no pixel is left, or a choice is not one of
            resize's.

    Example:
        >>> rescale(torch.ones(1, 3, 10, 13), (2.0, 0.3)).shape
        torch.Size([1, 3, 20, 3])
    """
    return like_given(
        _rescale_of_batch(in_batch(input, "input"), factor, interpolation, align_corners, antialias), input
    )


def _rescale_of_batch(
    input: Tensor,
    factor: Union[float, Tuple[float, float]],
    interpolation: str,
    align_corners: Optional[bool],
    antialias: bool,
) -> Tensor:
    check_pixels(input, "input", True)
    if isinstance(factor, (int, float)):
        down, across = float(factor), float(factor)
    else:
        down, across = factor  # pyright: ignore[reportGeneralTypeIssues]
    if not (down > 0.0 and across > 0.0):
        raise ValueError(f"factor: expected positive numbers, got ({down}, {across})")
    over_height, under_height = as_ratio(down)
    over_width, under_width = as_ratio(across)
    size = (input.size(2) * over_height // under_height, input.size(3) * over_width // under_width)
    if size[0] < 1 or size[1] < 1:
        raise ValueError(
            f"factor: expected to leave a pixel of {input.size(2)} x {input.size(3)}, got ({down}, {across})"
        )
    return resize(input, size, interpolation, align_corners, "short", antialias)


def resize_to_be_divisible(
    input: Tensor,
    divisible_factor: int,
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    side: str = "short",
    antialias: bool = False,
) -> Tensor:
    """Resize images to the nearest sizes that are divisible by a number.

    Args:
        input: (B, C, H, W), (C, H, W) or (H, W), of a type that :func:`resize` takes.
        divisible_factor: the number.
        interpolation, align_corners, antialias: as in :func:`resize`.
        side: for compatibility with Kornia; ignored, since both sizes are determined.

    Returns:
        The same with sizes k * divisible_factor and l * divisible_factor, k and l being H / divisible_factor
        and W / divisible_factor rounded to the nearest, halves to even.

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D, divisible_factor is not positive, no pixel is left, or a choice is
            not one of resize's.

    Example:
        >>> resize_to_be_divisible(torch.ones(1, 3, 30, 50), 16).shape
        torch.Size([1, 3, 32, 48])
    """
    check_pixels(in_batch(input, "input"), "input", True)
    if divisible_factor < 1:
        raise ValueError(f"divisible_factor: expected a positive number, got {divisible_factor}")
    size = (
        _nearest_multiple(input.size(-2), divisible_factor),
        _nearest_multiple(input.size(-1), divisible_factor),
    )
    if size[0] < 1 or size[1] < 1:
        raise ValueError(
            f"divisible_factor: expected less than twice the sides {input.size(-2)} x {input.size(-1)}, got"
            f" {divisible_factor}"
        )
    return resize(input, size, interpolation, align_corners, side, antialias)


def _nearest_multiple(size: int, factor: int) -> int:
    """Computed with + and // only, as sizes of outputs must be: counts where the even and the odd multiples
    begin."""
    odd = (size + (3 * factor - 1) // 2) // (2 * factor)
    even = (size + factor // 2) // (2 * factor)
    return (odd + even) * factor
