"""Clusters of points."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank
from ..primitives.core.loops import repeated
from ..primitives.linalg.matrices import small_matmul


def kmeans(x: Tensor, centers: Tensor, num_iterations: int) -> Tuple[Tensor, Tensor]:
    """Lloyd's algorithm with a fixed number of iterations: each point goes to the nearest centre, each centre
    to the mean of its points.

    S. P. Lloyd, Least squares quantization in PCM, IEEE Transactions on Information Theory 28(2), 1982. A
    centre without points stays where it is; of centres as near as each other the first has the point.
    Kornia's class draws the first centres itself and stops when they move little; here they are given, and
    once nothing changes further iterations change nothing. Computed in float64.

    Args:
        x: (N, D), floating point.
        centers: (K, D), the first centres, floating point.
        num_iterations: zero or more.

    Returns:
        The centres (K, D) in x's dtype, and the nearest of them to each point (N,), int64. Gradients are of
        the means, with the points staying with their centres.

    Raises:
        TypeError: if x or centers is not floating point.
        ValueError: if x is not (N, D), centers not (K, D) with K at least 1, or num_iterations negative.

    Example:
        >>> kmeans(torch.tensor([[0.0], [1.0], [8.0], [10.0]]), torch.tensor([[0.0], [1.0]]), 5)
        (tensor([[0.5000],
                [9.0000]]), tensor([0, 0, 1, 1]))
    """
    check_rank(x, 2, "(N, D)", "x")
    check_floating(x, "x")
    check_floating(centers, "centers")
    if centers.dim() != 2 or centers.size(1) != x.size(1) or centers.size(0) < 1:
        raise ValueError(f"centers: expected shape (K, D) for x {list(x.shape)}, got {list(centers.shape)}")
    if num_iterations < 0:
        raise ValueError(f"num_iterations: expected zero or more, got {num_iterations}")
    # About the mean, so that products of coordinates are not large beside the distances.
    points = x.to(torch.float64)
    origin = points.mean(0)
    points, found = points - origin, centers.to(torch.float64) - origin
    found = _moved(found, num_iterations, points)
    return (found + origin).to(x.dtype), _nearest(points, found)


def _nearest(points: Tensor, centers: Tensor) -> Tensor:
    """Index of the nearest centre: of the squared distance, what a point adds to that of every centre is left
    out."""
    fixed = centers.detach()
    return ((fixed * fixed).sum(1) - 2.0 * small_matmul(points.detach(), fixed.t())).argmin(1)


@repeated
def _moved(centers: Tensor, k: Tensor, points: Tensor) -> Tensor:
    """The centres after an iteration."""
    number = torch.arange(centers.size(0), device=centers.device)
    has = (_nearest(points, centers)[None] == number[:, None]).to(points.dtype)
    count = has.sum(1, keepdim=True)
    return torch.where(count > 0, small_matmul(has, points) / count.clamp(min=1.0), centers)
