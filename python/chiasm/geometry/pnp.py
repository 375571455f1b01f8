"""Refinement of a camera pose from 3D points and their pixels (perspective-n-point)."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_leading, check_matrix, check_rank
from ..primitives.core.loops import repeated
from ..primitives.core.lowering import carries_derivative
from ..primitives.geometry.intrinsics import over_depth
from ..primitives.geometry.rotations import nearest_rotation
from ..primitives.linalg.matrices import cross, small_matmul, spd_inverse
from .calibration import check_views
from .lie.so3 import so3_exp

__all__ = ["refine_pnp"]


def __dir__() -> list[str]:
    return __all__


def refine_pnp(
    world_points: Tensor,
    img_points: Tensor,
    intrinsics: Tensor,
    pose: Tensor,
    weights: Optional[Tensor] = None,
    num_iters: int = 10,
) -> Tensor:
    """Refine a camera pose: minimize the sum of squared reprojection errors, like ``cv2.solvePnPRefineLM``.
    The method is Levenberg-Marquardt on rotation and translation (R. Hartley, A. Zisserman, Multiple View
    Geometry, 2nd ed., A6.2), computed in float64. :func:`chiasm.geometry.calibration.solve_pnp_dlt` gives an
    initial pose; for a distorted image, apply :func:`chiasm.geometry.calibration.undistort_points` to the
    pixels first.

    Args:
        world_points: (B, N, 3), N >= 3, floating point; they may be coplanar.
        img_points: (B, N, 2), pixels.
        intrinsics: (B, 3, 3), camera matrices.
        pose: (B, 3, 4), [R | t] from the world to the camera's frame.
        weights: (B, N), weights of the squared distances, not negative; ones by default.
        num_iters: number of steps; a step that increases the sum is discarded.

    Returns:
        (B, 3, 4). Differentiable in all tensors except pose. The derivatives are those of the minimum,
        approximated by two terms of a series that converges faster for smaller residuals; they are wrong if
        the steps have not reached the minimum.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above or num_iters is negative.

    Example:
        >>> X = torch.tensor([[0, 0, 4], [1, 0, 5], [0, 1, 6], [1, 1, 4], [2, 1, 7], [1, 2, 5]]).float()[None]
        >>> start = torch.eye(4)[None, :3] + 0.05
        >>> refine_pnp(X, X[..., :2] / X[..., 2:], torch.eye(3)[None], start)[0].round(decimals=3).abs()
        tensor([[1., 0., 0., 0.],
                [0., 1., 0., 0.],
                [0., 0., 1., 0.]])
    """
    check_views(world_points, img_points, intrinsics, weights, 3)
    check_rank(pose, 3, "(B, 3, 4)", "pose")
    check_matrix(pose, 3, 4, "pose")
    check_leading(
        [world_points, img_points, intrinsics, pose],
        ["world_points", "img_points", "intrinsics", "pose"],
        [2, 2, 2, 2],
    )
    if weights is not None:
        check_leading([weights, pose], ["weights", "pose"], [1, 2])
    if num_iters < 0:
        raise ValueError(f"num_iters: expected at least 0, got {num_iters}")
    w = torch.ones_like(world_points[..., 0]) if weights is None else weights
    X, x, K, w = (
        world_points.to(torch.float64),
        img_points.to(torch.float64),
        intrinsics.to(torch.float64),
        w.to(torch.float64),
    )
    start = pose.detach().to(torch.float64)
    damping = torch.full_like(start[..., 0:1], 1e-3)
    state = torch.cat([torch.cat([nearest_rotation(start[..., 0:3]), start[..., 3:4]], -1), damping], -1)
    refined = _improved(state, num_iters, X.detach(), x.detach(), K.detach(), w.detach())[..., 0:4]
    return _derived(refined, X, x, K, w).to(world_points.dtype)


@carries_derivative
def _derived(pose: Tensor, X: Tensor, x: Tensor, K: Tensor, w: Tensor) -> Tensor:
    """The refined pose, with the derivative of two Gauss-Newton steps."""
    moved = pose
    for _ in range(2):
        moved = _gauss_newton(moved, X, x, K, w)
    change = moved - moved.detach()
    # The step only adds a derivative, and none if it is NaN.
    return pose + torch.where(change == 0, change, torch.zeros_like(change))


@repeated
def _improved(state: Tensor, k: Tensor, X: Tensor, x: Tensor, K: Tensor, w: Tensor) -> Tensor:
    """One step of Levenberg and Marquardt: the pose [R | t] of (B, 3, 5) and, in the last column, the
    damping.

    A step that does not increase the cost divides the damping by ten; a step that would increase it is
    discarded and multiplies the damping by ten.
    """
    pose, damping = state[..., 0:4], state[..., 4:5]
    slope, offset = _slopes(pose, X, x, K)
    moved = _moved(pose, slope, offset, w, damping[:, 0:1])
    # Near the minimum all costs are equal within rounding, but steps still improve the pose.
    better = (_cost(moved, X, x, K, w) <= _cost(pose, X, x, K, w) * (1.0 + 1e-10))[:, None, None]
    damping = torch.where(
        better, torch.clamp(0.1 * damping, min=1e-12), torch.clamp(10.0 * damping, max=1e12)
    )
    return torch.cat([torch.where(better, moved, pose), damping], -1)


def _gauss_newton(pose: Tensor, X: Tensor, x: Tensor, K: Tensor, w: Tensor) -> Tensor:
    """The pose (B, 3, 4) after one Gauss-Newton step; the inverse of its normal matrix has no gradient."""
    slope, offset = _slopes(pose, X, x, K)
    return _moved(pose, slope, offset, w, torch.zeros_like(pose[:, 0:1, 0:1]))


def _projected(pose: Tensor, X: Tensor, K: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """Pixels (B, N, 2), the rotated points (B, N, 3), and the homogeneous pixels K (R X + t) (B, N, 3)."""
    turned = small_matmul(X, pose[..., 0:3].transpose(1, 2))
    image = small_matmul(turned + pose[:, None, :, 3], K.transpose(1, 2))
    return over_depth(image, 1e-12), turned, image


def _cost(pose: Tensor, X: Tensor, x: Tensor, K: Tensor, w: Tensor) -> Tensor:
    offset = x - _projected(pose, X, K)[0]
    return ((offset * offset).sum(-1) * w).sum(-1)


def _slopes(pose: Tensor, X: Tensor, x: Tensor, K: Tensor) -> Tuple[Tensor, Tensor]:
    """Derivatives (B, 2, N, 6) of pixels with respect to rotations about and translations along the three
    axes, and the residuals of the pixels (B, 2, N)."""
    pixel, turned, image = _projected(pose, X, K)
    offset = (x - pixel).transpose(1, 2)
    # for u: (K0 - u K2) / depth, with respect to the point in the camera's frame
    by_point = (K[:, 0:2, None] - pixel.transpose(1, 2)[..., None] * K[:, 2:3, None]) / image[:, None, :, 2:3]
    return torch.cat([cross(turned[:, None] + torch.zeros_like(by_point), by_point), by_point], -1), offset


def _moved(pose: Tensor, slope: Tensor, offset: Tensor, w: Tensor, damping: Tensor) -> Tensor:
    """The pose after the step that minimizes the linearized offsets; the damping (B, 1, 1) is added to a unit
    diagonal."""
    weighted = slope * w[:, None, :, None]
    fixed = weighted.detach().flatten(1, 2)
    normal = small_matmul(fixed.transpose(1, 2), slope.detach().flatten(1, 2))
    size = torch.rsqrt(normal.diagonal(0, 1, 2) + 1e-300)
    eye = torch.eye(6, dtype=pose.dtype, device=pose.device)
    inverse = (
        spd_inverse(normal * size[:, :, None] * size[:, None, :] + (damping + 1e-14) * eye)
        * size[:, :, None]
        * size[:, None, :]
    )
    gradient = (weighted * offset[..., None]).sum(2).sum(1)
    step = (inverse * gradient[:, None, :]).sum(-1)
    rotation = small_matmul(so3_exp(step[:, 0:3]), pose[..., 0:3])
    return torch.cat([rotation, pose[..., 3:4] + step[:, 3:6, None]], -1)
