"""Planes through points."""

from typing import Optional, Tuple

from torch import Tensor

from ..primitives.linalg.matrices import smallest_eigenvector
from ..primitives.linalg.scatter_matrix import mean_and_scatter

__all__ = ["fit_plane"]


def __dir__() -> list[str]:
    return __all__


def fit_plane(points: Tensor, weights: Optional[Tensor] = None) -> Tuple[Tensor, Tensor]:
    """Fit planes (in 2D, lines) to points by the least sum of squared distances, computed in float64.

    K. Pearson, On lines and planes of closest fit to systems of points in space, 1901. Kornia returns an
    object with the same two values.

    Args:
        points: (B, N, D) or (N, D), N at least D and D at least 2, floating point.
        weights: (B, N) or (N,), not negative, some positive; ones by default.

    Returns:
        Normal (B, D) of unit length, whose largest coordinate in absolute value is positive, and offset (B,),
        without B if points have none: the plane is normal . x + offset = 0. Differentiable in both arguments.
        If no plane is the best one (all points equal, or on a sphere), the result is an arbitrary plane
        through the mean.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> fit_plane(torch.tensor([[[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [1.0, 1.0, 2.0]]]))
        (tensor([[0., 0., 1.]]), tensor([-2.]))
    """
    mean, scatter = mean_and_scatter(points, weights)
    normal = smallest_eigenvector(scatter)
    offset = -(normal * mean).sum(-1)
    if points.dim() == 2:
        normal, offset = normal[0], offset[0]
    return normal.to(points.dtype), offset.to(points.dtype)
