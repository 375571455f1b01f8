"""The softmax of each window of an image or a volume: its mean position and its mean value."""

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.checks import check_image, check_size3d
from ...primitives.features.extrema import largest
from ...primitives.filters.padding import padded
from ...primitives.resampling.volumes import check_volume
from ...primitives.resampling.warping import position_dtype
from ..conversions.pixels import normalisation
from .heatmaps import inverse_temperature


def conv_soft_argmax2d(
    input: Tensor,
    kernel_size: Tuple[int, int] = (3, 3),
    stride: Tuple[int, int] = (1, 1),
    padding: Tuple[int, int] = (1, 1),
    temperature: Union[Tensor, float] = 1.0,
    normalized_coordinates: bool = True,
    eps: float = 1e-8,
    output_value: bool = False,
) -> Union[Tensor, Tuple[Tensor, Tensor]]:
    """The mean position of each window under the softmax over its pixels, and the mean value.

    The weight of a pixel is exp(v / temperature); the weight of a pixel outside the image or with value -inf
    is 0. For a window that only has such pixels, the mean position is its centre and the value is -inf.

    Args:
        input: (B, C, H, W), floating point. Half precision is computed in float32.
        kernel_size: (rows, columns) of the window.
        stride: pixels from one window to the next, down and across.
        padding: number of pixels by which windows may extend outside the image, (vertical, horizontal); at
            most half of kernel_size.
        temperature: positive, a number or a tensor of one element, whose value is not checked; a smaller
            value gives a sharper peak.
        normalized_coordinates: True: positions in [-1, 1], the centres of the outermost pixels (an axis of
            one pixel is 0); False: positions in pixels from 0.
        eps: not used, here so that Kornia's calls work.
        output_value: True also returns the mean values.

    Returns:
        Positions (B, C, 2, h, w), x and y, where h = (H + 2 padding[0] - kernel_size[0]) // stride[0] + 1,
        and w by the same formula; with output_value, also values (B, C, h, w). Differentiable in input and
        temperature.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, a size, stride or padding not as above, or the temperature not one
            positive number.

    Example:
        >>> heatmap = torch.tensor([[[[0.0, 0.0, 0.0, 0.0], [0.0, 50.0, 50.0, 0.0]]]])
        >>> conv_soft_argmax2d(heatmap, normalized_coordinates=False)[0, 0, 0]
        tensor([[1.0000, 1.5000, 1.5000, 2.0000],
                [1.0000, 1.5000, 1.5000, 2.0000]])
    """
    check_image(input, "input")
    rows, columns = kernel_size
    down, across = stride
    above, left = padding
    _check_windows([rows, columns], [down, across], [above, left])
    means = _window_means(
        input.flatten(0, 1)[:, None], (1, rows, columns), (1, down, across), (0, above, left), temperature
    )
    position = _stacked([means[1], means[2]], [input.size(3), input.size(2)], normalized_coordinates)[:, :, 0]
    position = position.unflatten(0, [input.size(0), input.size(1)]).to(input.dtype)
    if output_value:
        return position, means[3][:, 0].unflatten(0, [input.size(0), input.size(1)]).to(input.dtype)
    return position


def conv_soft_argmax3d(
    input: Tensor,
    kernel_size: Tuple[int, int, int] = (3, 3, 3),
    stride: Tuple[int, int, int] = (1, 1, 1),
    padding: Tuple[int, int, int] = (1, 1, 1),
    temperature: Union[Tensor, float] = 1.0,
    normalized_coordinates: bool = False,
    eps: float = 1e-8,
    output_value: bool = True,
    strict_maxima_bonus: Optional[float] = None,
) -> Union[Tensor, Tuple[Tensor, Tensor]]:
    """The mean position of each window of a volume under the softmax over its voxels, and the mean value.

    See ``conv_soft_argmax2d``; the defaults are different.

    Args:
        input: (B, C, D, H, W), floating point. Half precision is computed in float32.
        kernel_size: (slices, rows, columns) of the window.
        stride: voxels from one window to the next.
        padding: number of voxels by which windows may extend outside the volume; at most half of kernel_size.
        temperature: positive, a number or a tensor of one element, whose value is not checked; a smaller
            value gives a sharper peak.
        normalized_coordinates: True: positions in [-1, 1], the centres of the outermost voxels (an axis of
            one voxel is 0); False: positions in voxels from 0.
        eps: not used, here so that Kornia's calls work.
        output_value: True also returns the mean values.
        strict_maxima_bonus: not used, here so that Kornia's calls work; ``nms3d`` selects strict maxima.

    Returns:
        Positions (B, C, 3, d, h, w), slice, x and y, with d, h and w as in ``conv_soft_argmax2d``; with
        output_value, also values (B, C, d, h, w). Differentiable in input and temperature.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 5-D, a size, stride or padding not as above, or the temperature not one
            positive number.

    Example:
        >>> volume = torch.zeros(1, 1, 3, 3, 3)
        >>> volume[0, 0, 1, 2, 0] = 50.0
        >>> position, value = conv_soft_argmax3d(volume, padding=(0, 0, 0))
        >>> position.flatten(), value.flatten()
        (tensor([1., 0., 2.]), tensor([50.]))
    """
    check_volume(input, "input")
    check_size3d(kernel_size, "kernel_size")
    check_size3d(stride, "stride")
    check_size3d(padding, "padding")
    _check_windows(
        [kernel_size[0], kernel_size[1], kernel_size[2]],
        [stride[0], stride[1], stride[2]],
        [padding[0], padding[1], padding[2]],
    )
    means = _window_means(input.flatten(0, 1), kernel_size, stride, padding, temperature)
    position = _stacked(means[:3], [input.size(2), input.size(4), input.size(3)], normalized_coordinates)
    position = position.unflatten(0, [input.size(0), input.size(1)]).to(input.dtype)
    if output_value:
        return position, means[3].unflatten(0, [input.size(0), input.size(1)]).to(input.dtype)
    return position


