"""Small linear algebra in arithmetic only: ONNX has no inverse, SVD or eigendecomposition."""

from typing import List

import torch
from torch import Tensor

from ..core.lowering import carries_derivative, primitive
from ..kernels import operators as kernels


def _has_kernel(m: Tensor, *_: object) -> bool:
    """Whether kernels support matrices (..., n, n)."""
    return (
        kernels.available(m)
        and m.dtype == torch.float64
        and isinstance(m.size(-1), int)
        and 3 <= m.size(-1) <= kernels.MOST_ROWS
    )


@primitive
def small_matmul(a: Tensor, b: Tensor) -> Tensor:
    """Matrix product of (..., n, k) and (..., k, m) for small sizes.

    Native code gets a sum of products, which compiles inline instead of calling a library; so do backward
    passes, which are traced once for every target.
    """
    if a.dtype != b.dtype:  # a product of other tensors promotes, this one raises
        common = torch.promote_types(a.dtype, b.dtype)
        return torch.matmul(a.to(common), b.to(common))
    return torch.matmul(a, b)


@small_matmul.lowering("native", "vjp")
def _sum_of_products(a: Tensor, b: Tensor) -> Tensor:
    return (a[..., :, :, None] * b[..., None, :, :]).sum(-2)


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


def cross4(a: Tensor, b: Tensor, c: Tensor) -> Tensor:
    """The vector of four whose product with any d is the determinant of the rows d, a, b, c; it is orthogonal
    to all three.

    >>> x, y, z = torch.eye(4)[:3].unbind()
    >>> cross4(x, y, z) + 0.0
    tensor([ 0.,  0.,  0., -1.])
    """
    return (_dual(b, c) * a[..., None, :]).sum(-1)


def _dual(a: Tensor, b: Tensor) -> Tensor:
    """The skew-symmetric (..., 4, 4) that maps c to cross4(c, a, b): the six minors of a and b, each at the
    place of the complementary indices."""
    minors = (a[..., :, None] * b[..., None, :] - b[..., :, None] * a[..., None, :]).flatten(-2)
    place = torch.tensor([0, 11, 13, 6, 14, 0, 3, 8, 7, 12, 0, 1, 9, 2, 4, 0], device=a.device)
    return minors.index_select(-1, place).unflatten(-1, [4, 4])


def cofactors(m: Tensor) -> Tensor:
    """Cofactors of (..., n, n) for n up to 4: the derivative of the determinant, and the transpose of the
    adjugate.

    >>> cofactors(torch.tensor([[1.0, 2.0], [3.0, 4.0]]))
    tensor([[ 4., -3.],
            [-2.,  1.]])
    """
    n = m.size(-1)
    if n == 1:
        return torch.ones_like(m)
    if n == 2:
        turned = torch.stack([m[..., 1, 1], -m[..., 1, 0], -m[..., 0, 1], m[..., 0, 0]], -1)
        return turned.unflatten(-1, [2, 2])
    if n == 3:
        r0, r1, r2 = m[..., 0, :], m[..., 1, :], m[..., 2, :]
        return torch.stack([cross(r1, r2), cross(r2, r0), cross(r0, r1)], -2)
    a, b, c, d = m[..., 0, :], m[..., 1, :], m[..., 2, :], m[..., 3, :]
    upper, lower = _dual(a, b), _dual(c, d)
    rows = [
        (lower * b[..., None, :]).sum(-1),
        -(lower * a[..., None, :]).sum(-1),
        (upper * d[..., None, :]).sum(-1),
        -(upper * c[..., None, :]).sum(-1),
    ]
    return torch.stack(rows, -2)


def det(m: Tensor) -> Tensor:
    """Determinant of (..., n, n), computed in float64: its relative error is about the rounding error times
    the condition number.

    By cofactors up to 2x2, by elimination with the largest pivot of each column beyond. The derivatives come
    from the cofactors up to 4x4, where they are finite everywhere. Beyond, they come from the elimination,
    and are correct for a regular matrix only.

    >>> det(2.0 * torch.eye(5))
    tensor(32.)
    """
    n = m.size(-1)
    a = m.to(torch.float64)
    if n <= 2:
        return _expanded(a).to(m.dtype)
    if n > 4:
        return _eliminated(a).to(m.dtype)
    # The expansion loses twice the digits if two singular values are small.
    return _derived_from_cofactors(_eliminated(a.detach()), a).to(m.dtype)


@carries_derivative
def _derived_from_cofactors(value: Tensor, a: Tensor) -> Tensor:
    expanded = _expanded(a)
    return value + (expanded - expanded.detach())


