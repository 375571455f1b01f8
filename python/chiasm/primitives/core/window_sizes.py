"""Window sizes that need not be odd; ``checks`` validates odd ones."""

from typing import Tuple, Union

import torch

from .checks import check_pair, check_sides


def any_pair(size: Union[int, Tuple[int, int]], name: str) -> Tuple[int, int]:
    """``size`` as (rows, columns).

    >>> any_pair(2, "padding"), any_pair((2, 0), "padding")
    ((2, 2), (2, 0))
    """
    if isinstance(size, int):
        return size, size
    check_pair(size, name)
    return size


def positive_pair(size: Union[int, Tuple[int, int]], name: str) -> Tuple[int, int]:
    """``size`` as (rows, columns); raise ValueError unless both are positive.

    >>> positive_pair((2, 3), "kernel_size")
    (2, 3)
    """
    ky, kx = any_pair(size, name)
    if ky < 1 or kx < 1:
        raise ValueError(f"{name}: expected positive sizes, got ({ky}, {kx})")
    return ky, kx


def four_sides(
    padding: Union[int, Tuple[int, int], Tuple[int, int, int, int]], name: str
) -> Tuple[int, int, int, int]:
    """``padding`` as numbers above, below, left and right; raise ValueError if one is negative.

    >>> four_sides((1, 2), "padding")
    (1, 1, 2, 2)
    """
    if isinstance(padding, int):
        top, bottom, left, right = padding, padding, padding, padding
    elif torch.jit.is_scripting():
        if torch.jit.isinstance(padding, Tuple[int, int]):
            top, bottom, left, right = padding[0], padding[0], padding[1], padding[1]
        else:
            assert torch.jit.isinstance(padding, Tuple[int, int, int, int])
            top, bottom, left, right = padding  # pyright: ignore[reportAssignmentType]: isinstance narrows
    else:
        check_sides(padding, name)
        if len(padding) == 2:
            top, bottom, left, right = padding[0], padding[0], padding[1], padding[1]
        else:
            top, bottom, left, right = padding
    if top < 0 or bottom < 0 or left < 0 or right < 0:
        raise ValueError(f"{name}: expected no negative number, got ({top}, {bottom}, {left}, {right})")
    return top, bottom, left, right


def as_ratio(value: float) -> Tuple[int, int]:
    """The simplest ratio of integers that is practically equal to a positive number, or the last convergent
    with a denominator of at most 65536, which is (0, 1) for a number below 1 / 65537.

    By continued fractions. A symbolic size times a float would become a constant; times a ratio it stays
    symbolic.

    >>> as_ratio(0.3), as_ratio(2.0), as_ratio(1e-5)
    ((3, 10), (2, 1), (0, 1))
    """
    p, q, p_before, q_before = 1, 0, 0, 1
    rest = value
    for _ in range(24):
        whole = int(rest)
        p_next, q_next = whole * p + p_before, whole * q + q_before
        if q_next > 65536:
            break
        p, q, p_before, q_before = p_next, q_next, p, q
        if abs(p / q - value) <= 1e-12 * value:
            break
        rest = 1.0 / (rest - whole)
    return p, q
