"""Rotations as axis-angle vectors, unit quaternions (w, x, y, z) and matrices.

Values and gradients are finite at the identity and at half a turn: near a removable singularity a series takes over,
and the other branch computes on a harmless input so that its gradient is no NaN times zero.
"""

import torch
from torch import Tensor

from ..primitives.checks import check_floating, check_last


def normalize_quaternion(quaternion: Tensor, eps: float = 1e-12) -> Tensor:
    """Scale quaternions to unit length.

    Args:
        quaternion: (*, 4), floating point.
        eps: lengths below this divide by it instead.

    Returns:
        (*, 4).

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> normalize_quaternion(torch.tensor([2.0, 0.0, 0.0, 0.0]))
        tensor([1., 0., 0., 0.])
    """
    check_last(quaternion, 4, "quaternion")
    squared = (quaternion * quaternion).sum(-1, keepdim=True)
    tiny = squared < eps * eps
    length = torch.sqrt(torch.where(tiny, torch.ones_like(squared), squared))
    return quaternion / torch.where(tiny, torch.full_like(length, eps), length)


def axis_angle_to_quaternion(axis_angle: Tensor) -> Tensor:
    """Unit quaternion (cos(a/2), sin(a/2) axis) of a rotation vector of length a, in radians.

    Args:
        axis_angle: (*, 3), floating point.

    Returns:
        (*, 4) in the order w, x, y, z.

    Raises:
        TypeError, ValueError: if axis_angle is not a floating-point (*, 3) tensor.

    Example:
        >>> axis_angle_to_quaternion(torch.zeros(3))
        tensor([1., 0., 0., 0.])
    """
    check_last(axis_angle, 3, "axis_angle")
    q = 0.25 * (axis_angle * axis_angle).sum(-1, keepdim=True)
    small = q < 1e-4
    half = torch.sqrt(torch.where(small, torch.ones_like(q), q))
    ratio = torch.where(small, 0.5 - q / 12.0 + q * q / 240.0 - q * q * q / 10080.0, 0.5 * torch.sin(half) / half)
    real = torch.where(small, 1.0 - q / 2.0 + q * q / 24.0 - q * q * q / 720.0, torch.cos(half))
    return torch.cat([real, axis_angle * ratio], -1)


def quaternion_to_axis_angle(quaternion: Tensor) -> Tensor:
    """Rotation vector, of length in [0, pi] radians, of a unit quaternion.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, of unit length; q and -q give the same rotation.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_to_axis_angle(torch.tensor([1.0, 0.0, 0.0, 0.0]))
        tensor([0., 0., 0.])
    """
    check_last(quaternion, 4, "quaternion")
    q = torch.where(quaternion[..., 0:1] < 0, -quaternion, quaternion)
    w, v = q[..., 0:1], q[..., 1:]
    squared = (v * v).sum(-1, keepdim=True)
    # The series is in |v| / w; where it applies, w is near 1.
    small = squared < 1e-4 * w * w
    length = torch.sqrt(torch.where(small, torch.ones_like(squared), squared))
    exact = 2.0 * torch.atan2(length, torch.where(small, torch.ones_like(w), w)) / length
    safe = torch.where(small, w, torch.ones_like(w))
    r = torch.where(small, squared, torch.zeros_like(squared)) / (safe * safe)
    series = 2.0 / safe * (1.0 - r / 3.0 + r * r / 5.0 - r * r * r / 7.0)
    return v * torch.where(small, series, exact)


def axis_angle_to_rotation_matrix(axis_angle: Tensor) -> Tensor:
    """Rotation matrix of a rotation vector, by Rodrigues' formula.

    Args:
        axis_angle: (*, 3) in radians, floating point. (Kornia takes (N, 3) only.)

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if axis_angle is not a floating-point (*, 3) tensor.

    Example:
        >>> axis_angle_to_rotation_matrix(torch.zeros(1, 3))[0].diagonal()
        tensor([1., 1., 1.])
    """
    check_last(axis_angle, 3, "axis_angle")
    return quaternion_to_rotation_matrix(axis_angle_to_quaternion(axis_angle))


def rotation_matrix_to_axis_angle(rotation_matrix: Tensor) -> Tensor:
    """Rotation vector, of length in [0, pi] radians, of a rotation matrix.

    Args:
        rotation_matrix: (*, 3, 3), orthonormal with determinant 1, floating point.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if rotation_matrix is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> rotation_matrix_to_axis_angle(torch.eye(3))
        tensor([0., 0., 0.])
    """
    return quaternion_to_axis_angle(rotation_matrix_to_quaternion(rotation_matrix))


def quaternion_to_rotation_matrix(quaternion: Tensor) -> Tensor:
    """Rotation matrix of a quaternion, which need not be of unit length.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, not zero, floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_to_rotation_matrix(torch.tensor([0.0, 1.0, 0.0, 0.0])).diagonal()
        tensor([ 1., -1., -1.])
    """
    check_last(quaternion, 4, "quaternion")
    w, x, y, z = quaternion[..., 0], quaternion[..., 1], quaternion[..., 2], quaternion[..., 3]
    s = 2.0 / (w * w + x * x + y * y + z * z)
    rows = [
        torch.stack([1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)], -1),
        torch.stack([s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)], -1),
        torch.stack([s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)], -1),
    ]
    return torch.stack(rows, -2)


def rotation_matrix_to_quaternion(rotation_matrix: Tensor) -> Tensor:
    """Unit quaternion with w >= 0 of a rotation matrix.

    S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1(3), 1978: of the four rows that are multiples
    of the quaternion, the one with the largest pivot. Kornia's may return the opposite sign, the same rotation.

    Args:
        rotation_matrix: (*, 3, 3), orthonormal with determinant 1, floating point.

    Returns:
        (*, 4) in the order w, x, y, z.

    Raises:
        TypeError, ValueError: if rotation_matrix is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> rotation_matrix_to_quaternion(torch.eye(3))
        tensor([1., 0., 0., 0.])
    """
    check_floating(rotation_matrix, "rotation_matrix")
    if rotation_matrix.dim() < 2 or rotation_matrix.size(-1) != 3 or rotation_matrix.size(-2) != 3:
        raise ValueError(f"rotation_matrix: expected shape (*, 3, 3), got {list(rotation_matrix.shape)}")
    m = rotation_matrix
    m00, m11, m22 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    a, b, c = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    d, e, f = m[..., 1, 0] + m[..., 0, 1], m[..., 0, 2] + m[..., 2, 0], m[..., 2, 1] + m[..., 1, 2]
    p0 = 1.0 + m00 + m11 + m22
    p1 = 1.0 + m00 - m11 - m22
    p2 = 1.0 - m00 + m11 - m22
    p3 = 1.0 - m00 - m11 + m22
    low = torch.where((p0 >= p1)[..., None], torch.stack([p0, a, b, c], -1), torch.stack([a, p1, d, e], -1))
    high = torch.where((p2 >= p3)[..., None], torch.stack([b, d, p2, f], -1), torch.stack([c, e, f, p3], -1))
    first = torch.maximum(p0, p1) >= torch.maximum(p2, p3)
    q = torch.where(first[..., None], low, high)
    q = q / torch.sqrt((q * q).sum(-1, keepdim=True))
    return torch.where(q[..., 0:1] < 0, -q, q)
