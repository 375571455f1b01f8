"""Key points of images, volumes and videos as objects, for eager Python."""

from typing import Any

import torch
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from ..primitives.core.checks import check_floating
from .held import Held

__all__ = ["Keypoints", "Keypoints3D", "VideoKeypoints"]


def __dir__() -> list[str]:
    return __all__


class Keypoints(Held):
    """Key points x, y of images.

    Args:
        keypoints: (N, 2) or (B, N, 2).
        raise_if_not_floating_point: False makes float32 of whole numbers.

    Raises:
        TypeError: if keypoints is not floating point.
        ValueError: if keypoints is not of the shape above.

    Example:
        >>> points = Keypoints.from_tensor(torch.tensor([[1.0, 2.0], [3.0, 4.0]]))
        >>> points.transform_keypoints(torch.diag(torch.tensor([2.0, 2.0, 1.0]))).to_tensor()
        tensor([[2., 4.],
                [6., 8.]])
    """

    _axes, _rank = 2, 2

    def __init__(self, keypoints: Tensor, raise_if_not_floating_point: bool = True) -> None:
        data = keypoints
        if isinstance(data, Tensor) and not data.is_floating_point() and not raise_if_not_floating_point:
            data = data.to(torch.get_default_dtype())
        check_floating(data, "keypoints")
        if data.dim() not in (2, 3) or data.size(-1) != self._axes:
            n = self._axes
            raise ValueError(f"keypoints: expected shape (N, {n}) or (B, N, {n}), got {list(data.shape)}")
        self._data = data

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._data})"

    @classmethod
    def from_tensor(cls, keypoints: Tensor) -> Self:
        """From coordinates; whole numbers become float32."""
        return cls(keypoints, False)

    def to_tensor(self) -> Tensor:
        """The coordinates."""
        return self._data.clone()

    def pad(self, padding_size: Tensor) -> Self:
        """Move these points as a border around the image does: padding_size (B, 4) or (1, 4), left, right,
        top, bottom, and (B, 6) of volumes, with front and back."""
        self._data = self._data + self._first(padding_size)
        return self

    def unpad(self, padding_size: Tensor) -> Self:
        """The opposite of ``pad``."""
        self._data = self._data - self._first(padding_size)
        return self

    def _first(self, padding_size: Tensor) -> Tensor:
        many = padding_size.to(self._data)[..., ::2]
        count = self._data.size(0) if self._data.dim() == 3 else 1
        if many.dim() != 2 or many.size(1) != self._axes or many.size(0) not in (1, count):
            raise ValueError(
                f"padding_size: expected shape ({count}, {2 * self._axes}), got {list(padding_size.shape)}"
            )
        return many[:, None] if self._data.dim() == 3 else many[0]

    def transform_keypoints(self, M: Tensor, inplace: bool = False) -> Self:
        """The points moved by matrices in pixels, (B, 3, 3) or (3, 3); of volumes (B, 4, 4) or (4, 4)."""
        return self._with(self._moved(M), inplace)

    def transform_keypoints_(self, M: Tensor) -> Self:
        """``transform_keypoints`` of these points themselves."""
        return self.transform_keypoints(M, inplace=True)


class VideoKeypoints(Keypoints):
    """Key points of videos, (B, T, N, 2), kept as (B T, N, 2).

    Example:
        >>> points = VideoKeypoints.from_tensor(torch.ones(2, 5, 3, 2))
        >>> points.data.shape, points.to_tensor().shape
        (torch.Size([10, 3, 2]), torch.Size([2, 5, 3, 2]))
    """

    temporal_channel_size: int

    @classmethod
    def from_tensor(cls, keypoints: Tensor) -> Self:
        """From coordinates (B, T, N, 2); whole numbers become float32."""
        if keypoints.dim() != 4:
            raise ValueError(f"keypoints: expected shape (B, T, N, 2), got {list(keypoints.shape)}")
        made = cls(keypoints.flatten(0, 1), False)
        made.temporal_channel_size = keypoints.size(1)
        return made

    def to_tensor(self) -> Tensor:
        """(B, T, N, 2), the coordinates."""
        return self._videos().clone()

    def _videos(self) -> Tensor:
        return self._data.unflatten(0, (-1, self.temporal_channel_size))

    def __getitem__(self, key: Any) -> Self:
        """Whole videos."""
        videos = self._videos()
        found = videos[key]
        found = found[None] if found.dim() == 3 else found
        if found.shape[1:] != videos.shape[1:]:
            raise IndexError(
                f"key: expected one that selects whole videos of {list(videos.shape)}, got {key!r}"
            )
        return self._with(found.flatten(0, 1))

    def __setitem__(self, key: Any, value: Self) -> None:
        self._videos()[key] = value._videos()


class Keypoints3D(Keypoints):
    """Key points x, y, z of volumes, (N, 3) or (B, N, 3).

    Example:
        >>> Keypoints3D(torch.zeros(2, 3)).pad(torch.tensor([[1, 0, 2, 0, 3, 0]])).data[0]
        tensor([1., 2., 3.])
    """

    _axes = 3
