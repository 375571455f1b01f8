"""Polar transforms of images."""

import math
from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_choice, check_one_for_each, check_pair
from ...primitives.resampling.warping import (
    check_source,
    pixel_axes,
    position_dtype,
    resample_image,
)
from .matrices import check_numbers, check_vectors


def warp_polar(
    src: Tensor,
    dsize: Tuple[int, int],
    center: Optional[Tensor] = None,
    max_radius: Optional[Tensor] = None,
    mapping: str = "linear",
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp images to polar coordinates, like ``cv2.warpPolar``: rows are directions, columns distances.

    Output pixel (i, j) shows the direction 2 pi i / height (from the x axis towards the y axis, clockwise as
    seen) at the distance max_radius j / width, or exp(j log(max_radius) / width) - 1 for "log". A rotation of
    src shifts the output's rows. (OpenCV subtracts this 1, although its manual does not say so;
    scikit-image's ``warp_polar`` does not.)

    Args:
        src: (B, C, H, W), floating point, uint8, int16 or uint16. Integers are sampled as in
            :func:`warp_affine`.
        dsize: (height, width) of the output; may come from another tensor's shape.
        center: (B, 2), x and y in pixels; the centre of the image, ((W - 1) / 2, (H - 1) / 2), by default.
        max_radius: (B,) in pixels, more than 1 for "log"; half the diagonal, sqrt(W^2 + H^2) / 2, by default.
        mapping: "linear" or "log".
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, height, width). Differentiable in src, center and max_radius ("nearest": in src).

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(5.0).expand(1, 1, 5, 5)
        >>> warp_polar(x, (4, 2), max_radius=torch.tensor([2.0]))[0, 0].round()
        tensor([[2., 3.],
                [2., 2.],
                [2., 1.],
                [2., 2.]])
    """
    check_source(src, mode, padding_mode, "src")
    check_choice(mapping, ["linear", "log"], "mapping")
    batch, height, width = src.size(0), src.size(2), src.size(3)
    precision = position_dtype(src.dtype)
    one = torch.ones([batch], dtype=precision, device=src.device)
    if center is None:
        middle = torch.stack([one * (width - 1) * 0.5, one * (height - 1) * 0.5], -1)
    else:
        check_vectors(center, 2, "center")
        check_one_for_each(center, src, "center", "src")
        middle = center.to(precision)
    if max_radius is None:
        radius = torch.sqrt(one * (width * width + height * height)) * 0.5
    else:
        check_numbers(max_radius, "max_radius")
        check_one_for_each(max_radius, src, "max_radius", "src")
        radius = max_radius.to(precision)
    check_pair(dsize, "dsize")
    column, row = pixel_axes(dsize[0], dsize[1], precision, src.device)
    angle = row * (2.0 * math.pi) / dsize[0]
    if mapping == "log":
        distance = torch.exp(column / dsize[1] * torch.log(radius)[:, None, None]) - 1.0
    else:
        distance = column / dsize[1] * radius[:, None, None]
    x = middle[:, 0, None, None] + distance * torch.cos(angle)
    y = middle[:, 1, None, None] + distance * torch.sin(angle)
    return resample_image(src, x, y, mode, padding_mode, align_corners, None)
