"""Distances of correspondences from the epipolar constraint x2^T F x1 = 0.

R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 11.4.
"""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.geometry.intrinsics import homogeneous
from ...primitives.linalg.matrices import small_matmul
from .lines import check_correspondences


def sampson_epipolar_distance(
    pts1: Tensor, pts2: Tensor, Fm: Tensor, squared: bool = True, eps: float = 1e-8
) -> Tensor:
    """Sampson distance: first-order approximation of the distance to the nearest exact correspondence. The
    distance is measured in both images together. Kornia's use_matmul_at_less_than_points, which only affects
    its speed, does not exist here.

    Args:
        pts1, pts2: (*, N, 2), or (*, N, 3) homogeneous, floating point.
        Fm: (*, 3, 3), fundamental matrices from the first image to the second.
        squared: return squared distances.
        eps: added under the square root, so that the derivative at distance 0 is finite.

    Returns:
        (*, N), in pixels or their squares. Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> F = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # rows are epipolar lines
        >>> sampson_epipolar_distance(torch.tensor([[1.0, 2.0]]), torch.tensor([[7.0, 4.0]]), F)
        tensor([2.])
    """
    product, first, second = _terms(pts1, pts2, Fm)
    return _rooted(product * product / _nonzero(first + second), squared, eps)


def symmetrical_epipolar_distance(
    pts1: Tensor, pts2: Tensor, Fm: Tensor, squared: bool = True, eps: float = 1e-8
) -> Tensor:
    """Squared distances of points from their epipolar lines, summed over both images.

    Args:
        pts1, pts2: (*, N, 2), or (*, N, 3) homogeneous, floating point.
        Fm: (*, 3, 3), fundamental matrices from the first image to the second.
        squared: return the sum; otherwise its square root.
        eps: added under the square root.

    Returns:
        (*, N). Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> F = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        >>> symmetrical_epipolar_distance(torch.tensor([[1.0, 2.0]]), torch.tensor([[7.0, 4.0]]), F)
        tensor([8.])
    """
    product, first, second = _terms(pts1, pts2, Fm)
    return _rooted(product * product * (1.0 / _nonzero(first) + 1.0 / _nonzero(second)), squared, eps)


def left_to_right_epipolar_distance(pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor:
    """Distances of the second image's points from the epipolar lines of the first's.

    Args:
        pts1, pts2: (*, N, 2), or (*, N, 3) homogeneous, floating point.
        Fm: (*, 3, 3), fundamental matrices from the first image to the second.

    Returns:
        (*, N), in pixels. Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> F = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        >>> left_to_right_epipolar_distance(torch.tensor([[1.0, 2.0]]), torch.tensor([[7.0, 4.0]]), F)
        tensor([2.])
    """
    product, _, second = _terms(pts1, pts2, Fm)
    return product.abs() / torch.sqrt(_nonzero(second))


def right_to_left_epipolar_distance(pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor:
    """Distances of the first image's points from the epipolar lines of the second's.

    Args:
        pts1, pts2: (*, N, 2), or (*, N, 3) homogeneous, floating point.
        Fm: (*, 3, 3), fundamental matrices from the first image to the second.

    Returns:
        (*, N), in pixels. Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> F = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        >>> right_to_left_epipolar_distance(torch.tensor([[1.0, 2.0]]), torch.tensor([[7.0, 4.0]]), F)
        tensor([2.])
    """
    product, first, _ = _terms(pts1, pts2, Fm)
    return product.abs() / torch.sqrt(_nonzero(first))


def _terms(pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """x2^T F x1, and the squared lengths of the epipolar lines' normals in the first and the second image."""
    x1 = _finite(homogeneous(pts1, "pts1"))
    x2 = _finite(homogeneous(pts2, "pts2"))
    check_correspondences(pts1, pts2, Fm)
    line2 = small_matmul(x1, Fm.transpose(-2, -1))
    line1 = small_matmul(x2, Fm)
    first = line1[..., 0] * line1[..., 0] + line1[..., 1] * line1[..., 1]
    second = line2[..., 0] * line2[..., 0] + line2[..., 1] * line2[..., 1]
    return (x2 * line2).sum(-1), first, second


def _finite(points: Tensor) -> Tensor:
    """Homogeneous points scaled to a last coordinate of 1, except for points at infinity."""
    last = points[..., 2:3]
    return points / _nonzero(last)


def _nonzero(x: Tensor) -> Tensor:
    """x with 1 in place of 0; there the numerators are 0 too."""
    return torch.where(x == 0, torch.ones_like(x), x)


def _rooted(error: Tensor, squared: bool, eps: float) -> Tensor:
    return error if squared else torch.sqrt(error + eps)
