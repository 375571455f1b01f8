"""Points and directions as objects, for eager Python: a thin cover of a tensor whose last dimension holds the
coordinates."""

from typing import Any, Callable, ClassVar, Dict, Optional, Sequence, Tuple, Union

import torch
import torch.nn.functional as F
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from ..primitives.core.checks import check_last, check_tensor

__all__ = ["Scalar", "Vector2", "Vector3"]


def __dir__() -> list[str]:
    return __all__


def bare(value: Any) -> Any:
    """The tensor of an object of this module; anything else as it is."""
    return value.data if isinstance(value, Scalar) else value


class Scalar:
    """Numbers (*), as ``Vector3.dot`` returns them. Torch's functions take them as a tensor, and arithmetic
    gives the same class.

    >>> Scalar(torch.tensor([1.0, 2.0])) * 2
    Scalar(tensor([2., 4.]))
    """

    def __init__(self, data: Tensor) -> None:
        check_tensor(data, "data")
        self.data = data

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.data})"

    def __len__(self) -> int:
        return len(self.data)

    @property
    def shape(self) -> torch.Size:
        """The tensor's shape."""
        return self.data.shape

    @property
    def dtype(self) -> torch.dtype:
        """The tensor's dtype."""
        return self.data.dtype

    @property
    def device(self) -> torch.device:
        """The tensor's device."""
        return self.data.device

    def to(self, *args: Any, **kwargs: Any) -> Self:
        """A copy of another dtype or on another device, with the arguments of ``Tensor.to``."""
        return type(self)(self.data.to(*args, **kwargs))

    def clone(self) -> Self:
        """A copy."""
        return type(self)(self.data.clone())

    def unwrap(self) -> Tensor:
        """The tensor."""
        return self.data

    def __add__(self, other: Any) -> Self:
        return type(self)(self.data + _beside(self, other))

    def __sub__(self, other: Any) -> Self:
        return type(self)(self.data - _beside(self, other))

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, _Vector) and not isinstance(self, _Vector):
            return other * self
        return type(self)(self.data * _beside(self, other))

    def __truediv__(self, other: Any) -> Self:
        return type(self)(self.data / _beside(self, other))

    def __radd__(self, other: Any) -> Self:
        return self + other

    def __rsub__(self, other: Any) -> Self:
        return type(self)(_beside(self, other) - self.data)

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __neg__(self) -> Self:
        return type(self)(-self.data)

    @classmethod
    def __torch_function__(
        cls,
        func: Callable[..., Any],
        types: Sequence[type],
        args: Tuple[Any, ...] = (),
        kwargs: Optional[Dict[str, Any]] = None,
    ) -> Any:
        named = {name: bare(value) for name, value in (kwargs or {}).items()}
        return func(*[_bare_list(a) for a in args], **named)


def _bare_list(value: Any) -> Any:
    return type(value)(map(bare, value)) if type(value) in (list, tuple) else bare(value)


def _beside(left: Scalar, right: Any) -> Any:
    """The other operand: numbers (*) beside vectors (*, D) are one for each vector."""
    vectors = isinstance(left, _Vector) and isinstance(right, Scalar) and not isinstance(right, _Vector)
    return bare(right)[..., None] if vectors else bare(right)


class _Vector(Scalar):
    """Vectors (*, D), D being the class's."""

    size: ClassVar[int]

    def __init__(self, vector: Tensor) -> None:
        check_last(vector, self.size, "vector")
        super().__init__(vector)

    def __getitem__(self, index: Any) -> Any:
        """Vectors by an index of the leading dimensions; a tensor where it reaches into the coordinates."""
        found = self.data[index]
        parts = index if isinstance(index, tuple) else (index,)
        taken = sum(p.dim() if isinstance(p, Tensor) and p.dtype == torch.bool else 1 for p in parts)
        inside = any(p is Ellipsis for p in parts) or taken >= self.data.dim()
        return found if inside else type(self)(found)

    @property
    def x(self) -> Tensor:
        """(*), the first coordinates."""
        return self.data[..., 0]

    @property
    def y(self) -> Tensor:
        """(*), the second coordinates."""
        return self.data[..., 1]

    def normalized(self) -> Self:
        """Vectors of length 1; a vector shorter than 1e-12 is divided by 1e-12."""
        return type(self)(F.normalize(self.data, dim=-1))

    def dot(self, right: Union[Self, Tensor]) -> Scalar:
        """(*), the inner products with other vectors."""
        return Scalar((self.data * bare(right)).sum(-1))

    def squared_norm(self) -> Scalar:
        """(*), the squared lengths."""
        return Scalar((self.data * self.data).sum(-1))

    @classmethod
    def random(
        cls,
        shape: Optional[Tuple[int, ...]] = None,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> Self:
        """Vectors of the leading shape ``shape``, with coordinates drawn from [0, 1)."""
        return cls(torch.rand(*(shape or ()), cls.size, device=device, dtype=dtype))

    @classmethod
    def _of(cls, coordinates: Sequence[Union[float, Tensor]], device: Any, dtype: Any) -> Self:
        made = [torch.as_tensor(v, device=device, dtype=dtype) for v in coordinates]
        return cls(torch.stack(torch.broadcast_tensors(*made), -1))


class Vector2(_Vector):
    """Vectors of the plane, (*, 2), floating point.

    >>> Vector2.from_coords(3.0, 4.0).normalized()
    Vector2(tensor([0.6000, 0.8000]))
    """

    size = 2

    @classmethod
    def from_coords(
        cls,
        x: Union[float, Tensor],
        y: Union[float, Tensor],
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> Self:
        """Vectors from numbers, or from tensors of one shape."""
        return cls._of((x, y), device, dtype)


class Vector3(_Vector):
    """Vectors of space, (*, 3), floating point.

    >>> Vector3(torch.tensor([1.0, 2.0, 2.0])).squared_norm()
    Scalar(9.0)
    """

    size = 3

    @property
    def z(self) -> Tensor:
        """(*), the third coordinates."""
        return self.data[..., 2]

    @classmethod
    def from_coords(
        cls,
        x: Union[float, Tensor],
        y: Union[float, Tensor],
        z: Union[float, Tensor],
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> Self:
        """Vectors from numbers, or from tensors of one shape."""
        return cls._of((x, y, z), device, dtype)
