"""Boxes of images, volumes and videos as objects, for eager Python: they hold vertices, know their format and
go where an image's matrix leads."""

from typing import Any, List, Optional, Tuple, Union

import torch
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from ..primitives.core.checks import check_choice, check_floating
from .bbox import bbox_to_mask, bbox_to_mask3d, infer_bbox_shape, infer_bbox_shape3d, is_bbox3d
from .held import Held

__all__ = ["Boxes", "Boxes3D", "VideoBoxes"]

#: Formats in two and three dimensions. "plus": the last pixel belongs to the box, and width is x2 - x1 + 1.
_MODES = ["xyxy", "xyxy_plus", "xywh", "vertices", "vertices_plus"]
_MODES_3D = ["xyzxyz", "xyzxyz_plus", "xyzwhd"]


def __dir__() -> list[str]:
    return __all__


class _Boxes(Held):
    """Vertices (N, V, D) or (B, N, V, D), and what all kinds of boxes do with them."""

    _rank = 3

    def __init__(self, data: Tensor, mode: str, counts: Optional[List[int]] = None) -> None:
        self._data, self._mode, self._counts = data, mode, counts

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._data}, mode='{self._mode}')"

    @property
    def mode(self) -> str:
        """The format that ``to_tensor`` returns if it is not told another."""
        return self._mode

    def to(self, device: Optional[torch.device] = None, dtype: Optional[torch.dtype] = None) -> Self:
        """Move these boxes to a device or another floating-point dtype."""
        if dtype is not None and not dtype.is_floating_point:
            raise ValueError(f"dtype: expected a floating-point type, got {dtype}")
        self._data = self._data.to(device=device, dtype=dtype)
        return self

    def __getitem__(self, key: Any) -> Self:
        made = super().__getitem__(key)
        made._counts = None
        return made

    def transform_boxes(self, M: Tensor, inplace: bool = False) -> Self:
        """The boxes moved by matrices in pixels, (B, 3, 3) or (B, 4, 4) of volumes: all vertices, so that a
        rotated box stays one."""
        return self._with(self._moved(M), inplace)

    def transform_boxes_(self, M: Tensor) -> Self:
        """``transform_boxes`` of these boxes themselves."""
        return self.transform_boxes(M, inplace=True)


