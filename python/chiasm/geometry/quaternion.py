"""Quaternions (w, x, y, z): products, rotated points, interpolation, averages."""

import math
from typing import Any, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_last,
    check_leading,
    check_number,
)
from ..primitives.core.modules import Module, hold
from ..primitives.geometry.angles import angle_of
from ..primitives.linalg.matrices import cross, largest_eigenvector
from .conversions.euler import euler_from_quaternion, quaternion_from_euler
from .conversions.rotations import (
    axis_angle_to_quaternion,
    normalize_quaternion,
    quaternion_to_axis_angle,
    quaternion_to_rotation_matrix,
    rotation_matrix_to_quaternion,
)

__all__ = [
    "Quaternion",
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
        t: (*) or (*, 1), floating point, or a number: 0 is q1, 1 is q2 (or -q2, the same rotation). With as
            many dimensions as q1 and a last one of size 1, it is (*, 1).

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
        part = _share(t, start, "q1") * way
    else:
        check_number(t, "t")
        part = t * way
    return quaternion_multiply(start, axis_angle_to_quaternion(part))


def _share(t: Tensor, each: Tensor, name: str) -> Tensor:
    """t (*) or (*, 1) as (*, 1), for ``each`` (*, n); raise unless the leading dimensions broadcast."""
    share = t if t.dim() > 0 and t.dim() == each.dim() and t.size(-1) == 1 else t[..., None]
    check_broadcastable(share, each, "t", name, 1, 1)
    return share


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
        check_leading([Q, w], ["Q", "w"], [2, 1])
        weighted = q * w.to(torch.float64)[..., None]
    m = (weighted[..., :, None] * q[..., None, :]).sum(-3)
    mean = largest_eigenvector(m.reshape(-1, 4, 4))
    mean = torch.where(mean[:, :1] < 0, -mean, mean).reshape(m[..., 0].shape)
    return mean.to(Q.dtype)


class Quaternion(Module):
    """Quaternions as an object, for eager Python, with this module's functions as methods. ``*`` with another
    is their product, with a number it scales; ``**`` t is exp(t log q): it multiplies the angle by t.

    Args:
        data: (*, 4) in the order w, x, y, z, floating point; a Parameter is learned.

    Raises:
        TypeError, ValueError: if data is not a floating-point (*, 4) tensor.

    Example:
        >>> quarter = Quaternion.from_axis_angle(torch.tensor([0.0, 0.0, torch.pi / 2]))
        >>> (quarter * quarter).to_axis_angle()
        tensor([0.0000, 0.0000, 3.1416])
    """

    data: Tensor

    def __init__(self, data: Tensor) -> None:
        super().__init__()
        check_last(data, 4, "data")
        hold(self, "data", data)

    def __getitem__(self, index: Any) -> "Quaternion":
        return Quaternion(self.data[index])

    def __neg__(self) -> "Quaternion":
        return Quaternion(-self.data)

    def __add__(self, right: "Quaternion") -> "Quaternion":
        return Quaternion(self.data + right.data)

    def __sub__(self, right: "Quaternion") -> "Quaternion":
        return Quaternion(self.data - right.data)

    def __mul__(self, right: Union["Quaternion", Tensor, float]) -> "Quaternion":
        if isinstance(right, Quaternion):
            return Quaternion(quaternion_multiply(*torch.broadcast_tensors(self.data, right.data)))
        return Quaternion(self.data * (right[..., None] if isinstance(right, Tensor) else right))

    def __rmul__(self, left: Union[Tensor, float]) -> "Quaternion":
        return self * left

    def __truediv__(self, right: Union["Quaternion", Tensor, float]) -> "Quaternion":
        return self * (right.inv() if isinstance(right, Quaternion) else 1.0 / right)

    def __pow__(self, t: Union[Tensor, float]) -> "Quaternion":
        power = torch.as_tensor(t, dtype=self.data.dtype, device=self.data.device)
        power = _share(power, self.data, "the quaternion")
        w, v = self.data[..., :1], self.data[..., 1:]
        length = torch.linalg.vector_norm(v, dim=-1, keepdim=True)
        angle, real = power * angle_of(length, w), length == 0
        one = torch.ones_like(length)
        limit = power * torch.cos(angle) / torch.where(w == 0, one, w)
        ratio = torch.where(real, limit, torch.sin(angle) / torch.where(real, one, length))
        # A negative number has no axis: x is taken. The sine is exactly 0 for whole powers.
        whole = power.detach().round()
        sine = torch.sin(math.pi * (power - whole)) * (1.0 - 2.0 * whole.remainder(2.0))
        beside = torch.where(real & (w < 0), sine, torch.zeros_like(sine))
        vector = ratio * v
        unit = torch.cat([torch.cos(angle), vector[..., :1] + beside, vector[..., 1:]], -1)
        return Quaternion(unit * self.norm(keepdim=True) ** power)

    @property
    def w(self) -> Tensor:
        """(*), the real part."""
        return self.data[..., 0]

    @property
    def x(self) -> Tensor:
        """(*)."""
        return self.data[..., 1]

    @property
    def y(self) -> Tensor:
        """(*)."""
        return self.data[..., 2]

    @property
    def z(self) -> Tensor:
        """(*)."""
        return self.data[..., 3]

    @property
    def real(self) -> Tensor:
        """(*), the real part; also ``scalar``."""
        return self.data[..., 0]

    scalar = real

    @property
    def vec(self) -> Tensor:
        """(*, 3), the vector part."""
        return self.data[..., 1:]

    @property
    def coeffs(self) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
        """w, x, y, z, each (*)."""
        return self.w, self.x, self.y, self.z

    @property
    def q(self) -> Tensor:
        """(*, 4), the tensor."""
        return self.data

    @property
    def shape(self) -> Tuple[int, ...]:
        """The tensor's shape."""
        return tuple(self.data.shape)

    @property
    def polar_angle(self) -> Tensor:
        """(*), the angle between the quaternion and the real axis, in radians: half of the rotation's."""
        return angle_of(torch.linalg.vector_norm(self.vec, dim=-1), self.real)

    def matrix(self) -> Tensor:
        """(*, 3, 3), the rotation matrices."""
        return quaternion_to_rotation_matrix(self.data)

    @classmethod
    def from_matrix(cls, matrix: Tensor, check_rotation: bool = False) -> "Quaternion":
        """From rotation matrices (*, 3, 3), as ``rotation_matrix_to_quaternion``."""
        return cls(rotation_matrix_to_quaternion(matrix, check_rotation=check_rotation))

    @classmethod
    def from_euler(cls, roll: Tensor, pitch: Tensor, yaw: Tensor) -> "Quaternion":
        """From angles (*) in radians, as ``quaternion_from_euler``."""
        return cls(torch.stack(quaternion_from_euler(roll, pitch, yaw), -1))

    def to_euler(self) -> Tuple[Tensor, Tensor, Tensor]:
        """Roll, pitch and yaw (*) in radians, as ``euler_from_quaternion``."""
        return euler_from_quaternion(self.w, self.x, self.y, self.z)

    @classmethod
    def from_axis_angle(cls, axis_angle: Tensor) -> "Quaternion":
        """From rotation vectors (*, 3) in radians."""
        return cls(axis_angle_to_quaternion(axis_angle))

    def to_axis_angle(self) -> Tensor:
        """(*, 3), the rotation vectors in radians."""
        return quaternion_to_axis_angle(self.data)

    @classmethod
    def from_coeffs(cls, w: float, x: float, y: float, z: float) -> "Quaternion":
        """From four numbers."""
        return cls(torch.tensor([w, x, y, z]))

    @classmethod
    def identity(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "Quaternion":
        """The rotation by nothing, (4,) or (batch_size, 4)."""
        one = torch.eye(4, device=device, dtype=dtype)[0]
        return cls(one if batch_size is None else one.repeat(batch_size, 1))

    @classmethod
    def random(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "Quaternion":
        """Rotations of equal probability, (4,) or (batch_size, 4), by PyTorch's generator.

        K. Shoemake, Uniform random rotations, Graphics Gems III, 1992.
        """
        size = [3] if batch_size is None else [3, batch_size]
        u, v, w = torch.rand(size, device=device, dtype=dtype).unbind()
        a, b = torch.sqrt(1.0 - u), torch.sqrt(u)
        v, w = 2.0 * math.pi * v, 2.0 * math.pi * w
        return cls(torch.stack([a * torch.sin(v), a * torch.cos(v), b * torch.sin(w), b * torch.cos(w)], -1))

    def slerp(self, q1: "Quaternion", t: Union[float, Tensor]) -> "Quaternion":
        """The rotations between this one (t = 0) and q1 (t = 1), as ``quaternion_slerp``."""
        return Quaternion(quaternion_slerp(self.data, q1.data, t))

    def norm(self, keepdim: bool = False) -> Tensor:
        """(*) or (*, 1), the lengths."""
        return torch.linalg.vector_norm(self.data, dim=-1, keepdim=keepdim)

    def squared_norm(self) -> Tensor:
        """(*), the squared lengths."""
        return self.data.square().sum(-1)

    def normalize(self) -> "Quaternion":
        """Of length 1."""
        return Quaternion(normalize_quaternion(self.data))

    def conj(self) -> "Quaternion":
        """The conjugates."""
        return Quaternion(quaternion_conjugate(self.data))

    def inv(self) -> "Quaternion":
        """The inverses."""
        return Quaternion(quaternion_inverse(self.data))
