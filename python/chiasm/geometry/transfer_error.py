"""Distances of correspondences from a homography."""

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_leading,
    check_matrix,
    check_rank,
    check_tensor,
)
from ..primitives.geometry.intrinsics import over_depth, with_one
from ..primitives.linalg.matrices import cross, inverse3x3, small_matmul
from ..primitives.numbers.loss_reduction import widened


def oneway_transfer_error(
    pts1: Tensor, pts2: Tensor, H: Tensor, squared: bool = True, eps: float = 1e-8
) -> Tensor:
    """Distances in the second image between points and the transformed points of the first image.

    Args:
        pts1, pts2: (B, N, 2), or (B, N, 3) homogeneous, floating point.
        H: (B, 3, 3), from the first image to the second.
        squared: return squared distances.
        eps: added under the square root, so that the derivative at distance 0 is finite.

    Returns:
        (B, N), in pixels or their squares. Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> oneway_transfer_error(
        ...     torch.tensor([[[1.0, 2.0]]]), torch.tensor([[[4.0, 6.0]]]), torch.eye(3)[None]
        ... )
        tensor([[25.]])
    """
    _check(pts1, pts2, H)
    error = _oneway(widened(pts1), widened(pts2), widened(H))
    return _as_given(error if squared else torch.sqrt(error + eps), pts1, pts2, H)


def _oneway(pts1: Tensor, pts2: Tensor, H: Tensor) -> Tensor:
    offset = _plain(pts2) - _mapped(H, _homogeneous(pts1))
    return (offset * offset).sum(-1)


def _as_given(error: Tensor, a: Tensor, b: Tensor, c: Tensor) -> Tensor:
    """What was computed of ``widened`` a, b and c in the dtype to which PyTorch promotes theirs."""
    return error.to(torch.promote_types(torch.promote_types(a.dtype, b.dtype), c.dtype))


def symmetric_transfer_error(
    pts1: Tensor, pts2: Tensor, H: Tensor, squared: bool = True, eps: float = 1e-8
) -> Tensor:
    """Sum of the squared transfer errors in both images: the distances between points and their transformed
    partners.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 4.2.2.

    Args:
        pts1, pts2: (B, N, 2), or (B, N, 3) homogeneous, floating point.
        H: (B, 3, 3), from the first image to the second.
        squared: return the sum; otherwise its square root.
        eps: added under the square root.

    Returns:
        (B, N); infinite if H has no inverse (in Kornia, the largest number of the dtype). Differentiable in
        all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> symmetric_transfer_error(
        ...     torch.tensor([[[1.0, 2.0]]]), torch.tensor([[[4.0, 6.0]]]), torch.eye(3)[None]
        ... )
        tensor([[50.]])
    """
    _check(pts1, pts2, H)
    p, q, h = widened(pts1), widened(pts2), widened(H)
    determinant = (h[:, 0] * cross(h[:, 1], h[:, 2])).sum(-1)
    singular = determinant == 0
    eye = torch.eye(3, dtype=h.dtype, device=h.device)
    safe = torch.where(singular[:, None, None], eye, h)
    error = _oneway(p, q, safe) + _oneway(q, p, inverse3x3(safe))
    error = error if squared else torch.sqrt(error + eps)
    error = torch.where(singular[:, None], torch.full_like(error, float("inf")), error)
    return _as_given(error, pts1, pts2, H)


def sampson_homography_distance(pts1: Tensor, pts2: Tensor, H: Tensor, squared: bool = True) -> Tensor:
    """Sampson distance: first-order approximation of the distance, in both images, to the nearest exact
    correspondence.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 4.2.6: e^T (J J^T)^-1 e, where e are the
    residuals of the two equations of the direct linear transform and J are their derivatives with respect to
    the four coordinates.

    Args:
        pts1, pts2: (B, N, 2), or (B, N, 3) homogeneous, floating point.
        H: (B, 3, 3), from the first image to the second.
        squared: return squared distances.

    Returns:
        (B, N), in pixels or their squares. Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> sampson_homography_distance(
        ...     torch.tensor([[[1.0, 2.0]]]), torch.tensor([[[4.0, 6.0]]]), torch.eye(3)[None]
        ... )
        tensor([[12.5000]])
    """
    _check(pts1, pts2, H)
    p, q, wide = _plain(widened(pts1)), _plain(widened(pts2)), widened(H)
    mapped = small_matmul(with_one(p), wide.transpose(1, 2))
    depth = mapped[..., 2]
    u, v = q[..., 0], q[..., 1]
    e1, e2 = mapped[..., 0] - u * depth, mapped[..., 1] - v * depth
    h = wide[:, None]
    a1, b1 = h[..., 0, 0] - u * h[..., 2, 0], h[..., 0, 1] - u * h[..., 2, 1]
    a2, b2 = h[..., 1, 0] - v * h[..., 2, 0], h[..., 1, 1] - v * h[..., 2, 1]
    first, second, mixed = (
        a1 * a1 + b1 * b1 + depth * depth,
        a2 * a2 + b2 * b2 + depth * depth,
        a1 * a2 + b1 * b2,
    )
    determinant = first * second - mixed * mixed
    flat = determinant <= 0
    error = (e1 * e1 * second - 2.0 * e1 * e2 * mixed + e2 * e2 * first) / torch.where(
        flat, torch.ones_like(determinant), determinant
    )
    return _as_given(error if squared else _safe_root(error), pts1, pts2, H)


