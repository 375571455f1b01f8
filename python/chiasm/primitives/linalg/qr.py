"""QR factorisation and null vectors of small matrices, in arithmetic only."""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.lowering import carries_derivative
from .matrices import normalized_power, small_matmul, spd_inverse


def frobenius_norm(m: Tensor) -> Tensor:
    """Frobenius norm (..., 1, 1), relative to the largest entry so that no square overflows; 1 for zeros.

    >>> frobenius_norm(torch.tensor([[3.0, 0.0], [0.0, 4.0]]))
    tensor([[5.]])
    """
    largest = m.abs().amax(-1, keepdim=True).amax(-2, keepdim=True)
    largest = torch.where(largest > 0, largest, torch.ones_like(largest))
    part = m / largest
    squared = (part * part).sum(-1, keepdim=True).sum(-2, keepdim=True)
    return largest * torch.sqrt(torch.where(squared > 0, squared, torch.ones_like(squared)))


def pointed(vectors: Tensor) -> Tensor:
    """1 or -1 for each column of (..., n, k). Multiplied by it, the column has a sign that does not depend on
    how it was found.

    The sum of its entries, the k-th weighted by 1.3247 ** -k, becomes positive: that sum is 0 only by chance,
    whereas symmetric problems have several largest entries. Without a gradient.

    >>> pointed(torch.tensor([[1.0, -1.0], [-1.0, 1.0]]))
    tensor([[ 1., -1.]])
    """
    fixed = vectors.detach()
    place = torch.arange(fixed.size(-2), device=fixed.device).to(fixed.dtype)
    total = (fixed * torch.exp(-0.2811995743 * place)[:, None]).sum(-2, keepdim=True)
    return torch.where(total >= 0, torch.ones_like(total), -torch.ones_like(total))


def qr(m: Tensor) -> Tuple[Tensor, Tensor]:
    """Q (..., r, n) with orthonormal columns and upper triangular R (..., n, n), its diagonal not negative,
    of (..., r, n), r >= n.

    By Householder's reflections in float64. Q is orthonormal for every rank. Differentiable if the columns
    are independent; the gradient is finite even if a column is zero.

    >>> q, r = qr(torch.tensor([[3.0, 1.0], [4.0, 2.0]]))
    >>> q
    tensor([[ 0.6000, -0.8000],
            [ 0.8000,  0.6000]])
    >>> r.diagonal()
    tensor([5.0000, 0.4000])
    """
    n = m.size(-1)
    a, mirrors = _reflect(m.to(torch.float64))
    r = _upper(a)
    sign = torch.where(r.diagonal(0, -2, -1) >= 0, 1.0, -1.0).to(a.dtype)
    rows = torch.arange(m.size(-2), device=m.device)
    start = (rows[:, None] == rows[None, :n]).to(a.dtype)
    q = start * sign[..., None, :]
    for k in range(n - 1, -1, -1):
        q = _mirrored(mirrors[k], q)
    return q.to(m.dtype), (r * sign[..., :, None]).to(m.dtype)


def _reflect(a: Tensor) -> Tuple[Tensor, List[Tensor]]:
    """The (..., r, n), reflected to an upper triangular matrix, and the normals (..., r) of the reflections,
    of length sqrt(2), or 0 for a zero column."""
    rows = torch.arange(a.size(-2), device=a.device)
    mirrors: List[Tensor] = []
    for k in range(a.size(-1)):
        x = a[..., k] * (rows >= k).to(a.dtype)
        squared = (x * x).sum(-1, keepdim=True)
        empty = squared == 0
        length = torch.sqrt(torch.where(empty, torch.ones_like(squared), squared))
        # the sign of the entry to which it is added, so nothing cancels
        signed = torch.where(x[..., k : k + 1] >= 0, length, -length)
        normal = x + signed * (rows == k).to(a.dtype)
        scale = torch.where(
            empty,
            torch.zeros_like(length),
            torch.rsqrt(torch.where(empty, length, length * (length + x[..., k : k + 1].abs()))),
        )
        mirrors.append(normal * scale)
        a = _mirrored(mirrors[k], a)
    return a, mirrors


