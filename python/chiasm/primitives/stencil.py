"""Linear stencils on padded images, and the channel split that lets native code share work between channels."""

from typing import List

import torch
import torch.nn.functional as F
from torch import Tensor

from . import kernels
from .padding import join_columns, padded_parts
from .target import native_forward, onnx_forward, tracing_vjp


def separable(x: Tensor, kernel_y: Tensor, kernel_x: Tensor, border_type: str) -> Tensor:
    """Correlate (B, C, H, W) with kernel_y (B or 1, ky) down the columns and kernel_x (B or 1, kx) along the rows.

    The kernel sizes are odd. One-row kernels are shared by the batch.
    """
    if not torch.jit.is_scripting() and kernels.has_kernel(x):
        return kernels.separable(x, kernel_y, kernel_x, border_type)
    ry = kernel_y.size(1) // 2
    rx = kernel_x.size(1) // 2
    # The column pass comes first: its rows stay contiguous, and only its result needs padded columns.
    tall = join_columns([correlate_rows(p, kernel_y) for p in padded_parts(x, ry, ry, 0, 0, border_type)])
    return join_columns([correlate_columns(p, kernel_x) for p in padded_parts(tall, 0, 0, rx, rx, border_type)])


def separable_shared(x: Tensor, taps_y: List[float], taps_x: List[float], border_type: str) -> Tensor:
    """``separable`` with symmetric taps that are numbers: constants in native code, two Conv nodes in ONNX."""
    ry = len(taps_y) // 2
    rx = len(taps_x) // 2
    if onnx_forward():
        # Channels are folded into the batch: a group count that comes from a size is silently wrong in some backends.
        # The new dimension apart from the merging: a reshape that does both asks whether the height divides 1.
        flat = x.flatten(0, 1)[:, None]
        padded = padded_parts(flat, ry, ry, rx, rx, border_type)[0]
        column = torch.tensor(taps_y, dtype=x.dtype, device=x.device).reshape(1, 1, -1, 1)
        row = torch.tensor(taps_x, dtype=x.dtype, device=x.device).reshape(1, 1, 1, -1)
        return F.conv2d(F.conv2d(padded, column), row).squeeze(1).reshape(x.shape)
    if not torch.jit.is_scripting() and kernels.has_kernel(x):
        return kernels.separable_shared(x, taps_y, taps_x, border_type)
    tall = join_columns([weigh_shifts(p, 2, taps_y) for p in padded_parts(x, ry, ry, 0, 0, border_type)])
    return join_columns([weigh_shifts(p, 3, taps_x) for p in padded_parts(tall, 0, 0, rx, rx, border_type)])


def separable_each(images: List[Tensor], taps_y: List[float], taps_x: List[float], border_type: str) -> List[Tensor]:
    """``separable_shared`` of several images of one shape, as one pass over all their channels.

    Native code makes a pass of each, which it fuses with the arithmetic that made the image.
    """
    if native_forward():
        return [separable_shared(image, taps_y, taps_x, border_type) for image in images]
    together = separable_shared(torch.cat(images, 1), taps_y, taps_x, border_type)
    channels = images[0].size(1)
    return [together.narrow(1, i * channels, channels) for i in range(len(images))]


def separable_scales(images: List[Tensor], taps: List[List[float]], border_type: str) -> List[List[Tensor]]:
    """``separable_each`` with each of several sets of taps, all of one length, that serve both axes: a list of images for each set.

    Backward passes are traced through one pass for all sets, a fraction of the operators of a pass for each.
    """
    if not tracing_vjp():
        return [separable_each(images, t, t, border_type) for t in taps]
    together = torch.cat(images, 1)
    kernels_of_sets = torch.tensor(taps, dtype=together.dtype, device=together.device)
    reach, channels = kernels_of_sets.size(1) // 2, images[0].size(1)
    tall = correlate_rows(padded_parts(together.flatten(0, 1)[None], reach, reach, 0, 0, border_type)[0], kernels_of_sets)
    wide = correlate_columns(padded_parts(tall, 0, 0, reach, reach, border_type)[0], kernels_of_sets)
    sets = wide.unflatten(1, [together.size(0), together.size(1)])
    return [[sets[k].narrow(1, i * channels, channels) for i in range(len(images))] for k in range(len(taps))]


def weigh_shifts(p: Tensor, dim: int, taps: List[float]) -> Tensor:
    """Valid correlation along ``dim`` with an odd number of symmetric taps, one product for each pair."""
    last = len(taps) - 1
    size = p.size(dim) - last
    out = p.narrow(dim, last // 2, size) * taps[last // 2]
    for i in range(last // 2):
        out = out + (p.narrow(dim, i, size) + p.narrow(dim, last - i, size)) * taps[i]
    return out


def correlate_rows(p: Tensor, kernel: Tensor) -> Tensor:
    """Valid correlation of (B, C, H + k - 1, W) with (B or 1, k) along the rows' axis."""
    taps = kernel.size(1)
    height = p.size(2) - taps + 1
    out = p[:, :, 0:height] * kernel[:, 0, None, None, None]
    for i in range(1, taps):
        out = out + p[:, :, i : i + height] * kernel[:, i, None, None, None]
    return out


def correlate_columns(p: Tensor, kernel: Tensor) -> Tensor:
    """Valid correlation of (B, C, H, W + k - 1) with (B or 1, k) along the columns' axis."""
    taps = kernel.size(1)
    width = p.size(3) - taps + 1
    out = p[..., 0:width] * kernel[:, 0, None, None, None]
    for i in range(1, taps):
        out = out + p[..., i : i + width] * kernel[:, i, None, None, None]
    return out


def split_channels(x: Tensor) -> List[Tensor]:
    """(B, C, H, W) as groups of channels to loop over: C planes in native code, all in one otherwise.

    A loop over planes lets one compiled loop compute what the channels share (weights, indices) once per pixel. A channel
    count that is symbolic cannot be looped over.
    """
    count = x.size(1)
    if native_forward() and isinstance(count, int):
        return [x[:, c : c + 1] for c in range(count)]
    return [x]


def join_channels(planes: List[Tensor]) -> Tensor:
    """Undo ``split_channels``."""
    if len(planes) == 1:
        return planes[0]
    # stack, not cat: AOTInductor turns cat of one-channel slices into scalar gathers.
    return torch.stack([plane.select(1, 0) for plane in planes], 1)
