"""Linear stencils on padded images, and the channel split that lets native code share work between
channels."""

from typing import List

import torch
import torch.nn.functional as F
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from .padding import padded, stencil


@primitive
def separable(x: Tensor, kernel_y: Tensor, kernel_x: Tensor, border_type: str) -> Tensor:
    """Correlate (B, C, H, W) with kernel_y (B or 1, ky) down the columns and kernel_x (B or 1, kx) along the
    rows.

    The kernel sizes are odd. One-row kernels are shared by the batch.
    """
    ry = kernel_y.size(1) // 2
    rx = kernel_x.size(1) // 2
    # The column pass comes first: its rows stay contiguous, and only its result needs padded columns.
    return along_rows(
        along_columns(x, (ry, ry), (0, 0), border_type, kernel_y), (0, 0), (rx, rx), border_type, kernel_x
    )


@separable.lowering("native", when=kernels.has_kernel)
def _separable_kernel(x: Tensor, kernel_y: Tensor, kernel_x: Tensor, border_type: str) -> Tensor:
    return kernels.separable(x, kernel_y, kernel_x, border_type, 1.0, 0.0)


@primitive
def separable_shared(x: Tensor, taps_y: List[float], taps_x: List[float], border_type: str) -> Tensor:
    """``separable`` with symmetric taps that are numbers: constants in native code, two Conv nodes in
    ONNX."""
    ry = len(taps_y) // 2
    rx = len(taps_x) // 2
    return _weighed(
        _weighed(x, (ry, ry), (0, 0), border_type, 2, taps_y), (0, 0), (rx, rx), border_type, 3, taps_x
    )


@separable_shared.lowering("native", when=kernels.has_kernel)
def separable_by_kernel(
    x: Tensor,
    taps_y: List[float],
    taps_x: List[float],
    border_type: str,
    scale: float = 1.0,
    centre: float = 0.0,
) -> Tensor:
    """``scale`` times ``separable_shared`` plus ``centre`` times x, for which a kernel exists."""
    column = torch.tensor([taps_y], dtype=x.dtype, device=x.device)
    row = torch.tensor([taps_x], dtype=x.dtype, device=x.device)
    return kernels.separable(x, column, row, border_type, scale, centre)


@separable_shared.lowering("onnx")
def _two_convolutions(x: Tensor, taps_y: List[float], taps_x: List[float], border_type: str) -> Tensor:
    ry = len(taps_y) // 2
    rx = len(taps_x) // 2
    # Channels are folded into the batch, because some backends silently compute wrong results if the group
    # count comes from a size. The new dimension is added separately: a reshape that does both asks whether
    # the height divides 1.
    flat = padded(x.flatten(0, 1)[:, None], (ry, ry), (rx, rx), border_type)
    column = torch.tensor(taps_y, dtype=x.dtype, device=x.device).reshape(1, 1, -1, 1)
    row = torch.tensor(taps_x, dtype=x.dtype, device=x.device).reshape(1, 1, 1, -1)
    return F.conv2d(F.conv2d(flat, column), row).squeeze(1).reshape(x.shape)


@primitive
def separable_each(
    images: List[Tensor], taps_y: List[float], taps_x: List[float], border_type: str
) -> List[Tensor]:
    """``separable_shared`` of several images of one shape, as one pass over all their channels.

    Native code makes one pass per image, which it fuses with the arithmetic that produced the image.
    """
    together = separable_shared(torch.cat(images, 1), taps_y, taps_x, border_type)
    channels = images[0].size(1)
    return [together.narrow(1, i * channels, channels) for i in range(len(images))]


@separable_each.lowering("native")
def _one_by_one(
    images: List[Tensor], taps_y: List[float], taps_x: List[float], border_type: str
) -> List[Tensor]:
    return [separable_shared(image, taps_y, taps_x, border_type) for image in images]


@primitive
def separable_scales(images: List[Tensor], taps: List[List[float]], border_type: str) -> List[List[Tensor]]:
    """``separable_each`` with each of several sets of taps, all of one length, that serve both axes: a list
    of images for each set.

    Backward passes are traced through one pass for all sets, a fraction of the operators of a pass for each.
    """
    return [separable_each(images, t, t, border_type) for t in taps]


@separable_scales.lowering("vjp")
def _all_at_once(images: List[Tensor], taps: List[List[float]], border_type: str) -> List[List[Tensor]]:
    together = torch.cat(images, 1)
    kernels_of_sets = torch.tensor(taps, dtype=together.dtype, device=together.device)
    reach, channels = kernels_of_sets.size(1) // 2, images[0].size(1)
    tall = along_columns(together.flatten(0, 1)[None], (reach, reach), (0, 0), border_type, kernels_of_sets)
    wide = along_rows(tall, (0, 0), (reach, reach), border_type, kernels_of_sets)
    sets = wide.unflatten(1, [together.size(0), together.size(1)])
    return [[sets[k].narrow(1, i * channels, channels) for i in range(len(images))] for k in range(len(taps))]


@stencil
def _weighed(p: Tensor, dim: int, taps: List[float]) -> Tensor:
    return weigh_shifts(p, dim, taps)


def weigh_shifts(p: Tensor, dim: int, taps: List[float]) -> Tensor:
    """Valid correlation along ``dim`` with an odd number of symmetric taps, one product per pair."""
    last = len(taps) - 1
    size = p.size(dim) - last
    out = p.narrow(dim, last // 2, size) * taps[last // 2]
    for i in range(last // 2):
        out = out + (p.narrow(dim, i, size) + p.narrow(dim, last - i, size)) * taps[i]
    return out


@stencil
def along_columns(p: Tensor, kernel: Tensor) -> Tensor:
    """Correlate (B, C, H, W) with (B or 1, k) down the columns."""
    taps = kernel.size(1)
    height = p.size(2) - taps + 1
    out = p[:, :, 0:height] * kernel[:, 0, None, None, None]
    for i in range(1, taps):
        out = out + p[:, :, i : i + height] * kernel[:, i, None, None, None]
    return out


@stencil
def along_rows(p: Tensor, kernel: Tensor) -> Tensor:
    """Correlate (B, C, H, W) with (B or 1, k) along the rows."""
    taps = kernel.size(1)
    width = p.size(3) - taps + 1
    out = p[..., 0:width] * kernel[:, 0, None, None, None]
    for i in range(1, taps):
        out = out + p[..., i : i + width] * kernel[:, i, None, None, None]
    return out


@primitive
def split_channels(x: Tensor) -> List[Tensor]:
    """(*, C, H, W) as groups of channels to loop over: C planes in native code, all in one otherwise.

    A loop over planes lets one compiled loop compute what the channels share (weights, indices) once per
    pixel. A channel count that is symbolic cannot be looped over.
    """
    return [x]


@split_channels.lowering("native", when=lambda x: isinstance(x.size(-3), int))
def _planes(x: Tensor) -> List[Tensor]:
    return [x[..., c : c + 1, :, :] for c in range(x.size(-3))]


def join_channels(planes: List[Tensor]) -> Tensor:
    """Undo ``split_channels``."""
    if len(planes) == 1:
        return planes[0]
    # stack, not cat: AOTInductor turns cat of one-channel slices into scalar gathers.
    channel = planes[0].dim() - 3
    return torch.stack([plane.select(channel, 0) for plane in planes], channel)
