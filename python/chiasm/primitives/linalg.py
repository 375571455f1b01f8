"""Small linear algebra in arithmetic only: ONNX has no inverse, SVD or eigen decomposition."""

import torch
from torch import Tensor

from .target import native_forward, tracing_vjp


def small_matmul(a: Tensor, b: Tensor) -> Tensor:
    """Matrix product of (..., n, k) and (..., k, m) for small sizes.

    Native code gets a sum of products, which compiles inline instead of calling a library; so do backward passes, which
    are traced once for every target.
    """
    if native_forward() or tracing_vjp():
        return (a[..., :, :, None] * b[..., None, :, :]).sum(-2)
    return torch.matmul(a, b)


def cross(a: Tensor, b: Tensor) -> Tensor:
    """Cross product along the last axis, of size 3."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return torch.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], -1)


def inverse3x3(m: Tensor) -> Tensor:
    """Inverse of (..., 3, 3) by cofactors.

    >>> inverse3x3(torch.diag(torch.tensor([1.0, 2.0, 4.0]))).diagonal()
    tensor([1.0000, 0.5000, 0.2500])
    """
    r0, r1, r2 = m[..., 0, :], m[..., 1, :], m[..., 2, :]
    c0 = cross(r1, r2)
    determinant = (r0 * c0).sum(-1)
    return torch.stack([c0, cross(r2, r0), cross(r0, r1)], -1) / determinant[..., None, None]


def spd_inverse(m: Tensor) -> Tensor:
    """Inverse of a symmetric positive definite (B, n, n) by n sweeps (Gauss-Jordan without pivoting)."""
    n = m.size(-1)
    eye = torch.eye(n, dtype=m.dtype, device=m.device)
    for k in range(n):
        column = m[:, :, k : k + 1] - eye[:, k : k + 1]
        row = m[:, k : k + 1, :] + eye[k : k + 1, :]
        m = m - column * (row / m[:, k : k + 1, k : k + 1])
    return m


def smallest_eigenvector(m: Tensor) -> Tensor:
    """Unit eigenvector (B, n) of the smallest eigenvalue of a symmetric positive semidefinite (B, n, n), float64.

    Inverse iteration: the inverse of the slightly shifted matrix, squared until its largest eigenvalue has swamped the
    others. That part carries no gradient; one first-order correction through the deflated inverse follows, which
    polishes the value and whose derivative is exactly the eigenvector's (for a simple eigenvalue; 0 for a double one).
    """
    m = m / (_trace(m) + 1e-300)
    return _eigenvector(m, spd_inverse(m.detach() + 1e-14 * _eye(m)), 7, 1.0)


def largest_eigenvector(m: Tensor) -> Tensor:
    """Unit eigenvector (B, n) of the largest eigenvalue of a symmetric positive semidefinite (B, n, n), float64.

    As `smallest_eigenvector`, by powers of the matrix itself: they tell apart eigenvalues that differ by a part in a hundred.
    """
    m = m / (_trace(m) + 1e-300)
    return _eigenvector(m, m.detach() + 1e-14 * _eye(m), 12, -1.0)


def _eigenvector(m: Tensor, power: Tensor, squarings: int, sign: float) -> Tensor:
    """The eigenvector that powers of `power` tend to, of m's smallest (sign 1) or largest (sign -1) eigenvalue."""
    eye = _eye(m)
    fixed = m.detach()
    for _ in range(squarings):
        power = power / _trace(power)
        power = small_matmul(power, power)
    # Every column is now a multiple of the eigenvector: take the longest, which is the one with the largest diagonal.
    diagonal = (power * eye).sum(-1)
    pick = (torch.argmax(diagonal, dim=-1)[:, None] == torch.arange(m.size(-1), device=m.device)).to(m.dtype)
    v = (power * pick[:, None, :]).sum(-1)
    v = v / torch.sqrt((v * v).sum(-1, keepdim=True))
    outer = v[:, :, None] * v[:, None, :]
    eigenvalue = (outer * fixed).sum(-1, keepdim=True).sum(-2, keepdim=True)
    deflated = sign * (spd_inverse(sign * (fixed - eigenvalue * eye) + outer) - outer)
    # Of a double eigenvalue any vector of the plane will do: no correction, and no derivative. (NaN is not less either.)
    simple = deflated.abs().amax(-1, keepdim=True).amax(-2, keepdim=True) < 1e12
    deflated = torch.where(simple, deflated, torch.zeros_like(deflated))
    residual = (m * v[:, None, :]).sum(-1)
    v = v - (deflated * residual[:, None, :]).sum(-1)
    return v / torch.sqrt((v * v).sum(-1, keepdim=True))


def _eye(m: Tensor) -> Tensor:
    return torch.eye(m.size(-1), dtype=m.dtype, device=m.device)


def _trace(m: Tensor) -> Tensor:
    """(B, 1, 1)."""
    return (m * _eye(m)).sum(-1, keepdim=True).sum(-2, keepdim=True)
