"""Lens distortion and camera pose.

The distortion is OpenCV's: 4, 5, 8, 12 or 14 coefficients k1, k2, p1, p2 [, k3 [, k4, k5, k6 [, s1, s2, s3,
s4 [, taux, tauy]]]].
"""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_floating,
    check_last,
    check_leading,
    check_matrix,
    check_not_empty,
    check_rank,
    check_same_shape,
    check_tensor,
    check_values,
)
from ..primitives.core.materialise import materialised
from ..primitives.geometry.intrinsics import from_pixels, to_pixels, with_one
from ..primitives.geometry.lens import coefficients, distort, tilt_matrices, under_homography, undistort
from ..primitives.geometry.rotations import nearest_rotation
from ..primitives.linalg.direct_linear import hartley, projective_equations
from ..primitives.linalg.matrices import cross, inverse3x3, small_matmul, smallest_eigenvector
from ..primitives.resampling.warping import position_dtype, resample_image

__all__ = [
    "distort_points",
    "solve_pnp_dlt",
    "tilt_projection",
    "undistort_image",
    "undistort_points",
]


def __dir__() -> list[str]:
    return __all__


def distort_points(points: Tensor, K: Tensor, dist: Tensor, new_K: Optional[Tensor] = None) -> Tensor:
    """Distort points: the pixels at which a lens shows points of an undistorted image.

    Args:
        points: (*, N, 2), pixels of an undistorted image with the camera matrix new_K, floating point.
        K: (*, 3, 3), the camera matrix of the distorted image.
        dist: (*, n) distortion coefficients, n one of 4, 5, 8, 12, 14.
        new_K: (*, 3, 3); K by default.

    Returns:
        (*, N, 2). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> K = torch.tensor([[100.0, 0.0, 50.0], [0.0, 100.0, 50.0], [0.0, 0.0, 1.0]])
        >>> distort_points(torch.tensor([[150.0, 50.0]]), K, torch.tensor([0.1, 0.0, 0.0, 0.0]))
        tensor([[160.,  50.]])
    """
    _check(points, K, dist, new_K)
    source = K if new_K is None else new_K
    flat = from_pixels(points, source[..., None, :, :])
    x, y = _lens(flat[..., 0], flat[..., 1], dist)
    return to_pixels(torch.stack([x, y], -1), K[..., None, :, :])


def undistort_points(
    points: Tensor, K: Tensor, dist: Tensor, new_K: Optional[Tensor] = None, num_iters: int = 5
) -> Tensor:
    """Remove the distortion from points of a distorted image; the inverse of :func:`distort_points`.

    The solver is Newton's method, which starts at the distorted point; its last step carries the gradient.
    OpenCV and Kornia use a fixed-point iteration instead, which takes more steps for the same accuracy.

    Args:
        points: (*, N, 2), pixels of the distorted image, floating point.
        K: (*, 3, 3), the camera matrix of the distorted image.
        dist: (*, n) distortion coefficients, n one of 4, 5, 8, 12, 14.
        new_K: (*, 3, 3), the camera matrix of the undistorted image; K by default.
        num_iters: Newton steps, at least 1.

    Returns:
        (*, N, 2). Differentiable in all.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if the last dimensions are not as above, or num_iters is below 1.

    Example:
        >>> K = torch.tensor([[100.0, 0.0, 50.0], [0.0, 100.0, 50.0], [0.0, 0.0, 1.0]])
        >>> undistort_points(torch.tensor([[160.0, 50.0]]), K, torch.tensor([0.1, 0.0, 0.0, 0.0])).round(
        ...     decimals=3
        ... )
        tensor([[150.,  50.]])
    """
    _check(points, K, dist, new_K)
    if num_iters < 1:
        raise ValueError(f"num_iters: expected at least 1, got {num_iters}")
    flat = from_pixels(points, K[..., None, :, :])
    x, y = flat[..., 0], flat[..., 1]
    if dist.size(-1) == 14:
        x, y = under_homography(x, y, tilt_matrices(dist[..., 12], dist[..., 13])[1])
    x, y = undistort(x, y, coefficients(dist), num_iters)
    target = K if new_K is None else new_K
    return to_pixels(torch.stack([x, y], -1), target[..., None, :, :])


