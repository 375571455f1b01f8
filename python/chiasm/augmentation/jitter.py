"""Random changes of colour, in a random order for each sample. If each of the four places of the order
computed all four changes for all samples, this would cost 16 changes. Jitter instead has one sequence that
contains every order. Jiggle has one formula for the changes of a place; each sample chooses the formula's
numbers.
"""

import math
from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..color.hsv import saturation_of, sixths_value_chroma, sixths_value_chroma_of
from ..color.hue import from_sixths, planes_of_sixths
from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_pixels, check_rgb
from ..primitives.images.color_planes import channels_of
from ..primitives.random.draws import ranks
from .decisions import applied, as_given, between, check_bounds, check_chance, drawn, numbers_of


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
    """Change brightness, contrast, saturation and hue like Pillow and torchvision, in a random order.

    ``adjust_brightness_accumulative``, ``adjust_contrast_with_mean_subtraction``,
    ``adjust_saturation_with_gray_subtraction`` and ``adjust_hue``, each with a factor (hue: an angle) uniform
    in its bounds. The 24 orders are equally likely.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
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
        between(u[:, 1], brightness, input),
        between(u[:, 2], contrast, input),
        between(u[:, 3], saturation, input),
        between(u[:, 4], hue, input) * 6.0,  # sixths of a turn
    ]
    changing = [
        _changes(brightness, 1.0),
        _changes(contrast, 1.0),
        _changes(saturation, 1.0),
        _changes(hue, 0.0),
    ]
    red, green, blue = channels_of(numbers_of(input))
    planes = [red, green, blue]
    if order is None:
        planes = _in_own_orders(planes, ranks(u[:, 5:]), factors, changing)
    else:
        _check_order(order)
        for i in order:
            if changing[i]:
                planes = _changed(planes, i, factors[i])
    return applied(as_given(torch.stack(planes, 1), input), input, u[:, 0], p)


def _changed(planes: List[Tensor], change: int, factor: Tensor) -> List[Tensor]:
    """The planes (B, H, W) after one of the four changes, by a factor (B,); for hue, by an angle (B,)."""
    by = each(factor, planes[0])
    if change == 0:
        return [(x * by).clamp(0.0, 1.0) for x in planes]
    if change == 3:
        sixths, value, chroma = sixths_value_chroma_of(planes[0], planes[1], planes[2])
        red, green, blue = planes_of_sixths(sixths + by, value, chroma)
        return [red, green, blue]
    grey = planes[0] * 0.299 + planes[1] * 0.587 + planes[2] * 0.114
    if change == 1:
        grey = grey.mean([1, 2], keepdim=True)
    other = grey * (1.0 - by)
    return [(x * by + other).clamp(0.0, 1.0) for x in planes]  # exactly x for a factor of 1


def _in_own_orders(
    planes: List[Tensor], place: Tensor, factors: List[Tensor], changing: List[bool]
) -> List[Tensor]:
    """Apply the changes to each sample in its own order; ``place`` (B, 4) is the place of each change. One
    sequence contains every order: [b s b h b s b] c [b s b h b s b]. Each sample applies each change at the
    right step for its order; at other steps a factor of 1 changes nothing. Contrast occurs once, since the
    mean of an image needs its own loop. Hue costs the most; it occurs twice instead of four times.
    """
    one = torch.ones_like(factors[0])
    earlier = place.unsqueeze(-1) < place.unsqueeze(-2)  # (B, i, j): i stands before j
    of_contrast = [~earlier[:, 1], earlier[:, 1]]  # the changes before contrast, and after it
    of_hue = [~earlier[:, 3], earlier[:, 3]]
    here: List[Tensor] = []
    for stands in of_contrast:
        for half in of_hue:
            now = stands & half
            here.append(torch.where(now[:, 0] & earlier[:, 0, 2], factors[0], one))
            here.append(torch.where(now[:, 2], factors[2], one))
            here.append(torch.where(now[:, 0] & earlier[:, 2, 0], factors[0], one))
        here.append(stands[:, 3].to(one.dtype))
    numbers = torch.stack(here, 1)  # (B, 14): computed once for each sample, not at every pixel
    for after in range(2):
        if after == 1 and changing[1]:
            planes = _changed(planes, 1, factors[1])
        for turned in range(2):
            if turned == 1 and changing[3]:
                is_here = each(numbers[:, 7 * after + 6], planes[0]) > 0.5
                hued = _changed(planes, 3, factors[3])
                planes = [torch.where(is_here, hued[i], planes[i]) for i in range(3)]
            for i in range(3):
                change = 2 if i == 1 else 0
                if changing[change]:
                    planes = _changed(planes, change, numbers[:, 7 * after + 3 * turned + i])
    return planes


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
    """Change brightness (a sum), contrast (a factor), and saturation and hue in HSV, in a random order.

    ``adjust_brightness`` by b - 1, ``adjust_contrast``, ``adjust_saturation`` and ``adjust_hue``, each number
    uniform in its bounds. The 24 orders are equally likely. Each of the four places of the order computes all
    changes that the bounds allow: brightness and contrast in one formula, saturation and hue in a second one.
    If ``order`` is given, each change is computed once.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
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
    """One place of the order: ``here`` (B, 4) says which change each sample has at this place, ``possible``
    which changes any sample may have here."""
    plain = x
    if possible[0] or possible[1]:
        sum = torch.where(each(here[:, 0], x), added, torch.zeros_like(added))
        product = torch.where(each(here[:, 1], x), factor, torch.ones_like(factor))
        plain = (x * product + sum).clamp(0.0, 1.0)
    if not possible[2] and not possible[3]:
        return plain
    sixths, value, chroma = sixths_value_chroma(x)
    turn = each(torch.where(here[:, 3], angle, torch.zeros_like(angle)), value) * 6.0
    # If only the hue changes, keep the spread as it is, so that a quotient and a product do not round it.
    saturated = value * (saturation_of(value, chroma, 1e-8) * each(richer, value)).clamp(0.0, 1.0)
    chroma = torch.where(each(here[:, 2], value), saturated, chroma)
    coloured = from_sixths(sixths + turn, value, chroma)
    return torch.where(each(here[:, 2] | here[:, 3], x), coloured, plain)


def _places(keys: Tensor, order: Optional[List[int]]) -> Tensor:
    """(B, 4): the place of each change, from random keys (B, 4) or from the order for all samples."""
    if order is None:
        return ranks(keys)
    _check_order(order)
    return torch.tensor([order.index(i) for i in range(4)], device=keys.device).expand(keys.shape)


def _check_order(order: List[int]) -> None:
    if sorted(order) != [0, 1, 2, 3]:
        raise ValueError(f"order: expected a permutation of 0, 1, 2 and 3, got {order}")


def _possible(order: Optional[List[int]], place: int, changing: List[bool]) -> List[bool]:
    """For each of the four changes, whether it may be at a place and has an effect."""
    return [changing[i] and (order is None or order[place] == i) for i in range(4)]


def _changes(bounds: Tuple[float, float], nothing: float) -> bool:
    return bounds[0] != nothing or bounds[1] != nothing
