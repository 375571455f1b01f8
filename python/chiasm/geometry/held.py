"""What boxes and key points of images, volumes and videos have in common."""

from typing import Any, Sequence, Union

import torch
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from .linalg import transform_points

__all__: list[str] = []


def __dir__() -> list[str]:
    return __all__


class Held:
    """A thin cover of points: (N, ..., D), or (B, N, ..., D) of a batch."""

    #: The number D of coordinates, and the rank of the points of one image.
    _axes: int
    _rank: int
    _data: Tensor

    def _with(self, data: Tensor, inplace: bool = False) -> Self:
        if inplace:
            self._data = data
            return self
        made = type(self).__new__(type(self))
        made.__dict__.update(self.__dict__)
        made._data = data
        return made

    def __len__(self) -> int:
        return len(self._data)

    def __getitem__(self, key: Any) -> Self:
        return self._with(self._data[key])

    def __setitem__(self, key: Any, value: Self) -> None:
        self._data[key] = value._data

    @property
    def data(self) -> Tensor:
        """The coordinates; the last pixel of a box is in it."""
        return self._data

    @property
    def shape(self) -> torch.Size:
        """The coordinates' shape."""
        return self._data.shape

    @property
    def device(self) -> torch.device:
        """The coordinates' device."""
        return self._data.device

    @property
    def dtype(self) -> torch.dtype:
        """The coordinates' dtype."""
        return self._data.dtype

    def type(self, dtype: torch.dtype) -> Self:
        """Change the coordinates' dtype."""
        self._data = self._data.to(dtype)
        return self

    def clone(self) -> Self:
        """A copy."""
        return self._with(self._data.clone())

    def index_put(
        self, indices: Sequence[Tensor], values: Union[Tensor, Self], inplace: bool = False
    ) -> Self:
        """The same with other coordinates at some places, as ``Tensor.index_put``."""
        other = values if isinstance(values, Tensor) else values._data
        return self._with(self._data.index_put(tuple(indices), other.to(self._data)), inplace)

    def _moved(self, M: Tensor) -> Tensor:
        """The coordinates by a matrix for each image, or one for all."""
        size = self._axes + 1
        matrix = M[None] if M.dim() == 2 else M
        if matrix.dim() != 3 or matrix.shape[1:] != (size, size):
            raise ValueError(
                f"M: expected shape (B, {size}, {size}) or ({size}, {size}), got {list(M.shape)}"
            )
        many = self._data if self._data.dim() > self._rank else self._data[None]
        if matrix.size(0) not in (1, many.size(0)):
            raise ValueError(f"M: expected 1 or {many.size(0)} matrices, got {matrix.size(0)}")
        moved = transform_points(matrix.to(many).expand(many.size(0), -1, -1), many.flatten(1, -2))
        return moved.reshape(self._data.shape)
