"""Projection of matrices that are nearly rotations onto the rotations."""

import torch
from torch import Tensor

from ..linalg.matrices import smallest_eigenvector


def nearest_rotation(m: Tensor) -> Tensor:
    """The rotation (*, 3, 3) nearest to a matrix of rank 2 or more, in the sum of squares: U diag(1, 1, det(U
    V^T)) V^T.

    Its quaternion is the eigenvector of the greatest eigenvalue of a symmetric 4x4 matrix: B. K. P. Horn,
    Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4(4), 1987. In
    float64; differentiable.

    >>> nearest_rotation(torch.diag(torch.tensor([2.0, 3.0, 4.0]))).diagonal()
    tensor([1., 1., 1.])
    """
    a = m.to(torch.float64).reshape(-1, 3, 3)
    length = torch.sqrt((a * a).sum(-1).sum(-1))[:, None, None] + 1e-300
    a = a / length.detach()
    xx, yy, zz = a[:, 0, 0], a[:, 1, 1], a[:, 2, 2]
    x, y, z = a[:, 2, 1] - a[:, 1, 2], a[:, 0, 2] - a[:, 2, 0], a[:, 1, 0] - a[:, 0, 1]
    xy, xz, yz = a[:, 0, 1] + a[:, 1, 0], a[:, 0, 2] + a[:, 2, 0], a[:, 1, 2] + a[:, 2, 1]
    rows = [
        torch.stack([xx + yy + zz, x, y, z], -1),
        torch.stack([x, xx - yy - zz, xy, xz], -1),
        torch.stack([y, xy, yy - xx - zz, yz], -1),
        torch.stack([z, xz, yz, zz - xx - yy], -1),
    ]
    # Twice the norm exceeds every eigenvalue: so the greatest becomes the smallest, and all are positive.
    turned = 2.0 * torch.eye(4, dtype=a.dtype, device=a.device) - torch.stack(rows, -2)
    q = smallest_eigenvector(turned)
    w, x, y, z = q[:, 0], q[:, 1], q[:, 2], q[:, 3]
    matrix = [
        torch.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)], -1),
        torch.stack([2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)], -1),
        torch.stack([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], -1),
    ]
    return torch.stack(matrix, -2).reshape(m.shape).to(m.dtype)