def tilt_projection(taux: Tensor, tauy: Tensor, return_inverse: bool = False) -> Tensor:
    """The homography from the plane z = 1 to a sensor that is tilted about x, then about y.

    Args:
        taux: (*, 1), angles about x in radians, floating point.
        tauy: (*, 1), angles about y in radians.
        return_inverse: return the inverse instead.

    Returns:
        (*, 3, 3). Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or not (*, 1).

    Example:
        >>> tilt_projection(torch.zeros(1), torch.zeros(1)).diagonal()
        tensor([1., 1., 1.])
    """
    check_last(taux, 1, "taux")
    check_last(tauy, 1, "tauy")
    check_same_shape(tauy, taux, "tauy", "taux")
    forth, back = tilt_matrices(taux[..., 0], tauy[..., 0])
    return back if return_inverse else forth


def undistort_image(image: Tensor, K: Tensor, dist: Tensor) -> Tensor:
    """Remove lens distortion from an image, like ``cv2.undistort`` with the same camera matrix for input and
    output. Each pixel is read with bilinear interpolation at the position that :func:`distort_points` gives;
    positions outside the image give zero. For integers, positions and values are rounded as in
    :func:`chiasm.geometry.transform.remap`.

    Args:
        image: (*, C, H, W), floating point, uint8, int16 or uint16.
        K: (*, 3, 3), camera matrices in pixels.
        dist: (*, n) distortion coefficients, n one of 4, 5, 8, 12, 14.

    Returns:
        (*, C, H, W). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not of a type as above or its last dimensions are not as above.

    Example:
        >>> x = torch.arange(16.0).reshape(1, 1, 4, 4)
        >>> undistort_image(x, torch.eye(3)[None], torch.zeros(1, 4)).equal(x)
        True
    """
    check_values(image, "image", True)
    if image.dim() < 3:
        raise ValueError(f"image: expected shape (*, C, H, W), got {list(image.shape)}")
    check_not_empty(image, 3, "image")
    _check_lens(K, dist)
    for value, name, own in ((K, "K", 2), (dist, "dist", 1)):
        if value.dim() - own != image.dim() - 3:
            raise ValueError(
                f"{name}: expected the leading dimensions of image {list(image.shape)}, got"
                f" {list(value.shape)}"
            )
    channels, height, width = image.size(-3), image.size(-2), image.size(-1)
    precision = position_dtype(image.dtype)
    camera = K.to(precision).reshape(-1, 3, 3)
    lens = dist.to(precision).reshape(-1, 1, dist.size(-1))
    flat = image.reshape(-1, channels, height, width)
    for given, name, own, value in ((K, "K", 2, camera), (dist, "dist", 1, lens)):
        if given.shape[: given.dim() - own] != image.shape[: image.dim() - 3] and value.size(0) != 1:
            raise ValueError(
                f"{name}: expected one for each of {flat.size(0)} images, or one for all, got"
                f" {list(given.shape)}"
            )
    row = torch.arange(height, device=image.device).to(precision)[None, :, None]
    column = torch.arange(width, device=image.device).to(precision)[None, None, :]
    # x depends on the column alone, y on the row alone: each position is divided once, not at every pixel.
    x = materialised((column - camera[:, 0:1, 2:3]) / camera[:, 0:1, 0:1], 2)
    y = materialised((row - camera[:, 1:2, 2:3]) / camera[:, 1:2, 1:2], 1)
    x, y = _lens(x, y, lens)
    x = x * camera[:, 0:1, 0:1] + camera[:, 0:1, 2:3]
    y = y * camera[:, 1:2, 1:2] + camera[:, 1:2, 2:3]
    return resample_image(flat, x, y, "bilinear", "zeros", True, None).reshape(image.shape)


