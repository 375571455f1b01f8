"""Lens distortion on the plane z = 1: D. Brown's radial and tangential terms, and what OpenCV adds to them.

Coefficients are a list of 14, each of which broadcasts with the points: k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 and the tilt of
the sensor about x and y. Sources: D. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971; OpenCV's
documentation of calib3d; T. Louhichi et al., Self-calibration of Scheimpflug cameras, Meas. Sci. Technol. 18, 2007, for the tilt.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from .linalg import small_matmul


def coefficients(dist: Tensor) -> List[Tensor]:
    """The columns of (*, n), n <= 14, as 14 tensors (*, 1); those that are not there are zeros."""
    columns: List[Tensor] = []
    for i in range(14):
        if i < dist.size(-1):
            columns.append(dist[..., i : i + 1])
        else:
            columns.append(torch.zeros_like(dist[..., 0:1]))
    return columns


def distort(x: Tensor, y: Tensor, k: List[Tensor]) -> Tuple[Tensor, Tensor]:
    """Where the lens takes points of the plane z = 1 (the tilt apart)."""
    q = x * x + y * y
    ratio, _ = _radial(q, k)
    twist = 2.0 * x * y
    dx = x * ratio + k[2] * twist + k[3] * (q + 2.0 * x * x) + q * (k[8] + q * k[9])
    dy = y * ratio + k[2] * (q + 2.0 * y * y) + k[3] * twist + q * (k[10] + q * k[11])
    return dx, dy


def undistort(x: Tensor, y: Tensor, k: List[Tensor], steps: int) -> Tuple[Tensor, Tensor]:
    """The inverse of :func:`distort` by Newton's method from (x, y); the last step carries the gradient."""
    fixed = [c.detach() for c in k]
    u, v = x.detach(), y.detach()
    for _ in range(steps - 1):
        dx, dy = distort(u, v, fixed)
        u, v = _newton_step(u, v, dx - x.detach(), dy - y.detach(), fixed)
    dx, dy = distort(u, v, k)
    return _newton_step(u, v, dx - x, dy - y, fixed)


def _radial(q: Tensor, k: List[Tensor]) -> Tuple[Tensor, Tensor]:
    """The radial factor as a function of the squared radius, and its derivative."""
    upper = 1.0 + q * (k[0] + q * (k[1] + q * k[4]))
    lower = 1.0 + q * (k[5] + q * (k[6] + q * k[7]))
    d_upper = k[0] + q * (2.0 * k[1] + q * 3.0 * k[4])
    d_lower = k[5] + q * (2.0 * k[6] + q * 3.0 * k[7])
    ratio = upper / lower
    return ratio, (d_upper - ratio * d_lower) / lower


def _newton_step(u: Tensor, v: Tensor, rx: Tensor, ry: Tensor, k: List[Tensor]) -> Tuple[Tensor, Tensor]:
    """(u, v) minus the inverse of distort's derivative there times the residual (rx, ry)."""
    q = u * u + v * v
    ratio, slope = _radial(q, k)
    thin_x, thin_y = 2.0 * (k[8] + 2.0 * q * k[9]), 2.0 * (k[10] + 2.0 * q * k[11])
    mixed = 2.0 * (u * v * slope + k[2] * u + k[3] * v)
    a = ratio + 2.0 * u * u * slope + 2.0 * k[2] * v + 6.0 * k[3] * u + thin_x * u
    b = mixed + thin_x * v
    c = mixed + thin_y * u
    d = ratio + 2.0 * v * v * slope + 6.0 * k[2] * v + 2.0 * k[3] * u + thin_y * v
    determinant = a * d - b * c
    return u - (d * rx - b * ry) / determinant, v - (a * ry - c * rx) / determinant


def tilt_matrices(taux: Tensor, tauy: Tensor) -> Tuple[Tensor, Tensor]:
    """The homography (*, 3, 3) onto a sensor tilted by angles (*), and its inverse."""
    zero, one = torch.zeros_like(taux), torch.ones_like(taux)
    cx, sx, cy, sy = torch.cos(taux), torch.sin(taux), torch.cos(tauy), torch.sin(tauy)
    turn_x = _matrix([one, zero, zero, zero, cx, sx, zero, -sx, cx])
    turn_y = _matrix([cy, zero, -sy, zero, one, zero, sy, zero, cy])
    rotation = small_matmul(turn_y, turn_x)
    r02, r12, r22 = rotation[..., 0, 2], rotation[..., 1, 2], rotation[..., 2, 2]
    onto = _matrix([r22, zero, -r02, zero, r22, -r12, zero, zero, one])
    back = _matrix([1.0 / r22, zero, r02 / r22, zero, 1.0 / r22, r12 / r22, zero, zero, one])
    return small_matmul(onto, rotation), small_matmul(rotation.transpose(-2, -1), back)


def under_homography(x: Tensor, y: Tensor, h: Tensor) -> Tuple[Tensor, Tensor]:
    """(x, y), each (*, N), under homographies (*, 3, 3)."""
    depth = h[..., 2, 0:1] * x + h[..., 2, 1:2] * y + h[..., 2, 2:3]
    return (h[..., 0, 0:1] * x + h[..., 0, 1:2] * y + h[..., 0, 2:3]) / depth, (h[..., 1, 0:1] * x + h[..., 1, 1:2] * y + h[..., 1, 2:3]) / depth


def _matrix(entries: List[Tensor]) -> Tensor:
    rows = [torch.stack(entries[0:3], -1), torch.stack(entries[3:6], -1), torch.stack(entries[6:9], -1)]
    return torch.stack(rows, -2)
