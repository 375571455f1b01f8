"""What belongs to the images of a batch: masks, boxes, keypoints and labels; their shapes, and how they
move."""

from typing import Any, Callable, Dict, List

import torch
from torch import Tensor

from ..geometry.linalg import transform_points
from ..primitives.core.checks import check_tensor

#: Shapes without the batch's dimension, for messages.
_LAYOUTS: Dict[str, List[Any]] = {
    "bbox": ["N", 4, 2],
    "bbox_xyxy": ["N", 4],
    "bbox_xywh": ["N", 4],
    "keypoints": ["N", 2],
}

#: Dtypes of the same bits.
_SIGNED = {torch.uint16: torch.int16, torch.uint32: torch.int32, torch.uint64: torch.int64}


def dimensions(key: str, rank: int) -> int:
    """The number of dimensions of a batch of ``key``, for batches of images of ``rank`` dimensions."""
    return 1 + len(_LAYOUTS[key]) if key in _LAYOUTS else rank


def is_single(key: str, value: Any, rank: int) -> bool:
    """Whether ``value`` is of one sample, without the batch's dimension."""
    return isinstance(value, Tensor) and key != "class" and value.dim() == dimensions(key, rank) - 1


def check_value(key: str, value: Any, batch: int, spatial: List[int], rank: int) -> None:
    """Raise unless ``value`` is what ``key`` names, for ``batch`` images; images and masks have the size
    ``spatial``, of any length if it is empty."""
    if key == "class":
        return
    if key in _LAYOUTS and isinstance(value, list):
        if len(value) != batch:
            raise ValueError(
                f"{key}: expected a list of {batch} tensors, one for each image, got {len(value)}"
            )
        for one in value:
            check_tensor(one, key)
            check_value(key, one[None], 1, [], rank)
        return
    check_tensor(value, key)
    axes = ["D", "H", "W"][5 - rank :]
    expected: List[Any] = [batch, *_LAYOUTS.get(key, ["C", *(spatial or axes)])]
    found = list(value.shape)
    if len(found) != len(expected) or any(isinstance(e, int) and e != f for e, f in zip(expected, found)):
        shape = ", ".join(str(e) for e in expected)
        raise ValueError(f"{key}: expected shape ({shape}), got {found}")


def as_movable(key: str, value: Any) -> Any:
    """Whole numbers of boxes and keypoints as float32, since a position may lie between them; a mask of
    unsigned numbers as signed ones of the same bits, which more of PyTorch's functions know."""
    if key not in _LAYOUTS:
        return value.view(_SIGNED.get(value.dtype, value.dtype)) if key == "mask" else value
    if isinstance(value, list):
        return [as_movable(key, one) for one in value]
    return value if value.is_floating_point() else value.to(torch.float32)


def moved_coordinates(key: str, data: Any, matrix: Tensor, edges: bool = False) -> Any:
    """Boxes or points, mapped by homographies (B, 3, 3); a list has the boxes of one image in each place.
    Of a box the centres of the corner pixels are mapped, with ``edges`` its edges."""
    if isinstance(data, list):
        return [moved_coordinates(key, one[None], matrix[i : i + 1], edges)[0] for i, one in enumerate(data)]
    if key in ("keypoints", "bbox"):
        flat = data.flatten(1, -2)
        return transform_points(matrix, flat.to(torch.float64)).reshape(data.shape).to(data.dtype)
    first, second = data[..., :2].to(torch.float64), data[..., 2:].to(torch.float64)
    last = second if key == "bbox_xyxy" else first + second
    # From edges to the centres of corner pixels; a box narrower than a pixel has none, and keeps its width.
    inset = 0.5 * (last - first).amin(-1, keepdim=True).clamp(0.0, 0.0 if edges else 1.0)
    first, last = first - 0.5 + inset, last - 0.5 - inset
    x, y = torch.stack([first[..., 0], last[..., 0]], -1), torch.stack([first[..., 1], last[..., 1]], -1)
    corners = torch.stack([x[..., [0, 1, 1, 0]], y[..., [0, 0, 1, 1]]], -1)
    moved = transform_points(matrix, corners.flatten(1, -2)).reshape(corners.shape)
    low, high = moved.amin(-2) - inset + 0.5, moved.amax(-2) + inset + 0.5
    return torch.cat([low, high if key == "bbox_xyxy" else high - low], -1).to(data.dtype)


def edges_of(key: str, boxes: Tensor) -> Tensor:
    """Boxes (*, N, 4, 2) or (*, N, 4) as (x1, y1, x2, y2), the coordinates of their edges."""
    if key == "bbox":  # the edge of the last pixel is one greater than its coordinate
        return torch.cat([boxes.amin(-2), boxes.amax(-2) + 1], -1)
    return torch.cat([boxes[..., :2], boxes[..., :2] + boxes[..., 2:]], -1) if key == "bbox_xywh" else boxes


def of_edges(key: str, boxes: Tensor) -> Tensor:
    """The inverse of ``edges_of``."""
    first, second = boxes[..., :2], boxes[..., 2:]
    if key == "bbox_xyxy":
        return boxes
    if key == "bbox_xywh":
        return torch.cat([first, second - first], -1)
    last = torch.maximum(second - 1, first)
    x, y = torch.stack([first[..., 0], last[..., 0]], -1), torch.stack([first[..., 1], last[..., 1]], -1)
    return torch.stack([x[..., [0, 1, 1, 0]], y[..., [0, 0, 1, 1]]], -1)


def _signed(fill: float, dtype: torch.dtype) -> float:
    """The number whose bits, in a signed dtype that stands for an unsigned one (``as_movable``), are those of
    ``fill``."""
    if dtype in _SIGNED.values() and torch.iinfo(dtype).max < fill < 2 ** torch.iinfo(dtype).bits:
        return int(fill) - 2 ** torch.iinfo(dtype).bits
    return fill


def moved_mask(
    mask: Tensor, move: Callable[[Tensor, float], Tensor], fill: float = 0.0, bytes_too: bool = True
) -> Tensor:
    """A mask (B, C, ...) of any dtype, moved by ``move``, which samples the nearest pixel of floating-point
    numbers and, if ``bytes_too``, of uint8; its second argument is the value outside, which ``fill`` is.

    Of other dtypes, ``move`` moves the numbers of pixels, (B, 1, ...), so that every value arrives as it is.
    """
    if mask.is_floating_point() or (bytes_too and mask.dtype == torch.uint8):
        return move(mask, fill)
    flat = mask.flatten(2)
    number = torch.arange(1, flat.size(2) + 1, dtype=torch.float64, device=mask.device)
    found = move(number.reshape(1, 1, *mask.shape[2:]).expand(mask.size(0), 1, *mask.shape[2:]), 0.0)
    index = found.to(torch.int64).expand(-1, mask.size(1), *found.shape[2:])
    values = torch.cat([torch.full_like(flat[:, :, :1], _signed(fill, mask.dtype)), flat], 2)
    return values.gather(2, index.flatten(2)).reshape(index.shape)
