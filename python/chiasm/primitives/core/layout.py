"""The layout of images in memory: plane after plane, or pixel by pixel as in frames of bytes.

An op has one form, for (B, C, H, W). It gets a frame (B, H, W, C) as a permuted view, which PyTorch calls
channels_last. Kernels take both as rows of values, in which neighbours are `step` values apart.
"""

from typing import Tuple

from torch import Tensor

from ..kernels import operators as kernels
from .lowering import primitive


def interleaved(x: Tensor) -> bool:
    """Whether (B, C, H, W) is stored pixel by pixel. For lowerings only.

    >>> import torch
    >>> interleaved(torch.zeros(2, 4, 5, 3).permute(0, 3, 1, 2)), interleaved(torch.zeros(2, 3, 4, 5))
    (True, False)
    """
    step = x.stride(1)
    return isinstance(step, int) and step == 1 and x.permute(0, 2, 3, 1).is_contiguous()


def as_rows(x: Tensor) -> Tuple[Tensor, int]:
    """(B, C, H, W) as rows (N, H, L) for a kernel, and the distance between neighbours in a row: 1 in planes,
    C in frames.

    >>> import torch
    >>> [
    ...     as_rows(x)[0].shape
    ...     for x in (torch.zeros(2, 3, 4, 5), torch.zeros(2, 4, 5, 3).permute(0, 3, 1, 2))
    ... ]
    [torch.Size([6, 4, 5]), torch.Size([2, 4, 15])]
    """
    if interleaved(x):
        return x.permute(0, 2, 3, 1).flatten(2), x.size(1)
    return x.flatten(0, 1), 1


def from_rows(rows: Tensor, like: Tensor) -> Tensor:
    """Undo `as_rows` of images with the layout, batch and channels of `like`; height and width may differ."""
    if interleaved(like):
        return rows.unflatten(2, [rows.size(2) // like.size(1), like.size(1)]).permute(0, 3, 1, 2)
    return rows.unflatten(0, [like.size(0), like.size(1)])


@primitive
def in_planes(x: Tensor) -> Tensor:
    """The same images, in native code stored plane after plane: code that reads single channels is then
    vectorised."""
    return x


def _is_frame(x: Tensor) -> bool:
    return kernels.has_moving_kernel(x) and x.dim() == 4 and interleaved(x)


@in_planes.lowering("native", when=_is_frame)
def _split(x: Tensor) -> Tensor:
    planes = kernels.split_pixels(x.permute(0, 2, 3, 1).flatten(1), x.size(1))
    return planes.unflatten(1, [x.size(1), x.size(2), x.size(3)])


@primitive
def in_frames(x: Tensor) -> Tensor:
    """Images (B, C, H, W) as frames (B, H, W, C), dense."""
    return x.permute(0, 2, 3, 1).contiguous()


@in_frames.lowering("native", when=lambda x: kernels.has_moving_kernel(x) and not interleaved(x))
def _joined(x: Tensor) -> Tensor:
    frames = kernels.join_pixels(x.contiguous().flatten(1), x.size(1))
    return frames.unflatten(1, [x.size(2), x.size(3), x.size(1)])
