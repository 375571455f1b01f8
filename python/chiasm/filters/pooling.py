"""Anti-aliased pooling."""

import math
from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_image, check_integer, odd_pair
from ..primitives.core.window_sizes import positive_pair
from ..primitives.filters.correlation import max_shifts, weigh_and_thin
from ..primitives.filters.padding import padded, stencil
from ..primitives.filters.stencil import separable_shared


def blur_pool2d(input: Tensor, kernel_size: Union[int, Tuple[int, int]], stride: int = 2) -> Tensor:
    """Smooth by a binomial kernel and keep every stride-th row and column; the border is padded with zeros.

    R. Zhang, Making convolutional networks shift-invariant again, ICML 2019.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: one for both axes or (rows, columns).
        stride: at least 1.

    Returns:
        (B, C, (H + 2 * ((rows - 1) // 2) - rows) // stride + 1, and the same formula for W and columns).

    Raises:
        TypeError: if input is not floating point, or stride not a whole number.
        ValueError: if input is not 4-D, or a size is not positive.

    Example:
        >>> blur_pool2d(torch.ones(1, 1, 4, 4), 3)[0, 0]
        tensor([[0.5625, 0.7500],
                [0.7500, 1.0000]])
    """
    check_image(input, "input")
    ky, kx = positive_pair(kernel_size, "kernel_size")
    check_integer(stride, "stride")
    if stride < 1:
        raise ValueError(f"stride: expected at least 1, got {stride}")
    ry, rx = (ky - 1) // 2, (kx - 1) // 2
    return weigh_and_thin(
        padded(input, (ry, ry), (rx, rx), "constant"), binomial_taps(ky), binomial_taps(kx), stride
    )


def max_blur_pool2d(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    stride: int = 2,
    max_pool_size: int = 2,
    ceil_mode: bool = False,
) -> Tensor:
    """Max pooling with stride 1, then ``blur_pool2d``.

    R. Zhang, Making convolutional networks shift-invariant again, ICML 2019.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: size of the blur kernel, one for both axes or (rows, columns).
        stride: stride of the blur, at least 1.
        max_pool_size: side of the max pooling window.
        ceil_mode: for compatibility with Kornia; it has no effect, since the stride of max pooling is 1.

    Returns:
        ``blur_pool2d`` of (B, C, H - max_pool_size + 1, W - max_pool_size + 1).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or a size is not positive.

    Example:
        >>> max_blur_pool2d(torch.eye(4)[None, None], 3)[0, 0]
        tensor([[0.5625, 0.3125],
                [0.3125, 0.5625]])
    """
    check_image(input, "input")
    if max_pool_size < 1:
        raise ValueError(f"max_pool_size: expected at least 1, got {max_pool_size}")
    return blur_pool2d(max_shifts(max_shifts(input, 2, max_pool_size), 3, max_pool_size), kernel_size, stride)


def edge_aware_blur_pool2d(
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    edge_threshold: float = 1.25,
    edge_dilation_kernel_size: int = 3,
    epsilon: float = 1e-6,
) -> Tensor:
    """Smooth by a binomial kernel, but not near edges; the output has the input's size.

    An edge is a place where the geometric mean of the channels changes by more than the factor edge_threshold
    over four pixels, along x or y. The border is reflected.

    Args:
        input: (B, C, H, W), floating point, not negative.
        kernel_size: odd, one for both axes or (rows, columns).
        edge_threshold: the factor, above 1.
        edge_dilation_kernel_size: side of the square that dilates the edges, odd.
        epsilon: added before the logarithm.

    Returns:
        (B, C, H, W). Edges count as constant in the gradient.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or another argument is not as above.

    Example:
        >>> step = torch.tensor([0.1, 0.1, 0.1, 0.1, 0.9, 0.9, 0.9, 0.9]).expand(1, 1, 8, 8)
        >>> torch.equal(edge_aware_blur_pool2d(step, 3)[..., 2:6], step[..., 2:6])
        True
    """
    check_image(input, "input")
    ky, kx = odd_pair(kernel_size, "kernel_size")
    size = odd_pair(edge_dilation_kernel_size, "edge_dilation_kernel_size")[0]
    if not edge_threshold > 1.0:
        raise ValueError(f"edge_threshold: expected more than 1, got {edge_threshold}")
    levels = torch.log2(input.detach() + epsilon).mean(1, keepdim=True)
    threshold = math.log(edge_threshold) / math.log(2.0)
    edges = _steps(levels, (2, 2), (2, 2), "reflect", threshold)
    r = size // 2
    mask = _widened(edges, (r, r), (r, r), "constant", size)
    blurred = separable_shared(input, binomial_taps(ky), binomial_taps(kx), "reflect")
    return mask * input + (1.0 - mask) * blurred


@stencil
def _steps(p: Tensor, threshold: float) -> Tensor:
    """Ones where levels over four pixels differ by more than the threshold, zeros elsewhere."""
    height, width = p.size(2) - 4, p.size(3) - 4
    rows, columns = p[:, :, 2 : height + 2], p[..., 2 : width + 2]
    along_x = (rows[..., 4:] - rows[..., :width]).abs()
    along_y = (columns[:, :, 4:] - columns[:, :, :height]).abs()
    return (torch.maximum(along_x, along_y) > threshold).to(p.dtype)


@stencil
def _widened(p: Tensor, size: int) -> Tensor:
    return max_shifts(max_shifts(p, 2, size), 3, size)


def binomial_taps(size: int) -> List[float]:
    """Row ``size - 1`` of Pascal's triangle, scaled to sum 1.

    >>> binomial_taps(3)
    [0.25, 0.5, 0.25]
    """
    taps = [1.0]
    for _ in range(size - 1):
        longer = [0.5 * taps[0]]
        for i in range(len(taps) - 1):
            longer.append(0.5 * (taps[i] + taps[i + 1]))
        longer.append(0.5 * taps[len(taps) - 1])
        taps = longer
    return taps