class Boxes(_Boxes):
    """Boxes of images. ``Boxes.from_tensor`` takes the usual formats.

    Args:
        boxes: vertices (N, 4, 2) or (B, N, 4, 2), clockwise from the top left, whose last pixel is in the box
            ("vertices_plus"); or a list of (N, 4, 2), one for each image, which is padded by zeros.
        raise_if_not_floating_point: False makes float32 of whole numbers.
        mode: the format that ``to_tensor`` returns by default.

    Raises:
        TypeError: if boxes are not floating point.
        ValueError: if the shape or the mode is not as above.

    Example:
        >>> boxes = Boxes.from_tensor(torch.tensor([[[1.0, 2.0, 4.0, 6.0]]]), "xyxy")
        >>> matrix = torch.tensor([[[0.0, -1.0, 9.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
        >>> boxes.transform_boxes(matrix).to_tensor()
        tensor([[[4., 1., 8., 4.]]])
    """

    _axes = 2

    def __init__(
        self,
        boxes: Union[Tensor, List[Tensor]],
        raise_if_not_floating_point: bool = True,
        mode: str = "vertices_plus",
    ) -> None:
        check_choice(mode, _MODES, "mode")
        data, counts = _padded(boxes, raise_if_not_floating_point)
        if data.dim() not in (3, 4) or data.shape[-2:] != (4, 2):
            raise ValueError(f"boxes: expected shape (N, 4, 2) or (B, N, 4, 2), got {list(data.shape)}")
        super().__init__(data, mode, counts)

    @classmethod
    def from_tensor(
        cls, boxes: Union[Tensor, List[Tensor]], mode: str = "xyxy", validate_boxes: bool = True
    ) -> "Boxes":
        """From boxes (N, 4) or (B, N, 4), or vertices (N, 4, 2) or (B, N, 4, 2), or a list of the unbatched.

        Args:
            boxes: the boxes; whole numbers become float32.
            mode: "xyxy" (x2 - x1 is the width), "xyxy_plus" (x2 is the last pixel), "xywh", "vertices" or
                "vertices_plus".
            validate_boxes: True raises ValueError if a width or a height is not positive, or a vertex is not
                finite.
        """
        check_choice(mode, _MODES, "mode")
        data, counts = _padded(boxes, False)
        last = (4, 2) if mode.startswith("vertices") else (4,)
        if data.dim() not in (len(last) + 1, len(last) + 2) or tuple(data.shape[-len(last) :]) != last:
            shape = ", ".join(map(str, last))
            raise ValueError(f"boxes: expected shape (N, {shape}) or (B, N, {shape}), got {list(data.shape)}")
        if last == (4, 2):
            made = data - _beyond(data) if mode == "vertices" else data
            if validate_boxes and not bool(made.isfinite().all()):
                raise ValueError("boxes: expected finite coordinates")
        else:
            first, second = data[..., :2], data[..., 2:]
            end = first + second - 1.0 if mode == "xywh" else second - (1.0 if mode == "xyxy" else 0.0)
            real = (end - first + 1.0 > 0.0).all(-1)
            if counts is not None:
                real = real | ~_present(counts, data)
            if validate_boxes and not bool(real.all()):
                raise ValueError("boxes: expected positive widths and heights")
            made = _corners(first, end)
        if counts is not None:  # the vertices of no box are 0, whatever the format
            made = torch.where(_present(counts, data)[..., None, None], made, torch.zeros_like(made))
        boxes_made = cls.__new__(cls)
        _Boxes.__init__(boxes_made, made, mode, counts)
        return boxes_made

    def to_tensor(self, mode: Optional[str] = None, as_padded_sequence: bool = False) -> Any:
        """The boxes in a format, by default their own; of boxes that are not along the axes, the least that
        hold them (``data`` has their vertices). Boxes of a list come back as a list, or as
        a padded tensor."""
        wanted = self._mode if mode is None else mode
        check_choice(wanted, _MODES, "mode")
        first, last = self._data.amin(-2), self._data.amax(-2)
        end = last if wanted.endswith("plus") else last + 1.0
        if wanted.startswith("vertices"):
            made = _corners(first, end)
        else:
            made = torch.cat([first, end - first if wanted == "xywh" else end], -1)
        if self._counts is None or as_padded_sequence:
            return made
        return [made[i, :n] for i, n in enumerate(self._counts)]

    def get_boxes_shape(self) -> Tuple[Tensor, Tensor]:
        """Heights and widths, (N,) or (B, N)."""
        height, width = infer_bbox_shape(self._data.reshape(-1, 4, 2))
        return height.reshape(self._data.shape[:-2]), width.reshape(self._data.shape[:-2])

    def compute_area(self) -> Tensor:
        """(N,) or (B, N), the areas of the polygons of the vertices; of an upright box that is (width - 1)
        (height - 1)."""
        x, y = self._data[..., 0], self._data[..., 1]
        return (x * y.roll(-1, -1) - x.roll(-1, -1) * y).sum(-1).abs() * 0.5

    def merge(self, boxes: "Boxes", inplace: bool = False) -> "Boxes":
        """These boxes and others of the same images."""
        if self._counts is None and boxes._counts is None:
            return self._with(torch.cat([self._data, boxes._data], -3), inplace)
        rows = [torch.cat([a[:n], b[:m]]) for a, n, b, m in zip(*_rows(self), *_rows(boxes))]
        data, counts = _padded(rows, True)
        made = self._with(data, inplace)
        made._counts = counts
        return made

    def pad(self, padding_size: Tensor) -> "Boxes":
        """Move these boxes as a border around the image does: padding_size (B, 4) or (1, 4), left, right,
        top, bottom."""
        self._data = self._data + self._for_each(padding_size[..., ::2])
        return self

    def unpad(self, padding_size: Tensor) -> "Boxes":
        """The opposite of ``pad``."""
        self._data = self._data - self._for_each(padding_size[..., ::2])
        return self

    def clamp(
        self, topleft: Optional[Tensor] = None, botright: Optional[Tensor] = None, inplace: bool = False
    ) -> "Boxes":
        """The boxes with each vertex inside bounds x, y, both (B, 2) or (1, 2)."""
        made = self._data
        if topleft is not None:
            made = torch.maximum(made, self._for_each(topleft))
        if botright is not None:
            made = torch.minimum(made, self._for_each(botright))
        return self._with(made, inplace)

    def filter_boxes_by_area(
        self, min_area: Optional[float] = None, max_area: Optional[float] = None, inplace: bool = False
    ) -> "Boxes":
        """The boxes, of which those outside of a range of areas are zeros."""
        area = self.compute_area()
        out = torch.zeros_like(area, dtype=torch.bool)
        if min_area is not None:
            out = out | (area < min_area)
        if max_area is not None:
            out = out | (area > max_area)
        return self._with(
            torch.where(out[..., None, None], torch.zeros_like(self._data), self._data), inplace
        )

    def translate(self, size: Tensor, method: str = "warp", inplace: bool = False) -> "Boxes":
        """The boxes moved by x, y, (B, 2) or (1, 2)."""
        check_choice(method, ["warp"], "method")
        return self._with(self._data + self._for_each(size), inplace)

    def to_mask(self, height: int, width: int) -> Tensor:
        """(N, height, width) or (B, N, height, width): 1 inside the boxes, 0 elsewhere. The edges are
        rounded to pixels, halves to even; of boxes that are not along the axes, the least that hold them."""
        first, last = self._data.amin(-2).round(), (self._data.amax(-2) + 1.0).round() - 1.0
        masks = bbox_to_mask(_corners(first, last).reshape(-1, 4, 2), width, height)
        masks = masks.reshape(*self._data.shape[:-2], height, width)
        if self._counts is None:
            return masks
        return masks * _present(self._counts, self._data)[..., None, None]

    def _for_each(self, pairs: Tensor) -> Tensor:
        """A pair x, y for each image, beside the vertices."""
        many = pairs.to(self._data)
        if many.dim() == 1:
            many = many[None]
        count = self._data.size(0) if self._data.dim() == 4 else 1
        if many.dim() != 2 or many.size(0) not in (1, count):
            raise ValueError(f"expected numbers for 1 or {count} images, got {list(pairs.shape)}")
        return many[:, None, None] if self._data.dim() == 4 else many[0]


