"""Reading images in the squares of local affine frames."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels
from ..numbers.reshaping import reshaped
from ..numbers.rounding import known_or


def patch_positions(frame: Tensor, PS: int) -> Tuple[Tensor, Tensor]:
    """The positions x and y, each (B, N, PS, PS), of each patch's pixels in the image."""
    side = (2.0 * torch.arange(PS, device=frame.device).to(frame.dtype) + 1.0) / PS - 1.0
    m = frame[..., None, None]
    x = m[:, :, 0, 0] * side + m[:, :, 0, 1] * side[:, None] + m[:, :, 0, 2]
    y = m[:, :, 1, 0] * side + m[:, :, 1, 1] * side[:, None] + m[:, :, 1, 2]
    return x, y


@primitive
def read_patches(
    pixels: Tensor, start: Tensor, height: Tensor, width: Tensor, frame: Tensor, PS: int
) -> Tensor:
    """(B, C, N, PS, PS): a patch for each frame (B, N, 2, 3). ``pixels`` (B, C, S) holds several images; a
    patch is read from the one that begins at ``start`` and has the size ``height`` x ``width``, each (B,
    N)."""
    x, y = patch_positions(frame, PS)
    index, weight = _level_taps(x, y, start, height, width)
    return reshaped(_gather(pixels, index, weight), [pixels.size(0), pixels.size(1), frame.size(1), PS, PS])


@read_patches.lowering("native", when=kernels.has_kernel)
def _read_patches_kernel(
    pixels: Tensor, start: Tensor, height: Tensor, width: Tensor, frame: Tensor, PS: int
) -> Tensor:
    frame = frame.to(pixels.dtype).contiguous()
    return kernels.extract_patches(
        pixels.contiguous(), start.contiguous(), height.contiguous(), width.contiguous(), frame, PS
    )


def _level_taps(
    x: Tensor, y: Tensor, start: Tensor, height: Tensor, width: Tensor
) -> Tuple[List[Tensor], List[Tensor]]:
    """Indices and weights (B, N, PS, PS) of the four pixels around positions, in the images that begin at
    ``start`` and have the size ``height`` x ``width``, each (B, N)."""
    start, height, width = start[..., None, None], height[..., None, None], width[..., None, None]
    x = torch.minimum(x.clamp(min=0), (width - 1).to(x.dtype))
    y = torch.minimum(y.clamp(min=0), (height - 1).to(y.dtype))
    left, upper = torch.floor(x.detach()), torch.floor(y.detach())
    fx, fy = x - left, y - upper
    # The index is in the image even if a position is NaN.
    column = torch.minimum(known_or(left, 0.0).to(torch.int64), width - 1)
    row = torch.minimum(known_or(upper, 0.0).to(torch.int64), height - 1)
    right = torch.minimum(column + 1, width - 1)
    above, below = start + row * width, start + torch.minimum(row + 1, height - 1) * width
    weight = [(1.0 - fy) * (1.0 - fx), (1.0 - fy) * fx, fy * (1.0 - fx), fy * fx]
    return [above + column, above + right, below + column, below + right], weight


def _gather(pixels: Tensor, index: List[Tensor], weight: List[Tensor]) -> Tensor:
    """(B, C, N * PS * PS): weighted sums of pixels (B, C, S)."""
    out = torch.zeros([1], dtype=pixels.dtype, device=pixels.device)
    for k in range(len(index)):
        where = index[k].flatten(1)[:, None]
        out = out + pixels.gather(2, where.expand(-1, pixels.size(1), -1)) * weight[k].flatten(1)[:, None].to(
            pixels.dtype
        )
    return out
