"""Rotations as axis-angle vectors, unit quaternions (w, x, y, z) and matrices.

Values and gradients are finite at the identity and at 180 degrees: near a removable singularity a series is
used, and the other branch gets a harmless input, so that its gradient is not NaN times zero.
"""

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_matrix
from ...primitives.geometry.angles import angle_of
from ...primitives.linalg.matrices import cross, small_matmul
from ...primitives.numbers.loss_reduction import narrowed, widened


def normalize_quaternion(quaternion: Tensor, eps: float = 1e-12) -> Tensor:
    """Scale quaternions to unit length.

    Args:
        quaternion: (*, 4), floating point.
        eps: the least divisor; a smaller length is replaced by eps.

    Returns:
        (*, 4).

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> normalize_quaternion(torch.tensor([2.0, 0.0, 0.0, 0.0]))
        tensor([1., 0., 0., 0.])
    """
    check_last(quaternion, 4, "quaternion")
    q = widened(quaternion)  # float16 has no number as small as eps
    squared = (q * q).sum(-1, keepdim=True)
    tiny = squared < eps * eps
    length = torch.sqrt(torch.where(tiny, torch.ones_like(squared), squared))
    return narrowed(q / torch.where(tiny, torch.full_like(length, eps), length), quaternion)


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
    return _exponential(0.5 * axis_angle)


def _exponential(v: Tensor) -> Tensor:
    """(cos |v|, v sin |v| / |v|) of vectors (*, 3)."""
    # For large vectors the squares are those of the unit direction, so that they do not overflow.
    largest = v.detach().abs().amax(-1, keepdim=True)
    scale = torch.where(largest > 50.0, largest, torch.ones_like(largest))
    u = v / scale
    q = (u * u).sum(-1, keepdim=True)
    small = q < 1e-4
    length = scale * torch.sqrt(torch.where(small, torch.ones_like(q), q))
    s = torch.where(small, q, torch.zeros_like(q))
    ratio = torch.where(small, 1.0 - s / 6.0 + s * s / 120.0 - s * s * s / 5040.0, torch.sin(length) / length)
    real = torch.where(small, 1.0 - s / 2.0 + s * s / 24.0 - s * s * s / 720.0, torch.cos(length))
    return torch.cat([real, v * ratio], -1)


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
    q = widened(quaternion)
    q = torch.where(q[..., 0:1] < 0, -q, q)
    v = q[..., 1:]
    turn = 2.0 * v * _angle_over_length(q[..., 0:1], (v * v).sum(-1, keepdim=True), 1e-12)
    return narrowed(turn, quaternion)


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


def rotation_matrix_to_axis_angle(rotation_matrix: Tensor, check_rotation: bool = False) -> Tensor:
    """Rotation vector, of length in [0, pi] radians, of a rotation matrix.

    Args:
        rotation_matrix: (*, 3, 3), orthonormal with determinant 1, floating point.
        check_rotation: True checks the values and raises an error if a matrix is not a rotation; such a call
            cannot be exported.

    Returns:
        (*, 3).

    Raises:
        TypeError, ValueError: if rotation_matrix is not a floating-point (*, 3, 3) tensor, or check_rotation
            finds that it is not a rotation.

    Example:
        >>> rotation_matrix_to_axis_angle(torch.eye(3))
        tensor([0., 0., 0.])
    """
    return quaternion_to_axis_angle(rotation_matrix_to_quaternion(rotation_matrix, 1e-8, check_rotation))


def quaternion_to_rotation_matrix(quaternion: Tensor) -> Tensor:
    """Rotation matrix of a quaternion, which need not be of unit length.

    Args:
        quaternion: (*, 4) in the order w, x, y, z, floating point.

    Returns:
        (*, 3, 3); the identity for a quaternion of zeros, as in Kornia.

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_to_rotation_matrix(torch.tensor([0.0, 1.0, 0.0, 0.0])).diagonal()
        tensor([ 1., -1., -1.])
    """
    check_last(quaternion, 4, "quaternion")
    w, x, y, z = quaternion[..., 0], quaternion[..., 1], quaternion[..., 2], quaternion[..., 3]
    square = w * w + x * x + y * y + z * z
    s = 2.0 / torch.where(square == 0, torch.ones_like(square), square)
    rows = [
        torch.stack([1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)], -1),
        torch.stack([s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)], -1),
        torch.stack([s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)], -1),
    ]
    return torch.stack(rows, -2)


def rotation_matrix_to_quaternion(
    rotation_matrix: Tensor, eps: float = 1e-8, check_rotation: bool = False
) -> Tensor:
    """Unit quaternion with w >= 0 of a rotation matrix.

    S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1(3), 1978: four vectors are
    multiples of the quaternion; the one with the largest pivot is used. Kornia may return the opposite sign,
    which is the same rotation.

    Args:
        rotation_matrix: (*, 3, 3), orthonormal with determinant 1, floating point.
        eps: not used, for compatibility with Kornia: the largest pivot is at least 1, so there is no small
            divisor.
        check_rotation: True checks the values and raises an error if a matrix is not a rotation; such a call
            cannot be exported.

    Returns:
        (*, 4) in the order w, x, y, z.

    Raises:
        TypeError, ValueError: if rotation_matrix is not a floating-point (*, 3, 3) tensor, or check_rotation
            finds that it is not a rotation.

    Example:
        >>> rotation_matrix_to_quaternion(torch.eye(3))
        tensor([1., 0., 0., 0.])
    """
    check_matrix(rotation_matrix, 3, 3, "rotation_matrix")
    if check_rotation:
        require_rotation(rotation_matrix, "rotation_matrix")
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


