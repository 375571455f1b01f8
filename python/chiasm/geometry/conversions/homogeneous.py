"""Points and matrices to and from homogeneous coordinates."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_floating, check_matrix, check_rank


def convert_points_to_homogeneous(points: Tensor) -> Tensor:
    """Append a coordinate 1.

    Args:
        points: (*, D), floating point.

    Returns:
        (*, D + 1).

    Raises:
        TypeError: if points is not floating point.
        ValueError: if points has no dimension.

    Example:
        >>> convert_points_to_homogeneous(torch.tensor([[3.0, 4.0]]))
        tensor([[3., 4., 1.]])
    """
    _check_points(points, 1, "(*, D)")
    return torch.cat([points, torch.ones_like(points[..., :1])], -1)


def convert_points_from_homogeneous(points: Tensor, eps: float = 1e-8) -> Tensor:
    """Divide by the last coordinate and drop it.

    Args:
        points: (*, D + 1), floating point.
        eps: if the absolute value of the last coordinate is at most eps, the other coordinates are not
            divided.

    Returns:
        (*, D).

    Raises:
        TypeError: if points is not floating point.
        ValueError: if points has fewer than two coordinates.

    Example:
        >>> convert_points_from_homogeneous(torch.tensor([[6.0, 8.0, 2.0], [6.0, 8.0, 0.0]]))
        tensor([[3., 4.],
                [6., 8.]])
    """
    _check_points(points, 2, "(*, D + 1)")
    last = points[..., -1:]
    return points[..., :-1] / torch.where(last.abs() > eps, last, torch.ones_like(last))


def convert_affinematrix_to_homography(A: Tensor) -> Tensor:
    """Append the row 0, 0, 1 to affine transforms of the plane.

    Args:
        A: (B, 2, 3), floating point.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError, ValueError: if A is not a floating-point (B, 2, 3) tensor.

    Example:
        >>> convert_affinematrix_to_homography(torch.ones(1, 2, 3))
        tensor([[[1., 1., 1.],
                 [1., 1., 1.],
                 [0., 0., 1.]]])
    """
    check_rank(A, 3, "(B, 2, 3)", "A")
    check_matrix(A, 2, 3, "A")
    return _with_last_row(A)


def convert_affinematrix_to_homography3d(A: Tensor) -> Tensor:
    """Append the row 0, 0, 0, 1 to affine transforms of space.

    Args:
        A: (B, 3, 4), floating point.

    Returns:
        (B, 4, 4).

    Raises:
        TypeError, ValueError: if A is not a floating-point (B, 3, 4) tensor.

    Example:
        >>> convert_affinematrix_to_homography3d(torch.ones(1, 3, 4))[0, 3]
        tensor([0., 0., 0., 1.])
    """
    check_rank(A, 3, "(B, 3, 4)", "A")
    check_matrix(A, 3, 4, "A")
    return _with_last_row(A)


def _check_points(points: Tensor, least: int, layout: str) -> None:
    check_floating(points, "points")
    if points.dim() < 1 or points.size(-1) < least:
        raise ValueError(f"points: expected shape {layout}, got {list(points.shape)}")


def _with_last_row(matrix: Tensor) -> Tensor:
    zero = torch.zeros_like(matrix[..., :1, :])
    return torch.cat([matrix, torch.cat([zero[..., :-1], zero[..., :1] + 1.0], -1)], -2)
