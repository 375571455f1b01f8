"""`grid_sample`: where positions are not finite, engines have other numbers than eager Python. ONNX has no
gradient of it, and native code only libtorch's."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import torch
import torch.nn.functional as F
from torch import Tensor
from torch.overrides import TorchFunctionMode

from chiasm.primitives.resampling.volumes import resample_volume
from chiasm.primitives.resampling.warping import from_normalized, resample_image

#: By the numbers that torch's operator takes.
MODES = ("bilinear", "nearest", "bicubic")
PADDINGS = ("zeros", "border", "reflection")


def sampled(input: Tensor, grid: Tensor, interpolation: int, padding: int, align_corners: bool) -> Tensor:
    """As in eager Python also where a position is not finite: moved into the image it is the first pixel, or
    the last voxel, of its axis; else an image's result is NaN, and 0 in mode "nearest"; a volume's is 0."""
    mode, beyond = MODES[interpolation], PADDINGS[padding]
    # The last coordinate counts slices, which are the first axis.
    sizes = input.shape[:1:-1]
    at = [from_normalized(grid[..., i], size, align_corners) for i, size in enumerate(sizes)]
    finite = torch.stack([torch.isfinite(position) for position in at]).all(0)
    moved = beyond != "zeros" and mode != "bicubic"
    if moved:
        kept = torch.isfinite if beyond == "reflection" else _is_number
        instead = [0] * 2 if len(sizes) == 2 else [size - 1 for size in sizes]
        at = [torch.where(kept(x), x, torch.full_like(x, end)) for x, end in zip(at, instead, strict=True)]
    if len(sizes) == 3:
        x, y, z = at
        return resample_volume(input, x, y, z, mode, beyond, align_corners)
    x, y = at
    out = resample_image(input, x, y, mode, beyond, align_corners, None)
    return out if moved or mode == "nearest" else torch.where(finite[:, None], out, math.nan)


def _is_number(x: Tensor) -> Tensor:
    return ~torch.isnan(x)


class GridSampling(TorchFunctionMode):
    """Inside it `grid_sample` is `sampled`, of which gradients are derived."""

    def __torch_function__(
        self, func: Any, types: Any, args: tuple[Any, ...] = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        forms: dict[Any, Callable[..., Tensor]] = {torch.grid_sampler: sampled, F.grid_sample: _by_names}
        return (forms.get(func) or func)(*args, **kwargs or {})


def _by_names(
    input: Tensor,
    grid: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool | None = None,
) -> Tensor:
    return sampled(input, grid, MODES.index(mode), PADDINGS.index(padding_mode), bool(align_corners))
