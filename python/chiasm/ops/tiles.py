"""Large images in tiles: cut images into tiles, and merge the results of a network for the tiles."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_pair, check_pixels, check_rank, check_tensor
from ..primitives.core.materialise import stored_index
from ..primitives.core.window_sizes import any_pair, positive_pair
from ..primitives.geometry.boxes import wide
from ..primitives.numbers.loss_reduction import widened
from ..primitives.numbers.reshaping import reshaped
from .decoding import Detections, suppressed


def tile(
    image: Tensor, size: Union[int, Tuple[int, int]], overlap: Union[int, Tuple[int, int]] = 0
) -> Tuple[Tensor, Tensor]:
    """Cut an image into tiles of one size, row by row, which cover it. The last tile of a row or column is
    shifted into the image, so that it overlaps the one before by more.

    Args:
        image: (B, C, H, W), floating point or uint8.
        size: (rows, columns) of a tile, or one number for both.
        overlap: the overlap of neighbours in pixels, (vertical, horizontal) or one number for both.

    Returns:
        Tiles (B, T, C, rows, columns); and the positions (T, 2), int64, of their upper left pixels, x and y.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if image is not 4-D, size is not positive or larger than the image, or overlap is not from
            0 to less than size.

    Example:
        >>> tiles, positions = tile(torch.arange(5.0).reshape(1, 1, 1, 5), (1, 3), (0, 1))
        >>> tiles[0, :, 0, 0], positions
        (tensor([[0., 1., 2.],
                [2., 3., 4.]]), tensor([[0, 0],
                [2, 0]]))
    """
    check_pixels(image, "image")
    rows, columns = positive_pair(size, "size")
    if rows > image.size(2) or columns > image.size(3):
        raise ValueError(f"size: expected one within the image {list(image.shape)}, got ({rows}, {columns})")
    down, right = _overlaps(overlap, rows, columns)
    top = _starts(image.size(2), rows, down, image.device)
    left = _starts(image.size(3), columns, right, image.device)
    high, wide = top.size(0), left.size(0)
    tall = image[:, :, top[:, None] + torch.arange(rows, device=image.device)]
    cut = tall[:, :, :, :, left[:, None] + torch.arange(columns, device=image.device)]
    tiles = reshaped(
        cut.permute(0, 2, 4, 1, 3, 5), [image.size(0), high * wide, image.size(1), rows, columns]
    )
    positions = torch.stack([left[None].expand(high, -1), top[:, None].expand(-1, wide)], 2)
    return tiles, reshaped(positions, [high * wide, 2])


def merge(tiles: Tensor, image_size: Tuple[int, int], overlap: Union[int, Tuple[int, int]] = 0) -> Tensor:
    """Merge tiles, as cut by ``tile``, into an image, and blend the seams. Each pixel is a weighted mean of
    the tiles that contain it. Along each axis a tile's weight falls towards its ends, over ``overlap`` pixels
    in equal steps to 1 / (overlap + 1); the weights of a pixel are divided by their sum. So equal pixels of
    overlapping tiles stay unchanged, within rounding.

    Args:
        tiles: (B, T, C, rows, columns), floating point. Half precision is computed in float32.
        image_size: (H, W) of the image.
        overlap: the overlap with which the tiles were cut.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if tiles is not floating point.
        ValueError: if tiles is not (B, T, C, rows, columns) with as many tiles as there are in the image, a
            tile is larger than the image, or overlap is not from 0 to less than a tile's size.

    Example:
        >>> tiles = torch.tensor([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]).reshape(1, 2, 1, 1, 3)
        >>> merge(tiles, (1, 4), (0, 2))
        tensor([[[[0.0000, 0.3333, 0.6667, 1.0000]]]])
    """
    check_rank(tiles, 5, "(B, T, C, rows, columns)", "tiles")
    check_floating(tiles, "tiles")
    rows, columns = tiles.size(3), tiles.size(4)
    check_pair(image_size, "image_size")
    height, width = image_size
    if rows < 1 or columns < 1 or rows > height or columns > width:
        raise ValueError(
            f"tiles: expected tiles of a pixel or more, within the image of ({height}, {width}), got"
            f" {list(tiles.shape)}"
        )
    down, right = _overlaps(overlap, rows, columns)
    high, wide = _count(height, rows, down), _count(width, columns, right)
    if tiles.size(1) != high * wide:
        raise ValueError(f"tiles: expected {high * wide} of them, {high} x {wide}, got {list(tiles.shape)}")
    laid_out = reshaped(
        widened(tiles).unflatten(1, [high, wide]).permute(0, 3, 1, 4, 2, 5),
        [tiles.size(0), tiles.size(2), high * rows, wide * columns],
    )
    tall, weight_y = _weighted_sum(laid_out, 2, height, rows, down)
    image, weight_x = _weighted_sum(tall, 3, width, columns, right)
    return (image / (weight_y[:, None] * weight_x)).to(tiles.dtype)


def merge_detections(
    boxes: Tensor,
    scores: Tensor,
    labels: Tensor,
    found: Tensor,
    origins: Tensor,
    iou_threshold: float = 0.45,
    max_output: int = 300,
) -> Detections:
    """Merge the detections of tiles into the detections of the large image. Boxes are shifted by the
    positions of their tiles. Then non-maximum suppression for each class keeps the highest score of
    overlapping boxes, from any tile. At the border of a tile only a part of an object is detected: so the
    overlap of tiles should be as large as the objects.

    Args:
        boxes: (B, T, N, 4) as x1, y1, x2, y2 in pixels of the tiles, floating point.
        scores: (B, T, N), floating point.
        labels: (B, T, N), int64, the classes.
        found: (B, T, N), bool, a mask of the slots that hold an object; the others are ignored.
        origins: (T, 2), int64 or floating point: the upper left corners of the tiles in the image, x and y.
        iou_threshold: a box is dropped if its IoU (intersection over union) with a kept box of its class is
            greater than this.
        max_output: the number K of slots for objects.

    Returns:
        Boxes (B, K, 4) in pixels of the image, float32 for half precision, which is too coarse for large
        images; scores (B, K), labels (B, K), int64, and (B, K), bool, a mask
        of the slots that hold an object, as in ``decode_yolov8``: in descending order of score, empty slots
        are 0.

    Raises:
        TypeError: if boxes or scores is not floating point, labels not int64, found not bool, or origins
            neither int64 nor floating point.
        ValueError: if a shape is not as above, or max_output is not positive.

    Example:
        >>> boxes = torch.tensor([[[[6.0, 2.0, 8.0, 4.0]], [[1.0, 2.0, 3.0, 4.0]]]])
        >>> labels, found = torch.zeros(1, 2, 1, dtype=torch.int64), torch.ones(1, 2, 1, dtype=torch.bool)
        >>> origins = torch.tensor([[0, 0], [5, 0]])
        >>> scores = torch.tensor([[[0.8], [0.9]]])
        >>> merge_detections(boxes, scores, labels, found, origins, max_output=2)[:2]
        (tensor([[[6., 2., 8., 4.],
                 [0., 0., 0., 0.]]]), tensor([[0.9000, 0.0000]]))
    """
    check_rank(boxes, 4, "(B, T, N, 4)", "boxes")
    if boxes.size(3) != 4:
        raise ValueError(f"boxes: expected shape (B, T, N, 4), got {list(boxes.shape)}")
    check_floating(boxes, "boxes")
    check_floating(scores, "scores")
    for name, each in [("scores", scores), ("labels", labels), ("found", found)]:
        check_tensor(each, name)
        if each.shape != boxes.shape[:3]:
            raise ValueError(f"{name}: expected shape {list(boxes.shape[:3])}, got {list(each.shape)}")
    if labels.dtype != torch.int64:
        raise TypeError(f"labels: expected dtype int64, got {labels.dtype}")
    if found.dtype != torch.bool:
        raise TypeError(f"found: expected dtype bool, got {found.dtype}")
    check_tensor(origins, "origins")
    if origins.dim() != 2 or origins.size(0) != boxes.size(1) or origins.size(1) != 2:
        raise ValueError(
            f"origins: expected shape (T, 2) for boxes {list(boxes.shape)}, got {list(origins.shape)}"
        )
    if origins.dtype != torch.int64 and not origins.is_floating_point():
        raise TypeError(f"origins: expected dtype int64 or floating point, got {origins.dtype}")
    batch, count = boxes.size(0), boxes.size(1) * boxes.size(2)
    moved = wide(boxes)
    moved = moved + torch.cat([origins, origins], 1).to(moved.dtype)[:, None]
    flat = reshaped(moved, [batch, count, 4])
    present = torch.where(found, scores, torch.full_like(scores, -float("inf")))
    values, classes = reshaped(present, [batch, count]), reshaped(labels, [batch, count])
    return suppressed(flat, values, classes, iou_threshold, max_output, -float("inf"))


def _overlaps(overlap: Union[int, Tuple[int, int]], rows: int, columns: int) -> Tuple[int, int]:
    """The vertical and the horizontal overlap."""
    down, right = any_pair(overlap, "overlap")
    if down < 0 or right < 0 or down >= rows or right >= columns:
        raise ValueError(
            f"overlap: expected 0 to less than the tiles' ({rows}, {columns}), got ({down}, {right})"
        )
    return down, right


def _count(length: int, size: int, overlap: int) -> int:
    """The number of tiles that cover an axis."""
    stride = size - overlap
    return (length - size + stride - 1) // stride + 1


def _starts(length: int, size: int, overlap: int, device: torch.device) -> Tensor:
    """The first positions of tiles along an axis."""
    number = torch.arange(_count(length, size, overlap), device=device)
    return (number * (size - overlap)).clamp(max=length - size)


def _weighted_sum(x: Tensor, dim: int, length: int, size: int, overlap: int) -> Tuple[Tensor, Tensor]:
    """The weighted sums along an axis of the tiles laid out on it, and the sums of the weights."""
    stride = size - overlap
    count = _count(length, size, overlap)
    position = torch.arange(length, device=x.device)
    latest = torch.div(position, stride, rounding_mode="floor")
    # The last tile begins where it fits; the tiles before begin at multiples of the stride.
    offset = position - (length - size)
    place = (count - 1) * size + offset.clamp(min=0)
    weight = _weight(offset, size, overlap, x.dtype)
    weight = torch.where(offset >= 0, weight, torch.zeros_like(weight))
    total = x.index_select(dim, stored_index(place)) * _along(weight, dim)
    weights = weight
    for earlier in range((size + stride - 1) // stride):
        index = latest - earlier
        offset = position - index * stride
        has = (index >= 0) & (index < count - 1) & (offset < size)
        place = index.clamp(min=0, max=count - 1) * size + offset.clamp(max=size - 1)
        weight = torch.where(has, _weight(offset, size, overlap, x.dtype), torch.zeros_like(weights))
        total = total + x.index_select(dim, stored_index(place)) * _along(weight, dim)
        weights = weights + weight
    return total, weights


def _weight(offset: Tensor, size: int, overlap: int, dtype: torch.dtype) -> Tensor:
    """The weight of a tile at an offset in pixels from its start."""
    nearest = torch.minimum(offset + 1, size - offset).clamp(max=overlap + 1)
    return nearest.to(dtype) / (overlap + 1)


def _along(weight: Tensor, dim: int) -> Tensor:
    """Weights along dimension 2 or 3 of four."""
    return weight[:, None] if dim == 2 else weight
