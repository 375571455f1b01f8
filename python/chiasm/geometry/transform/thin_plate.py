"""Thin-plate splines: smooth maps of the plane that map given points to given points.

F. Bookstein, Principal Warps: Thin-Plate Splines and the Decomposition of Deformations, IEEE TPAMI 11(6),
1989. A map is affine_weights[0] + p affine_weights[1:] + sum_i U(|p - kernel_centers[i]|) kernel_weights[i]
with U(r) = r^2 log(r).
"""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_image,
    check_leading,
    check_one_for_each,
)
from ...primitives.linalg.matrices import small_matmul, solve
from ...primitives.resampling.warping import (
    check_matrices,
    check_sampling,
    from_normalized,
    normalized_axis,
    position_dtype,
    resample_image,
)


def get_tps_transform(points_src: Tensor, points_dst: Tensor) -> Tuple[Tensor, Tensor]:
    """Weights of the spline that maps points_src to points_dst; its kernels are centred at **points_dst**.
    This is as in Kornia: ``warp_points_tps(points_src, points_dst, *get_tps_transform(points_src,
    points_dst))`` is points_dst. (Bookstein centres the kernels at the source points. Both splines
    interpolate; only his has the least bending energy.)

    Args:
        points_src: (B, N, 2), N >= 3, not all on a line. In exported graphs N is fixed.
        points_dst: (B, N, 2), not all on a line.

    Returns:
        kernel_weights (B, N, 2) and affine_weights (B, 3, 2). Differentiable in both points.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
        >>> kernel_weights, affine_weights = get_tps_transform(square, 2.0 * square + 1.0)
        >>> affine_weights[0].round() + 0.0
        tensor([[1., 1.],
                [2., 0.],
                [0., 2.]])
    """
    _check_plane(points_src, "points_src")
    _check_plane(points_dst, "points_dst")
    if points_src.size(1) < 3:
        raise ValueError(f"points_src: expected at least 3 points, got {points_src.size(1)}")
    if points_dst.size(1) != points_src.size(1):
        raise ValueError(
            f"points_dst: expected as many points as points_src, {points_src.size(1)}, got"
            f" {points_dst.size(1)}"
        )
    check_leading([points_src, points_dst], ["points_src", "points_dst"], [2, 2])
    source, target = torch.broadcast_tensors(points_src.to(torch.float64), points_dst.to(torch.float64))
    ones = torch.cat([torch.ones_like(source[:, :, :1]), source], 2)
    upper = torch.cat([_kernel(source, target), ones], 2)
    lower = torch.cat([ones.transpose(1, 2), torch.zeros_like(ones[:, :3]).expand(-1, 3, 3)], 2)
    wanted = torch.cat([target, torch.zeros_like(target[:, :3])], 1)
    weights = solve(torch.cat([upper, lower], 1), wanted).to(points_src.dtype)
    return weights[:, :-3], weights[:, -3:]


def _check_plane(points: Tensor, name: str) -> None:
    check_floating(points, name)
    if points.dim() != 3 or points.size(2) != 2:
        raise ValueError(f"{name}: expected shape (B, N, 2), got {list(points.shape)}")


def _kernel(points: Tensor, centers: Tensor) -> Tensor:
    """U (B, N, M) of the distances between (B, N, 2) and (B, M, 2)."""
    offset = points[:, :, None, :] - centers[:, None, :, :]
    return _radial((offset * offset).sum(-1))


def _radial(squared: Tensor) -> Tensor:
    """r^2 log(r) from r^2; at 0 the value is finite, and the derivative is chosen as 0."""
    at_center = squared <= 1e-30
    safe = torch.where(at_center, torch.ones_like(squared), squared)
    return 0.5 * torch.where(at_center, torch.zeros_like(squared), safe * torch.log(safe))


def _check_weights(kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor) -> None:
    _check_plane(kernel_centers, "kernel_centers")
    _check_plane(kernel_weights, "kernel_weights")
    check_matrices(affine_weights, 3, 2, "affine_weights")