def _upper(a: Tensor) -> Tensor:
    """The upper triangle of the first n rows, by index and mask: slices and triu would ask whether these are
    all rows."""
    index = torch.arange(a.size(-1), device=a.device)
    return a.index_select(-2, index) * (index[:, None] <= index[None, :]).to(a.dtype)


def _mirrored(normal: Tensor, a: Tensor) -> Tensor:
    return a - normal[..., :, None] * (normal[..., :, None] * a).sum(-2, keepdim=True)


def null_vector(m: Tensor) -> Tensor:
    """Unit vector (..., n) whose product with (..., r, n), r >= n - 1, is nearest to 0: the right singular
    vector of the smallest singular value.

    By the inverse of the R of m = Q R, so that the error grows with m's condition number, not with its square
    as for m^T m. R^-1 R^-T is squared until its largest eigenvalue dominates the others. `pointed` chooses
    the sign. The derivative is 0 if the squares of the two smallest singular values differ by less than 1e-13
    |m|^2.

    >>> null_vector(torch.tensor([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]))
    tensor([0., 0., 1.])
    """
    a = m.to(torch.float64)
    a = a / frobenius_norm(a.detach())
    fixed = a.detach()
    r = _upper(_reflect(torch.cat([fixed, torch.zeros_like(fixed[..., :1, :])], -2))[0])
    v = _longest_column(_upper_inverse(r))
    v = v * pointed(v[..., None])[..., 0, :]
    return _derived(v, a, r).to(m.dtype)


def _upper_inverse(r: Tensor) -> Tensor:
    """Inverse of an upper triangular matrix of norm 1, by substitution; diagonal entries near 0 count as
    1e-15."""
    n = r.size(-1)
    diagonal = r.diagonal(0, -2, -1)
    diagonal = torch.where(diagonal.abs() < 1e-15, torch.full_like(diagonal, 1e-15), diagonal)
    eye = torch.eye(n, dtype=r.dtype, device=r.device)
    x = torch.zeros_like(r)
    for k in range(n - 1, -1, -1):
        row = (eye[k] - (r[..., k, :, None] * x).sum(-2)) / diagonal[..., k : k + 1]
        x = x + eye[:, k : k + 1] * row[..., None, :]
    return x


def _longest_column(half: Tensor) -> Tensor:
    """Unit eigenvector of the largest eigenvalue of half half^T."""
    power = normalized_power(small_matmul(half, half.transpose(-1, -2)), 8)
    # Every column is now a multiple of the eigenvector: take the longest, which has the largest diagonal
    # entry.
    pick = torch.argmax(power.diagonal(0, -2, -1), dim=-1, keepdim=True) == torch.arange(
        half.size(-1), device=half.device
    )
    v = (power * pick.to(half.dtype)[..., None, :]).sum(-1)
    return v / torch.sqrt((v * v).sum(-1, keepdim=True))


@carries_derivative
def _derived(v: Tensor, a: Tensor, r: Tensor) -> Tensor:
    """The eigenvector v of a^T a = r^T r, with its derivative."""
    return v + _null_change(a, v, small_matmul(r.transpose(-1, -2), r))


def _null_change(a: Tensor, v: Tensor, square: Tensor) -> Tensor:
    """Zero, with the derivative of the eigenvector v of a^T a = square."""
    image = (a * v[..., None, :]).sum(-1)
    residual = (a * image[..., None]).sum(-2)
    outer = v[..., :, None] * v[..., None, :]
    value = (square * outer).sum(-1, keepdim=True).sum(-2, keepdim=True)
    eye = torch.eye(v.size(-1), dtype=v.dtype, device=v.device)
    # The shift exceeds rounding errors: it keeps the matrix positive definite if the next eigenvalue is
    # equal.
    others = spd_inverse(square + (4e-15 - value) * eye + outer) - outer
    gap_closed = (others * eye).sum(-1, keepdim=True).sum(-2, keepdim=True) > 1e13
    others = torch.where(gap_closed, torch.zeros_like(others), others)
    return -(others * (residual - residual.detach())[..., None, :]).sum(-1)
