"""Eigenvalues and singular values of small matrices by Jacobi's rotations, in arithmetic only.

G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 8.5 and 8.6.3. A round rotates n/2 disjoint pairs
of columns at once, as one product with an orthogonal matrix, and then permutes the columns like players of a
round-robin tournament, so that every round is the same code. A sweep of all pairs takes n - 1 rounds, or n if
n is odd. Then one rule (`_settling`) chooses the signs of all vectors and the vectors of equal values, so
that engines that round differently find the same vectors.

The sweeps carry no gradient. It comes from one first-order correction after them, in which 1 / (difference of
two values) is replaced with 0 if they differ by less than 1e-9 of the largest. Exported gradients copy the
rounds, which suits n up to about 4; for null vectors use `null_vector`.
"""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ..core.loops import repeated
from ..core.lowering import primitive
from .matrices import small_matmul
from .qr import frobenius_norm, pointed, qr


def symmetric_eigen(m: Tensor) -> Tuple[Tensor, Tensor]:
    """Eigenvalues (..., n), ascending, and unit eigenvectors in the columns of (..., n, n), of a symmetric
    (..., n, n).

    In float64, for n up to about 10.

    >>> values, vectors = symmetric_eigen(torch.tensor([[2.0, 1.0], [1.0, 2.0]]))
    >>> values
    tensor([1., 3.])
    """
    n = m.size(-1)
    a = m.to(torch.float64)
    a = 0.5 * (a + a.transpose(-1, -2))
    fixed = a.detach()
    norm = frobenius_norm(fixed)
    eye = torch.eye(n, dtype=a.dtype, device=a.device)
    state = torch.cat([fixed / norm, eye.expand_as(fixed)], -2)
    partner, turn, swap, side = _schedule(n, m)
    state = _two_sided(state, _rounds(n), partner, turn, swap, side)
    values = state[..., :n, :].diagonal(0, -2, -1)
    order = _order(values)
    values = small_matmul(values[..., None, :], order)[..., 0, :]
    vectors = small_matmul(state[..., n:, :], order)
    vectors = small_matmul(vectors, _settling(vectors, values))
    values, vectors = _derived_eigen(values * norm[..., 0], vectors, a, norm, eye)
    return values.to(m.dtype), vectors.to(m.dtype)


@primitive
def _derived_eigen(
    values: Tensor, vectors: Tensor, a: Tensor, norm: Tensor, eye: Tensor
) -> Tuple[Tensor, Tensor]:
    """The same values and vectors, with derivatives with respect to a."""
    change = small_matmul(vectors.transpose(-1, -2), small_matmul(a, vectors))
    change = change - change.detach()
    gap = _reciprocal(values[..., None, :] - values[..., :, None], norm)
    return values + (change * eye).sum(-1), vectors + small_matmul(vectors, change * gap)


@_derived_eigen.lowering("onnx", "native")
def _eigen_alone(
    values: Tensor, vectors: Tensor, a: Tensor, norm: Tensor, eye: Tensor
) -> Tuple[Tensor, Tensor]:
    return values, vectors


