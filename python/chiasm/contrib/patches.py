"""Conversion of images to overlapping windows, and back."""

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_image, check_rank
from ..primitives.core.materialise import stored_index
from ..primitives.core.window_sizes import four_sides, positive_pair
from ..primitives.filters.windows import windows
from ..primitives.numbers.reshaping import reshaped


def extract_tensor_patches(
    input: Tensor,
    window_size: Union[int, Tuple[int, int]],
    stride: Union[int, Tuple[int, int]] = 1,
    padding: Union[int, Tuple[int, int], Tuple[int, int, int, int]] = 0,
    allow_auto_padding: bool = False,
) -> Tensor:
    """Cut an image into windows, row by row.

    Args:
        input: (B, C, H, W), floating point.
        window_size: (rows, columns), or one number for both.
        stride: the distance of windows, (vertical, horizontal) or one number for both.
        padding: zeros around the image: one number, (above and below, left and right) or (above, below, left,
            right).
        allow_auto_padding: True adds zeros so that the last windows end with the image, half of them before
            it (rounded down) and the rest after it. False ignores pixels that the last windows do not reach.

    Returns:
        (B, N, C, rows, columns) with N = down * right windows, down = (H + padding - rows) // stride + 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, a window or a stride not positive, a padding negative, or the padded
            image smaller than the window.

    Example:
        >>> extract_tensor_patches(torch.arange(6.0).reshape(1, 1, 2, 3), 2)[0, :, 0]
        tensor([[[0., 1.],
                 [3., 4.]],
        <BLANKLINE>
                [[1., 2.],
                 [4., 5.]]])
    """
    check_image(input, "input")
    rows, columns = positive_pair(window_size, "window_size")
    down, right = positive_pair(stride, "stride")
    top, bottom, left, beyond = four_sides(padding, "padding")
    if input.size(2) + top + bottom < rows or input.size(3) + left + beyond < columns:
        raise ValueError(
            f"window_size: expected one within the padded input {list(input.shape)}, got ({rows}, {columns})"
        )
    top, high = _windows(input.size(2), rows, down, top, bottom, allow_auto_padding)
    left, wide = _windows(input.size(3), columns, right, left, beyond, allow_auto_padding)
    cut = windows(input, (high, wide), (rows, columns), (down, right), (-top, -left))
    return reshaped(cut.permute(0, 2, 4, 1, 3, 5), [input.size(0), high * wide, input.size(1), rows, columns])


def combine_tensor_patches(
    patches: Tensor,
    original_size: Union[int, Tuple[int, int]],
    window_size: Union[int, Tuple[int, int]],
    stride: Optional[Union[int, Tuple[int, int]]] = None,
    allow_auto_unpadding: bool = False,
    unpadding: Union[int, Tuple[int, int], Tuple[int, int, int, int]] = 0,
    eps: Optional[float] = None,
) -> Tensor:
    """Combine windows into an image; each pixel is the mean over its windows. The inverse of
    `extract_tensor_patches`.

    Args:
        patches: (B, N, C, rows, columns), floating point.
        original_size: (H, W) of the image, or one number for both.
        window_size: (rows, columns) of the windows.
        stride: the stride of the windows; by default windows are adjacent.
        allow_auto_unpadding: True if the windows were cut with allow_auto_padding.
        unpadding: the padding with which the windows were cut.
        eps: added to the number of windows of a pixel, 0 by default. A pixel without windows is 0.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if patches is not floating point.
        ValueError: if patches is not (B, N, C, rows, columns) with as many windows as there are in the image,
            a size or stride not positive, an unpadding negative, or the padded image smaller than the window.

    Example:
        >>> image = torch.arange(6.0).reshape(1, 1, 2, 3)
        >>> combine_tensor_patches(extract_tensor_patches(image, 2), (2, 3), 2, 1)[0, 0]
        tensor([[0., 1., 2.],
                [3., 4., 5.]])
    """
    check_rank(patches, 5, "(B, N, C, rows, columns)", "patches")
    check_floating(patches, "patches")
    height, width = positive_pair(original_size, "original_size")
    rows, columns = positive_pair(window_size, "window_size")
    down, right = (rows, columns) if stride is None else positive_pair(stride, "stride")
    top, bottom, left, beyond = four_sides(unpadding, "unpadding")
    if height + top + bottom < rows or width + left + beyond < columns:
        raise ValueError(
            f"window_size: expected one within the padded image of ({height}, {width}), got ({rows},"
            f" {columns})"
        )
    top, high = _windows(height, rows, down, top, bottom, allow_auto_unpadding)
    left, wide = _windows(width, columns, right, left, beyond, allow_auto_unpadding)
    if patches.size(1) != high * wide or patches.size(3) != rows or patches.size(4) != columns:
        raise ValueError(
            f"patches: expected shape (B, {high * wide}, C, {rows}, {columns}), got {list(patches.shape)}"
        )
    strips = patches.unflatten(1, [high, wide]).permute(0, 3, 1, 4, 2, 5).flatten(4, 5).flatten(2, 3)
    tall, county = _overlap_add(strips, 2, height, high, rows, down, top)
    image, countx = _overlap_add(tall, 3, width, wide, columns, right, left)
    count = (county[:, None] * countx).to(patches.dtype)
    if eps is None:
        return image / count.clamp(min=1.0)
    return image / (count + eps)


