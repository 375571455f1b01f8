"""Reading a volume at given positions."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.checks import check_choice, check_floating, check_not_empty, check_rank, check_values
from ..numbers.rounding import known_or
from .taps import gather_taps, index_dtype, reflect_positions


def check_volume(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, C, D, H, W) tensor with values; B may be 0."""
    check_rank(value, 5, "(B, C, D, H, W)", name)
    check_floating(value, name)
    check_not_empty(value, 4, name)


def check_voxels(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a (B, C, D, H, W) tensor with values, floating point or uint8; B may be
    0."""
    check_rank(value, 5, "(B, C, D, H, W)", name)
    check_values(value, name)
    check_not_empty(value, 4, name)


def check_volume_sampling(
    mode: str, padding_mode: str, mode_name: str = "mode", padding_name: str = "padding_mode"
) -> None:
    """Raise ValueError unless ``resample_volume`` knows both names."""
    check_choice(mode, ["bilinear", "nearest"], mode_name)
    check_choice(padding_mode, ["zeros", "border", "reflection"], padding_name)


def voxel_axes(
    size: Tuple[int, int, int], dtype: torch.dtype, device: torch.device
) -> Tuple[Tensor, Tensor, Tensor]:
    """Columns (1, 1, 1, W), rows (1, 1, H, 1) and slices (1, D, 1, 1) of a volume's voxels, for size (D, H,
    W)."""
    slices, height, width = size
    column = torch.arange(width, device=device).to(dtype)[None, None, None, :]
    row = torch.arange(height, device=device).to(dtype)[None, None, :, None]
    return column, row, torch.arange(slices, device=device).to(dtype)[None, :, None, None]


def resample_volume(
    src: Tensor, x: Tensor, y: Tensor, z: Tensor, mode: str, padding_mode: str, align_corners: bool
) -> Tensor:
    """src (B, C, D, H, W) at voxel positions x, y and z (B, d, h, w): (B, C, d, h, w).

    Args:
        mode, padding_mode: as ``check_volume_sampling`` allows; "bilinear" weights eight voxels.
        align_corners: whether "reflection" mirrors at the corner voxels' centres, else at the outer faces.
    """
    slices, height, width = src.size(2), src.size(3), src.size(4)
    kind = index_dtype([slices, height, width])
    plane, plane_weight = _axis(z, slices, mode, padding_mode, align_corners, kind)
    row, row_weight = _axis(y, height, mode, padding_mode, align_corners, kind)
    column, column_weight = _axis(x, width, mode, padding_mode, align_corners, kind)
    index: List[Tensor] = []
    weight: List[Tensor] = []
    for i in range(len(plane)):
        for j in range(len(row)):
            for k in range(len(column)):
                # Slices are treated as rows of one tall image.
                index.append(((plane[i] * height + row[j]) * width + column[k]).flatten(1, 2))
                weight.append(
                    (plane_weight[i] * row_weight[j] * column_weight[k]).to(src.dtype).flatten(1, 2)
                )
    out = gather_taps(src.flatten(2, 3), index, weight)
    return out.reshape(src.size(0), src.size(1), x.size(1), x.size(2), x.size(3))


def _axis(
    x: Tensor, size: int, mode: str, padding_mode: str, align_corners: bool, kind: torch.dtype
) -> Tuple[List[Tensor], List[Tensor]]:
    """Indices, of a type, and weights along one axis; weights are zero outside."""
    if padding_mode == "border":
        x = x.clamp(0, size - 1)
    elif padding_mode == "reflection":
        x = reflect_positions(x, size, align_corners)
    # Clamp to keep the conversion to integers defined; anything beyond one voxel outside reads nothing.
    x = x.clamp(-2, size + 1)
    if mode == "nearest":
        nearest = known_or(torch.round(x.detach()), -2.0)  # NaN counts as outside
        inside = (nearest >= 0) & (nearest <= size - 1)
        return [nearest.to(kind).clamp(0, size - 1)], [inside.to(x.dtype)]
    first = known_or(torch.floor(x.detach()), -2.0)
    fraction = x - first
    zero = torch.zeros_like(fraction)
    low = torch.where((first >= 0) & (first <= size - 1), 1.0 - fraction, zero)
    high = torch.where((first >= -1) & (first <= size - 2), fraction, zero)
    voxel = first.to(kind)
    return [voxel.clamp(0, size - 1), (voxel + 1).clamp(0, size - 1)], [low, high]