def svd(m: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """U (..., r, n), singular values (..., n), descending and not negative, and V (..., n, n) of (..., r, n),
    r >= n: U diag(s) V^T.

    In float64, for n up to about 10, by rotations of columns: small singular values have a small relative
    error, not only one that is small relative to the norm. U is orthonormal for every rank. A singular value
    below 4e-15 of the norm becomes 0. The derivative of U V^T is correct even if singular values are
    repeated. If r is exported as a symbol, its lower limit must be above n.

    >>> u, s, v = svd(torch.tensor([[0.0, 2.0], [-1.0, 0.0]]))
    >>> s
    tensor([2., 1.])
    """
    n = m.size(-1)
    a = m.to(torch.float64)
    fixed = a.detach()
    norm = frobenius_norm(fixed)
    columns = fixed / norm
    tall = m.size(-2) != n
    outer = columns
    if tall:
        outer, columns = qr(columns)
    eye = torch.eye(n, dtype=a.dtype, device=a.device)
    state = torch.cat([columns, eye.expand_as(columns)], -2)
    partner, turn, swap, side = _schedule(n, m)
    state = _one_sided(state, _rounds(n), partner, turn, swap, side)
    lengths = torch.sqrt((state[..., :n, :] * state[..., :n, :]).sum(-2, keepdim=True))
    order = _order(-lengths[..., 0, :])
    state, lengths = small_matmul(state, order), small_matmul(lengths, order)
    state = small_matmul(state, _settling(state[..., n:, :], lengths[..., 0, :]))
    columns, v = state[..., :n, :], state[..., n:, :]
    empty = lengths < 4e-15
    # The columns are orthogonal up to rounding. QR makes them orthonormal, even if one is empty.
    u, r = qr(torch.where(empty, torch.zeros_like(columns), columns))
    s = r.diagonal(0, -2, -1) * norm[..., 0]
    u = u * torch.where(empty, pointed(u), torch.ones_like(lengths))
    if tall:
        u = small_matmul(outer, u)
    u, s, v = _derived_svd(u, s, v, a, norm)
    return u.to(m.dtype), s.to(m.dtype), v.to(m.dtype)


@primitive
def _derived_svd(u: Tensor, s: Tensor, v: Tensor, a: Tensor, norm: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The same values, with derivatives with respect to a.

    With dU = U X and dV = V Y for skew-symmetric X and Y, the entries of U^T dA V = X S + dS - S Y give X +
    Y, divided by the differences of singular values, and X - Y, divided by their sums.
    """
    image = small_matmul(a, v)
    image = image - image.detach()
    change = small_matmul(u.transpose(-1, -2), image)
    left, right = s[..., :, None], s[..., None, :]
    both = (change + change.transpose(-1, -2)) * _reciprocal(right - left, norm)
    unlike = (change - change.transpose(-1, -2)) * _reciprocal(left + right, norm)
    outside = (image - small_matmul(u, change)) * _reciprocal(right, norm)
    moved = u + small_matmul(u, 0.5 * (both + unlike)) + outside
    own = torch.eye(s.size(-1), dtype=s.dtype, device=s.device)
    return moved, s + (change * own).sum(-1), v + small_matmul(v, 0.5 * (both - unlike))


@_derived_svd.lowering("onnx", "native")
def _svd_alone(u: Tensor, s: Tensor, v: Tensor, a: Tensor, norm: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    return u, s, v


def _reciprocal(x: Tensor, norm: Tensor) -> Tensor:
    """1 / x, or 0 if x is negligible."""
    small = x.abs() <= 1e-9 * norm
    return torch.where(small, torch.zeros_like(x), 1.0 / torch.where(small, torch.ones_like(x), x))


def _rounds(n: int) -> int:
    """The number of rounds, in whole sweeps, after which the columns are back in their places. It is one
    sweep more than any of thousands of matrices needed to converge, of condition 1 to 1e12 and with repeated
    values."""
    sweeps = [0, 1, 5, 6, 6, 7, 8, 9, 9, 11]
    return sweeps[min(n, 10) - 1] * (n if n % 2 == 1 else n - 1)


def _schedule(n: int, like: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Each column's partner; the permutation of columns after a round, as a matrix; the same after an
    exchange of partners; and 1, -1 or 0 for a column that is the first or second of its pair or has no
    partner.

    Columns 0 to odd - 1 are in a circle, in which pairs face each other. If n is even, the last column stays
    in place and is paired with the column that is left over.
    """
    odd = n if n % 2 == 1 else n - 1
    partner = [odd - 1 - i for i in range(odd)]
    if n != odd:
        partner[odd // 2] = odd
        partner.append(odd // 2)
    origin = [(i + 1) % odd for i in range(odd)] + [i for i in range(odd, n)]
    side: List[float] = []
    for i in range(n):
        side.append(1.0 if i < partner[i] else (0.0 if i == partner[i] else -1.0))
    index = torch.arange(n, device=like.device)
    pairs = torch.tensor(partner, device=like.device)
    turn = (index[:, None] == torch.tensor(origin, device=like.device)[None, :]).to(torch.float64)
    return (
        pairs,
        turn,
        turn.index_select(0, pairs),
        torch.tensor(side, dtype=torch.float64, device=like.device),
    )


def _rotation(
    d: Tensor, b: Tensor, floor: float, partner: Tensor, turn: Tensor, swap: Tensor, side: Tensor
) -> Tensor:
    """The orthogonal (..., n, n) that rotates each pair of columns and then permutes them, from squared
    lengths d and products b with the partner."""
    other = d.index_select(-1, partner)
    # Products within rounding count as 0, or vectors of equal values would rotate for ever.
    b = torch.where(b * b > 2e-29 * (d * other).abs() + floor, 2.0 * b, torch.zeros_like(b))
    delta = (other - d) * side
    sign = torch.where(delta >= 0, 1.0, -1.0).to(d.dtype)
    divisor = delta + sign * torch.sqrt(delta * delta + b * b)
    tangent = side * b / torch.where(divisor == 0, torch.ones_like(divisor), divisor)
    cosine = torch.rsqrt(1.0 + tangent * tangent)
    return cosine[..., :, None] * turn + (cosine * tangent)[..., :, None] * swap


@repeated
def _two_sided(state: Tensor, k: Tensor, partner: Tensor, turn: Tensor, swap: Tensor, side: Tensor) -> Tensor:
    """One round on the symmetric matrix in the upper half of the state; the lower half accumulates the
    rotations."""
    n = state.size(-1)
    a = state[..., :n, :]
    eye = torch.eye(n, dtype=state.dtype, device=state.device)
    product = (a.index_select(-1, partner) * eye).sum(-1)
    rotation = _rotation(a.diagonal(0, -2, -1), product, 2e-29, partner, turn, swap, side)
    rotated = small_matmul(state, rotation)
    a = small_matmul(rotation.transpose(-1, -2), rotated[..., :n, :])
    # Keep the matrix symmetric to the last bit, or the two columns of a pair would rotate by different
    # angles.
    return torch.cat([0.5 * (a + a.transpose(-1, -2)), rotated[..., n:, :]], -2)


@repeated
def _one_sided(state: Tensor, k: Tensor, partner: Tensor, turn: Tensor, swap: Tensor, side: Tensor) -> Tensor:
    """One round on the columns in the upper half of the state; the lower half accumulates the rotations."""
    columns = state[..., : state.size(-1), :]
    product = (columns * columns.index_select(-1, partner)).sum(-2)
    return small_matmul(
        state, _rotation((columns * columns).sum(-2), product, 1e-62, partner, turn, swap, side)
    )


def _order(values: Tensor) -> Tensor:
    """The permutation matrix that sorts columns by ascending values."""
    index = torch.arange(values.size(-1), device=values.device)
    one, other = values[..., :, None], values[..., None, :]
    before = (other < one) | ((other == one) & (index[None, :] < index[:, None]))
    return (before.to(values.dtype).sum(-1, keepdim=True) == index.to(values.dtype)).to(values.dtype)


def _settling(vectors: Tensor, values: Tensor) -> Tensor:
    """The orthogonal (..., n, n) that turns orthonormal vectors of sorted values into a basis that does not
    depend on how they were found.

    Each column has a fixed direction. Column k becomes the vector nearest to this direction, among those that
    belong to its value (to 1e-13, for a matrix of norm 1) and are orthogonal to the columns before. This
    chooses a sign for a single value, and a basis of the plane for a double one.
    """
    n = vectors.size(-1)
    # Numbers without a pattern, which form a matrix of condition about 3 up to n = 10. They are multiples of
    # 1/64, because TorchScript's tensor() rounds to float32.
    directions = [
        [math.floor(64.0 * math.cos(1.1 + 4.6 * i + 2.7 * j + 3.8 * i * j)) / 64.0 for j in range(n)]
        for i in range(n)
    ]
    aim = small_matmul(
        vectors.transpose(-1, -2), torch.tensor(directions, dtype=vectors.dtype, device=vectors.device)
    )
    alike = (values[..., :, None] - values[..., None, :]).abs() < 1e-13
    return qr(torch.where(alike, aim, torch.zeros_like(aim)))[0]
