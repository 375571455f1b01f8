"""Derivatives of volumes by finite differences."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice
from ..primitives.filters.padding import stencil3d
from ..primitives.resampling.volumes import check_volume


def spatial_gradient3d(input: Tensor, mode: str = "diff", order: int = 1) -> Tensor:
    """First or second derivatives of a volume by central differences; the border is replicated.

    Args:
        input: (B, C, D, H, W), floating point.
        mode: "diff".
        order: 1 or 2.

    Returns:
        (B, C, 3, D, H, W): d/dx, d/dy, d/dz in intensity per voxel; or (B, C, 6, D, H, W): xx, yy, zz, xy,
        yz, xz, where the mixed ones are four times the derivative, as in Kornia.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D, or mode or order is not as above.

    Example:
        >>> ramp = torch.arange(5.0).expand(1, 1, 3, 3, 5)
        >>> spatial_gradient3d(ramp)[0, 0, :, 1, 1, 2]
        tensor([1., 0., 0.])
    """
    check_volume(input, "input")
    check_choice(mode, ["diff"], "mode")
    if order != 1 and order != 2:
        raise ValueError(f"order: expected 1 or 2, got {order}")
    return _derivatives(input, (1, 1), (1, 1), (1, 1), "replicate", order)


@stencil3d
def _derivatives(p: Tensor, order: int) -> Tensor:
    return torch.stack(_first(p) if order == 1 else _second(p), 2)


def _first(p: Tensor) -> List[Tensor]:
    return [
        0.5 * (_at(p, 0, 0, 1) - _at(p, 0, 0, -1)),
        0.5 * (_at(p, 0, 1, 0) - _at(p, 0, -1, 0)),
        0.5 * (_at(p, 1, 0, 0) - _at(p, -1, 0, 0)),
    ]


def _second(p: Tensor) -> List[Tensor]:
    twice = 2.0 * _at(p, 0, 0, 0)
    return [
        _at(p, 0, 0, -1) - twice + _at(p, 0, 0, 1),
        _at(p, 0, -1, 0) - twice + _at(p, 0, 1, 0),
        _at(p, -1, 0, 0) - twice + _at(p, 1, 0, 0),
        _at(p, 0, -1, -1) - _at(p, 0, -1, 1) - _at(p, 0, 1, -1) + _at(p, 0, 1, 1),
        _at(p, -1, -1, 0) - _at(p, -1, 1, 0) - _at(p, 1, -1, 0) + _at(p, 1, 1, 0),
        _at(p, -1, 0, -1) - _at(p, -1, 0, 1) - _at(p, 1, 0, -1) + _at(p, 1, 0, 1),
    ]


def _at(p: Tensor, z: int, y: int, x: int) -> Tensor:
    """The volume, padded by one voxel, shifted by (z, y, x) voxels."""
    depth, height, width = p.size(2) - 2, p.size(3) - 2, p.size(4) - 2
    return p[:, :, 1 + z : 1 + z + depth, 1 + y : 1 + y + height, 1 + x : 1 + x + width]
