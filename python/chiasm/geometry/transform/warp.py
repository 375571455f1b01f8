"""Warping by a homography."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.checks import check_choice, check_floating, check_image
from ...primitives.linalg import inverse3x3
from ...primitives.sampling import bilinear_taps, gather_taps, larger, nearest_taps, reflect_positions
from ...primitives.stencil import join_channels, split_channels


def warp_perspective(
    src: Tensor,
    M: Tensor,
    dsize: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
    fill_value: Optional[Tensor] = None,
) -> Tensor:
    """Warp an image by homographies: out(p) = src(M^-1 p).

    With align_corners=True pixel centres lie at integers, and this is ``cv2.warpPerspective(src, M, (width, height))``
    with constant border 0 (OpenCV rounds positions to 1/32 pixel for 8-bit images).

    Args:
        src: (B, C, H, W), floating point.
        M: (B, 3, 3), invertible, mapping src pixels (x, y) to output pixels.
        dsize: (height, width) of the output; may come from another tensor's shape.
        mode: "bilinear" or "nearest".
        padding_mode: what lies outside src: "zeros", "border" (replicate), "reflection" (about the corner pixels'
            centres, or the outer edges when align_corners is False) or "fill".
        align_corners: when False, src position x is read at x * W / (W - 1) - 1/2, which is what
            Kornia's normalisation followed by ``grid_sample(align_corners=False)`` does.
        fill_value: (C,) colour for "fill"; black by default.

    Returns:
        (B, C, height, width). Differentiable in src and M ("nearest": in src).

    Raises:
        TypeError: if src or M is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(4.0).expand(1, 1, 2, 4)
        >>> shift = torch.tensor([[[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
        >>> warp_perspective(x, shift, (2, 4))[0, 0, 0]
        tensor([0., 0., 1., 2.])
    """
    check_image(src, "src")
    check_floating(M, "M")
    if M.dim() != 3 or M.size(1) != 3 or M.size(2) != 3:
        raise ValueError(f"M: expected shape (B, 3, 3), got {list(M.shape)}")
    check_choice(mode, ["bilinear", "nearest"], "mode")
    check_choice(padding_mode, ["zeros", "border", "reflection", "fill"], "padding_mode")
    height, width = src.size(2), src.size(3)
    x, y = _source_positions(M, dsize[0], dsize[1], src.dtype)
    if not align_corners:
        x = x * width / larger(width - 1, 1) - 0.5
        y = y * height / larger(height - 1, 1) - 0.5
    if padding_mode == "border":
        x = x.clamp(0, width - 1)
        y = y.clamp(0, height - 1)
    elif padding_mode == "reflection":
        x = reflect_positions(x, width, align_corners)
        y = reflect_positions(y, height, align_corners)
    if mode == "bilinear":
        index, weight = bilinear_taps(x, y, height, width)
    else:
        index, weight = nearest_taps(x, y, height, width)
    weight = [w.to(src.dtype) for w in weight]
    out = join_channels([gather_taps(plane, index, weight) for plane in split_channels(src)])
    if padding_mode == "fill" and fill_value is not None:
        if fill_value.dim() != 1:
            raise ValueError(f"fill_value: expected shape (C,), got {list(fill_value.shape)}")
        covered = weight[0]
        for w in weight[1:]:
            covered = covered + w
        out = out + (1.0 - covered)[:, None] * fill_value.to(src.dtype)[:, None, None]
    return out


def _source_positions(M: Tensor, height: int, width: int, dtype: torch.dtype) -> Tuple[Tensor, Tensor]:
    """Position in src, x and y (B, height, width), of each output pixel."""
    # The inverse of a homography loses half the digits of float32; nine numbers in float64 cost nothing.
    inverse = inverse3x3(M.to(torch.float64))
    # Positions in half precision would be off by whole pixels.
    precision = torch.float64 if dtype == torch.float64 else torch.float32
    inverse = inverse.to(precision)
    m = inverse[:, :, :, None, None]
    column = torch.arange(width, device=M.device).to(precision)[None, None, :]
    row = torch.arange(height, device=M.device).to(precision)[None, :, None]
    depth = m[:, 2, 0] * column + m[:, 2, 1] * row + m[:, 2, 2]
    # Points at infinity land far outside instead of at NaN.
    depth = torch.where(depth.abs() > 1e-8, depth, torch.full_like(depth, 1e-8))
    x = (m[:, 0, 0] * column + m[:, 0, 1] * row + m[:, 0, 2]) / depth
    y = (m[:, 1, 0] * column + m[:, 1, 1] * row + m[:, 1, 2]) / depth
    return x, y
