"""Random smoothing."""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ..filters.box import box_blur
from ..filters.correlation import filter2d
from ..filters.gaussian import gaussian_blur2d
from ..filters.median import median_blur
from ..filters.motion import get_motion_kernel2d
from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_pixels
from .decisions import applied, between, check_bounds, check_chance, drawn, whole_between


def random_box_blur(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int] = (3, 3),
    border_type: str = "reflect",
    p: float = 0.5,
) -> Tensor:
    """Replace each pixel by the mean of its window, by ``box_blur``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        kernel_size: (rows, columns).
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.arange(5.0).reshape(1, 1, 1, 5)
        >>> random_box_blur(x, torch.tensor([7]), (1, 3), "replicate", 1.0).flatten()
        tensor([0.3333, 1.0000, 2.0000, 3.0000, 3.6667])
    """
    check_pixels(input, "input")
    check_chance(p)
    return applied(box_blur(input, kernel_size, border_type), input, drawn(seed, 1, input)[:, 0], p)


def random_gaussian_blur(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int],
    sigma: Tuple[float, float],
    border_type: str = "reflect",
    separable: bool = True,
    p: float = 0.5,
) -> Tensor:
    """Convolve with an isotropic Gaussian, by ``gaussian_blur2d``; its standard deviation is uniform in
    ``sigma``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        kernel_size: (rows, columns), odd.
        sigma: (least, greatest) standard deviation in pixels, positive.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        separable: as in ``gaussian_blur2d``.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_gaussian_blur(torch.ones(1, 1, 5, 5), torch.tensor([7]), (3, 3), (0.1, 2.0)).shape
        torch.Size([1, 1, 5, 5])
    """
    check_pixels(input, "input")
    check_bounds(sigma, 0.0, math.inf, "sigma")
    check_chance(p)
    u = drawn(seed, 2, input)
    if sigma[0] == sigma[1]:
        blurred = gaussian_blur2d(input, kernel_size, sigma, border_type, separable)
    else:
        width = between(u[:, 1], sigma, input)
        blurred = gaussian_blur2d(input, kernel_size, torch.stack([width, width], 1), border_type, separable)
    return applied(blurred, input, u[:, 0], p)


def random_median_blur(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int] = (3, 3),
    border_type: str = "reflect",
    p: float = 0.5,
) -> Tensor:
    """Replace each pixel by the median of its window, by ``median_blur``.

    Args:
        input: (B, C, H, W), floating point, without NaN, or uint8.
        seed: (B,), int64, one for each sample.
        kernel_size: (rows, columns), odd.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 5, 5)
        >>> x[0, 0, 2, 2] = 9.0
        >>> random_median_blur(x, torch.tensor([7]), p=1.0).max()
        tensor(0.)
    """
    check_pixels(input, "input")
    check_chance(p)
    return applied(median_blur(input, kernel_size, border_type), input, drawn(seed, 1, input)[:, 0], p)


def random_motion_blur(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int],
    angle: Tuple[float, float],
    direction: Tuple[float, float],
    border_type: str = "constant",
    resample: str = "nearest",
    p: float = 0.5,
) -> Tensor:
    """Blur as if the camera had moved along a line, by ``motion_blur``; each sample has its own length, angle
    and direction.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        kernel_size: (least, greatest) length of the line, odd, at least 3; all odd lengths in this range,
            including both bounds, are equally likely. All kernels have the size of the greatest one, padded
            with zeros.
        angle: (least, greatest) in degrees, counterclockwise.
        direction: (least, greatest), within [-1, 1], see ``get_motion_kernel2d``.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        resample: how the line is resampled, "nearest" or "bilinear".
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, seed = torch.eye(5)[None, None], torch.tensor([7])
        >>> random_motion_blur(x, seed, (5, 5), (135.0, 135.0), (0.0, 0.0), p=1.0)[0, 0, 2, 2]
        tensor(1.)
    """
    check_pixels(input, "input")
    least, greatest = kernel_size
    if least < 3 or least % 2 == 0 or greatest % 2 == 0 or least > greatest:
        raise ValueError(
            f"kernel_size: expected odd (least, greatest) of at least 3, got ({least}, {greatest})"
        )
    check_bounds(angle, -math.inf, math.inf, "angle")
    check_bounds(direction, -1.0, 1.0, "direction")
    check_chance(p)
    u = drawn(seed, 4, input)
    turn, slope = between(u[:, 1], angle, input), between(u[:, 2], direction, input)
    length = least + 2 * whole_between(u[:, 3], (0, (greatest - least) // 2))
    kernel = get_motion_kernel2d(greatest, turn, slope, resample)
    for size in range(least, greatest, 2):
        around: List[int] = [(greatest - size) // 2] * 4
        shorter = torch.nn.functional.pad(get_motion_kernel2d(size, turn, slope, resample), around)
        kernel = torch.where(each(length == size, kernel), shorter, kernel)
    return applied(filter2d(input, kernel, border_type), input, u[:, 0], p)
