"""Elastic deformations."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ...filters.gaussian import gaussian_blur2d
from ...primitives.core.checks import (
    broadcastable,
    check_floating,
    check_image,
    check_interval,
    check_one_for_each,
)
from ...primitives.resampling.warping import (
    check_sampling,
    from_normalized,
    normalized_axis,
    position_dtype,
    resample_image,
)


def elastic_transform2d(
    image: Tensor,
    noise: Tensor,
    kernel_size: Tuple[int, int] = (63, 63),
    sigma: Union[Tuple[float, float], Tensor] = (32.0, 32.0),
    alpha: Union[Tuple[float, float], Tensor] = (1.0, 1.0),
    align_corners: bool = False,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
) -> Tensor:
    """Deform an image by smoothed random displacements.

    P. Simard, D. Steinkraus, J. Platt, Best Practices for Convolutional Neural Networks, ICDAR 2003.
    Displacements are in units of half the image's width and height, as in Kornia; the noise is zero outside
    the image.

    Args:
        image: (B, C, H, W), floating point.
        noise: (B, 2, H, W), displacements along x and y before smoothing, usually uniform in [-1, 1].
        kernel_size: odd number of taps of the Gaussian, (rows, columns).
        sigma: standard deviations of the Gaussian in pixels, (y, x) or a tensor (B, 2) (or (1, 2) for all).
        alpha: factors of the displacements along x and y, two numbers or a tensor (2,), (1, 2) or (B, 2).
        align_corners: True: the unit is half the distance between the centres of the corner pixels; False:
            half the distance between the edges.
        mode: "bilinear", "nearest" (halves are rounded to the even neighbour) or "bicubic" (a = -0.75, as in
            PyTorch and OpenCV).
        padding_mode: the values outside the input: "zeros", "border" (replicate), "reflection" or "fill"
            (black here, as "zeros").

    Returns:
        (B, C, H, W). Differentiable in image, noise, sigma and alpha ("nearest": in image).

    Raises:
        TypeError: if image or noise is not floating point.
        ValueError: if a shape, a size or a choice is not as above.

    Example:
        >>> x = torch.rand(1, 3, 8, 9)
        >>> torch.allclose(elastic_transform2d(x, torch.zeros(1, 2, 8, 9), (3, 3), (1.0, 1.0)), x, atol=1e-5)
        True
    """
    check_image(image, "image")
    check_floating(noise, "noise")
    check_sampling(mode, padding_mode)
    if noise.dim() != 4 or noise.size(1) != 2:
        raise ValueError(f"noise: expected shape (B, 2, H, W), got {list(noise.shape)}")
    check_one_for_each(noise, image, "noise", "image")
    if not broadcastable(noise[:, 0], image[:, 0]):
        raise ValueError(f"noise: expected the size of image {list(image.shape)}, got {list(noise.shape)}")
    precision = position_dtype(image.dtype)
    if isinstance(alpha, Tensor):
        if alpha.dim() > 2 or alpha.size(-1) != 2:
            raise ValueError(f"alpha: expected shape (B, 2), got {list(alpha.shape)}")
        factor = alpha.to(precision).reshape(-1, 2)
        check_one_for_each(factor, image, "alpha", "image")
    else:
        check_interval(alpha, "alpha")
        factor = torch.tensor([alpha[0], alpha[1]], dtype=precision, device=noise.device)[None]
    moved = gaussian_blur2d(noise.to(precision), kernel_size, sigma, "constant")
    column = normalized_axis(image.size(3), align_corners, precision, image.device)[None, None, :]
    row = normalized_axis(image.size(2), align_corners, precision, image.device)[None, :, None]
    x = from_normalized(column + moved[:, 0] * factor[:, 0, None, None], image.size(3), align_corners)
    y = from_normalized(row + moved[:, 1] * factor[:, 1, None, None], image.size(2), align_corners)
    return resample_image(image, x, y, mode, padding_mode, align_corners, None)
