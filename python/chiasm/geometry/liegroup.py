"""Rotations and rigid motions of the plane and of space as objects, for eager Python, with the functions of
`lie` as methods. ``a * b`` applies b first; ``a * points`` moves points."""

from typing import Any, ClassVar, Optional, Union

import torch
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from ..primitives.core.checks import check_last, check_matrix
from ..primitives.core.modules import Module, hold
from .lie import (
    se2_adjoint,
    se2_exp,
    se2_hat,
    se2_log,
    se2_vee,
    se3_adjoint,
    se3_exp,
    se3_hat,
    se3_log,
    se3_vee,
    so2_exp,
    so2_hat,
    so2_vee,
    so3_adjoint,
    so3_hat,
    so3_left_jacobian,
    so3_right_jacobian,
    so3_vee,
)
from .quaternion import Quaternion, quaternion_rotate
from .vector import Vector2, Vector3, bare

__all__ = ["Se2", "Se3", "So2", "So3"]


def __dir__() -> list[str]:
    return __all__


def _size(batch_size: Optional[int]) -> list[int]:
    return [] if batch_size is None else [batch_size]


class So2(Module):
    """Rotations of the plane.

    Args:
        z: (*), complex numbers of length 1.

    Raises:
        TypeError: if z is not complex.

    Example:
        >>> turn = So2.exp(torch.tensor(torch.pi / 2))
        >>> (turn * torch.tensor([1.0, 0.0])).round()
        tensor([-0., 1.])
    """

    z: Tensor

    def __init__(self, z: Tensor) -> None:
        super().__init__()
        if not (isinstance(z, Tensor) and z.is_complex()):
            raise TypeError(f"z: expected a complex tensor, got {getattr(z, 'dtype', type(z).__name__)}")
        hold(self, "z", z)

    def __getitem__(self, index: Any) -> "So2":
        return So2(self.z[index])

    def __mul__(self, right: Union["So2", Vector2, Tensor]) -> Any:
        """Another rotation, or points (*, 2)."""
        if isinstance(right, So2):
            return So2(self.z * right.z)
        points = bare(right)
        check_last(points, 2, "right")
        moved = torch.view_as_real(self.z * torch.view_as_complex(points.contiguous()))
        return Vector2(moved) if isinstance(right, Vector2) else moved

    @staticmethod
    def exp(theta: Tensor) -> "So2":
        """Rotations by angles (*) in radians."""
        return So2(torch.complex(torch.cos(theta), torch.sin(theta)))

    def log(self) -> Tensor:
        """(*), the angles in radians."""
        return torch.atan2(self.z.imag, self.z.real)

    @staticmethod
    def hat(theta: Tensor) -> Tensor:
        """``so2_hat``."""
        return so2_hat(theta)

    @staticmethod
    def vee(omega: Tensor) -> Tensor:
        """``so2_vee``."""
        return so2_vee(omega)

    def matrix(self) -> Tensor:
        """(*, 2, 2)."""
        return so2_exp(self.log())

    @classmethod
    def from_matrix(cls, matrix: Tensor) -> "So2":
        """From rotation matrices (*, 2, 2)."""
        check_matrix(matrix, 2, 2, "matrix")
        return So2(torch.complex(matrix[..., 0, 0], matrix[..., 1, 0]))

    @classmethod
    def identity(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "So2":
        """The rotation by nothing, () or (batch_size,)."""
        return So2.exp(torch.zeros(_size(batch_size), device=device, dtype=dtype))

    @classmethod
    def random(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "So2":
        """Rotations of equal probability, by PyTorch's generator."""
        return So2.exp(2.0 * torch.pi * torch.rand(_size(batch_size), device=device, dtype=dtype))

    def inverse(self) -> "So2":
        """The rotations back."""
        return So2(self.z.conj().resolve_conj())

    def adjoint(self) -> Tensor:
        """(*, 2, 2), identities: turns of a plane commute, so that a tangent does not change."""
        return torch.eye(2, dtype=self.z.real.dtype, device=self.z.device).expand(*self.z.shape, 2, 2)


class So3(Module):
    """Rotations of space.

    Args:
        q: unit quaternions.

    Example:
        >>> turn = So3.rot_z(torch.tensor(torch.pi / 2))
        >>> (turn * torch.tensor([1.0, 0.0, 0.0])).round()
        tensor([0., 1., 0.])
    """

    def __init__(self, q: Quaternion) -> None:
        super().__init__()
        if not isinstance(q, Quaternion):
            raise TypeError(f"q: expected a Quaternion, got {type(q).__name__}")
        self._q = q

    @property
    def q(self) -> Quaternion:
        """The quaternions."""
        return self._q

    def __getitem__(self, index: Any) -> "So3":
        return So3(self._q[index])

    def __mul__(self, right: Union["So3", Vector3, Tensor]) -> Any:
        """Another rotation, or points (*, 3)."""
        if isinstance(right, So3):
            return So3(self._q * right._q)
        moved = quaternion_rotate(self._q.data, bare(right))
        return Vector3(moved) if isinstance(right, Vector3) else moved

    @staticmethod
    def exp(v: Tensor) -> "So3":
        """Rotations by rotation vectors (*, 3) in radians."""
        return So3(Quaternion.from_axis_angle(v))

    def log(self) -> Tensor:
        """(*, 3), the rotation vectors in radians."""
        return self._q.to_axis_angle()

    @staticmethod
    def hat(v: Union[Vector3, Tensor]) -> Tensor:
        """``so3_hat``."""
        return so3_hat(bare(v))

    @staticmethod
    def vee(omega: Tensor) -> Tensor:
        """``so3_vee``."""
        return so3_vee(omega)

    def matrix(self) -> Tensor:
        """(*, 3, 3)."""
        return self._q.matrix()

    @classmethod
    def from_matrix(cls, matrix: Tensor, check_rotation: bool = False) -> "So3":
        """From rotation matrices (*, 3, 3)."""
        return So3(Quaternion.from_matrix(matrix, check_rotation))

    @classmethod
    def from_wxyz(cls, wxyz: Tensor) -> "So3":
        """From unit quaternions (*, 4)."""
        return So3(Quaternion(wxyz))

    @classmethod
    def identity(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "So3":
        """The rotation by nothing."""
        return So3(Quaternion.identity(batch_size, device, dtype))

    @classmethod
    def random(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "So3":
        """Rotations of equal probability, by PyTorch's generator."""
        return So3(Quaternion.random(batch_size, device, dtype))

    @classmethod
    def rot_x(cls, x: Tensor) -> "So3":
        """Rotations about the x axis by angles (*) in radians."""
        return cls.exp(_along(x, 0))

    @classmethod
    def rot_y(cls, y: Tensor) -> "So3":
        """Rotations about the y axis by angles (*) in radians."""
        return cls.exp(_along(y, 1))

    @classmethod
    def rot_z(cls, z: Tensor) -> "So3":
        """Rotations about the z axis by angles (*) in radians."""
        return cls.exp(_along(z, 2))

    def inverse(self) -> "So3":
        """The rotations back."""
        return So3(self._q.conj())

    def adjoint(self) -> Tensor:
        """(*, 3, 3), ``so3_adjoint``."""
        return so3_adjoint(self.matrix())

    @staticmethod
    def right_jacobian(vec: Tensor) -> Tensor:
        """``so3_right_jacobian``; also ``Jr``."""
        return so3_right_jacobian(vec)

    @staticmethod
    def left_jacobian(vec: Tensor) -> Tensor:
        """``so3_left_jacobian``; also ``Jl``."""
        return so3_left_jacobian(vec)

    Jr, Jl = right_jacobian, left_jacobian


def _along(value: Tensor, axis: int) -> Tensor:
    """Vectors (*, 3) that are 0 but along one axis."""
    zero = torch.zeros_like(value)
    return torch.stack([value if i == axis else zero for i in range(3)], -1)


class _Motion(Module):
    """A rotation, then a translation: what the motions of the plane and of space have in common."""

    #: The class of the rotations, and that of vectors.
    _rotations: ClassVar[Any]
    _vectors: ClassVar[Any]
    _rotation: Any
    _t: Tensor

    def _hold(self, rotation: Any, translation: Any) -> None:
        check_last(bare(translation), self._vectors.size, "translation")
        self._rotation = rotation
        hold(self, "_t", bare(translation))

    @property
    def rotation(self) -> Any:
        """The rotations; also ``r``."""
        return self._rotation

    @property
    def translation(self) -> Tensor:
        """(*, D), the translations; also ``t``."""
        return self._t

    r, t = rotation, translation

    def __getitem__(self, index: Any) -> Self:
        return type(self)(self.r[index], self.t[index])

    def __mul__(self, right: Any) -> Any:
        """Another motion, or points (*, D)."""
        if isinstance(right, type(self)):
            return type(self)(self.r * right.r, self.t + self.r * right.t)
        moved = self.r * bare(right) + self.t
        return self._vectors(moved) if isinstance(right, self._vectors) else moved

    def matrix(self) -> Tensor:
        """(*, D + 1, D + 1)."""
        return _rigid(self.r.matrix(), self.t)

    @classmethod
    def identity(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> Self:
        """The motion that moves nothing."""
        shift = torch.zeros([*_size(batch_size), cls._vectors.size], device=device, dtype=dtype)
        return cls(cls._rotations.identity(batch_size, device, dtype), shift)

    @classmethod
    def random(
        cls,
        batch_size: Optional[int] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> Self:
        """A random rotation, and translations in [0, 1), by PyTorch's generator."""
        shift = torch.rand([*_size(batch_size), cls._vectors.size], device=device, dtype=dtype)
        return cls(cls._rotations.random(batch_size, device, dtype), shift)

    def inverse(self) -> Self:
        """The motions back."""
        back = self.r.inverse()
        return type(self)(back, -(back * self.t))


class Se2(_Motion):
    """Rigid motions of the plane: a rotation, then a translation.

    Args:
        rotation: rotations (*).
        translation: (*, 2), floating point; a Parameter is learned.

    Example:
        >>> Se2.trans(torch.tensor(1.0), torch.tensor(2.0)) * torch.tensor([5.0, 5.0])
        tensor([6., 7.])
    """

    _rotations, _vectors = So2, Vector2

    def __init__(self, rotation: So2, translation: Union[Vector2, Tensor]) -> None:
        super().__init__()
        if not isinstance(rotation, So2):
            raise TypeError(f"rotation: expected a So2, got {type(rotation).__name__}")
        self._hold(rotation, translation)

    @property
    def rotation(self) -> So2:
        """The rotations; also ``so2`` and ``r``."""
        return self._rotation

    so2 = r = rotation

    @staticmethod
    def exp(v: Tensor) -> "Se2":
        """From tangents (*, 3), ``se2_exp``."""
        return Se2.from_matrix(se2_exp(v))

    def log(self) -> Tensor:
        """(*, 3), ``se2_log``."""
        return se2_log(self.matrix())

    @staticmethod
    def hat(v: Tensor) -> Tensor:
        """``se2_hat``."""
        return se2_hat(v)

    @staticmethod
    def vee(omega: Tensor) -> Tensor:
        """``se2_vee``."""
        return se2_vee(omega)

    @classmethod
    def from_matrix(cls, matrix: Tensor) -> "Se2":
        """From matrices (*, 3, 3)."""
        check_matrix(matrix, 3, 3, "matrix")
        return Se2(So2.from_matrix(matrix[..., :2, :2]), matrix[..., :2, 2])

    @classmethod
    def trans(cls, x: Tensor, y: Tensor) -> "Se2":
        """Translations (*)."""
        return Se2(So2.exp(torch.zeros_like(x)), torch.stack([x, y], -1))

    @classmethod
    def trans_x(cls, x: Tensor) -> "Se2":
        """Translations along x (*)."""
        return cls.trans(x, torch.zeros_like(x))

    @classmethod
    def trans_y(cls, y: Tensor) -> "Se2":
        """Translations along y (*)."""
        return cls.trans(torch.zeros_like(y), y)

    def adjoint(self) -> Tensor:
        """(*, 3, 3), ``se2_adjoint``."""
        return se2_adjoint(self.matrix())


class Se3(_Motion):
    """Rigid motions of space: a rotation, then a translation.

    Args:
        rotation: rotations (*), or their quaternions.
        translation: (*, 3), floating point; a Parameter is learned.

    Example:
        >>> motion = Se3.exp(torch.tensor([1.0, 2.0, 3.0, 0.0, 0.0, torch.pi]))
        >>> (motion.inverse() * motion * torch.tensor([5.0, 6.0, 7.0])).round()
        tensor([5., 6., 7.])
    """

    _rotations, _vectors = So3, Vector3

    def __init__(self, rotation: Union[So3, Quaternion], translation: Union[Vector3, Tensor]) -> None:
        super().__init__()
        if not isinstance(rotation, (So3, Quaternion)):
            raise TypeError(f"rotation: expected a So3 or a Quaternion, got {type(rotation).__name__}")
        self._hold(So3(rotation) if isinstance(rotation, Quaternion) else rotation, translation)

    @property
    def rotation(self) -> So3:
        """The rotations; also ``so3`` and ``r``."""
        return self._rotation

    so3 = r = rotation

    @property
    def quaternion(self) -> Quaternion:
        """The rotations' quaternions."""
        return self._rotation.q

    @staticmethod
    def exp(v: Tensor) -> "Se3":
        """From tangents (*, 6), ``se3_exp``."""
        return Se3(So3.exp(v[..., 3:]), se3_exp(v)[..., :3, 3])

    def log(self) -> Tensor:
        """(*, 6), ``se3_log``."""
        return se3_log(self.matrix())

    @staticmethod
    def hat(v: Tensor) -> Tensor:
        """``se3_hat``."""
        return se3_hat(v)

    @staticmethod
    def vee(omega: Tensor) -> Tensor:
        """``se3_vee``."""
        return se3_vee(omega)

    @classmethod
    def from_matrix(cls, matrix: Tensor, check_rotation: bool = False) -> "Se3":
        """From matrices (*, 4, 4)."""
        check_matrix(matrix, 4, 4, "matrix")
        return Se3(So3.from_matrix(matrix[..., :3, :3], check_rotation), matrix[..., :3, 3])

    @classmethod
    def from_qxyz(cls, qxyz: Tensor) -> "Se3":
        """From quaternions and translations, (*, 7): w, x, y, z, then x, y, z."""
        check_last(qxyz, 7, "qxyz")
        return Se3(So3.from_wxyz(qxyz[..., :4]), qxyz[..., 4:])

    @classmethod
    def rot_x(cls, x: Tensor) -> "Se3":
        """Rotations about the x axis by angles (*) in radians."""
        return Se3(So3.rot_x(x), _along(torch.zeros_like(x), 0))

    @classmethod
    def rot_y(cls, y: Tensor) -> "Se3":
        """Rotations about the y axis by angles (*) in radians."""
        return Se3(So3.rot_y(y), _along(torch.zeros_like(y), 0))

    @classmethod
    def rot_z(cls, z: Tensor) -> "Se3":
        """Rotations about the z axis by angles (*) in radians."""
        return Se3(So3.rot_z(z), _along(torch.zeros_like(z), 0))

    @classmethod
    def trans(cls, x: Tensor, y: Tensor, z: Tensor) -> "Se3":
        """Translations (*)."""
        shift = torch.stack([x, y, z], -1)
        return Se3(So3.exp(torch.zeros_like(shift)), shift)

    @classmethod
    def trans_x(cls, x: Tensor) -> "Se3":
        """Translations along x (*)."""
        return cls.trans(*_along(x, 0).unbind(-1))

    @classmethod
    def trans_y(cls, y: Tensor) -> "Se3":
        """Translations along y (*)."""
        return cls.trans(*_along(y, 1).unbind(-1))

    @classmethod
    def trans_z(cls, z: Tensor) -> "Se3":
        """Translations along z (*)."""
        return cls.trans(*_along(z, 2).unbind(-1))

    def adjoint(self) -> Tensor:
        """(*, 6, 6), ``se3_adjoint``."""
        return se3_adjoint(self.matrix())


def _rigid(rotation: Tensor, shift: Tensor) -> Tensor:
    """(*, n + 1, n + 1), the matrices of motions."""
    top = torch.cat([rotation, shift[..., None]], -1)
    last = torch.zeros_like(top[..., :1, :])
    last[..., -1] = 1.0
    return torch.cat([top, last], -2)