def _check_windows(kernel_size: List[int], stride: List[int], padding: List[int]) -> None:
    if min(kernel_size) < 1:
        raise ValueError(f"kernel_size: expected positive sizes, got {kernel_size}")
    if min(stride) < 1:
        raise ValueError(f"stride: expected positive numbers, got {stride}")
    for k in range(len(padding)):
        if padding[k] < 0 or 2 * padding[k] > kernel_size[k]:
            raise ValueError(f"padding: expected numbers from 0 to half of kernel_size, got {padding}")


def _window_means(
    x: Tensor,
    kernel_size: Tuple[int, int, int],
    stride: Tuple[int, int, int],
    padding: Tuple[int, int, int],
    temperature: Union[Tensor, float],
) -> List[Tensor]:
    """Means (N, d, h, w) of each window of (N, D, H, W): slice, x and y in voxels, and value."""
    p = _padded(x.to(position_dtype(x.dtype)), padding)
    taps = _taps(p, kernel_size, stride)
    sharpness = inverse_temperature(temperature, p)
    lowest = -1e30  # finite in place of minus infinity, so that its product with a weight of 0 is 0
    # The subtracted number cancels in the means, so it needs no gradient.
    peak = largest(taps).detach().clamp(min=lowest)
    total = torch.zeros_like(peak)
    through, down, across, value = total, total, total, total
    slices, rows, columns = kernel_size
    for k in range(slices):
        plane = torch.zeros_like(peak)
        for i in range(rows):
            line = torch.zeros_like(peak)
            for j in range(columns):
                below = (taps[(k * rows + i) * columns + j] - peak).clamp(min=lowest)
                weight = torch.exp(below * sharpness)
                line = line + weight
                across = across + weight * (j - 0.5 * (columns - 1))
                value = value + weight * below
            plane = plane + line
            down = down + line * (i - 0.5 * (rows - 1))
        total = total + plane
        through = through + plane * (k - 0.5 * (slices - 1))
    empty = total == 0
    total = torch.where(empty, torch.ones_like(total), total)
    centre = [
        _centres(peak.size(k + 1), stride[k], 0.5 * (kernel_size[k] - 1) - padding[k], peak) for k in range(3)
    ]
    value = torch.where(empty, torch.full_like(value, -float("inf")), peak + value / total)
    return [
        through / total + centre[0][:, None, None],
        across / total + centre[2],
        down / total + centre[1][:, None],
        value,
    ]


def _padded(x: Tensor, padding: Tuple[int, int, int]) -> Tensor:
    beyond = -float("inf")
    if padding[0] > 0:
        plane = [torch.full_like(x[:, 0:1], beyond) for _ in range(padding[0])]
        x = torch.cat(plane + [x] + plane, 1)
    return padded(x, (padding[1], padding[1]), (padding[2], padding[2]), "constant", beyond)


def _taps(p: Tensor, kernel_size: Tuple[int, int, int], stride: Tuple[int, int, int]) -> List[Tensor]:
    """The windows' first voxels, their second ones, and so on, columns first."""
    depth, height, width = (
        p.size(1) - kernel_size[0] + 1,
        p.size(2) - kernel_size[1] + 1,
        p.size(3) - kernel_size[2] + 1,
    )
    if depth < 1 or height < 1 or width < 1:
        raise ValueError(
            f"kernel_size: expected no more than the padded input's {list(p.shape[1:])}, got"
            f" {list(kernel_size)}"
        )
    down, along, across = stride
    taps: List[Tensor] = []
    for k in range(kernel_size[0]):
        sheet = p[:, k : k + depth : down]
        for i in range(kernel_size[1]):
            row = sheet[:, :, i : i + height : along]
            for j in range(kernel_size[2]):
                taps.append(row[..., j : j + width : across])
    return taps


def _centres(count: int, stride: int, first: float, like: Tensor) -> Tensor:
    return torch.arange(count, device=like.device).to(like.dtype) * stride + first


def _stacked(positions: List[Tensor], sizes: List[int], normalized_coordinates: bool) -> Tensor:
    """(N, axes, d, h, w)."""
    out = torch.stack(positions, 1)
    if normalized_coordinates:
        half, offset = normalisation(sizes, True, out.dtype, out.device)
        return out / half[:, None, None, None] + offset[:, None, None, None]
    return out
