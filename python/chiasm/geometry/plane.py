"""Planes through points."""

from typing import Optional, Tuple, Union

import torch
import torch.nn.functional as F
from torch import Tensor

from ..primitives.core.modules import Module, hold
from ..primitives.linalg.matrices import smallest_eigenvector
from ..primitives.linalg.scatter_matrix import mean_and_scatter
from ..primitives.numbers.loss_reduction import widened
from .vector import Scalar, Vector3, bare

__all__ = ["Hyperplane", "fit_plane"]


def __dir__() -> list[str]:
    return __all__


class Hyperplane(Module):
    """Planes: the points p with ``normal . p + offset = 0``, for eager Python.

    Args:
        n: (*, 3), the normals, of length 1 for the distances and projections; a Vector3 or a tensor.
        d: (*), the offsets; a Scalar or a tensor.

    Example:
        >>> plane = Hyperplane.through(torch.eye(3)[0], torch.eye(3)[1], torch.zeros(3))
        >>> plane.abs_distance(torch.tensor([5.0, 6.0, 7.0]))
        Scalar(7.0)
    """

    _normal: Tensor
    _offset: Tensor

    def __init__(self, n: Union[Vector3, Tensor], d: Union[Scalar, Tensor]) -> None:
        super().__init__()
        hold(self, "_normal", Vector3(bare(n)).data)
        hold(self, "_offset", Scalar(bare(d)).data)

    @property
    def normal(self) -> Vector3:
        """(*, 3)."""
        return Vector3(self._normal)

    @property
    def offset(self) -> Scalar:
        """(*)."""
        return Scalar(self._offset)

    def extra_repr(self) -> str:
        return f"normal={self.normal}, offset={self.offset}"

    @classmethod
    def from_vector(cls, n: Union[Vector3, Tensor], e: Union[Vector3, Tensor]) -> "Hyperplane":
        """The planes with normals n through the points e, both (*, 3)."""
        return cls(n, -(bare(n) * bare(e)).sum(-1))

    @classmethod
    def through(
        cls,
        p0: Union[Vector3, Tensor],
        p1: Union[Vector3, Tensor],
        p2: Union[Vector3, Tensor],
    ) -> "Hyperplane":
        """The planes through three points (*, 3), which seen from the side of the normal turn to the right.
        Where the points are on a line, the plane is one of those through that line."""
        points = [bare(p0), bare(p1), bare(p2)]
        origin = widened(points[0])
        first, second = widened(points[1]) - origin, widened(points[2]) - origin
        normal = torch.linalg.cross(second, first)
        length = torch.linalg.vector_norm(normal, dim=-1, keepdim=True)
        edges = [torch.linalg.vector_norm(edge, dim=-1, keepdim=True) for edge in (first, second)]
        is_plane = length > torch.finfo(normal.dtype).eps * (edges[0] * edges[1])
        along = torch.where(edges[0] > edges[1], first, second)
        # On a line, the normal is the line's cross product with the axis that is farthest from it.
        axis = F.one_hot(along.abs().argmin(-1), 3).to(along)
        beside = torch.where(along.abs().sum(-1, keepdim=True) > 0, torch.linalg.cross(along, axis), axis)
        scaled = normal / torch.where(is_plane, length, torch.ones_like(length))
        unit = torch.where(is_plane, scaled, F.normalize(beside, dim=-1))
        dtype = (points[0] + points[1] + points[2]).dtype
        return cls(unit.to(dtype), -(unit * origin).sum(-1).to(dtype))

    def signed_distance(self, p: Union[Vector3, Tensor]) -> Scalar:
        """(*), the distances of points (*, 3), positive on the normal's side."""
        return Scalar((bare(p) * self._normal).sum(-1) + self._offset)

    def abs_distance(self, p: Union[Vector3, Tensor]) -> Scalar:
        """(*), the distances of points (*, 3)."""
        return Scalar(self.signed_distance(p).data.abs())

    def projection(self, p: Union[Vector3, Tensor]) -> Vector3:
        """(*, 3), the points of the planes that are nearest to points (*, 3)."""
        return Vector3(bare(p) - self.signed_distance(p).data[..., None] * self._normal)


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
