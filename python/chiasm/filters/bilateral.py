"""Edge-preserving smoothing."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.checks import check_choice, check_image, odd_pair
from ..primitives.padding import join_columns, padded_parts
from ..primitives.stencil import join_channels, split_channels
from .gaussian import gaussian_kernels


def bilateral_blur(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    sigma_color: Union[float, Tensor],
    sigma_space: Union[Tuple[float, float], Tensor],
    border_type: str = "reflect",
    color_distance_type: str = "l1",
) -> Tensor:
    """Average over neighbours, weighted by closeness in space and in colour.

    C. Tomasi, R. Manduchi, Bilateral filtering for gray and color images, ICCV 1998. OpenCV's ``bilateralFilter`` uses
    the "l1" distance, and a disc where this uses the whole rectangle.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: odd size, one for both axes or (rows, columns).
        sigma_color: standard deviation of the colour distance in input's units; a float, or a tensor (B,) or scalar.
        sigma_space: standard deviations in pixels, (y, x) or a tensor (B, 2).
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        color_distance_type: "l1" sums the channels' absolute differences, "l2" is the Euclidean distance.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> bilateral_blur(torch.ones(1, 3, 5, 5), 3, 0.1, (1.0, 1.0)).shape
        torch.Size([1, 3, 5, 5])
    """
    check_image(input, "input")
    check_choice(color_distance_type, ["l1", "l2"], "color_distance_type")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    kernel_y, kernel_x = gaussian_kernels(ky, kx, sigma_space, input, "sigma_space")
    if isinstance(sigma_color, Tensor):
        color = sigma_color.to(input.dtype).reshape(-1, 1, 1, 1)
    else:
        color = torch.full([1, 1, 1, 1], sigma_color, dtype=input.dtype, device=input.device)
    falloff = -0.5 / (color * color)
    outs: List[Tensor] = []
    for p in padded_parts(input, ky // 2, ky // 2, kx // 2, kx // 2, border_type, store=True):
        outs.append(_bilateral_valid(p, kernel_y, kernel_x, falloff, color_distance_type))
    return join_columns(outs)


def _bilateral_valid(p: Tensor, kernel_y: Tensor, kernel_x: Tensor, falloff: Tensor, distance_type: str) -> Tensor:
    ky, kx = kernel_y.size(1), kernel_x.size(1)
    height = p.size(2) - ky + 1
    width = p.size(3) - kx + 1
    planes = split_channels(p)
    centres = [plane[:, :, ky // 2 : ky // 2 + height, kx // 2 : kx // 2 + width] for plane in planes]
    total = torch.zeros([1], dtype=p.dtype, device=p.device)
    sums = [total for _ in planes]
    for i in range(ky):
        rows = [plane[:, :, i : i + height] for plane in planes]
        for j in range(kx):
            taps = [row[..., j : j + width] for row in rows]
            distance = torch.zeros([1], dtype=p.dtype, device=p.device)
            for c in range(len(planes)):
                difference = taps[c] - centres[c]
                if distance_type == "l1":
                    distance = distance + difference.abs().sum(1, keepdim=True)
                else:
                    distance = distance + (difference * difference).sum(1, keepdim=True)
            if distance_type == "l1":
                distance = distance * distance
            nearness = (kernel_y[:, i] * kernel_x[:, j])[:, None, None, None]
            weight = torch.exp(distance * falloff) * nearness
            total = total + weight
            sums = [sums[c] + taps[c] * weight for c in range(len(planes))]
    return join_channels([s / total for s in sums])
