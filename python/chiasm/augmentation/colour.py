"""Random brightness, contrast, saturation, hue and grey of each sample."""

import math
from typing import Optional, Tuple

from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..enhance.adjust import adjust_brightness, adjust_contrast, adjust_gamma
from ..enhance.arithmetic import shift_rgb
from ..enhance.hue import adjust_hue, adjust_saturation
from ..primitives.core.checks import check_pixels, check_rgb
from .decisions import applied, as_given, between, check_bounds, check_chance, drawn, numbers_of, white_of


def random_brightness(
    input: Tensor,
    seed: Tensor,
    brightness: Tuple[float, float] = (1.0, 1.0),
    clip_output: bool = True,
    p: float = 1.0,
) -> Tensor:
    """Add a number to every value, by ``adjust_brightness`` with ``b - 1``, where b is uniform in
    ``brightness``. For uint8, the number is multiplied by 255.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        brightness: (least, greatest), within [0, 2]; 1 changes nothing.
        clip_output: limit the result to [0, 1]; bytes saturate in any case.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_brightness(torch.tensor([[[[0.25, 0.75]]]]), torch.tensor([7]), (1.5, 1.5))
        tensor([[[[0.7500, 1.0000]]]])
    """
    check_pixels(input, "input")
    check_bounds(brightness, 0.0, 2.0, "brightness")
    check_chance(p)
    u = drawn(seed, 2, input)
    addition = (between(u[:, 1], brightness, input) - 1.0) * white_of(input)
    return applied(adjust_brightness(input, addition, clip_output), input, u[:, 0], p)


def random_contrast(
    input: Tensor,
    seed: Tensor,
    contrast: Tuple[float, float] = (1.0, 1.0),
    clip_output: bool = True,
    p: float = 1.0,
) -> Tensor:
    """Multiply every value by a factor, by ``adjust_contrast``; the factor is uniform in ``contrast``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        contrast: (least, greatest), not negative; 1 changes nothing.
        clip_output: limit the result to [0, 1]; bytes saturate in any case.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_contrast(torch.tensor([[[[0.25, 0.75]]]]), torch.tensor([7]), (2.0, 2.0))
        tensor([[[[0.5000, 1.0000]]]])
    """
    check_pixels(input, "input")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_chance(p)
    u = drawn(seed, 2, input)
    factor = between(u[:, 1], contrast, input)
    return applied(adjust_contrast(input, factor, clip_output), input, u[:, 0], p)


def random_saturation(
    input: Tensor, seed: Tensor, saturation: Tuple[float, float] = (1.0, 1.0), p: float = 1.0
) -> Tensor:
    """Multiply the saturation in HSV, by ``adjust_saturation``; the factor is uniform in ``saturation``.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        saturation: (least, greatest), not negative; 0 gives grey, 1 changes nothing.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> red = torch.tensor([0.8, 0.4, 0.4]).reshape(1, 3, 1, 1)
        >>> random_saturation(red, torch.tensor([7]), (0.5, 0.5)).flatten()
        tensor([0.8000, 0.6000, 0.6000])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_chance(p)
    u = drawn(seed, 2, input)
    richer = adjust_saturation(numbers_of(input), between(u[:, 1], saturation, input))
    return applied(as_given(richer, input), input, u[:, 0], p)


def random_hue(input: Tensor, seed: Tensor, hue: Tuple[float, float] = (0.0, 0.0), p: float = 1.0) -> Tensor:
    """Rotate the hue, by ``adjust_hue``; the angle is uniform in ``hue``.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        hue: (least, greatest), in turns, within [-0.5, 0.5]; 0 changes nothing.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> red = torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)
        >>> random_hue(red, torch.tensor([7]), (0.5, 0.5)).flatten()
        tensor([0., 1., 1.])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = drawn(seed, 2, input)
    turned = adjust_hue(numbers_of(input), between(u[:, 1], hue, input) * (2.0 * math.pi))
    return applied(as_given(turned, input), input, u[:, 0], p)


def random_gamma(
    input: Tensor,
    seed: Tensor,
    gamma: Tuple[float, float] = (1.0, 1.0),
    gain: Tuple[float, float] = (1.0, 1.0),
    p: float = 1.0,
) -> Tensor:
    """Apply a power law, by ``adjust_gamma``; the exponent is uniform in ``gamma``, the factor in ``gain``.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        gamma: (least, greatest), not negative; 1 changes nothing.
        gain: (least, greatest), not negative.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to its range.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_gamma(torch.tensor([[[[0.25, 1.0]]]]), torch.tensor([7]), (0.5, 0.5))
        tensor([[[[0.5000, 1.0000]]]])
    """
    check_pixels(input, "input")
    check_bounds(gamma, 0.0, math.inf, "gamma")
    check_bounds(gain, 0.0, math.inf, "gain")
    check_chance(p)
    u = drawn(seed, 3, input)
    curved = adjust_gamma(input, between(u[:, 1], gamma, input), between(u[:, 2], gain, input))
    return applied(curved, input, u[:, 0], p)


def random_grayscale(
    input: Tensor, seed: Tensor, rgb_weights: Optional[Tensor] = None, p: float = 0.1
) -> Tensor:
    """Convert to grey, with the same value in all three channels, by ``rgb_to_grayscale``.

    Args:
        input: RGB (B, 3, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        rgb_weights: (3,), weights of red, green and blue, by default those of the luma of ITU-R BT.601; must
            be None for uint8.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> red = torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1)
        >>> random_grayscale(red, torch.tensor([7]), p=1.0).flatten()
        tensor([0.2990, 0.2990, 0.2990])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_chance(p)
    grey = rgb_to_grayscale(input, rgb_weights).expand(-1, 3, -1, -1)
    return applied(grey, input, drawn(seed, 1, input)[:, 0], p)


def random_rgb_shift(
    input: Tensor,
    seed: Tensor,
    r_shift_limit: Tuple[float, float] = (-0.5, 0.5),
    g_shift_limit: Tuple[float, float] = (-0.5, 0.5),
    b_shift_limit: Tuple[float, float] = (-0.5, 0.5),
    p: float = 0.5,
) -> Tensor:
    """Add a different number to each channel, by ``shift_rgb``.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        r_shift_limit: (least, greatest) number that is added to red, uniform, as a fraction of white, also
            for uint8.
        g_shift_limit: the same for green.
        b_shift_limit: the same for blue.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype; a changed sample is limited to its range.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> grey, seed = torch.full((1, 3, 1, 1), 0.5), torch.tensor([7])
        >>> random_rgb_shift(grey, seed, (0.1, 0.1), (0.0, 0.0), (-0.2, -0.2), 1.0).flatten()
        tensor([0.6000, 0.5000, 0.3000])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(r_shift_limit, -math.inf, math.inf, "r_shift_limit")
    check_bounds(g_shift_limit, -math.inf, math.inf, "g_shift_limit")
    check_bounds(b_shift_limit, -math.inf, math.inf, "b_shift_limit")
    check_chance(p)
    u = drawn(seed, 4, input)
    red, green, blue = (
        between(u[:, 1], r_shift_limit, input),
        between(u[:, 2], g_shift_limit, input),
        between(u[:, 3], b_shift_limit, input),
    )
    shifted = shift_rgb(numbers_of(input), red, green, blue)
    return applied(as_given(shifted, input), input, u[:, 0], p)
