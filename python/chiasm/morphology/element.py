"""Structuring elements: the common code of dilation and erosion."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_choice,
    check_indices,
    check_optional,
    check_pixels,
    check_tensor,
)
from ..primitives.core.pixels import pixel_range
from ..primitives.filters.minmax import morphology, morphology_gradient


def check_engine(engine: str) -> None:
    """Raise ValueError unless ``engine`` is one of the names of Kornia's implementations."""
    check_choice(engine, ["auto", "unfold", "convolution", "shift"], "engine")


def extreme(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor],
    origin: Optional[List[int]],
    border_type: str,
    border_value: float,
    max_val: float,
    largest: bool,
    mirrored: bool = False,
) -> Tensor:
    """Dilation (``largest``) or erosion over the window that starts ``origin`` before the pixel; ``mirrored``
    counts the origin from the other end."""
    heights, row, column = _window(tensor, kernel, structuring_element, origin, border_type, max_val)
    if mirrored:
        row, column = kernel.size(0) - 1 - row, kernel.size(1) - 1 - column
    border, value = _border(tensor, border_type, border_value, max_val, largest)
    return morphology(tensor, heights, row, column, border, value, max_val, largest)


def extreme_range(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor],
    origin: Optional[List[int]],
    border_type: str,
    border_value: float,
    max_val: float,
) -> Tensor:
    """Dilation minus erosion."""
    heights, row, column = _window(tensor, kernel, structuring_element, origin, border_type, max_val)
    border, high_value = _border(tensor, border_type, border_value, max_val, True)
    low_value = _border(tensor, border_type, border_value, max_val, False)[1]
    return morphology_gradient(tensor, heights, row, column, border, high_value, low_value, max_val)


def _window(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor],
    origin: Optional[List[int]],
    border_type: str,
    max_val: float,
) -> Tuple[Tensor, int, int]:
    """The element's heights, -max_val where it has no pixel, and its origin."""
    check_pixels(tensor, "tensor", True)
    check_choice(border_type, ["geodesic", "reflect", "replicate", "circular", "constant"], "border_type")
    check_tensor(kernel, "kernel")
    if kernel.dim() != 2:
        raise ValueError(f"kernel: expected shape (kh, kw), got {list(kernel.shape)}")
    kh, kw = kernel.size(0), kernel.size(1)
    if kh < 1 or kw < 1:
        raise ValueError(f"kernel: expected at least one pixel, got [{kh}, {kw}]")
    check_optional(structuring_element, "structuring_element")
    row, column = _origin(origin, kh, kw)
    dtype = tensor.dtype if tensor.is_floating_point() else torch.float64
    heights = torch.zeros_like(kernel, dtype=dtype)
    if structuring_element is not None:
        if not tensor.is_floating_point():
            raise TypeError(
                "structuring_element: expected None, as elements for whole numbers are flat, got heights for"
                f" dtype {tensor.dtype}"
            )
        if (
            structuring_element.dim() != 2
            or structuring_element.size(0) != kh
            or structuring_element.size(1) != kw
        ):
            raise ValueError(
                f"structuring_element: expected the kernel's shape ({kh}, {kw}), got"
                f" {list(structuring_element.shape)}"
            )
        heights = structuring_element.to(dtype)
    return torch.where(kernel == 0, torch.full_like(heights, -max_val), heights), row, column


def _border(
    tensor: Tensor, border_type: str, border_value: float, max_val: float, largest: bool
) -> Tuple[str, float]:
    """The name of the border in ``stencil``, and its value; for a geodesic border, a value that is never the
    result."""
    low, high = -max_val, max_val
    if not tensor.is_floating_point():
        least, most = pixel_range(tensor)
        low, high = float(least), float(most)
        if border_type == "constant" and not (
            border_value >= low and border_value <= high and border_value == float(int(border_value))
        ):
            raise ValueError(f"border_value: expected a number of dtype {tensor.dtype}, got {border_value}")
    if border_type == "geodesic":
        return "constant", low if largest else high
    return border_type, border_value


def _origin(origin: Optional[List[int]], kh: int, kw: int) -> Tuple[int, int]:
    if origin is None:
        return kh // 2, kw // 2
    check_indices(origin, "origin")
    row, column = origin[0], origin[1]
    if row < 0 or row >= kh or column < 0 or column >= kw:
        raise ValueError(f"origin: expected a position inside the ({kh}, {kw}) kernel, got [{row}, {column}]")
    return row, column
