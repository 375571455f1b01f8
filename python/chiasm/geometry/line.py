"""Lines through points."""

from typing import Iterator, Optional, Tuple, Union

import torch
import torch.nn.functional as F
from torch import Tensor

from ..primitives.core.checks import check_broadcastable, check_floating
from ..primitives.core.modules import Module, hold
from ..primitives.linalg.matrices import largest_eigenvector
from ..primitives.linalg.scatter_matrix import mean_and_scatter
from .plane import Hyperplane
from .vector import Scalar, bare

__all__ = ["ParametrizedLine", "fit_line"]


def __dir__() -> list[str]:
    return __all__


class ParametrizedLine(Module):
    """Lines: the points ``origin + t direction``, for eager Python.

    Args:
        origin: (*, D), a point of each line; a Parameter is learned.
        direction: (*, D), of any length; of length 1 for the distances and projections.

    Raises:
        TypeError, ValueError: if an argument is not floating point, or the shapes do not agree.

    Example:
        >>> line = ParametrizedLine.through(torch.tensor([0.0, 1.0]), torch.tensor([3.0, 5.0]))
        >>> line.point_at(5.0), line.distance(torch.tensor([4.0, -2.0]))
        (tensor([3., 5.]), tensor(5.))
    """

    origin: Tensor
    direction: Tensor

    def __init__(self, origin: Tensor, direction: Tensor) -> None:
        super().__init__()
        check_floating(origin, "origin")
        check_floating(direction, "direction")
        check_broadcastable(direction, origin, "direction", "origin", 0, 0)
        hold(self, "origin", origin)
        hold(self, "direction", direction)

    def __iter__(self) -> Iterator[Tensor]:
        return iter((self.origin, self.direction))

    def __getitem__(self, index: int) -> Tensor:
        return (self.origin, self.direction)[index]

    def dim(self) -> int:
        """The number D of coordinates."""
        return self.direction.size(-1)

    @classmethod
    def through(cls, p0: Tensor, p1: Tensor) -> "ParametrizedLine":
        """Lines from points (*, D) to points (*, D), with directions of length 1."""
        if bool((p0 == p1).all(-1).any()):
            raise ValueError("p1: expected a point other than p0")
        return cls(p0, F.normalize(p1 - p0, dim=-1))

    def point_at(self, t: Union[float, Tensor, Scalar]) -> Tensor:
        """(*, D), the points ``origin + t direction``; t is a number, or (*) or (*, 1)."""
        step = torch.as_tensor(bare(t), dtype=self.direction.dtype, device=self.direction.device)
        if step.dim() > 0 and step.shape != (*self.direction.shape[:-1], 1):
            step = step[..., None]
        return self.origin + step * self.direction

    def projection(self, point: Tensor) -> Tensor:
        """(*, D), the point of each line that is nearest to ``point`` (*, D)."""
        along = ((point - self.origin) * self.direction).sum(-1, keepdim=True)
        return self.origin + along * self.direction

    def squared_distance(self, point: Tensor) -> Tensor:
        """(*), the squared distance of ``point`` (*, D) from each line."""
        return (point - self.projection(point)).square().sum(-1)

    def distance(self, point: Tensor) -> Tensor:
        """(*), the distance of ``point`` (*, D) from each line."""
        return torch.linalg.vector_norm(point - self.projection(point), dim=-1)

    def intersect(self, plane: Hyperplane, eps: float = 1e-6) -> Tuple[Tensor, Tensor]:
        """The parameter t (*) and the point (*, D) where each line meets a plane. Where a line is parallel to
        its plane (the inner product of direction and normal is below eps), t is infinite."""
        normal = bare(plane.normal)
        slope = (normal * self.direction).sum(-1)
        height = bare(plane.offset) + (normal * self.origin).sum(-1)
        parallel = slope.abs() < eps
        reach = -height / torch.where(parallel, torch.ones_like(slope), slope)
        t = torch.where(parallel, torch.full_like(slope, torch.inf), reach)
        point = self.point_at(t.detach()).detach()
        return t, torch.where(parallel[..., None], point, self.point_at(reach))


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