def quaternion_log_to_exp(quaternion: Tensor, eps: float = 1e-8) -> Tensor:
    """Exponential of pure quaternions (0, v): (cos |v|, v sin |v| / |v|).

    Args:
        quaternion: (*, 3), the vector part, floating point: half a rotation vector, in radians.
        eps: not used, for compatibility with Kornia: near 0 a series is used.

    Returns:
        (*, 4) in the order w, x, y, z, of unit length.

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 3) tensor.

    Example:
        >>> quaternion_log_to_exp(torch.tensor([torch.pi / 2, 0.0, 0.0])).round(decimals=4)
        tensor([-0., 1., 0., 0.])
    """
    check_last(quaternion, 3, "quaternion")
    return _exponential(quaternion)


def quaternion_exp_to_log(quaternion: Tensor, eps: float = 1e-8) -> Tensor:
    """Vector part of the logarithm of unit quaternions: the inverse of `quaternion_log_to_exp`, of length in
    [0, pi].

    Args:
        quaternion: (*, 4) in the order w, x, y, z, of unit length, floating point. Although q and -q are the
            same rotation, their logarithms differ.
        eps: near -1, where every vector of length pi is a solution, the vector part is divided by a length of
            at least eps.

    Returns:
        (*, 3): half a rotation vector, in radians; 0 for 1 and for -1.

    Raises:
        TypeError, ValueError: if quaternion is not a floating-point (*, 4) tensor.

    Example:
        >>> quaternion_exp_to_log(torch.tensor([0.0, 0.0, 0.0, 1.0]))
        tensor([0.0000, 0.0000, 1.5708])
    """
    check_last(quaternion, 4, "quaternion")
    q = widened(quaternion)
    v = q[..., 1:]
    return narrowed(v * _angle_over_length(q[..., 0:1], (v * v).sum(-1, keepdim=True), eps), quaternion)


def vector_to_skew_symmetric_matrix(vec: Tensor) -> Tensor:
    """The matrix whose product with a vector is the cross product: [v]x u = v x u.

    Args:
        vec: (*, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if vec is not a floating-point (*, 3) tensor.

    Example:
        >>> vector_to_skew_symmetric_matrix(torch.tensor([1.0, 2.0, 3.0]))
        tensor([[ 0., -3.,  2.],
                [ 3.,  0., -1.],
                [-2.,  1.,  0.]])
    """
    check_last(vec, 3, "vec")
    x, y, z = vec[..., 0], vec[..., 1], vec[..., 2]
    zero = torch.zeros_like(x)
    rows = [torch.stack([zero, -z, y], -1), torch.stack([z, zero, -x], -1), torch.stack([-y, x, zero], -1)]
    return torch.stack(rows, -2)


def require_rotation(matrix: Tensor, name: str) -> None:
    """Raise ValueError unless every (3, 3) matrix is a rotation, within 1e-4 (1e-9 in float64). This reads
    the values.

    >>> require_rotation(torch.eye(3), "R")
    """
    eye = torch.eye(3, dtype=matrix.dtype, device=matrix.device)
    error = float((small_matmul(matrix, matrix.transpose(-1, -2)) - eye).abs().max())
    normal = cross(matrix[..., 0, :], matrix[..., 1, :])
    mirrored = float((normal * matrix[..., 2, :]).sum(-1).min()) < 0.0
    if mirrored or not error <= (1e-9 if matrix.dtype == torch.float64 else 1e-4):
        raise ValueError(
            f"{name}: expected rotation matrices, got |R R^T - I| = {error}, some determinant negative:"
            f" {mirrored}"
        )


def _angle_over_length(w: Tensor, squared: Tensor, eps: float) -> Tensor:
    """atan2(|v|, w) / |v| for |v|^2 = squared: half the angle of a quaternion (w, v), over the length of v,
    which is at least eps."""
    # The series is in |v| / w; where it applies, w is near 1.
    small = (squared < 1e-4 * w * w) & (w > 0)
    tiny = squared < eps * eps
    length = torch.sqrt(torch.where(small | tiny, torch.ones_like(squared), squared))
    length = torch.where(tiny, torch.full_like(length, eps), length)
    exact = angle_of(length, torch.where(small, torch.ones_like(w), w)) / length
    safe = torch.where(small, w, torch.ones_like(w))
    r = torch.where(small, squared, torch.zeros_like(squared)) / (safe * safe)
    return torch.where(small, (1.0 - r / 3.0 + r * r / 5.0 - r * r * r / 7.0) / safe, exact)


# Older names, which Kornia still has.
angle_axis_to_quaternion = axis_angle_to_quaternion
angle_axis_to_rotation_matrix = axis_angle_to_rotation_matrix
quaternion_to_angle_axis = quaternion_to_axis_angle
rotation_matrix_to_angle_axis = rotation_matrix_to_axis_angle
