"""Random rain and snow."""

from typing import Tuple

import torch
from torch import Tensor

from ..color.hls import hls_to_rgb, rgb_to_hls
from ..primitives.core.checks import check_image, check_pair, check_rgb
from ..primitives.random.draws import uniform
from .decisions import applied, between, check_bounds, check_chance, drawn, whole_between


def random_rain(
    input: Tensor,
    seed: Tensor,
    number_of_drops: Tuple[int, int] = (1000, 2000),
    drop_height: Tuple[int, int] = (5, 20),
    drop_width: Tuple[int, int] = (-5, 5),
    p: float = 0.5,
) -> Tensor:
    """Draw rain drops: lines of the grey 200 / 255; in one image all lines have the same slope.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        number_of_drops: (least, greatest), not negative; all numbers in the range are equally likely, here
            and below.
        drop_height: (least, greatest) number of rows, at least 1.
        drop_width: (least, greatest) horizontal offset, in pixels, of a drop's lower end from its upper end,
            positive to the right; its absolute value must not exceed the least height.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype. The part of a drop outside the image is cut off.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = random_rain(torch.zeros(1, 1, 30, 30), torch.tensor([7]), (1, 1), (5, 5), (0, 0), 1.0)
        >>> x.max(), (x > 0).sum()
        (tensor(0.7843), tensor(5))
    """
    check_image(input, "input")
    check_pair(number_of_drops, "number_of_drops")
    check_pair(drop_height, "drop_height")
    check_pair(drop_width, "drop_width")
    if number_of_drops[0] < 0 or number_of_drops[0] > number_of_drops[1]:
        raise ValueError(
            "number_of_drops: expected (least, greatest), not negative, got"
            f" ({number_of_drops[0]}, {number_of_drops[1]})"
        )
    if drop_height[0] < 1 or drop_height[0] > drop_height[1]:
        raise ValueError(
            f"drop_height: expected (least, greatest) of at least 1, got ({drop_height[0]}, {drop_height[1]})"
        )
    if drop_width[0] > drop_width[1] or max(-drop_width[0], drop_width[1]) > drop_height[0]:
        raise ValueError(
            f"drop_width: expected (least, greatest) within {drop_height[0]} of 0, got ({drop_width[0]},"
            f" {drop_width[1]})"
        )
    check_chance(p)
    height, width, most = input.size(2), input.size(3), number_of_drops[1]
    u = drawn(seed, 4, input)
    drops = whole_between(u[:, 1], number_of_drops)[:, None, None]
    high = whole_between(u[:, 2], drop_height)[:, None, None]
    wide = whole_between(u[:, 3], drop_width)[:, None, None]
    place = uniform(seed, 2 * most, 1).reshape(seed.size(0), most, 2, 1)
    # Drops begin at positions where they lie within the image, if there is room for them.
    top = torch.floor(place[:, :, 0] * (height - high + 1).clamp(min=1)).to(torch.int64)
    room = (width - wide.abs()).clamp(min=1)
    left = torch.floor(place[:, :, 1] * room).to(torch.int64) - wide.clamp(max=0)
    step = torch.arange(drop_height[1], device=input.device)
    row = top + step
    column = left + torch.div(2 * step * wide + high, 2 * high, rounding_mode="floor")
    drop = torch.arange(most, device=input.device)[:, None]
    seen = (drop < drops) & (step < high) & (row < height) & (column >= 0) & (column < width)
    # Invisible parts are written to one extra pixel.
    pixel = torch.where(seen, row * width + column, torch.full_like(row, height * width)).flatten(1)
    wet = torch.zeros([input.size(0), height * width + 1], dtype=torch.int64, device=input.device)
    wet = wet.scatter(1, pixel, torch.ones_like(pixel))[:, : height * width] > 0
    wet = wet.reshape(-1, 1, height, width)
    rainy = torch.where(wet, torch.full_like(input, 200.0 / 255.0), input)
    return applied(rainy, input, u[:, 0], p)


def random_snow(
    input: Tensor,
    seed: Tensor,
    snow_coefficient: Tuple[float, float] = (0.5, 0.5),
    brightness: Tuple[float, float] = (2.0, 2.0),
    p: float = 1.0,
) -> Tensor:
    """Multiply the lightness in HLS by a factor where the lightness is below a threshold.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        snow_coefficient: (least, greatest) of the threshold, within [0, 1], uniform.
        brightness: (least, greatest) of the factor, at least 1, uniform.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_snow(torch.full((1, 3, 1, 1), 0.25), torch.tensor([7])).flatten()
        tensor([0.5000, 0.5000, 0.5000])
    """
    check_rgb(input, "input")
    check_image(input, "input")
    check_bounds(snow_coefficient, 0.0, 1.0, "snow_coefficient")
    check_bounds(brightness, 1.0, 1e6, "brightness")
    check_chance(p)
    u = drawn(seed, 3, input)
    hls = rgb_to_hls(input)
    lightness = hls[:, 1]
    level = between(u[:, 1], snow_coefficient, input)[:, None, None]
    factor = between(u[:, 2], brightness, input)[:, None, None]
    snowy = torch.where(lightness < level, lightness * factor, lightness).clamp(0.0, 1.0)
    return applied(hls_to_rgb(torch.stack([hls[:, 0], snowy, hls[:, 2]], 1)), input, u[:, 0], p)
