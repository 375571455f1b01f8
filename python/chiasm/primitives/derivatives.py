"""First derivatives by finite differences."""

from typing import Tuple

from torch import Tensor


def first_derivatives(p: Tensor, mode: str, normalized: bool) -> Tuple[Tensor, Tensor]:
    """d/dx and d/dy (B, C, H, W) of an image padded by one pixel."""
    height = p.size(2) - 2
    width = p.size(3) - 2
    if mode == "diff":
        dx = p[:, :, 1 : height + 1, 2 : width + 2] - p[:, :, 1 : height + 1, 0:width]
        dy = p[:, :, 2 : height + 2, 1 : width + 1] - p[:, :, 0:height, 1 : width + 1]
        scale = 0.5 if normalized else 1.0
    else:
        smooth = p[:, :, 0:height] + 2.0 * p[:, :, 1 : height + 1] + p[:, :, 2 : height + 2]
        slope = p[:, :, 2 : height + 2] - p[:, :, 0:height]
        dx = smooth[..., 2 : width + 2] - smooth[..., 0:width]
        dy = slope[..., 0:width] + 2.0 * slope[..., 1 : width + 1] + slope[..., 2 : width + 2]
        scale = 0.125 if normalized else 1.0
    return dx * scale, dy * scale