def warp_points_tps(
    points_src: Tensor, kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor
) -> Tensor:
    """Transform points by thin-plate splines.

    Args:
        points_src: (B, N, 2).
        kernel_centers: (B, K, 2).
        kernel_weights: (B, K, 2).
        affine_weights: (B, 3, 2): first the translation, then the 2x2 matrix that multiplies points as row
            vectors.

    Returns:
        (B, N, 2). Differentiable in all.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> moved = torch.tensor([[[5.0, 7.0], [1.0, 0.0], [0.0, 1.0]]])
        >>> warp_points_tps(torch.ones(1, 1, 2), torch.zeros(1, 4, 2), torch.zeros(1, 4, 2), moved)
        tensor([[[6., 8.]]])
    """
    _check_plane(points_src, "points_src")
    _check_weights(kernel_centers, kernel_weights, affine_weights)
    if kernel_weights.size(1) != kernel_centers.size(1):
        raise ValueError(
            f"kernel_weights: expected one for each of kernel_centers {list(kernel_centers.shape)}, got"
            f" {list(kernel_weights.shape)}"
        )
    names = ["points_src", "kernel_centers", "kernel_weights", "affine_weights"]
    check_leading([points_src, kernel_centers, kernel_weights, affine_weights], names, [2, 2, 2, 2])
    bent = small_matmul(_kernel(points_src, kernel_centers), kernel_weights)
    return affine_weights[:, :1] + small_matmul(points_src, affine_weights[:, 1:]) + bent


def warp_image_tps(
    image: Tensor,
    kernel_centers: Tensor,
    kernel_weights: Tensor,
    affine_weights: Tensor,
    align_corners: bool = False,
    padding_mode: str = "zeros",
) -> Tensor:
    """Warp an image by thin-plate splines: out(p) = image(spline(p)), in coordinates from -1 to 1. So the
    spline maps the output to the image. With kernel_centers = points and the weights of
    ``get_tps_transform(others, points)``, the content of the image at points moves to others.

    Args:
        image: (B, C, H, W), floating point.
        kernel_centers: (B, K, 2).
        kernel_weights: (B, K, 2).
        affine_weights: (B, 3, 2).
        align_corners: True: coordinates -1 and 1 are the centres of the corner pixels; False: the outer
            edges.
        padding_mode: the values outside the input: "zeros", "border", "reflection" or "fill" (black here, as
            "zeros").

    Returns:
        (B, C, H, W). Differentiable in all.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape or the padding is not as above.

    Example:
        >>> mirror = torch.tensor([[[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]])
        >>> warp_image_tps(
        ...     torch.arange(4.0).expand(1, 1, 2, 4), torch.zeros(1, 3, 2), torch.zeros(1, 3, 2), mirror
        ... )[0, 0, 0]
        tensor([3., 2., 1., 0.])
    """
    check_image(image, "image")
    check_sampling("bilinear", padding_mode)
    _check_weights(kernel_centers, kernel_weights, affine_weights)
    check_broadcastable(kernel_weights, kernel_centers, "kernel_weights", "kernel_centers")
    check_one_for_each(kernel_centers, image, "kernel_centers", "image")
    check_one_for_each(kernel_weights, image, "kernel_weights", "image")
    check_one_for_each(affine_weights, image, "affine_weights", "image")
    precision = position_dtype(image.dtype)
    column = normalized_axis(image.size(3), align_corners, precision, image.device)[None, None, :]
    row = normalized_axis(image.size(2), align_corners, precision, image.device)[None, :, None]
    a = affine_weights.to(precision)[:, :, :, None, None]
    x = a[:, 0, 0] + a[:, 1, 0] * column + a[:, 2, 0] * row
    y = a[:, 0, 1] + a[:, 1, 1] * column + a[:, 2, 1] * row
    center, weight = kernel_centers.to(precision), kernel_weights.to(precision)
    across = column[..., None] - center[:, None, None, :, 0]
    down = row[..., None] - center[:, None, None, :, 1]
    bend = _radial(across * across + down * down)
    x = x + (bend * weight[:, None, None, :, 0]).sum(-1)
    y = y + (bend * weight[:, None, None, :, 1]).sum(-1)
    x, y = from_normalized(x, image.size(3), align_corners), from_normalized(y, image.size(2), align_corners)
    return resample_image(image, x, y, "bilinear", padding_mode, align_corners, None)
