"""Random changes of colour in a random order of each sample.

An order of each sample's own would cost each of the four changes at each of four places. Here a place has one
form for all of them, whose numbers a sample chooses: a change costs nothing twice but where it must.
"""

import math
from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..color.hsv import saturation_of, sixths_value_chroma
from ..color.hue import from_sixths
from ..enhance.hue import adjust_hue
from ..primitives.core.checks import check_pixels, check_rgb
from ..primitives.random.draws import ranks
from .decisions import applied, as_given, between, check_bounds, check_chance, drawn, each, numbers_of


def random_color_jitter(
    input: Tensor,
    seed: Tensor,
    brightness: Tuple[float, float] = (1.0, 1.0),
    contrast: Tuple[float, float] = (1.0, 1.0),
    saturation: Tuple[float, float] = (1.0, 1.0),
    hue: Tuple[float, float] = (0.0, 0.0),
    order: Optional[List[int]] = None,
    p: float = 1.0,
) -> Tensor:
    """Brightness, contrast, saturation and hue as Pillow and torchvision have them, in a random order.

    ``adjust_brightness_accumulative``, ``adjust_contrast_with_mean_subtraction``,
    ``adjust_saturation_with_gray_subtraction`` and ``adjust_hue``, each by a factor uniform in its bounds.
    The 24 orders are equally likely. What changes is computed at each of four places, the first three in one
    go; where an order is given, once.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one a sample.
        brightness: (least, greatest), not negative; 1 changes nothing.
        contrast: the same.
        saturation: the same.
        hue: (least, greatest), in turns, within [-0.5, 0.5]; 0 changes nothing.
        order: 0, 1, 2, 3 (brightness, contrast, saturation, hue) in the order in which all samples get them;
            None draws one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype, in [0, 1]; bytes are rounded once, after all changes.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> grey = torch.full((1, 3, 1, 2), 0.25)
        >>> random_color_jitter(grey, torch.tensor([7]), brightness=(2.0, 2.0))[0, 0]
        tensor([[0.5000, 0.5000]])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(brightness, 0.0, math.inf, "brightness")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = drawn(seed, 9, input)
    factors = [
        each(between(u[:, 1], brightness, input), input),
        each(between(u[:, 2], contrast, input), input),
        each(between(u[:, 3], saturation, input), input),
    ]
    angle = between(u[:, 4], hue, input) * (2.0 * math.pi)
    changing = [
        _changes(brightness, 1.0),
        _changes(contrast, 1.0),
        _changes(saturation, 1.0),
        _changes(hue, 0.0),
    ]
    place = _places(u[:, 5:], order)
    x = numbers_of(input)
    for i in range(4):
        x = _jittered(x, place == i, factors, angle, _possible(order, i, changing))
    return applied(as_given(x, input), input, u[:, 0], p)


def _jittered(x: Tensor, here: Tensor, factors: List[Tensor], angle: Tensor, possible: List[bool]) -> Tensor:
    """One place of the order: ``here`` (B, 4) says which change of each sample stands here, ``possible``
    which of any sample may."""
    if possible[0] or possible[1] or possible[2]:
        # All three are blends with something: black, the mean grey, each pixel's grey.
        other, factor = torch.zeros_like(factors[0]), torch.ones_like(factors[0])
        for i in range(3):
            factor = torch.where(each(here[:, i], x), factors[i], factor)
        if possible[1] or possible[2]:
            grey = rgb_to_grayscale(x)
            if possible[1]:
                other = torch.where(each(here[:, 1], x), grey.mean([1, 2, 3], keepdim=True), other)
            if possible[2]:
                other = torch.where(each(here[:, 2], x), grey, other)
        blended = (other + (x - other) * factor).clamp(0.0, 1.0)
    else:
        blended = x
    if possible[3]:
        return torch.where(each(here[:, 3], x), adjust_hue(x, angle), blended)
    return blended


def random_color_jiggle(
    input: Tensor,
    seed: Tensor,
    brightness: Tuple[float, float] = (1.0, 1.0),
    contrast: Tuple[float, float] = (1.0, 1.0),
    saturation: Tuple[float, float] = (1.0, 1.0),
    hue: Tuple[float, float] = (0.0, 0.0),
    order: Optional[List[int]] = None,
    p: float = 1.0,
) -> Tensor:
    """Brightness, contrast, saturation and hue in a random order: what is added to all values, what they are
    multiplied by, and saturation and hue in HSV.

    ``adjust_brightness`` by b - 1, ``adjust_contrast``, ``adjust_saturation`` and ``adjust_hue``, each number
    uniform in its bounds. The 24 orders are equally likely. What changes is computed at each of four places,
    the first two in one go and the last two; where an order is given, once.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one a sample.
        brightness: (least, greatest), within [0, 2]; 1 changes nothing.
        contrast: (least, greatest), not negative; 1 changes nothing.
        saturation: the same.
        hue: (least, greatest), in turns, within [-0.5, 0.5]; 0 changes nothing.
        order: 0, 1, 2, 3 (brightness, contrast, saturation, hue) in the order in which all samples get them;
            None draws one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype, in [0, 1]; bytes are rounded once, after all changes.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> grey = torch.full((1, 3, 1, 2), 0.25)
        >>> random_color_jiggle(grey, torch.tensor([7]), brightness=(1.5, 1.5))[0, 0]
        tensor([[0.7500, 0.7500]])
    """
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_bounds(brightness, 0.0, 2.0, "brightness")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = drawn(seed, 9, input)
    added = each(between(u[:, 1], brightness, input) - 1.0, input)
    factor = each(between(u[:, 2], contrast, input), input)
    richer = between(u[:, 3], saturation, input)
    angle = between(u[:, 4], hue, input)
    changing = [
        _changes(brightness, 1.0),
        _changes(contrast, 1.0),
        _changes(saturation, 1.0),
        _changes(hue, 0.0),
    ]
    place = _places(u[:, 5:], order)
    x = numbers_of(input)
    for i in range(4):
        x = _jiggled(x, place == i, added, factor, richer, angle, _possible(order, i, changing))
    return applied(as_given(x, input), input, u[:, 0], p)


def _jiggled(
    x: Tensor,
    here: Tensor,
    added: Tensor,
    factor: Tensor,
    richer: Tensor,
    angle: Tensor,
    possible: List[bool],
) -> Tensor:
    """One place of the order: ``here`` (B, 4) says which change of each sample stands here, ``possible``
    which of any sample may."""
    plain = x
    if possible[0] or possible[1]:
        sum = torch.where(each(here[:, 0], x), added, torch.zeros_like(added))
        product = torch.where(each(here[:, 1], x), factor, torch.ones_like(factor))
        plain = (x * product + sum).clamp(0.0, 1.0)
    if not possible[2] and not possible[3]:
        return plain
    sixths, value, chroma = sixths_value_chroma(x)
    turn = each(torch.where(here[:, 3], angle, torch.zeros_like(angle)), value) * 6.0
    # Of hue alone the spread as it is, lest a quotient and a product round it.
    saturated = value * (saturation_of(value, chroma, 1e-8) * each(richer, value)).clamp(0.0, 1.0)
    chroma = torch.where(each(here[:, 2], value), saturated, chroma)
    coloured = from_sixths(sixths + turn, value, chroma)
    return torch.where(each(here[:, 2] | here[:, 3], x), coloured, plain)


def _places(keys: Tensor, order: Optional[List[int]]) -> Tensor:
    """(B, 4): the place of each change, from random keys (B, 4) or from the order of all."""
    if order is None:
        return ranks(keys)
    if sorted(order) != [0, 1, 2, 3]:
        raise ValueError(f"order: expected a permutation of 0, 1, 2 and 3, got {order}")
    return torch.tensor([order.index(i) for i in range(4)], device=keys.device).expand(keys.shape)


def _possible(order: Optional[List[int]], place: int, changing: List[bool]) -> List[bool]:
    """Of the four changes those that may stand at a place, and change anything."""
    return [changing[i] and (order is None or order[place] == i) for i in range(4)]


def _changes(bounds: Tuple[float, float], nothing: float) -> bool:
    return bounds[0] != nothing or bounds[1] != nothing