def compute_padding(
    original_size: Union[int, Tuple[int, int]],
    window_size: Union[int, Tuple[int, int]],
    stride: Optional[Union[int, Tuple[int, int]]] = None,
) -> Tuple[int, int, int, int]:
    """The padding by which the last windows end with the image, as ``allow_auto_padding`` adds it.

    Args:
        original_size: (H, W) of the image, or one number for both.
        window_size: (rows, columns) of the windows.
        stride: the distance of windows; by default they are adjacent.

    Returns:
        Above, below, left and right, of which those before are the same or one less.

    Raises:
        ValueError: if a size or a stride is not positive.

    Example:
        >>> compute_padding((32, 40), 7)
        (1, 2, 1, 1)
    """
    height, width = positive_pair(original_size, "original_size")
    rows, columns = positive_pair(window_size, "window_size")
    down, right = positive_pair(window_size if stride is None else stride, "stride")
    more_rows, more_columns = _missing(height - rows, down), _missing(width - columns, right)
    return more_rows // 2, more_rows - more_rows // 2, more_columns // 2, more_columns - more_columns // 2


def _missing(room: int, stride: int) -> int:
    """The pixels that an axis lacks beyond its first window and ``room`` more, to hold whole steps."""
    return -room if room < 0 else (stride - room % stride) % stride


def _windows(
    size: int, window: int, stride: int, before: int, after: int, is_fitted: bool
) -> Tuple[int, int]:
    """The number of zeros before an axis, and the number of windows along it."""
    room = before + size + after - window
    if not is_fitted:
        return before, room // stride + 1
    count = (room + stride - 1) // stride + 1
    return before + ((count - 1) * stride - room) // 2, count


def _overlap_add(
    x: Tensor, dim: int, size: int, count: int, window: int, stride: int, before: int
) -> Tuple[Tensor, Tensor]:
    """The sums along an axis of ``size`` of the windows laid out on it, and how many of them each position
    has."""
    position = torch.arange(size, device=x.device) + before
    latest = torch.div(position, stride, rounding_mode="floor")
    sums: List[Tensor] = []
    counts: List[Tensor] = []
    for earlier in range((window + stride - 1) // stride):
        index = latest - earlier
        offset = position - index * stride
        has = (index >= 0) & (index < count) & (offset < window)
        values = x.index_select(
            dim, stored_index(index.clamp(min=0, max=count - 1) * window + offset.clamp(max=window - 1))
        )
        sums.append(torch.where(_along(has, dim), values, torch.zeros_like(values)))
        counts.append(has.to(torch.int64))
    total, covered = sums[0], counts[0]
    for k in range(1, len(sums)):
        total, covered = total + sums[k], covered + counts[k]
    return total, covered


def _along(mask: Tensor, dim: int) -> Tensor:
    """A mask of positions along dimension 2 or 3 of four."""
    return mask[:, None] if dim == 2 else mask
