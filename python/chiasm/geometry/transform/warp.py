"""Warping by a homography."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.broadcasting import one_for_each
from ...primitives.core.checks import check_pair
from ...primitives.linalg.matrices import inverse3x3
from ...primitives.resampling.warping import check_matrices, check_source, resample_projective


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

    Pixel centres lie at integers, as for ``cv2.warpPerspective(src, M, (width, height))`` with constant
    border 0 (OpenCV rounds positions to 1/32 pixel for 8-bit and 16-bit images).

    Args:
        src: (B, C, H, W), floating point, uint8, int16 or uint16. Integers are sampled as in
            :func:`warp_affine`.
        M: (B, 3, 3), or (1, 3, 3) for all images, invertible, mapping src pixels (x, y) to output pixels.
        dsize: (height, width) of the output; may come from another tensor's shape.
        mode: "bilinear", "nearest" (halves are rounded to the even neighbour) or "bicubic" (a = -0.75, as in
            PyTorch and OpenCV).
        padding_mode: the values outside src: "zeros", "border" (replicate), "reflection" or "fill".
        align_corners: True: "reflection" mirrors at the centres of the border pixels; False: at the outer
            edges. It has no other effect, since M is in pixels.
        fill_value: (C,) colour for "fill", for integers in levels; 0 by default.

    Returns:
        (B, C, height, width). Differentiable in src and M ("nearest": in src).

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(4.0).expand(1, 1, 2, 4)
        >>> shift = torch.tensor([[[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
        >>> warp_perspective(x, shift, (2, 4))[0, 0, 0]
        tensor([0., 0., 1., 2.])
    """
    check_source(src, mode, padding_mode, "src")
    check_matrices(M, 3, 3, "M")
    check_pair(dsize, "dsize")
    src = one_for_each(src, M, "src", "M")
    return resample_projective(
        src, pixels_to_source(M), dsize[0], dsize[1], mode, padding_mode, align_corners, fill_value
    )


def pixels_to_source(M: Tensor) -> Tensor:
    """The inverse (B, 3, 3), float64, of homographies from a source to an output."""
    # The inverse of a homography loses half the digits of float32; nine numbers in float64 cost nothing.
    return inverse3x3(M.to(torch.float64))
