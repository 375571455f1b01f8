"""Borders: the values that a stencil reads outside the image. A stencil is written for a padded image, and
returns an output for each window inside this image. ``stencil`` turns it into a filter of a whole image.
``padded`` pads the image in memory; it is for stencils whose arithmetic costs more than this copy.

Eager code and ONNX pad the image and apply the stencil once. Native code does not store a padded image. On
the CPU it applies the stencil to two parts, the ends of the rows and their middle. Rows are padded by an
index (constant along the inner loop), and columns in two small strips, because any index or condition that
varies along the inner loop keeps AOTInductor from vectorising it. On a GPU rows and columns are padded by an
index, in the loop that applies the stencil. Backward passes are traced through slices and ``cat``, whose
gradients have an ONNX form where those of ``F.pad`` have none.
"""

from typing import Any, Callable, Concatenate, List, ParamSpec, Tuple

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.checks import check_choice
from ..core.layout import as_rows, from_rows, interleaved
from ..core.lowering import primitive
from ..core.source import function_from, parameters_of, positional
from ..kernels import operators as kernels

P = ParamSpec("P")


def check_border(border_type: str) -> None:
    """Raise ValueError unless ``border_type`` names a border."""
    check_choice(border_type, ["reflect", "replicate", "circular", "constant"], "border_type")


def check_margin(size: int, margin: Tuple[int, int], border_type: str, what: str, name: str) -> None:
    """Raise ValueError unless an axis of ``size`` pixels, ``what`` in the message, is long enough for a
    border's margins. A symbol has no size while it is traced: an exported graph has the limits of its spec.

    >>> check_margin(3, (2, 2), "reflect", "rows", "input")
    """
    widest = max(margin[0], margin[1])
    if not isinstance(size, int) or widest == 0 or border_type == "constant":
        return
    least = 1
    if border_type == "reflect":
        least = widest + 1
    if border_type == "circular":
        least = widest
    if size < least:
        raise ValueError(
            f"{name}: expected at least {least} {what} for the border '{border_type}' and a window of"
            f" {margin[0] + margin[1] + 1}, got {size}"
        )


def check_margins(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, name: str = "input"
) -> None:
    """Raise ValueError unless (..., H, W) is large enough for a border of this name. ``padded`` calls it; an
    op whose image has another name than "input" does so before."""
    check_border(border_type)
    check_margin(x.size(-2), margin_y, border_type, "rows", name)
    check_margin(x.size(-1), margin_x, border_type, "columns", name)


def check_inside(size: int, window: int, what: str, name: str = "input") -> None:
    """Raise ValueError unless a window fits into an axis of ``size`` pixels, ``what`` in the message."""
    if isinstance(size, int) and isinstance(window, int) and size < window:
        raise ValueError(f"{name}: expected at least {window} {what} for a window inside it, got {size}")


@primitive
def padded(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float = 0.0
) -> Tensor:
    """A (B, C, H, W) tensor with margins (before, after); reflect mirrors without repeating the edge
    (OpenCV's BORDER_REFLECT_101).

    >>> padded(torch.tensor([[[[1.0, 2.0, 3.0]]]]), (0, 0), (1, 2), "reflect")
    tensor([[[[2., 1., 2., 3., 2., 1.]]]])
    """
    check_margins(x, margin_y, margin_x, border_type)
    if border_type == "circular":
        return _by_cat(x, margin_y, margin_x, border_type, value)
    margins = [margin_x[0], margin_x[1], margin_y[0], margin_y[1]]
    if border_type == "constant":
        return F.pad(x, margins, "constant", value)
    return F.pad(x, margins, border_type)


