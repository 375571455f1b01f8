"""Resampling to a size that is known only at run time.

Every runtime passes tensors, and not every one passes integers that change from call to call; so the size wanted comes in
as the shape of a tensor.
"""

from typing import Optional

from torch import Tensor

from .resize import resize
from .warp import warp_perspective


def resize_like(
    input: Tensor,
    like: Tensor,
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    antialias: bool = False,
) -> Tensor:
    """Resize images to the height and width of another tensor.

    Args:
        input: images (B, C, H, W).
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        interpolation, align_corners, antialias: as in :func:`resize`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> import torch
        >>> resize_like(torch.rand(1, 3, 32, 48), torch.empty(16, 20, dtype=torch.uint8)).shape
        torch.Size([1, 3, 16, 20])
    """
    size = (like.shape[-2], like.shape[-1])
    return resize(input, size, interpolation, align_corners, "short", antialias)


def warp_perspective_like(
    src: Tensor,
    M: Tensor,
    like: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp images by homographies to the height and width of another tensor.

    Args:
        src: images (B, C, H, W).
        M: homographies (B, 3, 3) from source to destination pixels.
        like: a tensor (..., OH, OW) of any dtype, whose values are not read.
        mode, padding_mode, align_corners: as in :func:`warp_perspective`.

    Returns:
        Images (B, C, OH, OW).

    Example:
        >>> import torch
        >>> like = torch.empty(16, 20, dtype=torch.uint8)
        >>> warp_perspective_like(torch.rand(1, 3, 32, 48), torch.eye(3)[None], like).shape
        torch.Size([1, 3, 16, 20])
    """
    dsize = (like.shape[-2], like.shape[-1])
    return warp_perspective(src, M, dsize, mode, padding_mode, align_corners)