def _expanded(a: Tensor) -> Tensor:
    """The determinant by cofactors of the first row."""
    return (a[..., 0, :] * cofactors(a)[..., 0, :]).sum(-1)


def _eliminated(a: Tensor) -> Tensor:
    """The determinant as the product of the pivots."""
    n = a.size(-1)
    free = torch.ones_like(a[..., 0])
    earlier = torch.ones([n, n], dtype=a.dtype, device=a.device).triu(1)
    result = torch.ones_like(a[..., 0, 0])
    exchanges = torch.zeros_like(result)
    for k in range(n):
        pick = _largest(a[..., k], free)
        exchanges = exchanges + (free * (earlier * pick[..., None, :]).sum(-1)).sum(-1)
        free = free - pick
        row = (a * pick[..., None]).sum(-2)
        pivot = row[..., k]
        result = result * pivot
        # A column of zeros needs no elimination; the divisor 1 keeps the gradient finite.
        safe = torch.where(pivot == 0, torch.ones_like(pivot), pivot)
        a = a - (a[..., k] * free / safe[..., None])[..., None] * row[..., None, :]
    return result * (1.0 - 2.0 * (exchanges - 2.0 * torch.floor(0.5 * exchanges)))


def _largest(column: Tensor, free: Tensor) -> Tensor:
    """1 at the free row whose entry is largest, 0 elsewhere."""
    size = torch.where(free > 0, column.detach().abs(), -torch.ones_like(column))
    return (
        torch.argmax(size, dim=-1, keepdim=True) == torch.arange(column.size(-1), device=column.device)
    ).to(column.dtype)


def inverse(m: Tensor) -> Tensor:
    """Inverse of (..., n, n), computed in float64; infinite or NaN if m is singular.

    The inverse of the detached matrix, then two of Newton's steps X (2 - M X). They refine the value and give
    the first three derivatives, because each step squares the error. `inverse3x3` is for images of 3x3
    matrices, in their own dtype.

    >>> inverse(torch.tensor([[2.0, 1.0], [1.0, 1.0]]))
    tensor([[ 1., -1.],
            [-1.,  2.]])
    """
    a = m.to(torch.float64)
    eye = torch.eye(m.size(-1), dtype=a.dtype, device=a.device)
    x = _inverse(a.detach())
    for _ in range(2):
        x = x + small_matmul(x, eye - small_matmul(a, x))
    return x.to(m.dtype)


def solve(a: Tensor, b: Tensor) -> Tensor:
    """The x of a x = b for (..., n, n) and (..., n, k), computed in float64; infinite or NaN if a is
    singular.

    By the inverse of the detached matrix and two steps of refinement, which also give the first two
    derivatives.

    >>> solve(torch.tensor([[2.0, 1.0], [1.0, 1.0]]), torch.tensor([[3.0], [2.0]])).flatten()
    tensor([1., 1.])
    """
    m, wanted = a.to(torch.float64), b.to(torch.float64)
    inverted = _inverse(m.detach())
    x = small_matmul(inverted, wanted)
    for _ in range(2):
        x = x + small_matmul(inverted, wanted - small_matmul(m, x))
    return x.to(b.dtype)


def _inverse(m: Tensor) -> Tensor:
    """By cofactors up to 2x2; by Gauss-Jordan elimination with the largest pivot of each column beyond.

    Cofactors of larger matrices would lose twice the digits if two singular values are small.
    """
    n = m.size(-1)
    if n <= 2:
        turned = cofactors(m).transpose(-1, -2)
        return turned / (m[..., 0:1, :] * turned[..., :, 0:1].transpose(-1, -2)).sum(-1, keepdim=True)
    return _eliminated_inverse(m)


@primitive
def _eliminated_inverse(m: Tensor) -> Tensor:
    """The inverse by Gauss-Jordan elimination."""
    n = m.size(-1)
    joined = torch.cat([m, torch.eye(n, dtype=m.dtype, device=m.device).expand_as(m)], -1)
    free = torch.ones_like(m[..., 0])
    order: List[Tensor] = []
    for k in range(n):
        pick = _largest(joined[..., k], free)
        free = free - pick
        order.append(pick)
        row = (joined * pick[..., None]).sum(-2)
        joined = joined - (joined[..., k] - pick)[..., None] * (row / row[..., k : k + 1])[..., None, :]
    return small_matmul(torch.stack(order, -2), joined[..., n:])


