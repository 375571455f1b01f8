"""Quaternions (w, x, y, z): products, rotated points, interpolation, averages."""

from typing import Optional, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_broadcastable, check_floating, check_last, check_number
from ..primitives.linalg.matrices import cross, largest_eigenvector
from .conversions.rotations import axis_angle_to_quaternion, normalize_quaternion, quaternion_to_axis_angle

__all__ = [
    "average_quaternions",
    "quaternion_conjugate",
    "quaternion_inverse",
    "quaternion_multiply",
    "quaternion_rotate",
    "quaternion_slerp",
]


def __dir__() -> list[str]:
    return __all__


def quaternion_multiply(q1: Tensor, q2: Tensor) -> Tensor:
    """Hamilton product; as rotations, q2 is applied first, then q1.

    Args:
        q1: (*, 4) in the order w, x, y, z, floating point.
        q2: (*, 4), of q1's shape or broadcast with it.

    Returns:
        (*, 4).

    Raises:
        TypeError, ValueError: if an argument is not a floating-point (*, 4) tensor.

    Example:
        >>> i, j = torch.tensor([0.0, 1.0, 0.0, 0.0]), torch.tensor([0.0, 0.0, 1.0, 0.0])
        >>> quaternion_multiply(i, j)
        tensor([0., 0., 0., 1.])
    """
    check_last(q1, 4, "q1")
    check_last(q2, 4, "q2")
    check_broadcastable(q2, q1, "q2", "q1", 1, 1)
    w1, x1, y1, z1 = q1[..., 0], q1[..., 1], q1[..., 2], q1[..., 3]
    w2, x2, y2, z2 = q2[..., 0], q2[..., 1], q2[..., 2], q2[..., 3]
    parts = [
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    ]
    return torch.stack(parts, -1)


def quaternion_conjugate(quaternion: Tensor) -> Tensor:
    """The conjugate, with a negated vector part; for a unit quaternion it is the inverse rotation.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, floating point.

    Returns:
        (*, 4).

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_conjugate(torch.tensor([1.0, 2.0, 3.0, 4.0]))
        tensor([ 1., -2., -3., -4.])
    """
    check_last(quaternion, 4, "quaternion")
    return torch.cat([quaternion[..., :1], -quaternion[..., 1:]], -1)


def quaternion_inverse(quaternion: Tensor) -> Tensor:
    """The inverse: the conjugate divided by the squared length.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, floating point.

    Returns:
        (*, 4); 0 for 0, which has no inverse.

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_inverse(torch.tensor([0.0, 2.0, 0.0, 0.0]))
        tensor([ 0.0000, -0.5000, -0.0000, -0.0000])
    """
    conjugate = quaternion_conjugate(quaternion)
    squared = (quaternion * quaternion).sum(-1, keepdim=True)
    return conjugate / torch.where(squared == 0, torch.ones_like(squared), squared)


def quaternion_rotate(quaternion: Tensor, points: Tensor) -> Tensor:
    """Rotate points by unit quaternions: the vector part of q (0, p) q*.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, of unit length, floating point.
        points: (*, 3), with leading dimensions equal to those of quaternion or broadcast with them:
            quaternions (N, 4) rotate each of N points differently, (4,) or (1, 4) rotates all points.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> half = torch.tensor(0.5).sqrt()
        >>> quaternion_rotate(
        ...     torch.stack([half, 0 * half, 0 * half, half]), torch.tensor([1.0, 0.0, 0.0])
        ... ).round(decimals=4)
        tensor([0., 1., 0.])
    """
    check_last(quaternion, 4, "quaternion")
    check_last(points, 3, "points")
    check_broadcastable(points, quaternion, "points", "quaternion", 1, 1)
    w, v = quaternion[..., :1], quaternion[..., 1:]
    twice = 2.0 * cross(v, points)
    return points + w * twice + cross(v, twice)


def quaternion_slerp(q1: Tensor, q2: Tensor, t: Union[float, Tensor]) -> Tensor:
    """Interpolate rotations at constant angular speed, along the shorter of the two arcs.

    K. Shoemake, Animating rotation with quaternion curves, SIGGRAPH 1985, in the form q1 (q1^-1 q2)^t, which
    does not divide by a small sine.

    Args:
        q1: (*, 4) in the order w, x, y, z, floating point; it is scaled to unit length.
        q2: (*, 4), of q1's shape; it is scaled to unit length.
        t: (*), floating point, or a number: 0 is q1, 1 is q2 (or -q2, the same rotation).

    Returns:
        (*, 4), of unit length.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or not of the shape above.

    Example:
        >>> quaternion_slerp(torch.tensor([1.0, 0.0, 0.0, 0.0]), torch.tensor([0.0, 1.0, 0.0, 0.0]), 0.5)
        tensor([0.7071, 0.7071, 0.0000, 0.0000])
    """
    check_last(q1, 4, "q1")
    check_last(q2, 4, "q2")
    start, end = normalize_quaternion(q1), normalize_quaternion(q2)
    way = quaternion_to_axis_angle(quaternion_multiply(quaternion_conjugate(start), end))
    if isinstance(t, Tensor):
        check_floating(t, "t")
        check_broadcastable(t, way, "t", "q1", 0, 1)
        part = t[..., None] * way
    else:
        check_number(t, "t")
        part = t * way
    return quaternion_multiply(start, axis_angle_to_quaternion(part))


def average_quaternions(Q: Tensor, w: Optional[Tensor] = None) -> Tensor:
    """The mean rotation of unit quaternions. It maximizes the weighted sum of the squared cosines of half the
    angles to the given rotations.

    F. L. Markley et al., Averaging quaternions, J. Guidance, Control, and Dynamics 30(4), 2007: the
    eigenvector of sum w q q^T of the largest eigenvalue, computed in float64. Signs of the quaternions do not
    matter.

    Args:
        Q: (*, N, 4) in the order w, x, y, z, of unit length, floating point.
        w: (*, N), not negative; ones by default.

    Returns:
        (*, 4), with w >= 0. Differentiable in both. If the two largest eigenvalues are equal, the mean is not
        unique and the result is an arbitrary unit quaternion.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> average_quaternions(torch.tensor([[1.0, 0.0, 0.0, 0.0], [0.6, 0.8, 0.0, 0.0]]))
        tensor([0.8944, 0.4472, 0.0000, 0.0000])
    """
    check_last(Q, 4, "Q")
    if Q.dim() < 2:
        raise ValueError(f"Q: expected shape (*, N, 4), got {list(Q.shape)}")
    if Q.size(-2) < 1:
        raise ValueError(f"Q: expected at least one quaternion, got {list(Q.shape)}")
    q = Q.to(torch.float64)
    weighted = q
    if w is not None:
        check_floating(w, "w")
        if w.dim() + 1 != Q.dim() or w.size(-1) != Q.size(-2):
            raise ValueError(f"w: expected shape (*, N) for Q {list(Q.shape)}, got {list(w.shape)}")
        weighted = q * w.to(torch.float64)[..., None]
    m = (weighted[..., :, None] * q[..., None, :]).sum(-3).reshape(-1, 4, 4)
    mean = largest_eigenvector(m)
    mean = torch.where(mean[:, :1] < 0, -mean, mean).reshape(Q[..., 0, :].shape)
    return mean.to(Q.dtype)
