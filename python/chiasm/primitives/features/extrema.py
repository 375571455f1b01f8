"""Strict extrema of images and volumes."""

import math
from typing import List

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.lowering import primitive
from ..filters.padding import stencil
from ..kernels import operators as kernels
from ..numbers.ranking import stable_topk


def strict_maxima(x: Tensor, slices: int, rows: int, columns: int) -> Tensor:
    """The voxels of (N, D, H, W) that exceed all others of their windows."""
    # The border is infinite: no voxel whose window reaches beyond the image is a maximum.
    beyond = float("inf")
    if slices > 1:
        plane = torch.full_like(x[:, 0:1], beyond)
        deep = torch.cat(
            [plane for _ in range((slices - 1) // 2)] + [x] + [plane for _ in range(slices // 2)], 1
        )
    else:
        deep = x
    margin_y, margin_x = ((rows - 1) // 2, rows // 2), ((columns - 1) // 2, columns // 2)
    return x > _largest_neighbour(deep, margin_y, margin_x, "constant", slices, rows, columns, beyond)


@stencil
def _largest_neighbour(p: Tensor, slices: int, rows: int, columns: int) -> Tensor:
    """The largest voxel of each valid window, without its centre."""
    depth, height, width = p.size(1) - slices + 1, p.size(2) - rows + 1, p.size(3) - columns + 1
    middle_slice, middle_row, middle_column = (slices - 1) // 2, (rows - 1) // 2, (columns - 1) // 2
    each_row = [p[:, :, i : i + height] for i in range(rows)]
    whole_column = largest(each_row)
    each_column = [whole_column[..., j : j + width] for j in range(columns)]
    # In the centre's plane: whole columns, which neighbouring windows share, and the middle column without
    # the centre.
    around = _without(each_column, middle_column)
    if rows > 1:
        around.append(largest(_without(each_row, middle_row))[..., middle_column : middle_column + width])
    found = [plane[:, middle_slice : middle_slice + depth] for plane in around]
    if slices > 1:
        whole_plane = largest(each_column)
        found += _without([whole_plane[:, k : k + depth] for k in range(slices)], middle_slice)
    return largest(found)


def largest(values: List[Tensor]) -> Tensor:
    """The largest of tensors, elementwise.

    >>> largest([torch.tensor([1, 5]), torch.tensor([2, 3])])
    tensor([2, 5])
    """
    out = values[0]
    for value in values[1:]:
        out = torch.maximum(out, value)
    return out


def _without(values: List[Tensor], k: int) -> List[Tensor]:
    return values[:k] + values[k + 1 :]


@primitive
def scale_space_nms(volume: Tensor, radii: List[float], signed: bool, count: int) -> Tensor:
    """The positions (B, count) of the strongest positive maxima among 3x3x3 voxels of each volume (B, L, H,
    W); if ``signed``, also of the negative minima. The first of equal extrema counts; unused entries are -1.
    A disk with its level's radius around each position lies in the image."""
    extreme = strict_maxima(volume, 3, 3, 3) & (volume > 0)
    if signed:
        extreme = extreme | (strict_maxima(-volume, 3, 3, 3) & (volume < 0))
    strength = torch.where(
        extreme & _has_room(volume, radii), volume.abs(), torch.full_like(volume, -1.0)
    ).flatten(1)
    # A small image may have fewer voxels than there are slots.
    strength, place = stable_topk(F.pad(strength, [0, count], "constant", -1.0), count)
    return torch.where(strength > 0, place, torch.full_like(place, -1))


@scale_space_nms.lowering("native", when=kernels.has_kernel)
def _scale_space_nms_kernel(volume: Tensor, radii: List[float], signed: bool, count: int) -> Tensor:
    return kernels.scale_space_nms(
        volume.contiguous(),
        torch.tensor([math.ceil(radius) for radius in radii], dtype=torch.int64),
        signed,
        count,
    )


def _has_room(volume: Tensor, radii: List[float]) -> Tensor:
    """(L, H, W): whether a disk of the level's radius around each voxel lies in the image."""
    column, row = (
        torch.arange(volume.size(3), device=volume.device),
        torch.arange(volume.size(2), device=volume.device)[:, None],
    )
    rooms: List[Tensor] = []
    for radius in radii:
        across = (column >= radius) & (column <= volume.size(3) - 1 - radius)
        rooms.append(across & (row >= radius) & (row <= volume.size(2) - 1 - radius))
    return torch.stack(rooms)