@padded.lowering("native", "vjp")
def _padded_by_cat(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    check_margins(x, margin_y, margin_x, border_type)
    return _by_cat(x, margin_y, margin_x, border_type, value)


@padded.lowering("cuda")
def _padded_by_index(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    check_margins(x, margin_y, margin_x, border_type)
    rows = _pad_by_index(x, 2, margin_y[0], margin_y[1], border_type, value)
    return _pad_by_index(rows, 3, margin_x[0], margin_x[1], border_type, value)


@primitive
def bordered(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    """``padded`` for any type of pixels, as the result of an op, whose margins may be wide; and with the
    border "symmetric", which mirrors and repeats the edge. The caller checks the sizes.

    >>> bordered(torch.tensor([[[[1, 2, 3]]]]), (0, 0), (1, 2), "symmetric", 0.0)
    tensor([[[[1, 1, 2, 3, 3, 2]]]])
    """
    # Engines lack operations on 16 bits.
    wide = x.to(torch.int32) if x.dtype == torch.int16 or x.dtype == torch.uint16 else x
    rows = _pad_by_index(wide, 2, margin_y[0], margin_y[1], border_type, value)
    return _pad_by_index(rows, 3, margin_x[0], margin_x[1], border_type, value).to(x.dtype)


@bordered.lowering("native", when=kernels.has_pixel_kernel)
def _bordered_kernel(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    rows = _row_or_column(x.size(2), margin_y, border_type, x)
    columns = _row_or_column(x.size(3), margin_x, border_type, x)
    if not interleaved(x):
        return kernels.gather_pixels(x, rows, columns, 1, value)
    pixels, step = as_rows(x)
    return from_rows(kernels.gather_pixels(pixels, rows, columns, step, value), x)


def _row_or_column(size: int, margin: Tuple[int, int], border_type: str, x: Tensor) -> Tensor:
    """What an axis with a border reads, for a kernel: -1 in a constant border."""
    place = torch.arange(-margin[0], size + margin[1], device=x.device, dtype=torch.int32)
    if border_type == "constant":
        return place
    return _source(place, size, border_type).to(torch.int32)


@bordered.lowering("vjp")
def _bordered_by_cat(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    return _by_cat(x, margin_y, margin_x, border_type, value)


@primitive
def padded_parts(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> List[Tensor]:
    """``padded`` in parts: a valid stencil is applied to each, and ``join_columns`` joins the outputs to the
    filtered image."""
    return [padded(x, margin_y, margin_x, border_type, value)]


padded_parts.lowering("cuda")(padded_parts.definition)


@padded_parts.lowering("native")
def _native_parts(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> List[Tensor]:
    check_margins(x, margin_y, margin_x, border_type)
    (top, bottom), (left, right) = margin_y, margin_x
    if left != right:
        wide = _pad_by_cat(x, 3, left, right, border_type, value)
        return [_pad_rows(wide, top, bottom, border_type, value)]
    if left == 0:
        return [_pad_rows(x, top, bottom, border_type, value)]
    width = x.size(3)
    if isinstance(width, int) and width < 2 * left:
        wide = _pad_by_cat(x, 3, left, right, border_type, value)
        return [_pad_rows(wide, top, bottom, border_type, value)]
    # Both padded strips, each 3 * left wide, form one part; only the outer ones of its 4 * left valid outputs
    # are used.
    first = _before(x, 3, left, border_type, value) + [x[..., : 2 * left]]
    last = [x[..., width - 2 * left :]] + _after(x, 3, left, border_type, value)
    ends = torch.cat(first + last, 3)
    return [_pad_rows(ends, top, bottom, border_type, value), _pad_rows(x, top, bottom, border_type, value)]


def join_columns(parts: List[Tensor]) -> Tensor:
    """Join the outputs computed from the ``padded_parts``."""
    if len(parts) == 1:
        return parts[0]
    ends, middle = parts[0], parts[1]
    border = ends.size(-1) // 4
    return torch.cat([ends[..., :border], middle, ends[..., 3 * border :]], -1)


def volume_parts(
    x: Tensor,
    margin_z: Tuple[int, int],
    margin_y: Tuple[int, int],
    margin_x: Tuple[int, int],
    border_type: str,
    value: float,
) -> List[Tensor]:
    """``padded_parts`` of a (B, C, D, H, W) volume."""
    check_margin(x.size(2), margin_z, border_type, "slices", "input")
    # The depth is padded as the rows of a transposed volume.
    deep = padded_parts(x.flatten(0, 1).transpose(1, 2), margin_z, (0, 0), border_type, value)[0].transpose(
        1, 2
    )
    parts = padded_parts(deep, margin_y, margin_x, border_type, value)
    return [p.reshape(x.size(0), x.size(1), p.size(1), p.size(2), p.size(3)) for p in parts]


def stencil(valid: Callable[Concatenate[Tensor, P], Tensor]) -> Callable[..., Tensor]:
    """The filter ``filter(image, margin_y, margin_x, border_type, *settings, value=0.0)`` of a stencil
    ``valid(padded, *settings)``.

    ``valid`` computes (..., H, W) from (B, C, H, W) with the margins around it, each output from its own
    window. The margins are (before, after); ``value`` is the value of a constant border.

    >>> @stencil
    ... def rise(p: Tensor, step: float) -> Tensor:
    ...     width = p.size(3) - 2
    ...     return (p[..., 2:] - p[..., :width]) / (2.0 * step)
    >>> rise(torch.tensor([[[[1.0, 2.0, 4.0]]]]), (0, 0), (1, 1), "replicate", 0.5)
    tensor([[[[1., 3., 2.]]]])
    """
    return _filter(valid, ["margin_y", "margin_x"], padded_parts)


def stencil3d(valid: Callable[Concatenate[Tensor, P], Tensor]) -> Callable[..., Tensor]:
    """``stencil`` for volumes (B, C, D, H, W), as ``filter(volume, margin_z, margin_y, margin_x, border_type,
    *settings, value=0.0)``."""
    return _filter(valid, ["margin_z", "margin_y", "margin_x"], volume_parts)


def _filter(
    valid: Callable[..., Tensor], margins: List[str], parts: Callable[..., List[Tensor]]
) -> Callable[..., Tensor]:
    image, *settings = parameters_of(valid)
    passed = "".join(f", {p.name}" for p in settings)
    body = [
        "outs: List[Tensor] = []",
        f"for part in parts({image.name}, {', '.join(margins)}, border_type, value):",
        f"    outs.append(valid(part{passed}))",
        "return join_columns(outs)",
    ]
    before = [positional(name, Tuple[int, int]) for name in margins] + [positional("border_type", str)]
    scope: dict[str, Any] = {
        "List": List,
        "Tensor": Tensor,
        "valid": valid,
        "parts": parts,
        "join_columns": join_columns,
    }
    return function_from(valid, [image, *before, *settings, positional("value", float, 0.0)], body, scope)


def _by_cat(
    x: Tensor, margin_y: Tuple[int, int], margin_x: Tuple[int, int], border_type: str, value: float
) -> Tensor:
    rows = _pad_by_cat(x, 2, margin_y[0], margin_y[1], border_type, value)
    return _pad_by_cat(rows, 3, margin_x[0], margin_x[1], border_type, value)


def _pad_rows(x: Tensor, top: int, bottom: int, border_type: str, value: float) -> Tensor:
    return _pad_by_index(x, 2, top, bottom, border_type, value)


def _pad_by_index(x: Tensor, dim: int, before: int, after: int, border_type: str, value: float) -> Tensor:
    if before == 0 and after == 0:
        return x
    size = x.size(dim)
    place = torch.arange(-before, size + after, device=x.device)
    padded = x.index_select(dim, _source(place, size, border_type))
    if border_type == "constant":
        inside = (place >= 0) & (place < size)
        if dim == 2:
            inside = inside[:, None]
        padded = torch.where(inside, padded, torch.full_like(padded, value))
    return padded


def _source(place: Tensor, size: int, border_type: str) -> Tensor:
    """The positions in an axis of ``size`` pixels whose values the positions ``place`` have; of a constant
    border, those at its edge."""
    if border_type == "reflect":
        return (size - 1) - ((size - 1) - place.abs()).abs()
    if border_type == "circular":
        return torch.where(place < 0, place + size, torch.where(place >= size, place - size, place))
    if border_type == "symmetric":
        return torch.where(place < 0, -1 - place, torch.where(place >= size, 2 * size - 1 - place, place))
    return place.clamp(0, size - 1)


def _pad_by_cat(x: Tensor, dim: int, before: int, after: int, border_type: str, value: float) -> Tensor:
    if before == 0 and after == 0:
        return x
    return torch.cat(
        _before(x, dim, before, border_type, value) + [x] + _after(x, dim, after, border_type, value), dim
    )


def _before(x: Tensor, dim: int, count: int, border_type: str, value: float) -> List[Tensor]:
    if count == 0:
        parts: List[Tensor] = []
        return parts
    if border_type == "reflect":
        return [x.narrow(dim, 1, count).flip([dim])]
    if border_type == "circular":
        return [x.narrow(dim, x.size(dim) - count, count)]
    if border_type == "symmetric":
        return [x.narrow(dim, 0, count).flip([dim])]
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
    if border_type == "symmetric":
        return [x.narrow(dim, size - count, count).flip([dim])]
    edge = x.narrow(dim, size - 1, 1)
    if border_type == "constant":
        edge = torch.full_like(edge, value)
    return [edge for _ in range(count)]
