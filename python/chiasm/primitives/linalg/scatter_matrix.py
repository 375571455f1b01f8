"""Mean and scatter of points, whose eigenvectors are the lines and planes of closest fit."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..core.checks import check_floating, check_leading, check_rank, check_tensor


def mean_and_scatter(points: Tensor, weights: Optional[Tensor]) -> Tuple[Tensor, Tensor]:
    """Weighted mean (B, D) and sum of w (p - mean)(p - mean)^T (B, D, D) of points (B, N, D), float64. Points
    (N, D) are a batch of one.

    >>> mean_and_scatter(torch.tensor([[[0.0, 1.0], [2.0, 1.0]]]), None)[1][0].tolist()
    [[2.0, 0.0], [0.0, 0.0]]
    """
    check_tensor(points, "points")
    if points.dim() != 2:
        check_rank(points, 3, "(B, N, D)", "points")
    check_floating(points, "points")
    if points.size(-1) < 2:
        raise ValueError(f"points: expected two coordinates or more, got {points.size(-1)}")
    p = points.to(torch.float64)
    w = torch.ones_like(p[..., :1])
    if weights is not None:
        check_tensor(weights, "weights")
        if weights.dim() != points.dim() - 1 or weights.size(-1) != points.size(-2):
            raise ValueError(
                f"weights: expected shape {list(points.shape[:-1])} for points {list(points.shape)},"
                f" got {list(weights.shape)}"
            )
        check_floating(weights, "weights")
        check_leading([points, weights], ["points", "weights"], [2, 1])
        w = weights.to(torch.float64)[..., None]
    if points.dim() == 2:
        p, w = p.unsqueeze(0), w.unsqueeze(0)
    mean = (w * p).sum(1) / w.sum(1)
    offset = p - mean[:, None]
    return mean, ((w * offset)[..., :, None] * offset[..., None, :]).sum(1)
