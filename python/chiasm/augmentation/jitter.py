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
from ..primitives.core.checks import check_image, check_rgb
from ..primitives.random import uniform
from .decisions import applied, between, check_bounds, check_chance, each, ranks

BRIGHTNESS, CONTRAST, SATURATION, HUE = 0, 1, 2, 3


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
    The 24 orders are equally likely. Hue is computed at each of four places; where its bounds are (0, 0), or
    an order is given, not so.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1].
        seed: (B,), int64, one a sample.
        brightness: (least, greatest), not negative; 1 changes nothing.
        contrast: the same.
        saturation: the same.
        hue: (least, greatest), in turns, within [-0.5, 0.5]; 0 changes nothing.
        order: 0, 1, 2, 3 (brightness, contrast, saturation, hue) in the order in which all samples get them;
            None draws one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype, in [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> grey = torch.full((1, 3, 1, 2), 0.25)
        >>> random_color_jitter(grey, torch.tensor([7]), brightness=(2.0, 2.0))[0, 0]
        tensor([[0.5000, 0.5000]])
    """
    check_rgb(input, "input")
    check_image(input, "input")
    check_bounds(brightness, 0.0, math.inf, "brightness")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = uniform(seed, 9, 0)
    factors = [
        each(between(u[:, 1], brightness, input), input),
        each(between(u[:, 2], contrast, input), input),
        each(between(u[:, 3], saturation, input), input),
    ]
    angle = between(u[:, 4], hue, input) * (2.0 * math.pi)
    turns = hue[0] != 0.0 or hue[1] != 0.0
    place = _places(u[:, 5:], order)
    x = input
    for i in range(4):
        x = _jittered(x, place == i, factors, angle, turns, _at(order, i))
    return applied(x, input, u[:, 0], p)


def _jittered(
    x: Tensor, here: Tensor, factors: List[Tensor], angle: Tensor, turns: bool, only: int
) -> Tensor:
    """One place of the order: what stands here of each sample, (B, 4); ``only`` is what stands here of all,
    or -1."""
    if only == HUE:
        return adjust_hue(x, angle) if turns else x
    # All three are blends with something: black, the mean grey, each pixel's grey.
    one, black = torch.ones_like(factors[0]), torch.zeros_like(factors[0])
    factor = torch.where(each(here[:, BRIGHTNESS], x), factors[0], one)
    factor = torch.where(each(here[:, CONTRAST], x), factors[1], factor)
    factor = torch.where(each(here[:, SATURATION], x), factors[2], factor)
    other = black
    if only != BRIGHTNESS:
        grey = rgb_to_grayscale(x)
        if only != SATURATION:
            mean = grey.mean([1, 2, 3], keepdim=True)
            other = torch.where(each(here[:, CONTRAST], x), mean, other)
        other = torch.where(each(here[:, SATURATION], x), grey, other)
    blended = (other + (x - other) * factor).clamp(0.0, 1.0)
    if turns and only == -1:
        return torch.where(each(here[:, HUE], x), adjust_hue(x, angle), blended)
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
    uniform in its bounds. The 24 orders are equally likely. HSV is computed at each of four places; where
    saturation and hue change nothing, or an order is given, not so.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1].
        seed: (B,), int64, one a sample.
        brightness: (least, greatest), within [0, 2]; 1 changes nothing.
        contrast: (least, greatest), not negative; 1 changes nothing.
        saturation: the same.
        hue: (least, greatest), in turns, within [-0.5, 0.5]; 0 changes nothing.
        order: 0, 1, 2, 3 (brightness, contrast, saturation, hue) in the order in which all samples get them;
            None draws one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype, in [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> grey = torch.full((1, 3, 1, 2), 0.25)
        >>> random_color_jiggle(grey, torch.tensor([7]), brightness=(1.5, 1.5))[0, 0]
        tensor([[0.7500, 0.7500]])
    """
    check_rgb(input, "input")
    check_image(input, "input")
    check_bounds(brightness, 0.0, 2.0, "brightness")
    check_bounds(contrast, 0.0, math.inf, "contrast")
    check_bounds(saturation, 0.0, math.inf, "saturation")
    check_bounds(hue, -0.5, 0.5, "hue")
    check_chance(p)
    u = uniform(seed, 9, 0)
    added = each(between(u[:, 1], brightness, input) - 1.0, input)
    factor = each(between(u[:, 2], contrast, input), input)
    richer = between(u[:, 3], saturation, input)
    angle = between(u[:, 4], hue, input)
    colours = hue[0] != 0.0 or hue[1] != 0.0 or saturation[0] != 1.0 or saturation[1] != 1.0
    place = _places(u[:, 5:], order)
    x = input
    for i in range(4):
        x = _jiggled(x, place == i, added, factor, richer, angle, colours, _at(order, i))
    return applied(x, input, u[:, 0], p)


def _jiggled(
    x: Tensor,
    here: Tensor,
    added: Tensor,
    factor: Tensor,
    richer: Tensor,
    angle: Tensor,
    colours: bool,
    only: int,
) -> Tensor:
    """One place of the order: what stands here of each sample, (B, 4); ``only`` is what stands here of all,
    or -1."""
    plain = x
    if only != HUE and only != SATURATION:
        sum = torch.where(each(here[:, BRIGHTNESS], x), added, torch.zeros_like(added))
        product = torch.where(each(here[:, CONTRAST], x), factor, torch.ones_like(factor))
        plain = (x * product + sum).clamp(0.0, 1.0)
    if not colours or only == BRIGHTNESS or only == CONTRAST:
        return plain
    sixths, value, chroma = sixths_value_chroma(x)
    richness = each(torch.where(here[:, SATURATION], richer, torch.ones_like(richer)), value)
    turn = each(torch.where(here[:, HUE], angle, torch.zeros_like(angle)), value) * 6.0
    # Of hue alone the spread as it is, lest a quotient and a product round it.
    saturated = value * (saturation_of(value, chroma, 1e-8) * richness).clamp(0.0, 1.0)
    chroma = torch.where(each(here[:, SATURATION], value), saturated, chroma)
    coloured = from_sixths(sixths + turn, value, chroma)
    return torch.where(each(here[:, SATURATION] | here[:, HUE], x), coloured, plain)


def _places(keys: Tensor, order: Optional[List[int]]) -> Tensor:
    """(B, 4): the place of each change, from random keys (B, 4) or from the order of all."""
    if order is None:
        return ranks(keys)
    if sorted(order) != [0, 1, 2, 3]:
        raise ValueError(f"order: expected a permutation of 0, 1, 2 and 3, got {order}")
    return torch.argsort(torch.tensor(order, device=keys.device)).expand(keys.shape)


def _at(order: Optional[List[int]], place: int) -> int:
    return -1 if order is None else order[place]
