"""Essential matrices E = [t]x R: x2^T E x1 = 0 for points x1, x2 of the planes z = 1 of two views."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_broadcastable,
    check_expands,
    check_last,
    check_leading,
    check_matrix,
    check_optional,
)
from ...primitives.geometry.intrinsics import with_one
from ...primitives.linalg.matrices import cofactors, inverse3x3, small_matmul
from ...primitives.linalg.qr import null_vector, pointed
from ...primitives.numbers.loss_reduction import narrowed, widened
from .lines import cross_product_matrix
from .projection import depth_from_point, left_null_vector
from .triangulation import triangulate_points


def essential_from_fundamental(F_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor:
    """Essential matrices K2^T F K1. R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., formula 9.12.

    Args:
        F_mat: (*, 3, 3), fundamental matrices, floating point.
        K1, K2: (*, 3, 3), camera matrices.

    Returns:
        (*, 3, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> essential_from_fundamental(torch.ones(3, 3), torch.eye(3), 2.0 * torch.eye(3))[0]
        tensor([2., 2., 2.])
    """
    check_matrix(F_mat, 3, 3, "F_mat")
    check_matrix(K1, 3, 3, "K1")
    check_matrix(K2, 3, 3, "K2")
    check_leading([F_mat, K1, K2], ["F_mat", "K1", "K2"], [2, 2, 2])
    return small_matmul(small_matmul(K2.transpose(-2, -1), F_mat), K1)


def relative_camera_motion(R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tuple[Tensor, Tensor]:
    """Rotation and translation from the first camera's frame to the second's: R2 R1^T and t2 - R2 R1^T t1.

    Args:
        R1, R2: (*, 3, 3), rotations from the world to the cameras' frames, floating point.
        t1, t2: (*, 3, 1), translations.

    Returns:
        R (*, 3, 3) and t (*, 3, 1). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> R, t = relative_camera_motion(torch.eye(3), torch.ones(3, 1), torch.eye(3), torch.zeros(3, 1))
        >>> t[:, 0]
        tensor([-1., -1., -1.])
    """
    check_matrix(R1, 3, 3, "R1")
    check_matrix(t1, 3, 1, "t1")
    check_matrix(R2, 3, 3, "R2")
    check_matrix(t2, 3, 1, "t2")
    check_leading([R1, t1, R2, t2], ["R1", "t1", "R2", "t2"], [2, 2, 2, 2])
    R = small_matmul(R2, R1.transpose(-2, -1))
    return R, t2 - small_matmul(R, t1)


def essential_from_Rt(R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tensor:
    """Essential matrices [t]x R of the motion from the first camera's frame to the second's.

    Args:
        R1, R2: (*, 3, 3), rotations from the world to the cameras' frames, floating point.
        t1, t2: (*, 3, 1), translations.

    Returns:
        (*, 3, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> (
        ...     essential_from_Rt(
        ...         torch.eye(3), torch.zeros(3, 1), torch.eye(3), torch.tensor([[1.0], [0.0], [0.0]])
        ...     )
        ...     + 0.0
        ... )
        tensor([[ 0.,  0.,  0.],
                [ 0.,  0., -1.],
                [ 0.,  1.,  0.]])
    """
    R, t = relative_camera_motion(R1, t1, R2, t2)
    return small_matmul(cross_product_matrix(t[..., 0]), R)


def decompose_essential_matrix(E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The two rotations and the direction of translation of essential matrices, also of approximate ones.
    With E = U S V^T they are U W V^T, U W^T V^T and the third column of U (R. Hartley, A. Zisserman, Multiple
    View Geometry, 2nd ed., 9.6.2). They are computed in float64 without a decomposition: U diag(1, 1, 0) V^T
    is the 2x2 rotation nearest to E in the planes orthogonal to its null vectors.

    Args:
        E_mat: (*, 3, 3) of rank 2 or more, floating point.

    Returns:
        R1, R2 (*, 3, 3), and t (*, 3, 1) of unit length, with a sign that does not depend on the sign of E:
        [t]x R1 is a positive multiple of E (of the nearest essential matrix), [t]x R2 a negative one.
        Differentiable.

    Raises:
        TypeError, ValueError: if E_mat is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> E = cross_product_matrix(torch.tensor([0.0, 0.0, 2.0]))
        >>> R1, R2, t = decompose_essential_matrix(E)
        >>> R1.diagonal(), t[:, 0]
        (tensor([1., 1., 1.]), tensor([0., 0., 1.]))
    """
    check_matrix(E_mat, 3, 3, "E_mat")
    upper, axis, t = _parts(E_mat)
    turned = small_matmul(cross_product_matrix(t), upper)
    return (axis - turned).to(E_mat.dtype), (axis + turned).to(E_mat.dtype), t[..., None].to(E_mat.dtype)


def decompose_essential_matrix_no_svd(E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """The two rotations and the direction of translation of essential matrices, in closed form.

    B. K. P. Horn, Recovering Baseline and Orientation from Essential Matrix, 1990: the baseline b is the
    longest cross product of two columns, and (b . b) R = cofactors(E) -+ [b]x E. The result is exact for an
    essential matrix; for an approximate one R1 and R2 are only approximate rotations, unlike in
    :func:`decompose_essential_matrix`.

    Args:
        E_mat: (*, 3, 3), [t]x R, floating point.

    Returns:
        R1, R2 (*, 3, 3), and t (*, 3, 1) of unit length, with a sign that does not depend on the sign of E:
        [t]x R1 is a positive multiple of E, [t]x R2 a negative one. Differentiable.

    Raises:
        TypeError, ValueError: if E_mat is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> E = cross_product_matrix(torch.tensor([0.0, 0.0, 2.0]))
        >>> R1, R2, t = decompose_essential_matrix_no_svd(E)
        >>> R1.diagonal(), t[:, 0]
        (tensor([1., 1., 1.]), tensor([0., 0., 1.]))
    """
    check_matrix(E_mat, 3, 3, "E_mat")
    b = left_null_vector(E_mat)
    # b . b is half the sum of squares of [b]x; here b has unit length.
    squared = 0.5 * (E_mat * E_mat).sum(-1, keepdim=True).sum(-2, keepdim=True)
    axis = cofactors(E_mat) / squared
    turned = small_matmul(cross_product_matrix(b), E_mat) / torch.sqrt(squared)
    return axis - turned, axis + turned, b[..., None]


def motion_from_essential(E_mat: Tensor) -> Tuple[Tensor, Tensor]:
    """The four possible motions of an essential matrix, from the first camera's frame to the second's.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., result 9.19.

    Args:
        E_mat: (*, 3, 3), floating point.

    Returns:
        Rotations (*, 4, 3, 3) and unit translations (*, 4, 3, 1): (R1, t), (R1, -t), (R2, t), (R2, -t) of
        :func:`decompose_essential_matrix`. Differentiable.

    Raises:
        TypeError, ValueError: if E_mat is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> Rs, Ts = motion_from_essential(cross_product_matrix(torch.tensor([0.0, 0.0, 2.0])))
        >>> Ts[:, 2, 0]
        tensor([ 1., -1.,  1., -1.])
    """
    R1, R2, t = decompose_essential_matrix(E_mat)
    return torch.stack([R1, R1, R2, R2], -3), torch.stack([t, -t, t, -t], -3)


def motion_from_essential_choose_solution(
    E_mat: Tensor, K1: Tensor, K2: Tensor, x1: Tensor, x2: Tensor, mask: Optional[Tensor] = None
) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Choose the motion of an essential matrix that has most points in front of both cameras.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 9.6.3. The first of the four motions wins ties.

    Args:
        E_mat: (*, 3, 3), floating point.
        K1, K2: (*, 3, 3), camera matrices.
        x1, x2: (*, N, 2), pixels.
        mask: (*, N), bool: the points to use; all by default.

    Returns:
        R (*, 3, 3) and t (*, 3, 1) from the first camera's frame to the second's, |t| = 1; the points (*, N,
        3) in the first camera's frame; and a mask (*, N), bool, of the points that ``mask`` selects and that
        are in front of both cameras. Differentiable.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> E = cross_product_matrix(torch.tensor([-1.0, 0.0, 0.0]))
        >>> x = torch.tensor([[0.5, 0.25], [-0.25, 0.5]])
        >>> R, t, X, seen = motion_from_essential_choose_solution(
        ...     E, torch.eye(3), torch.eye(3), x, x - torch.tensor([0.25, 0.0])
        ... )
        >>> X.round(decimals=4), seen
        (tensor([[ 2.,  1.,  4.],
                [-1.,  2.,  4.]]), tensor([True, True]))
    """
    check_matrix(E_mat, 3, 3, "E_mat")
    check_matrix(K1, 3, 3, "K1")
    check_matrix(K2, 3, 3, "K2")
    check_last(x1, 2, "x1")
    check_last(x2, 2, "x2")
    _check_view(E_mat, K1, x1, "K1", "x1")
    _check_view(E_mat, K2, x2, "K2", "x2")
    if x2.size(-2) != x1.size(-2) and x2.size(-2) != 1:
        raise ValueError(f"x2: expected as many points as x1, {x1.size(-2)}, got {x2.size(-2)}")
    Rs, Ts = motion_from_essential(widened(E_mat))
    # Triangulation on the planes z = 1 is better conditioned than with pixels.
    p1, p2 = _rays(x1, K1)[..., None, :, :], _rays(x2, K2)[..., None, :, :]
    P2 = torch.cat([Rs, Ts], -1)
    P1 = torch.eye(4, dtype=P2.dtype, device=P2.device)[:3].expand_as(P2)
    shape = list(P2.shape[:-2]) + [x1.size(-2), 2]
    X = triangulate_points(P1, P2, p1.expand(shape), p2.expand(shape))
    seen = (X[..., 2] > 0) & (depth_from_point(Rs, Ts, X) > 0)
    check_optional(mask, "mask")
    if mask is not None:
        check_broadcastable(mask, x1, "mask", "x1", 0, 1)
        check_leading([E_mat, mask], ["E_mat", "mask"], [2, 1])
        seen = seen & mask[..., None, :]
    best = torch.argmax(seen.to(torch.int32).sum(-1), dim=-1)
    pick = (best[..., None] == torch.arange(4, device=best.device))[..., None, None]
    zero = torch.zeros([], dtype=X.dtype, device=X.device)
    R, t = torch.where(pick, Rs, zero).sum(-3), torch.where(pick, Ts, zero).sum(-3)
    points = narrowed(torch.where(pick, X, zero).sum(-3), x1, K1)
    return narrowed(R, E_mat), narrowed(t, E_mat), points, (pick[..., 0] & seen).any(-2)


def project_to_essential(E_mat: Tensor) -> Tensor:
    """The nearest essential matrices in the least-squares sense: U diag(s, s, 0) V^T, where s is the mean of
    the two larger singular values.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 11.7.3.

    Args:
        E_mat: (*, 3, 3) of rank 2 or more, floating point.

    Returns:
        (*, 3, 3). Differentiable.

    Raises:
        TypeError, ValueError: if E_mat is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> project_to_essential(torch.diag(torch.tensor([3.0, 1.0, 0.5]))).diagonal()
        tensor([2., 2., 0.])
    """
    check_matrix(E_mat, 3, 3, "E_mat")
    upper, _, _ = _parts(E_mat)
    size = 0.5 * (upper * E_mat).sum(-1, keepdim=True).sum(-2, keepdim=True)
    return (size * upper).to(E_mat.dtype)


def _parts(E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """From the singular vectors, in float64: u1 v1^T + u2 v2^T and +-u3 v3^T, which add up to a rotation, and
    u3."""
    E = E_mat.to(torch.float64)
    length = torch.sqrt((E * E).sum(-1, keepdim=True).sum(-2, keepdim=True))
    E = E / torch.where(length == 0, torch.ones_like(length), length)
    v = null_vector(E)
    E = E - small_matmul(E, v[..., None]) * v[..., None, :]
    minors = cofactors(E)
    size = torch.sqrt((minors * minors).sum(-1, keepdim=True).sum(-2, keepdim=True))
    axis = minors / torch.where(size == 0, torch.ones_like(size), size)
    u = (axis * v[..., None, :]).sum(-1)
    # Orthogonal to v and u, E is a 2x2 matrix with a positive determinant; the nearest rotation is the scaled
    # sum of this matrix and its cofactors.
    upper = E + small_matmul(
        cross_product_matrix(u), small_matmul(E, cross_product_matrix(v).transpose(-2, -1))
    )
    length = torch.sqrt((upper * upper).sum(-1, keepdim=True).sum(-2, keepdim=True) * 0.5)
    return (
        upper / torch.where(length == 0, torch.ones_like(length), length),
        axis,
        u * pointed(u[..., None])[..., 0, :],
    )


def _check_view(E_mat: Tensor, K: Tensor, x: Tensor, K_name: str, x_name: str) -> None:
    if x.dim() < 2:
        raise ValueError(f"{x_name}: expected shape (*, N, 2), got {list(x.shape)}")
    check_expands(x, E_mat, x_name, "E_mat", 2, 2)
    check_expands(K, E_mat, K_name, "E_mat", 2, 2)


def _rays(x: Tensor, K: Tensor) -> Tensor:
    """Points (*, N, 2) of the plane z = 1 from pixels."""
    seen = small_matmul(with_one(widened(x)), inverse3x3(widened(K)).transpose(-2, -1))
    return seen[..., 0:2] / seen[..., 2:3]
