"""Borders: what a stencil sees beyond the image.

``padded_parts`` is the one entry: it returns the padded image as a list of parts, of which the valid stencil's outputs,
joined by ``join_columns``, are the filtered image. Eager code and ONNX get one part. Native code gets two, the ends of
the rows and their middle: rows are padded by an index (constant along the inner loop), and columns in two small strips,
because any index or condition that varies along the inner loop keeps AOTInductor from vectorising it. Backward passes are traced
through slices and ``cat``, whose gradients have an ONNX form where those of ``F.pad`` have none.
"""

from typing import List

import torch
import torch.nn.functional as F
from torch import Tensor

from .checks import check_choice
from .target import native_forward, tracing_vjp


def check_border(border_type: str) -> None:
    """Raise ValueError unless ``border_type`` names a border."""
    check_choice(border_type, ["reflect", "replicate", "circular", "constant"], "border_type")


def padded_parts(x: Tensor, top: int, bottom: int, left: int, right: int, border_type: str, value: float = 0.0, store: bool = False) -> List[Tensor]:
    """Pad a (B, C, H, W) tensor; reflect mirrors without repeating the edge (OpenCV's BORDER_REFLECT_101).

    ``store`` says that the stencil's arithmetic outweighs a copy: native code then gets one part too, padded in memory,
    whose taps are plain loads. The valid stencil is to be applied to each part, and the outputs to be given to ``join_columns``.

    >>> [list(p.shape) for p in padded_parts(torch.zeros(1, 1, 4, 5), 1, 1, 2, 2, "reflect")]
    [[1, 1, 6, 9]]
    """
    check_border(border_type)
    if native_forward() and not store:
        return _native_parts(x, top, bottom, left, right, border_type, value)
    if tracing_vjp() or native_forward() or border_type == "circular":
        rows = _pad_by_cat(x, 2, top, bottom, border_type, value)
        return [_pad_by_cat(rows, 3, left, right, border_type, value)]
    if border_type == "constant":
        return [F.pad(x, [left, right, top, bottom], "constant", value)]
    return [F.pad(x, [left, right, top, bottom], border_type)]


def join_columns(parts: List[Tensor]) -> Tensor:
    """Put together the outputs computed from the ``padded_parts``."""
    if len(parts) == 1:
        return parts[0]
    ends, middle = parts[0], parts[1]
    border = ends.size(-1) // 4
    return torch.cat([ends[..., :border], middle, ends[..., 3 * border :]], -1)


def _native_parts(x: Tensor, top: int, bottom: int, left: int, right: int, border_type: str, value: float) -> List[Tensor]:
    if left != right:
        wide = _pad_by_cat(x, 3, left, right, border_type, value)
        return [_pad_rows(wide, top, bottom, border_type, value)]
    if left == 0:
        return [_pad_rows(x, top, bottom, border_type, value)]
    width = x.size(3)
    # Both padded strips, 3 * left wide each, in one part: of its 4 * left valid outputs the outer ones count.
    first = _before(x, 3, left, border_type, value) + [x[..., : 2 * left]]
    last = [x[..., width - 2 * left :]] + _after(x, 3, left, border_type, value)
    ends = torch.cat(first + last, 3)
    return [_pad_rows(ends, top, bottom, border_type, value), _pad_rows(x, top, bottom, border_type, value)]


def _pad_rows(x: Tensor, top: int, bottom: int, border_type: str, value: float) -> Tensor:
    if top == 0 and bottom == 0:
        return x
    size = x.size(2)
    row = torch.arange(-top, size + bottom, device=x.device)
    if border_type == "reflect":
        index = (size - 1) - ((size - 1) - row.abs()).abs()
    elif border_type == "circular":
        index = torch.where(row < 0, row + size, torch.where(row >= size, row - size, row))
    else:
        index = row.clamp(0, size - 1)
    rows = x.index_select(2, index)
    if border_type == "constant":
        inside = (row >= 0) & (row < size)
        rows = torch.where(inside[:, None], rows, torch.full_like(rows, value))
    return rows


def _pad_by_cat(x: Tensor, dim: int, before: int, after: int, border_type: str, value: float) -> Tensor:
    if before == 0 and after == 0:
        return x
    return torch.cat(_before(x, dim, before, border_type, value) + [x] + _after(x, dim, after, border_type, value), dim)


def _before(x: Tensor, dim: int, count: int, border_type: str, value: float) -> List[Tensor]:
    if count == 0:
        parts: List[Tensor] = []
        return parts
    if border_type == "reflect":
        return [x.narrow(dim, 1, count).flip([dim])]
    if border_type == "circular":
        return [x.narrow(dim, x.size(dim) - count, count)]
    edge = x.narrow(dim, 0, 1)
    if border_type == "constant":
        edge = torch.full_like(edge, value)
    return [edge for _ in range(count)]


def _after(x: Tensor, dim: int, count: int, border_type: str, value: float) -> List[Tensor]:
    if count == 0:
        parts: List[Tensor] = []
        return parts
    size = x.size(dim)
    if border_type == "reflect":
        return [x.narrow(dim, size - count - 1, count).flip([dim])]
    if border_type == "circular":
        return [x.narrow(dim, 0, count)]
    edge = x.narrow(dim, size - 1, 1)
    if border_type == "constant":
        edge = torch.full_like(edge, value)
    return [edge for _ in range(count)]