def solve_pnp_dlt(
    world_points: Tensor, img_points: Tensor, intrinsics: Tensor, weights: Optional[Tensor] = None
) -> Tensor:
    """Camera pose from 3D points and their pixels, by the direct linear transform (DLT).

    The 12 entries of the projection matrix are computed by least squares from normalized points; the rotation
    is the one nearest to the left part of this matrix. R. Hartley, A. Zisserman, Multiple View Geometry, 2nd
    ed., 7.1. Computed in float64. Kornia's svd_eps does not exist here, since an exported op cannot raise
    errors that depend on values. The result for coplanar points is meaningless.
    :func:`chiasm.geometry.pnp.refine_pnp` minimizes the distances in the image.

    Args:
        world_points: (B, N, 3), N >= 6, not coplanar, floating point.
        img_points: (B, N, 2), pixels.
        intrinsics: (B, 3, 3), camera matrices.
        weights: (B, N), not negative; ones by default. A batch of 1 is for all, here and above.

    Returns:
        (B, 3, 4), [R | t] from the world to the camera's frame. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> X = torch.tensor(
        ...     [[0, 0, 4], [1, 0, 5], [0, 1, 6], [1, 1, 4], [2, 1, 7], [1, 2, 5], [2, 2, 6]]
        ... ).float()[None]
        >>> solve_pnp_dlt(X, X[..., :2] / X[..., 2:], torch.eye(3)[None])[0].round(decimals=3).abs()
        tensor([[1., 0., 0., 0.],
                [0., 1., 0., 0.],
                [0., 0., 1., 0.]])
    """
    check_views(world_points, img_points, intrinsics, weights, 6)
    inverse = inverse3x3(intrinsics.to(torch.float64))
    ray = small_matmul(with_one(img_points.to(torch.float64)), inverse.transpose(1, 2))
    p, t1 = hartley(world_points.to(torch.float64), None, 1e-8)
    q, t2 = hartley(ray[..., 0:2] / ray[..., 2:3], None, 1e-8)
    w = torch.ones_like(p[..., 0] + q[..., 0])
    if weights is not None:
        w = w * weights.to(torch.float64)
    P = smallest_eigenvector(projective_equations(with_one(p), q, w)).reshape(-1, 3, 4)
    P = small_matmul(small_matmul(inverse3x3(t2), P), t1)
    m = P[..., 0:3]
    volume = (m[:, 0] * cross(m[:, 1], m[:, 2])).sum(-1)
    P = torch.where((volume < 0)[:, None, None], -P, P)
    m = P[..., 0:3]
    rotation = nearest_rotation(m)
    # The mean of the singular values.
    scale = (rotation * m).sum(-1, keepdim=True).sum(-2, keepdim=True) / 3.0
    return torch.cat([rotation, P[..., 3:4] / scale], -1).to(world_points.dtype)


def _lens(x: Tensor, y: Tensor, dist: Tensor) -> Tuple[Tensor, Tensor]:
    """Lens distortion and tilt, applied to points (*, N) of the plane z = 1, or (B, H, W) with coefficients
    (B, 1, n)."""
    x, y = distort(x, y, coefficients(dist))
    if dist.size(-1) == 14:
        x, y = under_homography(x, y, tilt_matrices(dist[..., 12], dist[..., 13])[0])
    return x, y


def _check(points: Tensor, K: Tensor, dist: Tensor, new_K: Optional[Tensor]) -> None:
    check_last(points, 2, "points")
    if points.dim() < 2:
        raise ValueError(f"points: expected shape (*, N, 2), got {list(points.shape)}")
    _check_lens(K, dist)
    check_leading([points, K, dist], ["points", "K", "dist"], [2, 2, 1])
    if new_K is not None:
        check_matrix(new_K, 3, 3, "new_K")
        check_leading([points, K, dist, new_K], ["points", "K", "dist", "new_K"], [2, 2, 1, 2])


def _check_lens(K: Tensor, dist: Tensor) -> None:
    check_matrix(K, 3, 3, "K")
    check_floating(dist, "dist")
    if dist.dim() < 1 or dist.size(-1) not in (4, 5, 8, 12, 14):
        raise ValueError(f"dist: expected shape (*, n) with n one of 4, 5, 8, 12, 14, got {list(dist.shape)}")


def check_views(
    world_points: Tensor, img_points: Tensor, intrinsics: Tensor, weights: Optional[Tensor], least: int
) -> None:
    """Raise unless there are ``least`` points (B, N, 3), their pixels (B, N, 2), camera matrices (B, 3, 3)
    and, if any, weights (B, N). Each B may be 1."""
    check_rank(world_points, 3, "(B, N, 3)", "world_points")
    check_last(world_points, 3, "world_points")
    check_rank(img_points, 3, "(B, N, 2)", "img_points")
    check_last(img_points, 2, "img_points")
    check_rank(intrinsics, 3, "(B, 3, 3)", "intrinsics")
    check_matrix(intrinsics, 3, 3, "intrinsics")
    if world_points.size(1) < least:
        raise ValueError(f"world_points: expected at least {least} points, got {world_points.size(1)}")
    if img_points.size(1) != world_points.size(1):
        raise ValueError(
            f"img_points: expected as many points as world_points, {world_points.size(1)}, got"
            f" {img_points.size(1)}"
        )
    check_leading(
        [world_points, img_points, intrinsics], ["world_points", "img_points", "intrinsics"], [2, 2, 2]
    )
    if weights is not None:
        check_tensor(weights, "weights")
        if weights.dim() != 2:
            raise ValueError(f"weights: expected shape (B, N), got {list(weights.shape)}")
        check_leading([world_points, weights], ["world_points", "weights"], [1, 0])
        check_leading([img_points, intrinsics, weights], ["img_points", "intrinsics", "weights"], [2, 2, 1])
