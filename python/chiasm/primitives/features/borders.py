"""Parallel border following for sets of pixels. A border runs along sides of pixels of the set, with the set
on its left. The pixels ahead determine the next side of each side: so borders are the cycles of a
permutation. The first side of a cycle, and the distance of each side from it, are found by doubling: after k
steps a side knows the 2^k sides that follow it (J. C. Wyllie, The Complexity of Parallel Computations, 1979).

Sides are numbered by their direction, then by pixel: (side * H + y) * W + x with the sides 0 top, 1 left, 2
bottom, 3 right, in the order of the border around a single pixel.
"""

from typing import Tuple

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def find_contours(mask: Tensor, polygons: int, points: int) -> Tensor:
    """The borders of (N, H, W) bool that enclose the most pixels, largest first: (N, polygons, 2 + points),
    int64.

    Each row has the number of points, 1 if the border is around a hole, and the points: the pixels, as
    numbers y * W + x, where the 8-connected path along the border changes direction. If a border has more
    than ``points``, they are chosen evenly. Unused entries are -1.

    >>> find_contours(torch.tensor([[[True, True]]]), 1, 3)
    tensor([[[ 2,  0,  0,  1, -1]]])
    """
    width, count = mask.size(2), mask.size(1) * mask.size(2)
    successor, is_corner = border_successors(mask)
    batch = mask.size(0)
    side = torch.arange(4 * count, device=mask.device).expand_as(successor)
    facing, none = side // count, torch.zeros_like(side)
    pixel = side - facing * count
    x = pixel - pixel // width * width
    # Green's theorem: the area is the sum of x along the vertical sides.
    strip = torch.where(facing == 3, x + 1, torch.where(facing == 1, -x, none))
    strip = torch.where(successor == side, none, strip)
    root, corners, area = border_sums(successor, is_corner.to(torch.int64), strip)
    # A border's first side is the top of its first pixel. Borders of equal area are in the order of these
    # pixels.
    key = area[:, :count].abs() * count + (count - 1 - side[:, :count])
    key = torch.where((root == side)[:, :count] & (key >= count), key, none[:, :count])
    # A small mask may have fewer pixels than there are slots.
    key = torch.cat([key, none[:, :1].expand(-1, polygons)], 1)
    key = torch.topk(key, polygons, 1)[0]
    used = key > 0
    first = torch.where(used, count - 1 - (key - key // count * count), torch.zeros_like(key))
    number = torch.where(used, corners.gather(1, first).clamp(max=points), torch.zeros_like(first))
    is_hole = used & (area.gather(1, first) < 0)
    # An unused slot begins at a side beyond the last.
    begin = torch.where(used, first, torch.full_like(first, 4 * count))
    slots = torch.full([mask.size(0), 4 * count + 1], polygons, dtype=torch.int64, device=mask.device)
    slot = slots.scatter(1, begin, torch.arange(polygons, device=mask.device).expand_as(first)).gather(
        1, root
    )
    whole = corners.gather(1, root)
    place = whole - corners
    # Point k is the corner k * span // points.
    span = whole.clamp(min=points)
    point = (place * points + span - 1) // span
    is_drawn = is_corner & (slot < polygons) & (point * span // points == place)
    point = torch.where(is_drawn, slot * points + point, torch.full_like(slot, polygons * points))
    room = torch.full([batch, polygons * points + 1], -1, dtype=torch.int64, device=mask.device)
    pixels = room.scatter(1, point, pixel)[:, : polygons * points]
    pixels = pixels.reshape(batch, polygons, points)
    return torch.cat([number[..., None], is_hole[..., None].to(torch.int64), pixels], 2)


@find_contours.lowering("native", when=kernels.available)
def _find_contours_kernel(mask: Tensor, polygons: int, points: int) -> Tensor:
    return kernels.find_contours(mask.to(torch.uint8), polygons, points + 2)


def border_successors(mask: Tensor) -> Tuple[Tensor, Tensor]:
    """For each side of the pixels of (N, H, W) bool, two tensors (N, 4 H W).

    The first has the next side of the border, int64, or the side itself if it is not in a border. The second
    is true if the 8-connected path through the pixels leaves the side in a new direction.

    >>> successor, is_corner = border_successors(torch.tensor([[[True, True]]]))
    >>> successor, is_corner
    (tensor([[2, 0, 4, 3, 5, 7, 6, 1]]), tensor([[False,  True, False, False,  True, False, False, False]]))
    """
    height, width = mask.size(1), mask.size(2)
    around = torch.nn.functional.pad(mask.to(torch.int32), [1, 1, 1, 1])
    count = height * width
    pixel = torch.arange(count, device=mask.device).reshape(1, height, width)
    successors, straights, diagonals, turns = [], [], [], []
    # The direction (y, x) that each side faces. From a side, a border goes on in the direction that the next
    # side faces.
    facing = [(-1, 0), (0, -1), (1, 0), (0, 1)]
    for side in range(4):
        out_y, out_x = facing[side]
        on_y, on_x = facing[(side + 1) % 4]
        own = pixel + side * count
        is_border = mask & ~_shifted(around, out_y, out_x, height, width)
        diagonal = is_border & _shifted(around, on_y + out_y, on_x + out_x, height, width)
        straight = is_border & _shifted(around, on_y, on_x, height, width) & ~diagonal
        successor = torch.where(is_border, pixel + (side + 1) % 4 * count, own)
        successor = torch.where(straight, own + (on_y * width + on_x), successor)
        beyond = pixel + ((side + 3) % 4 * count + (on_y + out_y) * width + on_x + out_x)
        successors.append(torch.where(diagonal, beyond, successor).flatten(1))
        straights.append(straight.flatten(1))
        diagonals.append(diagonal.flatten(1))
        turns.append((is_border & ~straight & ~diagonal).flatten(1))
    # The path of a single pixel leaves none of its sides: its first side is the corner.
    alone = turns[0] & turns[1] & turns[2] & turns[3]
    no = torch.zeros_like(alone)
    alone = torch.cat([alone, no, no, no], 1)
    successor, turn = torch.cat(successors, 1), torch.cat(turns, 1)
    straight, diagonal = torch.cat(straights, 1), torch.cat(diagonals, 1)
    own = torch.arange(4 * count, device=mask.device).expand_as(successor)
    before = torch.zeros_like(successor).scatter(1, successor, own)
    # The direction stays the same in two straight steps, and in two diagonal steps with one turn between
    # them.
    same = straight & straight.gather(1, before)
    same = same | (diagonal & turn.gather(1, before) & diagonal.gather(1, before.gather(1, before)))
    return successor, ((straight | diagonal) & ~same) | alone


def border_sums(successor: Tensor, first: Tensor, second: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The lowest side of each side's border, (N, S) int64, and the sums of two weights (N, S), int64, from
    each side to the end of its border. At the lowest side they are the sums of the whole border.

    >>> ones = torch.ones(1, 4, dtype=torch.int64)
    >>> border_sums(torch.tensor([[1, 2, 0, 3]]), ones, 2 * ones)
    (tensor([[0, 0, 0, 3]]), tensor([[3, 2, 1, 1]]), tensor([[6, 4, 2, 2]]))
    """
    own = torch.arange(successor.size(1), device=successor.device).expand_as(successor)
    root = _least(torch.stack([own, successor]), 64)[0]
    is_root, none = root == own, torch.zeros_like(own)
    after = torch.where(is_root, own, successor)
    state = torch.stack([after, torch.where(is_root, none, first), torch.where(is_root, none, second)])
    state = _summed(state, 64)
    first = torch.where(is_root, first + state[1].gather(1, successor), state[1])
    return root, first, torch.where(is_root, second + state[2].gather(1, successor), state[2])


def _shifted(around: Tensor, y: int, x: int, height: int, width: int) -> Tensor:
    """The pixels that have a pixel of the set at the offset (y, x)."""
    return around[:, 1 + y : 1 + y + height, 1 + x : 1 + x + width] > 0


@until_stable
def _least(state: Tensor, k: Tensor) -> Tensor:
    """state: the lowest side seen so far, and the side after those seen."""
    least, ahead = state[0], state[1]
    lower = torch.minimum(least, least.gather(1, ahead))
    # If nothing is lower, each border has been seen whole.
    moved = (lower != least).any()
    return torch.where(moved, torch.stack([lower, ahead.gather(1, ahead)]), state)


@until_stable
def _summed(state: Tensor, k: Tensor) -> Tensor:
    """state: the side after those summed so far, and the two sums."""
    ahead = state[0]
    first, second = state[1] + state[1].gather(1, ahead), state[2] + state[2].gather(1, ahead)
    return torch.stack([ahead.gather(1, ahead), first, second])