def line_segment_transfer_error_one_way(ls1: Tensor, ls2: Tensor, H: Tensor, squared: bool = False) -> Tensor:
    """Mean distance of the transferred end points of segments from the lines through the second image's
    segments.

    The distance is in pixels: the lines are normalized, so that long and short segments have equal weights.

    Args:
        ls1, ls2: (B, N, 2, 2), the segments' two end points, floating point.
        H: (B, 3, 3), from the first image to the second.
        squared: return the square of the mean.

    Returns:
        (B, N). Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> segment = torch.tensor([[[[0.0, 0.0], [4.0, 0.0]]]])
        >>> line_segment_transfer_error_one_way(segment + 1.0, segment, torch.eye(3)[None])
        tensor([[1.]])
    """
    check_segments(ls1, "ls1")
    check_segments(ls2, "ls2")
    check_rank(H, 3, "(B, 3, 3)", "H")
    check_matrix(H, 3, 3, "H")
    check_broadcastable(ls2, ls1, "ls2", "ls1", 2, 2)
    check_leading([ls1, ls2, H], ["ls1", "ls2", "H"], [3, 3, 2])
    a, b, h = widened(ls1), widened(ls2), widened(H)
    line = line_through(with_one(b[:, :, 0]), with_one(b[:, :, 1]))
    first = (line * with_one(_mapped(h, with_one(a[:, :, 0])))).sum(-1)
    second = (line * with_one(_mapped(h, with_one(a[:, :, 1])))).sum(-1)
    error = 0.5 * (first.abs() + second.abs())
    return _as_given(error * error if squared else error, ls1, ls2, H)


def line_through(a: Tensor, b: Tensor) -> Tensor:
    """The line (*, 3) through homogeneous points (*, 3), with a normal of unit length; zero if the points are
    equal."""
    line = cross(a, b)
    squared = line[..., 0:1] * line[..., 0:1] + line[..., 1:2] * line[..., 1:2]
    return line / torch.sqrt(torch.where(squared == 0, torch.ones_like(squared), squared))


def check_segments(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, N, 2, 2) tensor."""
    check_rank(value, 4, "(B, N, 2, 2)", name)
    check_matrix(value, 2, 2, name)


def _check(pts1: Tensor, pts2: Tensor, H: Tensor) -> None:
    _check_points(pts1, "pts1")
    _check_points(pts2, "pts2")
    check_rank(H, 3, "(B, 3, 3)", "H")
    check_matrix(H, 3, 3, "H")
    check_broadcastable(pts2, pts1, "pts2", "pts1", 1, 1)
    check_leading([pts1, pts2, H], ["pts1", "pts2", "H"], [2, 2, 2])


def _check_points(value: Tensor, name: str) -> None:
    check_tensor(value, name)
    if value.dim() != 3 or value.size(2) not in (2, 3):
        raise ValueError(f"{name}: expected shape (B, N, 2) or (B, N, 3), got {list(value.shape)}")
    check_floating(value, name)


def _homogeneous(points: Tensor) -> Tensor:
    return with_one(points) if points.size(-1) == 2 else points


def _plain(points: Tensor) -> Tensor:
    return points if points.size(-1) == 2 else over_depth(points, 1e-8)


def _mapped(H: Tensor, points: Tensor) -> Tensor:
    """Points (B, N, 2) of homogeneous (B, N, 3) under H."""
    return over_depth(small_matmul(points, H.transpose(1, 2)), 1e-8)


def _safe_root(x: Tensor) -> Tensor:
    """Square root whose derivative at 0 is 0."""
    positive = x > 0
    return torch.where(
        positive, torch.sqrt(torch.where(positive, x, torch.ones_like(x))), torch.zeros_like(x)
    )
