"""Affine maps from correspondences."""

from typing import Optional

import torch
from torch import Tensor

from ...primitives.core.checks import check_floating, check_leading
from ...primitives.linalg.matrices import inverse, small_matmul


def find_affine(points1: Tensor, points2: Tensor, weights: Optional[Tensor] = None) -> Tensor:
    """Affine map from three or more correspondences: the least weighted sum of squared distances.

    The normal equations of points moved to their centroid, in float64: A = C M^-1 with M the second moments
    of points1 and C those between points2 and points1.

    Args:
        points1: (B, N, 2), floating point, N >= 3, not all on a line.
        points2: (B, N, 2).
        weights: (B, N), not negative; ones by default.

    Returns:
        (B, 3, 3) with the last row (0, 0, 1), mapping points1 to points2. Infinite or NaN where points1 lie
        on a line.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> corner = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])
        >>> find_affine(corner, 2.0 * corner + 1.0)[0]
        tensor([[2., 0., 1.],
                [0., 2., 1.],
                [0., 0., 1.]])
    """
    check_floating(points1, "points1")
    check_floating(points2, "points2")
    if points1.dim() != 3 or points1.size(2) != 2 or points1.size(1) < 3:
        raise ValueError(f"points1: expected shape (B, N, 2) with N of at least 3, got {list(points1.shape)}")
    if points2.dim() != 3 or points2.size(2) != 2 or points2.size(1) != points1.size(1):
        raise ValueError(
            f"points2: expected shape (B, {points1.size(1)}, 2) like points1, got {list(points2.shape)}"
        )
    check_leading([points1, points2], ["points1", "points2"], [1, 1])
    p, q = points1.to(torch.float64), points2.to(torch.float64)
    w = torch.ones_like(p[..., :1])
    if weights is not None:
        check_floating(weights, "weights")
        if weights.dim() != 2 or weights.size(1) != points1.size(1):
            raise ValueError(f"weights: expected shape (B, {points1.size(1)}), got {list(weights.shape)}")
        check_leading([points1, points2, weights], ["points1", "points2", "weights"], [1, 1, 0])
        w = weights.to(torch.float64)[..., None]
    total = w.sum(1, keepdim=True)
    centre1, centre2 = (w * p).sum(1, keepdim=True) / total, (w * q).sum(1, keepdim=True) / total
    offset = p - centre1
    weighted = (w * offset)[..., None, :]
    moments = (offset[..., :, None] * weighted).sum(1)
    mixed = ((q - centre2)[..., :, None] * weighted).sum(1)
    linear = small_matmul(mixed, inverse(moments))
    shift = centre2.transpose(1, 2) - small_matmul(linear, centre1.transpose(1, 2))
    upper = torch.cat([linear, shift], -1)
    last = torch.tensor([[[0.0, 0.0, 1.0]]], dtype=upper.dtype, device=upper.device)
    return torch.cat([upper, last.expand_as(upper[:, :1])], 1).to(points1.dtype)
