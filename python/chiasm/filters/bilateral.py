"""Edge-preserving smoothing."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_leading, check_pixels, check_positive, odd_pair
from ..primitives.filters.bilateral import bilateral_bytes, bilateral_mean
from ..primitives.numbers.loss_reduction import narrowed, widened
from .gaussian import gaussian_kernels


def bilateral_blur(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma_color: Union[float, Tensor],
    sigma_space: Union[Tuple[float, float], Tensor],
    border_type: str = "reflect",
    color_distance_type: str = "l1",
) -> Tensor:
    """Average over neighbours, weighted by closeness in space and in colour.

    C. Tomasi, R. Manduchi, Bilateral filtering for gray and color images, ICCV 1998. OpenCV's
    ``bilateralFilter`` uses the "l1" distance, and a disc where this uses the whole rectangle.

    For uint8, the weights of space and colour are rounded to multiples of 1/2^16, the sums are exact, and the
    mean is rounded (halves up). The result differs by at most one level from the exact mean, and from
    OpenCV's if the corners of the rectangle have no weight.

    Args:
        input: (B, C, H, W), floating point or uint8.
        kernel_size: odd size, one for both axes or (rows, columns); for uint8 at most 4096 pixels.
        sigma_color: standard deviation of the colour distance in input's units; a float, or a tensor (B,) or
            scalar.
        sigma_space: standard deviations in pixels, (y, x) or a tensor (B, 2).
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        color_distance_type: "l1" sums the channels' absolute differences, "l2" is the Euclidean distance.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if a shape or a choice is not as above, or a standard deviation given as a number is not
            positive.

    Example:
        >>> bilateral_blur(torch.ones(1, 3, 5, 5), 3, 0.1, (1.0, 1.0)).shape
        torch.Size([1, 3, 5, 5])
        >>> step = torch.tensor([10, 12, 10, 200], dtype=torch.uint8).reshape(1, 1, 1, 4)
        >>> bilateral_blur(step, (1, 3), 20.0, (9.0, 9.0), "replicate")
        tensor([[[[ 11,  11,  11, 200]]]], dtype=torch.uint8)
    """
    check_pixels(input, "input")
    return _weighted_mean(
        input, input, kernel_size, sigma_color, sigma_space, border_type, color_distance_type
    )


def joint_bilateral_blur(
    input: Tensor,
    guidance: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma_color: Union[float, Tensor],
    sigma_space: Union[Tuple[float, float], Tensor],
    border_type: str = "reflect",
    color_distance_type: str = "l1",
) -> Tensor:
    """Average over neighbours, weighted by closeness in space and in the colour of another image.

    G. Petschnigg et al., Digital photography with flash and no-flash image pairs, SIGGRAPH 2004. uint8 is
    computed as in ``bilateral_blur``.

    Args:
        input: (B, C, H, W), floating point or uint8; the image to average.
        guidance: (B or 1, D, H, W), floating point, or uint8 if input is; the image in which colour distances
            are measured.
        kernel_size: odd size, one for both axes or (rows, columns); for uint8 at most 4096 pixels.
        sigma_color: standard deviation of the colour distance in guidance's units; a float, or a tensor (B,)
            or scalar.
        sigma_space: standard deviations in pixels, (y, x) or a tensor (B, 2).
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        color_distance_type: "l1" sums the channels' absolute differences, "l2" is the Euclidean distance.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input or guidance is neither floating point nor uint8, or one is uint8 and the other one
            is not.
        ValueError: if a shape or a choice is not as above, or a standard deviation given as a number is not
            positive.

    Example:
        >>> joint_bilateral_blur(torch.ones(1, 3, 5, 5), torch.ones(1, 1, 5, 5), 3, 0.1, (1.0, 1.0)).shape
        torch.Size([1, 3, 5, 5])
    """
    check_pixels(input, "input")
    check_pixels(guidance, "guidance")
    if (input.dtype == torch.uint8) != (guidance.dtype == torch.uint8):
        raise TypeError(
            f"guidance: expected uint8 with an input of uint8 and no other, got {guidance.dtype} and"
            f" {input.dtype}"
        )
    if guidance.size(2) != input.size(2) or guidance.size(3) != input.size(3):
        raise ValueError(
            f"guidance: expected input's height and width {list(input.shape)}, got {list(guidance.shape)}"
        )
    check_leading([input, guidance], ["input", "guidance"], [3, 3])
    return _weighted_mean(
        input, guidance, kernel_size, sigma_color, sigma_space, border_type, color_distance_type
    )


def _weighted_mean(
    input: Tensor,
    guidance: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma_color: Union[float, Tensor],
    sigma_space: Union[Tuple[float, float], Tensor],
    border_type: str,
    color_distance_type: str,
) -> Tensor:
    check_choice(color_distance_type, ["l1", "l2"], "color_distance_type")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    of_bytes = input.dtype == torch.uint8
    if of_bytes and ky * kx > 4096:
        raise ValueError(f"kernel_size: expected at most 4096 pixels for bytes, got ({ky}, {kx})")
    wide = widened(input)  # a square of a difference, and its quotient, may exceed half precision
    like = torch.empty([0], dtype=torch.float64 if of_bytes else wide.dtype, device=input.device)
    kernel_y, kernel_x = gaussian_kernels(ky, kx, sigma_space, input.size(0), like, "sigma_space")
    if isinstance(sigma_color, Tensor):
        color = sigma_color.to(like.dtype).reshape(-1, 1, 1, 1)
    else:
        check_positive(sigma_color, "sigma_color")
        color = torch.full([1, 1, 1, 1], sigma_color, dtype=like.dtype, device=input.device)
    range_coefficient = -0.5 / (color * color)
    squares = color_distance_type == "l2"
    if of_bytes:
        return bilateral_bytes(input, guidance, kernel_y, kernel_x, range_coefficient, squares, border_type)
    # in input's dtype, so that both have the same neighbourhoods
    guide = wide if guidance is input else guidance.to(wide.dtype)
    mean = bilateral_mean(wide, guide, kernel_y, kernel_x, range_coefficient, squares, border_type)
    return narrowed(mean, input)
