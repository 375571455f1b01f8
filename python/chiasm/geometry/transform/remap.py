"""Sampling of an image at positions given by maps."""

from typing import Optional

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_floating, check_one_for_each, check_rank
from ...primitives.resampling.warping import (
    check_source,
    from_normalized,
    position_dtype,
    resample_image,
    stretched,
)


def remap(
    image: Tensor,
    map_x: Tensor,
    map_y: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: Optional[bool] = None,
    normalized_coordinates: bool = False,
) -> Tensor:
    """Sample an image at given positions: out(p) = image(map_x(p), map_y(p)).

    With align_corners=True this is ``cv2.remap(image, map_x, map_y, interpolation)`` with constant border 0.
    For integers, positions are rounded to 1/32 pixel (for "bilinear" and 16 bits to 1/65536, for "nearest" to
    pixels), halves to even, and values to integers, halves up. For uint8, "bilinear" is identical to OpenCV
    4.6, and "bicubic" is within one level of it. OpenCV 5 does not round positions; for smooth images the
    result is within one level of it. Without align_corners, positions are computed and may differ in their
    last digits between engines, so that a position half-way between two steps may be rounded either way.

    Args:
        image: (B, C, H, W), floating point, uint8, int16 or uint16.
        map_x: (B, h, w), columns of image, floating point.
        map_y: (B, h, w), rows of image.
        mode: "bilinear", "nearest" (halves are rounded to the even neighbour) or "bicubic" (a = -0.75, as in
            PyTorch and OpenCV).
        padding_mode: the values outside the input: "zeros", "border" (replicate), "reflection" (about the
            corner pixels' centres, or the outer edges unless align_corners is True) or "fill" (black here, as
            "zeros").
        align_corners: True for pixel centres at integers. None is False, as in Kornia: then positions in
            pixels are read at x * W / (W - 1) - 1/2, so that identity maps are **not** the identity.
        normalized_coordinates: the maps are in [-1, 1], from corner pixel to corner pixel with align_corners,
            otherwise from edge to edge.

    Returns:
        (B, C, h, w). Differentiable in image and the maps ("nearest": in image).

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(4.0).expand(1, 1, 2, 4)
        >>> remap(x, torch.tensor([[[0.25, 2.5]]]), torch.zeros(1, 1, 2), align_corners=True)
        tensor([[[[0.2500, 2.5000]]]])
    """
    check_source(image, mode, padding_mode, "image")
    check_rank(map_x, 3, "(B, h, w)", "map_x")
    check_rank(map_y, 3, "(B, h, w)", "map_y")
    check_floating(map_x, "map_x")
    check_floating(map_y, "map_y")
    check_broadcastable(map_y, map_x, "map_y", "map_x")
    check_one_for_each(map_x, image, "map_x", "image")
    check_one_for_each(map_y, image, "map_y", "image")
    corners = align_corners is not None and align_corners
    precision = position_dtype(image.dtype)
    if not image.is_floating_point() and corners and not normalized_coordinates:
        precision = torch.promote_types(torch.float32, map_x.dtype)  # positions are rounded in this dtype
    x, y = map_x.to(precision), map_y.to(precision)
    if normalized_coordinates:
        x, y = from_normalized(x, image.size(3), corners), from_normalized(y, image.size(2), corners)
    elif not corners:
        x, y = stretched(x, image.size(3)), stretched(y, image.size(2))
    return resample_image(image, x, y, mode, padding_mode, corners, None)
