"""Square roots of matrices by products alone."""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from .matrices import small_matmul


def spd_square_roots(m: Tensor, least: float = 1e-5) -> Tuple[Tensor, Tensor]:
    """The square root of a symmetric positive definite (n, n), and the root's inverse; best in float64.

    Newton-Schulz iteration in N. J. Higham's coupled form (Functions of Matrices, 2008, 6.35), scaled as by
    J. Chen and E. Chow (A stable scaling of Newton-Schulz, 2014), so that eigenvalues down to ``least``
    squared times the trace converge in a fixed number of steps.

    >>> root, inverse = spd_square_roots(torch.diag(torch.tensor([1.0, 4.0, 9.0], dtype=torch.float64)))
    >>> root.diagonal()
    tensor([1.0000, 2.0000, 3.0000], dtype=torch.float64)
    >>> inverse.diagonal()
    tensor([1.0000, 0.5000, 0.3333], dtype=torch.float64)
    """
    eye = torch.eye(m.size(0), dtype=m.dtype, device=m.device)
    trace = (m * eye).sum()
    root = m / trace
    inverse = eye
    for scale in _scales(least):
        # One step maps a singular value s of the root to scale s (3 - scale^2 s^2) / 2, which is closer to 1.
        step = (3.0 * eye - small_matmul(inverse, root) * (scale * scale)) * (0.5 * scale)
        root = small_matmul(root, step)
        inverse = small_matmul(step, inverse)
    length = torch.sqrt(trace)
    return root * length, inverse / length


def _scales(least: float) -> List[float]:
    """The scale of each step if all singular values are between ``least`` and 1: it maps both ends to the
    same value."""
    scales: List[float] = []
    low = least
    while low < 1.0 - 1e-9:
        scale = math.sqrt(3.0 / (1.0 + low + low * low))
        scales.append(scale)
        low = 0.5 * scale * low * (3.0 - scale * scale * low * low)
    # one step more, for smaller values and for rounding
    scales.append(1.0)
    scales.append(1.0)
    return scales
