"""Distances of pixels to the nearest pixel of a shape."""

import math
from typing import List

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..filters.padding import padded
from ..kernels import operators as kernels


@primitive
def euclidean_distances(x: Tensor) -> Tensor:
    """The distance from each pixel of (B, C, H, W), float32 or float64, that is above 0 to the nearest pixel
    that is not. It is infinite if there is no such pixel, and 0 for the other pixels.

    The squared distance is a minimum over rows of a minimum over columns. Each is taken by erosions with (2k
    + 1, 0, 2k + 1), k = 0, 1, ..., whose sum is the parabola (F. Shih, O. Mitchell, A mathematical morphology
    approach to Euclidean distance transformation, IEEE TIP 1(2), 1992): the sum of the first d odd numbers is
    d^2. The loop takes as many steps as the largest distance.

    >>> euclidean_distances(torch.tensor([[[[0.0, 1.0, 1.0, 1.0, 1.0, 0.0]]]]))
    tensor([[[[0., 1., 2., 2., 1., 0.]]]])
    """
    zeros = torch.zeros_like(x)
    squared = torch.where(x > 0, zeros + math.inf, zeros)
    for dim in [2, 3]:
        squared = _eroded_by_parabola(squared, 2147483647, dim)
    return torch.sqrt(squared)


@euclidean_distances.lowering("native", when=kernels.has_kernel)
def _euclidean_distances_kernel(x: Tensor) -> Tensor:
    return kernels.distance_transform_edt(x)


@until_stable
def _eroded_by_parabola(x: Tensor, k: Tensor, dim: int) -> Tensor:
    size = x.size(dim)
    before = torch.cat([x.narrow(dim, 0, 1), x.narrow(dim, 0, size - 1)], dim)
    after = torch.cat([x.narrow(dim, 1, size - 1), x.narrow(dim, size - 1, 1)], dim)
    return torch.minimum(x, torch.minimum(before, after) + (2 * k + 1).to(x.dtype))


@primitive
def grown_distances(shape: Tensor, limit: int, taps: List[float], kernel_size: int, h: float) -> Tensor:
    """The time at which a shape (B, C, H, W) of ones reaches each pixel, if it grows by half a kernel per
    step, at most ``limit`` times: see ``contrib.distance_transform``.

    ``taps`` are the kernel_size x kernel_size values of exp(-d / h).

    >>> taps = [math.exp(-math.hypot(i, j) / 0.01) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    >>> grown_distances(torch.tensor([[[[1.0, 0.0, 0.0, 0.0]]]]), 5, taps, 3, 0.01).round()
    tensor([[[[0., 1., 2., 3.]]]])
    """
    return _grown(torch.stack([torch.zeros_like(shape), shape]), limit, taps, kernel_size, h)[0]


@grown_distances.lowering("native", when=kernels.has_kernel)
def _grown_distances_kernel(
    shape: Tensor, limit: int, taps: List[float], kernel_size: int, h: float
) -> Tensor:
    window = torch.tensor(taps, dtype=shape.dtype, device=shape.device).reshape(kernel_size, kernel_size)
    return kernels.grown_distances(shape.flatten(0, 1), window, h, limit).reshape(shape.shape)


@until_stable
def _grown(state: Tensor, k: Tensor, taps: List[float], kernel_size: int, h: float) -> Tensor:
    """One step: the distances found so far, and the shape that they reach."""
    shape, radius = state[1], kernel_size // 2
    p = padded(shape, (radius, radius), (radius, radius), "replicate")
    height, width = p.size(2) - 2 * radius, p.size(3) - 2 * radius
    near = torch.zeros_like(p[:, :, :height, :width])
    for i in range(kernel_size):
        for j in range(kernel_size):
            near = near + p[:, :, i : i + height, j : j + width] * taps[i * kernel_size + j]
    return _reached(state, k * radius, near, h)


def grown_distances3d(shape: Tensor, limit: int, taps: List[float], kernel_size: int, h: float) -> Tensor:
    """``grown_distances`` for volumes (B, C, D, H, W), with kernel_size^3 ``taps``.

    >>> taps = [math.exp(-math.sqrt(float(i != 13)) / 0.01) for i in range(27)]
    >>> grown_distances3d(
    ...     torch.tensor([1.0, 0.0, 0.0]).reshape(1, 1, 3, 1, 1), 5, taps, 3, 0.01
    ... ).round().flatten()
    tensor([0., 1., 2.])
    """
    return _grown3d(torch.stack([torch.zeros_like(shape), shape]), limit, taps, kernel_size, h)[0]


@until_stable
def _grown3d(state: Tensor, k: Tensor, taps: List[float], kernel_size: int, h: float) -> Tensor:
    """``_grown`` for volumes."""
    p, radius = state[1], kernel_size // 2
    depth, height, width = p.size(2), p.size(3), p.size(4)
    for dim in [2, 3, 4]:
        position = torch.arange(p.size(dim) + 2 * radius, device=p.device) - radius
        p = p.index_select(dim, position.clamp(0, p.size(dim) - 1))
    near = torch.zeros_like(state[0])
    for i in range(kernel_size):
        for j in range(kernel_size):
            for m in range(kernel_size):
                part = p[:, :, i : i + depth, j : j + height, m : m + width]
                near = near + part * taps[(i * kernel_size + j) * kernel_size + m]
    return _reached(state, k * radius, near, h)


def _reached(state: Tensor, offset: Tensor, near: Tensor, h: float) -> Tensor:
    """The distances found so far, and the shape that they reach, after a step of ``near``, the sums of the
    shape's pixels in the kernel."""
    distance, shape = state[0], state[1]
    # The sum is 1 or more on the shape, and 0 out of reach.
    reached = (near > 0) & (near < 1)
    beyond = -h * torch.log(torch.where(reached, near, torch.ones_like(near)))
    found = reached & (beyond > 0)
    return torch.stack(
        [
            torch.where(found, distance + offset.to(distance.dtype) + beyond, distance),
            torch.where(found, torch.ones_like(shape), shape),
        ]
    )