@_eliminated_inverse.lowering("native", when=_has_kernel)
def _eliminated_inverse_kernel(m: Tensor) -> Tensor:
    return kernels.batched_inverse(m.contiguous())


@primitive
def spd_inverse(m: Tensor) -> Tensor:
    """Inverse of a symmetric positive definite (..., n, n) by n sweeps (Gauss-Jordan without pivoting)."""
    n = m.size(-1)
    eye = torch.eye(n, dtype=m.dtype, device=m.device)
    for k in range(n):
        column = m[..., :, k : k + 1] - eye[:, k : k + 1]
        row = m[..., k : k + 1, :] + eye[k : k + 1, :]
        m = m - column * (row / m[..., k : k + 1, k : k + 1])
    return m


@spd_inverse.lowering("native", when=_has_kernel)
def _spd_inverse_kernel(m: Tensor) -> Tensor:
    return kernels.spd_inverse(m.contiguous())


def smallest_eigenvector(m: Tensor) -> Tensor:
    """Unit eigenvector (B, n) of the smallest eigenvalue of a symmetric positive semidefinite (B, n, n),
    float64.

    Inverse iteration: the inverse of the slightly shifted matrix, squared until its largest eigenvalue
    dominates the others. That part carries no gradient. One first-order correction through the deflated
    inverse follows: it refines the value, and its derivative is exactly the eigenvector's for a simple
    eigenvalue, and 0 for a double one.
    """
    m = m / (_trace(m) + 1e-300)
    return _eigenvector(m, spd_inverse(m.detach() + 1e-14 * _eye(m)), 7, 1.0)


def largest_eigenvector(m: Tensor) -> Tensor:
    """Unit eigenvector (B, n) of the largest eigenvalue of a symmetric positive semidefinite (B, n, n),
    float64.

    Like `smallest_eigenvector`, but by powers of the matrix itself, which separate eigenvalues that differ by
    1%.
    """
    m = m / (_trace(m) + 1e-300)
    return _eigenvector(m, m.detach() + 1e-14 * _eye(m), 12, -1.0)


def _eigenvector(m: Tensor, power: Tensor, squarings: int, sign: float) -> Tensor:
    """The eigenvector of m's smallest (sign 1) or largest (sign -1) eigenvalue, to which the columns of
    `power`'s powers converge."""
    eye = _eye(m)
    fixed = m.detach()
    power = normalized_power(power, squarings)
    # Every column is now a multiple of the eigenvector: take the longest, which has the largest diagonal
    # entry.
    diagonal = (power * eye).sum(-1)
    pick = (torch.argmax(diagonal, dim=-1)[:, None] == torch.arange(m.size(-1), device=m.device)).to(m.dtype)
    v = (power * pick[:, None, :]).sum(-1)
    v = v / torch.sqrt((v * v).sum(-1, keepdim=True))
    outer = v[:, :, None] * v[:, None, :]
    eigenvalue = (outer * fixed).sum(-1, keepdim=True).sum(-2, keepdim=True)
    deflated = sign * (spd_inverse(sign * (fixed - eigenvalue * eye) + outer) - outer)
    # For a double eigenvalue, any vector of the plane is right: no correction and no derivative. The same for
    # NaN, because the comparison is then False.
    simple = (deflated.abs() < 1e12).all(-1, keepdim=True).all(-2, keepdim=True)
    deflated = torch.where(simple, deflated, torch.zeros_like(deflated))
    residual = (m * v[:, None, :]).sum(-1)
    v = v - (deflated * residual[:, None, :]).sum(-1)
    return v / torch.sqrt((v * v).sum(-1, keepdim=True))


@primitive
def normalized_power(m: Tensor, squarings: int) -> Tensor:
    """(..., n, n) divided by its trace and squared, ``squarings`` times; the part of its largest eigenvalue
    remains.

    >>> normalized_power(torch.tensor([[2.0, 0.0], [0.0, 1.0]]), 5).round(decimals=3)
    tensor([[1., 0.],
            [0., 0.]])
    """
    for _ in range(squarings):
        m = m / _trace(m)
        m = small_matmul(m, m)
    return m


@normalized_power.lowering("native", when=_has_kernel)
def _normalized_power_kernel(m: Tensor, squarings: int) -> Tensor:
    return kernels.normalized_power(m.contiguous(), squarings)


def _eye(m: Tensor) -> Tensor:
    return torch.eye(m.size(-1), dtype=m.dtype, device=m.device)


def _trace(m: Tensor) -> Tensor:
    """(..., 1, 1)."""
    return (m * _eye(m)).sum(-1, keepdim=True).sum(-2, keepdim=True)
