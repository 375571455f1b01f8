"""Stereo pairs: rectification, so that rows correspond, and points from disparities."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_leading,
    check_matrix,
    check_one_channel,
    check_optional,
    check_rank,
)
from ..primitives.geometry.intrinsics import focal_lengths, from_pixels, over_depth, with_one
from ..primitives.linalg.matrices import cross, small_matmul
from .calibration import undistort_points
from .conversions.rotations import (
    quaternion_to_rotation_matrix,
    rotation_matrix_to_quaternion,
    vector_to_skew_symmetric_matrix,
)

__all__ = [
    "reproject_disparity_to_3d",
    "stereo_rectify",
]


def __dir__() -> list[str]:
    return __all__


def stereo_rectify(
    K1: Tensor,
    K2: Tensor,
    R: Tensor,
    t: Tensor,
    height: int,
    width: int,
    dist1: Optional[Tensor] = None,
    dist2: Optional[Tensor] = None,
    zero_disparity: bool = True,
) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """Rectify a stereo pair by J.-Y. Bouguet's method, like ``cv2.stereoRectify`` with its default alpha of
    -1. After the returned rotations and projections, points are in the same row of both images. Each camera
    is rotated by half of the rotation between them; then both are rotated, by the smallest angle, until the
    baseline is along the x axis, or along the y axis if this is nearer (points are then in the same column).
    Both cameras get the mean of the focal lengths across the baseline, and principal points that keep the
    mean of their images' corners at the centre. The image size does not change and there are no regions of
    interest; for other choices, scale P1, P2 and Q.

    Args:
        K1, K2: (B, 3, 3), camera matrices, floating point.
        R: (B, 3, 3), rotations from the first camera's frame to the second's.
        t: (B, 3, 1), translations from the first camera's frame to the second's, not 0.
        height, width: size of both images.
        dist1, dist2: (B, n), distortion coefficients as for
            :func:`chiasm.geometry.calibration.undistort_points`; none by default. They only change the
            corners.
        zero_disparity: give both cameras the same principal point, so that points at infinity have the
            disparity 0; otherwise it is the same only across the baseline.

    Returns:
        R1, R2 (B, 3, 3), rotations from the cameras' frames to the rectified ones; P1, P2 (B, 3, 4),
        projection matrices of rectified pixels from the first rectified frame; and Q (B, 4, 4) for
        :func:`reproject_disparity_to_3d`. Differentiable in all tensors.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> K = torch.tensor([[[100.0, 0.0, 50.0], [0.0, 100.0, 50.0], [0.0, 0.0, 1.0]]])
        >>> t = torch.tensor([[[-0.6], [0.0], [0.0]]])  # the second camera is 0.6 to the right
        >>> R1, R2, P1, P2, Q = stereo_rectify(K, K, torch.eye(3)[None], t, 101, 101)
        >>> P2[0].round(decimals=3) + 0.0
        tensor([[100.,   0.,  50., -60.],
                [  0., 100.,  50.,   0.],
                [  0.,   0.,   1.,   0.]])
    """
    check_optional(dist1, "dist1")
    check_optional(dist2, "dist2")
    _check_pair(K1, K2, R, t, dist1, dist2)
    half = _half_rotation(R.to(torch.float64))
    # The position of the second camera in the frame rotated by half.
    shift = small_matmul(half.transpose(1, 2), t.to(torch.float64))[..., 0]
    horizontal = shift[:, 0:1].abs() > shift[:, 1:2].abs()
    eye = torch.eye(3, dtype=torch.float64, device=t.device)
    axis = torch.where(horizontal, eye[0], eye[1])
    along = (axis * shift).sum(-1, keepdim=True)
    turn = _shortest_turn(shift, torch.where(along > 0, axis, -axis))
    R1, R2 = small_matmul(turn, half), small_matmul(turn, half.transpose(1, 2))
    # positive if it points along the axis: the rotation keeps the length
    baseline = torch.where(along > 0, 1.0, -1.0).to(along.dtype) * _length(shift)
    across = 1.0 - axis[:, 0:2]
    k1, k2 = K1.to(torch.float64), K2.to(torch.float64)
    focal = 0.5 * (focal_lengths(k1 + k2) * across).sum(-1, keepdim=True)
    c1 = _principal_point(k1, R1, focal, height, width, dist1)
    c2 = _principal_point(k2, R2, focal, height, width, dist2)
    mean = 0.5 * (c1 + c2)
    if zero_disparity:
        c1, c2 = mean, mean
    else:
        kept = axis[:, 0:2] > 0
        c1, c2 = torch.where(kept, c1, mean), torch.where(kept, c2, mean)
    P1 = _projection(focal, c1, torch.zeros_like(shift))
    P2 = _projection(focal, c2, axis * baseline * focal)
    Q = _reprojection(focal, c1, baseline, ((c1 - c2) * axis[:, 0:2]).sum(-1, keepdim=True))
    dtype = K1.dtype
    return R1.to(dtype), R2.to(dtype), P1.to(dtype), P2.to(dtype), Q.to(dtype)


def reproject_disparity_to_3d(disparity: Tensor, Q: Tensor) -> Tensor:
    """Convert a disparity map to 3D points: (X, Y, Z) / W of Q (x, y, disparity, 1), like
    ``cv2.reprojectImageTo3D``. :func:`chiasm.geometry.depth.depth_from_disparity` computes only Z, for two
    cameras with the same principal point.

    Args:
        disparity: (B, 1, H, W), x in the first image minus x in the second image (y for a vertical pair), in
            pixels, floating point.
        Q: (B, 4, 4), from :func:`stereo_rectify`.

    Returns:
        (B, H, W, 3), in the first rectified camera's frame. Points at infinity become very distant points.
        Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> Q = torch.tensor(
        ...     [[[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 100.0], [0.0, 0.0, 2.0, 0.0]]]
        ... )
        >>> reproject_disparity_to_3d(torch.full((1, 1, 1, 3), 10.0), Q)[0, 0]
        tensor([[-0.0500,  0.0000,  5.0000],
                [ 0.0000,  0.0000,  5.0000],
                [ 0.0500,  0.0000,  5.0000]])
    """
    check_one_channel(disparity, "disparity")
    check_rank(Q, 3, "(B, 4, 4)", "Q")
    check_matrix(Q, 4, 4, "Q")
    check_leading([disparity, Q], ["disparity", "Q"], [3, 2])
    d = disparity[:, 0]
    x = torch.arange(d.size(2), device=d.device).to(d.dtype)
    y = torch.arange(d.size(1), device=d.device).to(d.dtype)[:, None]
    q = Q[:, :, :, None, None]
    rows: List[Tensor] = []
    for i in range(4):
        rows.append(q[:, i, 0] * x + q[:, i, 1] * y + q[:, i, 2] * d + q[:, i, 3])
    w = rows[3]
    least = torch.where(w < 0, torch.full_like(w, -1e-8), torch.full_like(w, 1e-8))
    inverse = 1.0 / torch.where(w.abs() < 1e-8, least, w)
    return torch.stack([rows[0] * inverse, rows[1] * inverse, rows[2] * inverse], -1)


def _half_rotation(R: Tensor) -> Tensor:
    """The rotation (B, 3, 3) whose square is R: its quaternion is halfway between that of R and 1."""
    q = rotation_matrix_to_quaternion(R)
    q = torch.cat([q[..., 0:1] + 1.0, q[..., 1:]], -1)
    return quaternion_to_rotation_matrix(q / _length(q))


def _shortest_turn(v: Tensor, axis: Tensor) -> Tensor:
    """The rotation (B, 3, 3) by less than 90 degrees that rotates v (B, 3) to the direction of the unit
    vector axis (B, 3)."""
    u = v / _length(v)
    normal = vector_to_skew_symmetric_matrix(cross(u, axis))
    eye = torch.eye(3, dtype=v.dtype, device=v.device)
    return eye + normal + small_matmul(normal, normal) / (1.0 + (u * axis).sum(-1)[:, None, None])


def _length(v: Tensor) -> Tensor:
    return torch.sqrt((v * v).sum(-1, keepdim=True))


def _principal_point(
    K: Tensor, R: Tensor, focal: Tensor, height: int, width: int, dist: Optional[Tensor]
) -> Tensor:
    """The principal point (B, 2) that puts the mean of the rotated image corners at the image centre."""
    one = torch.ones([], dtype=focal.dtype, device=focal.device)
    size = torch.stack([one * (width - 1), one * (height - 1)], -1)
    corner = torch.tensor([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], dtype=K.dtype, device=K.device)
    corners = (corner * size).expand([K.size(0), 4, 2])
    if dist is not None:
        corners = undistort_points(corners, K, dist.to(K.dtype))
    seen = over_depth(small_matmul(with_one(from_pixels(corners, K[:, None])), R.transpose(1, 2)), 1e-12)
    return 0.5 * size - focal * seen.mean(1)


def _projection(focal: Tensor, centre: Tensor, last: Tensor) -> Tensor:
    """[diag(focal) with the principal point | last] (B, 3, 4)."""
    eye = torch.eye(3, dtype=focal.dtype, device=focal.device)
    left = focal[..., None] * (eye - eye[2][:, None] * eye[2])
    third = torch.cat([centre, torch.ones_like(focal)], -1)
    return torch.cat([left[..., 0:2], third[..., None], last[..., None]], -1)


def _reprojection(focal: Tensor, centre: Tensor, baseline: Tensor, offset: Tensor) -> Tensor:
    """Q (B, 4, 4): (x - cx, y - cy, focal, (offset - disparity) / baseline)."""
    zero, one = torch.zeros_like(focal), torch.ones_like(focal)
    rows = [
        torch.cat([one, zero, zero, -centre[:, 0:1]], -1),
        torch.cat([zero, one, zero, -centre[:, 1:2]], -1),
        torch.cat([zero, zero, zero, focal], -1),
        torch.cat([zero, zero, -1.0 / baseline, offset / baseline], -1),
    ]
    return torch.stack(rows, -2)


def _check_pair(
    K1: Tensor, K2: Tensor, R: Tensor, t: Tensor, dist1: Optional[Tensor], dist2: Optional[Tensor]
) -> None:
    check_rank(K1, 3, "(B, 3, 3)", "K1")
    check_matrix(K1, 3, 3, "K1")
    check_rank(K2, 3, "(B, 3, 3)", "K2")
    check_matrix(K2, 3, 3, "K2")
    check_rank(R, 3, "(B, 3, 3)", "R")
    check_matrix(R, 3, 3, "R")
    check_rank(t, 3, "(B, 3, 1)", "t")
    check_matrix(t, 3, 1, "t")
    check_leading([R, t], ["R", "t"], [2, 2])
    _check_batch(K1, R, t, "K1")
    _check_batch(K2, R, t, "K2")
    if dist1 is not None and dist1.dim() > 1:
        _check_batch(dist1, R, t, "dist1")
    if dist2 is not None and dist2.dim() > 1:
        _check_batch(dist2, R, t, "dist2")


def _check_batch(value: Tensor, R: Tensor, t: Tensor, name: str) -> None:
    """Raise unless ``value`` has the batch of R and t, or of 1."""
    batch = R.size(0) if t.size(0) == 1 else t.size(0)
    if value.size(0) != batch and value.size(0) != 1:
        raise ValueError(f"{name}: expected the batch of R and t, {batch}, or 1, got {list(value.shape)}")