class VideoBoxes(Boxes):
    """Boxes of videos, (B, T, N, 4, 2), kept as (B T, N, 4, 2).

    Example:
        >>> boxes = VideoBoxes.from_tensor(torch.ones(2, 5, 3, 4, 2))
        >>> boxes.data.shape, boxes.to_tensor("xyxy").shape
        (torch.Size([10, 3, 4, 2]), torch.Size([2, 5, 3, 4]))
    """

    temporal_channel_size: int

    @classmethod
    def from_tensor(  # pyright: ignore[reportIncompatibleMethodOverride]
        cls, boxes: Tensor, validate_boxes: bool = True
    ) -> "VideoBoxes":
        """From vertices (B, T, N, 4, 2), whose last pixel is in the box."""
        if boxes.dim() != 5 or boxes.shape[-2:] != (4, 2):
            raise ValueError(f"boxes: expected shape (B, T, N, 4, 2), got {list(boxes.shape)}")
        made = cls(boxes.flatten(0, 1), False)
        made.temporal_channel_size = boxes.size(1)
        if validate_boxes and not bool(made.data.isfinite().all()):
            raise ValueError("boxes: expected finite coordinates")
        return made

    def to_tensor(self, mode: Optional[str] = None, as_padded_sequence: bool = False) -> Tensor:
        """(B, T, N, 4) or (B, T, N, 4, 2), the boxes in a format."""
        return super().to_tensor(mode, True).unflatten(0, (-1, self.temporal_channel_size))

    def __getitem__(self, key: Any) -> "VideoBoxes":
        """Whole videos."""
        found = self._data.unflatten(0, (-1, self.temporal_channel_size))[key]
        return self._with((found[None] if isinstance(key, int) else found).flatten(0, 1))

    def __setitem__(self, key: Any, value: "VideoBoxes") -> None:
        self._data.unflatten(0, (-1, self.temporal_channel_size))[key] = value._data.unflatten(
            0, (-1, self.temporal_channel_size)
        )


