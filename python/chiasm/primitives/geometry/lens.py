"""Lens distortion on the plane z = 1: D. Brown's radial and tangential terms, and OpenCV's further terms.

Coefficients are a list of 4, 5, 8, 12 or 14, each of which broadcasts with the points: k1, k2, p1, p2, k3,
k4, k5, k6, s1, s2, s3, s4 and the tilt of the sensor about x and y. Terms that a list omits are not computed.
Sources: D. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971; OpenCV's
documentation of calib3d; T. Louhichi et al., Self-calibration of Scheimpflug cameras, Meas. Sci. Technol. 18,
2007, for the tilt.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..linalg.matrices import small_matmul


def coefficients(dist: Tensor) -> List[Tensor]:
    """The columns of (*, n), as n tensors (*, 1)."""
    return [dist[..., i : i + 1] for i in range(dist.size(-1))]


def distort(x: Tensor, y: Tensor, k: List[Tensor]) -> Tuple[Tensor, Tensor]:
    """Points of the plane z = 1 after the lens distortion, without the tilt."""
    q = x * x + y * y
    ratio = _polynomial(q, k, 0)
    if len(k) > 5:
        ratio = ratio / _polynomial(q, k, 5)
    twist = 2.0 * x * y
    dx = x * ratio + k[2] * twist + k[3] * (q + 2.0 * x * x)
    dy = y * ratio + k[2] * (q + 2.0 * y * y) + k[3] * twist
    if len(k) > 8:
        dx, dy = dx + q * (k[8] + q * k[9]), dy + q * (k[10] + q * k[11])
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


def _polynomial(q: Tensor, k: List[Tensor], first: int) -> Tensor:
    """1 + k1 q + k2 q^2 + k3 q^3, or, with ``first`` 5, the same of k4, k5 and k6."""
    third = 4 if first == 0 else 7
    if third < len(k):
        return 1.0 + q * (k[first] + q * (k[first + 1] + q * k[third]))
    return 1.0 + q * (k[first] + q * k[first + 1])


def _slope(q: Tensor, k: List[Tensor], first: int) -> Tensor:
    """The derivative of ``_polynomial``."""
    third = 4 if first == 0 else 7
    if third < len(k):
        return k[first] + q * (2.0 * k[first + 1] + q * 3.0 * k[third])
    return k[first] + q * (2.0 * k[first + 1])


def _newton_step(u: Tensor, v: Tensor, rx: Tensor, ry: Tensor, k: List[Tensor]) -> Tuple[Tensor, Tensor]:
    """(u, v) minus the inverse of distort's derivative there times the residual (rx, ry)."""
    q = u * u + v * v
    ratio, slope = _polynomial(q, k, 0), _slope(q, k, 0)
    if len(k) > 5:
        lower = _polynomial(q, k, 5)
        ratio = ratio / lower
        slope = (slope - ratio * _slope(q, k, 5)) / lower
    b = 2.0 * (u * v * slope + k[2] * u + k[3] * v)
    a = ratio + 2.0 * u * u * slope + 2.0 * k[2] * v + 6.0 * k[3] * u
    d = ratio + 2.0 * v * v * slope + 6.0 * k[2] * v + 2.0 * k[3] * u
    c = b
    if len(k) > 8:
        thin_x, thin_y = 2.0 * (k[8] + 2.0 * q * k[9]), 2.0 * (k[10] + 2.0 * q * k[11])
        a, b, c, d = a + thin_x * u, b + thin_x * v, c + thin_y * u, d + thin_y * v
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
    return (h[..., 0, 0:1] * x + h[..., 0, 1:2] * y + h[..., 0, 2:3]) / depth, (
        h[..., 1, 0:1] * x + h[..., 1, 1:2] * y + h[..., 1, 2:3]
    ) / depth


def _matrix(entries: List[Tensor]) -> Tensor:
    rows = [torch.stack(entries[0:3], -1), torch.stack(entries[3:6], -1), torch.stack(entries[6:9], -1)]
    return torch.stack(rows, -2)
