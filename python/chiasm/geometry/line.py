"""Lines through points."""

from typing import Optional, Tuple

from torch import Tensor

from ..primitives.linalg.matrices import largest_eigenvector
from ..primitives.linalg.scatter_matrix import mean_and_scatter

__all__ = ["fit_line"]


def __dir__() -> list[str]:
    return __all__


def fit_line(points: Tensor, weights: Optional[Tensor] = None) -> Tuple[Tensor, Tensor]:
    """Fit lines to points by the least sum of squared perpendicular distances, computed in float64.

    K. Pearson, On lines and planes of closest fit to systems of points in space, 1901. Kornia returns an
    object with the same two values.

    Args:
        points: (B, N, D) or (N, D), N and D at least 2, floating point.
        weights: (B, N) or (N,), not negative, some positive; ones by default.

    Returns:
        Origin (B, D), the (weighted) mean, and direction (B, D) of unit length, whose largest coordinate in
        absolute value is positive; without B if points have none. Differentiable in both arguments. If no
        direction is the best one (all points equal, or on a circle), the direction is an arbitrary unit
        vector.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> fit_line(torch.tensor([[[0.0, 1.0], [2.0, 1.0], [4.0, 1.0]]]))
        (tensor([[2., 1.]]), tensor([[1., 0.]]))
    """
    origin, scatter = mean_and_scatter(points, weights)
    direction = largest_eigenvector(scatter)
    if points.dim() == 2:
        origin, direction = origin[0], direction[0]
    return origin.to(points.dtype), direction.to(points.dtype)