class Boxes3D(_Boxes):
    """Boxes of volumes. ``Boxes3D.from_tensor`` takes the usual formats.

    Args:
        boxes: vertices (N, 8, 3) or (B, N, 8, 3), the front clockwise from the top left, then the back, whose
            last voxel is in the box.
        raise_if_not_floating_point: False makes float32 of whole numbers.
        mode: the format that ``mode`` tells.

    Raises:
        TypeError: if boxes are not floating point.
        ValueError: if the shape or the mode is not as above.

    Example:
        >>> boxes = Boxes3D.from_tensor(torch.tensor([[0.0, 0.0, 0.0, 2.0, 3.0, 4.0]]))
        >>> boxes.to_tensor("xyzwhd"), boxes.to_mask(6, 6, 6).sum()
        (tensor([[0., 0., 0., 2., 3., 4.]]), tensor(24.))
    """

    _axes = 3

    def __init__(
        self, boxes: Tensor, raise_if_not_floating_point: bool = True, mode: str = "xyzxyz_plus"
    ) -> None:
        check_choice(mode, _MODES_3D, "mode")
        data, _ = _padded(boxes, raise_if_not_floating_point)
        if data.dim() not in (3, 4) or data.shape[-2:] != (8, 3):
            raise ValueError(f"boxes: expected shape (N, 8, 3) or (B, N, 8, 3), got {list(data.shape)}")
        super().__init__(data, mode)

    @classmethod
    def from_tensor(cls, boxes: Tensor, mode: str = "xyzxyz", validate_boxes: bool = True) -> "Boxes3D":
        """From boxes (N, 6) or (B, N, 6).

        Args:
            boxes: the boxes; whole numbers become float32.
            mode: "xyzxyz", "xyzxyz_plus" (the second corner is the last voxel) or "xyzwhd".
            validate_boxes: True raises ValueError if an extent is not positive.
        """
        check_choice(mode, _MODES_3D, "mode")
        data, _ = _padded(boxes, False)
        if data.dim() not in (2, 3) or data.size(-1) != 6:
            raise ValueError(f"boxes: expected shape (N, 6) or (B, N, 6), got {list(data.shape)}")
        first, second = data[..., :3], data[..., 3:]
        end = first + second - 1.0 if mode == "xyzwhd" else second - (1.0 if mode == "xyzxyz" else 0.0)
        if validate_boxes and not bool((end - first + 1.0 > 0.0).all()):
            raise ValueError("boxes: expected positive widths, heights and depths")
        return cls(_corners3d(first, end), mode=mode)

    def to_tensor(self, mode: str = "xyzxyz") -> Tensor:
        """(N, 6) or (B, N, 6), or with "vertices" and "vertices_plus" (N, 8, 3) or (B, N, 8, 3), the boxes in
        a format; of boxes that are not along the axes, the least that hold them."""
        check_choice(mode, [*_MODES_3D, "vertices", "vertices_plus"], "mode")
        first, last = self._data.amin(-2), self._data.amax(-2)
        end = last if mode.endswith("plus") else last + 1.0
        if mode.startswith("vertices"):
            return _corners3d(first, end)
        return torch.cat([first, end - first if mode == "xyzwhd" else end], -1)

    def get_boxes_shape(self) -> Tuple[Tensor, Tensor, Tensor]:
        """Depths, heights and widths, (N,) or (B, N)."""
        shape = self._data.shape[:-2]
        depth, height, width = infer_bbox_shape3d(self._data.reshape(-1, 8, 3))
        return depth.reshape(shape), height.reshape(shape), width.reshape(shape)

    def to_mask(self, depth: int, height: int, width: int) -> Tensor:
        """(N, depth, height, width) or (B, N, ...): 1 inside the boxes, 0 elsewhere. The boxes lie along the
        axes."""
        if not bool(is_bbox3d(self._data.reshape(-1, 8, 3)).all()):
            raise ValueError("boxes: expected boxes along the axes")
        masks = bbox_to_mask3d(self._data.reshape(-1, 8, 3), (depth, height, width))
        return masks.reshape(*self._data.shape[:-2], depth, height, width)


def _padded(boxes: Union[Tensor, List[Tensor]], strict: bool) -> Tuple[Tensor, Optional[List[int]]]:
    """Boxes as one tensor, and how many each image of a list has."""
    counts: Optional[List[int]] = None
    if isinstance(boxes, (list, tuple)):
        if not boxes or not all(isinstance(b, Tensor) and b.dim() == boxes[0].dim() for b in boxes):
            raise TypeError("boxes: expected a list of tensors of one rank")
        counts = [b.size(0) for b in boxes]
        boxes = torch.nn.utils.rnn.pad_sequence(list(boxes), batch_first=True)
    if isinstance(boxes, Tensor) and not boxes.is_floating_point() and not strict:
        boxes = boxes.to(torch.get_default_dtype())
    check_floating(boxes, "boxes")
    return boxes, counts


def _present(counts: List[int], like: Tensor) -> Tensor:
    """(B, N), which of padded boxes are real."""
    return torch.arange(like.size(1), device=like.device) < torch.tensor(counts, device=like.device)[:, None]


def _rows(boxes: Boxes) -> Tuple[Tensor, List[int]]:
    counts = boxes._counts or [boxes._data.size(1)] * boxes._data.size(0)
    return boxes._data, counts


def _corners(first: Tensor, last: Tensor) -> Tensor:
    """(*, 4, 2), clockwise from the top left."""
    low_x, low_y, high_x, high_y = *first.unbind(-1), *last.unbind(-1)
    pairs = ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y))
    return torch.stack([torch.stack(pair, -1) for pair in pairs], -2)


def _corners3d(first: Tensor, last: Tensor) -> Tensor:
    """(*, 8, 3), the front clockwise from the top left, then the back."""
    face = _corners(first[..., :2], last[..., :2])
    depths = [z[..., None, None].expand(*face.shape[:-1], 1) for z in (first[..., 2], last[..., 2])]
    return torch.cat([torch.cat([face, z], -1) for z in depths], -2)


def _beyond(like: Tensor) -> Tensor:
    """(4, 2), from the last pixels to the edges behind them."""
    return torch.tensor([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=like.dtype, device=like.device)
