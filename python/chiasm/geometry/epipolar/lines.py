"""Points and lines of an image, and the epipolar lines of another image's points."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_broadcastable, check_last, check_matrix
from ...primitives.geometry.intrinsics import homogeneous, over_depth
from ...primitives.linalg.matrices import cross, small_matmul
from ...primitives.numbers.loss_reduction import widened


def cross_product_matrix(x: Tensor) -> Tensor:
    """The skew-symmetric matrix that maps y to the cross product x x y.

    Args:
        x: (*, 3), floating point.

    Returns:
        (*, 3, 3).

    Raises:
        TypeError, ValueError: if x is not a floating-point (*, 3) tensor.

    Example:
        >>> cross_product_matrix(torch.tensor([1.0, 2.0, 3.0]))
        tensor([[ 0., -3.,  2.],
                [ 3.,  0., -1.],
                [-2.,  1.,  0.]])
    """
    check_last(x, 3, "x")
    a, b, c = x[..., 0], x[..., 1], x[..., 2]
    zero = torch.zeros_like(a)
    return torch.stack(
        [torch.stack([zero, -c, b], -1), torch.stack([c, zero, -a], -1), torch.stack([-b, a, zero], -1)], -2
    )


def compute_correspond_epilines(points: Tensor, F_mat: Tensor) -> Tensor:
    """Epipolar lines F x in the other image, on which the partners of points x lie.

    Args:
        points: (*, N, 2), or (*, N, 3) homogeneous, floating point. (For points of the second image, pass the
            transposed F.)
        F_mat: (*, 3, 3), fundamental matrices.

    Returns:
        (*, N, 3): a, b, c of a x + b y + c = 0 with a^2 + b^2 = 1, where a and b are not both zero.
        Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> compute_correspond_epilines(
        ...     torch.tensor([[1.0, 2.0]]), cross_product_matrix(torch.tensor([1.0, 0.0, 0.0]))
        ... )
        tensor([[ 0., -1.,  2.]])
    """
    x = homogeneous(points, "points")
    check_matrix(F_mat, 3, 3, "F_mat")
    check_broadcastable(F_mat, x, "F_mat", "points", 2, 2)
    return _epilines(x, F_mat)


def get_perpendicular(lines: Tensor, points: Tensor) -> Tensor:
    """Lines through points, perpendicular to given lines.

    Args:
        lines: (*, N, 3): a, b, c of a x + b y + c = 0, floating point.
        points: (*, N, 2), or (*, N, 3) homogeneous.

    Returns:
        (*, N, 3), not normalized. Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> get_perpendicular(torch.tensor([[0.0, 1.0, -5.0]]), torch.tensor([[3.0, 4.0]]))  # x = 3
        tensor([[-1.,  0.,  3.]])
    """
    check_last(lines, 3, "lines")
    x = homogeneous(points, "points")
    check_broadcastable(points, lines, "points", "lines", 1, 1)
    # All perpendiculars meet at infinity, in the direction of the lines' normal.
    normal = torch.cat([lines[..., 0:2], torch.zeros_like(lines[..., 2:3])], -1)
    return cross(x, normal)


def get_closest_point_on_epipolar_line(pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor:
    """Points of the second image, moved to the nearest point on the epipolar line of their partner.

    Args:
        pts1, pts2: (*, N, 2), or (*, N, 3) homogeneous, floating point.
        Fm: (*, 3, 3), fundamental matrices from the first image to the second.

    Returns:
        (*, N, 2), in the second image. Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> F = cross_product_matrix(torch.tensor([1.0, 0.0, 0.0]))
        >>> get_closest_point_on_epipolar_line(torch.tensor([[1.0, 2.0]]), torch.tensor([[7.0, 3.0]]), F)
        tensor([[7., 2.]])
    """
    x1 = homogeneous(pts1, "pts1")
    x2 = homogeneous(pts2, "pts2")
    check_correspondences(pts1, pts2, Fm)
    line = _epilines(widened(x1), widened(Fm))
    x = over_depth(widened(x2), 1e-8)
    normal = line[..., 0:2]
    made = x - ((x * normal).sum(-1, keepdim=True) + line[..., 2:3]) * normal
    return made.to(torch.promote_types(torch.promote_types(pts1.dtype, pts2.dtype), Fm.dtype))


def check_correspondences(pts1: Tensor, pts2: Tensor, Fm: Tensor) -> None:
    """Raise unless the shapes of ``pts1``, ``pts2`` and ``Fm`` fit together."""
    check_matrix(Fm, 3, 3, "Fm")
    check_broadcastable(pts2, pts1, "pts2", "pts1", 1, 1)
    check_broadcastable(Fm, pts1, "Fm", "pts1", 2, 2)
    check_broadcastable(Fm, pts2, "Fm", "pts2", 2, 2)


def _epilines(x: Tensor, Fm: Tensor) -> Tensor:
    """Lines Fm x of homogeneous points, with (a, b) of unit length."""
    line = small_matmul(x, Fm.transpose(-2, -1))
    squared = line[..., 0:1] * line[..., 0:1] + line[..., 1:2] * line[..., 1:2]
    return line / torch.sqrt(torch.where(squared == 0, torch.ones_like(squared), squared))
