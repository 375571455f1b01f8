"""Roll, pitch and yaw: rotations about the fixed axes x, then y, then z, so that R = Rz(yaw) Ry(pitch)
Rx(roll)."""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_all_broadcastable, check_floating
from ...primitives.geometry.angles import angle_of


def euler_from_quaternion(w: Tensor, x: Tensor, y: Tensor, z: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """Roll, pitch and yaw of unit quaternions.

    If the pitch is +-90 degrees (gimbal lock), only a combination of roll and yaw is determined; then roll is
    0. Unlike in Kornia, the angles also describe the same rotation in this case, and their gradients are
    finite.

    Args:
        w: (*), the real part, floating point.
        x: (*), of w's shape, like y and z.
        y: (*).
        z: (*).

    Returns:
        Roll in (-pi, pi], pitch in [-pi / 2, pi / 2] and yaw in (-pi, pi], in radians.

    Raises:
        TypeError: if a part is not floating point.
        ValueError: if the shapes do not broadcast.

    Example:
        >>> half = torch.tensor(0.5).sqrt()
        >>> euler_from_quaternion(half, half, 0 * half, 0 * half)
        (tensor(1.5708), tensor(0.), tensor(0.))
    """
    for part, name in ((w, "w"), (x, "x"), (y, "y"), (z, "z")):
        check_floating(part, name)
    check_all_broadcastable([w, x, y, z], ["w", "x", "y", "z"])
    # R's last row is (-sin pitch, cos pitch sin roll, cos pitch cos roll).
    sine, a, b = 2.0 * (w * y - z * x), 2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)
    squared = a * a + b * b
    locked = squared < (1e-28 if w.dtype == torch.float64 else 1e-12)
    zero, one = torch.zeros_like(squared), torch.ones_like(squared)
    cosine = torch.where(locked, zero, torch.sqrt(torch.where(locked, one, squared)))
    roll = angle_of(torch.where(locked, zero, a), torch.where(locked, one, b))
    # The y axis of R Rx(-roll) is (-sin yaw, cos yaw, 0), which has length 1 for every pitch.
    s, c = torch.sin(roll), torch.cos(roll)
    yaw_sine = 2.0 * (s * (x * z + w * y) - c * (x * y - w * z))
    yaw_cosine = c * (1.0 - 2.0 * (x * x + z * z)) - s * 2.0 * (y * z - w * x)
    return roll, angle_of(sine, cosine), angle_of(yaw_sine, yaw_cosine)


def quaternion_from_euler(roll: Tensor, pitch: Tensor, yaw: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Unit quaternions of roll, pitch and yaw.

    Args:
        roll: (*) in radians, floating point.
        pitch: (*), of roll's shape.
        yaw: (*), of roll's shape.

    Returns:
        w, x, y and z, each (*).

    Raises:
        TypeError: if an angle is not floating point.
        ValueError: if the shapes do not broadcast.

    Example:
        >>> zero = torch.tensor(0.0)
        >>> quaternion_from_euler(zero, zero, zero)
        (tensor(1.), tensor(0.), tensor(0.), tensor(0.))
    """
    for part, name in ((roll, "roll"), (pitch, "pitch"), (yaw, "yaw")):
        check_floating(part, name)
    check_all_broadcastable([roll, pitch, yaw], ["roll", "pitch", "yaw"])
    cr, cp, cy = torch.cos(0.5 * roll), torch.cos(0.5 * pitch), torch.cos(0.5 * yaw)
    sr, sp, sy = torch.sin(0.5 * roll), torch.sin(0.5 * pitch), torch.sin(0.5 * yaw)
    w = cy * cp * cr + sy * sp * sr
    x = cy * cp * sr - sy * sp * cr
    y = sy * cp * sr + cy * sp * cr
    z = sy * cp * cr - cy * sp * sr
    return w, x, y, z
