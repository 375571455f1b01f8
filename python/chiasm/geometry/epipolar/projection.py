"""Projection matrices K [R | t] and their parts."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_broadcastable,
    check_image,
    check_leading,
    check_matrix,
    check_number,
    check_same_leading,
    check_tensor,
)
from ...primitives.linalg.matrices import cross, small_matmul
from ...primitives.linalg.qr import pointed
from .lines import cross_product_matrix


def intrinsics_like(focal: float, input: Tensor) -> Tensor:
    """Camera matrices for images, with one focal length and the principal point at (W / 2, H / 2).

    Args:
        focal: focal length in pixels, positive.
        input: (B, C, H, W), floating point; its shape, dtype and device are used.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or focal is not positive.

    Example:
        >>> intrinsics_like(500.0, torch.zeros(1, 3, 4, 6))[0]
        tensor([[500.,   0.,   3.],
                [  0., 500.,   2.],
                [  0.,   0.,   1.]])
    """
    check_image(input, "input")
    if not focal > 0:
        raise ValueError(f"focal: expected a positive number, got {focal}")
    # The sizes stay symbols in an exported graph: they multiply tensors.
    unit = torch.eye(3, dtype=input.dtype, device=input.device)
    last = unit[2]
    diagonal = unit * torch.tensor([focal, focal, 1.0], dtype=input.dtype, device=input.device)
    matrix = (
        diagonal
        + unit[0][:, None] * last * (0.5 * input.size(3))
        + unit[1][:, None] * last * (0.5 * input.size(2))
    )
    return matrix.expand(input.size(0), 3, 3).clone()


def scale_intrinsics(camera_matrix: Tensor, scale_factor: Union[float, Tensor]) -> Tensor:
    """Camera matrices for images scaled by a factor: focal lengths, skew and principal point are multiplied.

    Args:
        camera_matrix: (*, 3, 3), floating point.
        scale_factor: a number, or a tensor (*).

    Returns:
        (*, 3, 3). Differentiable in both.

    Raises:
        TypeError, ValueError: if camera_matrix is not a floating-point (*, 3, 3) tensor, or scale_factor not
            of a shape that broadcasts with its leading dimensions.

    Example:
        >>> scale_intrinsics(torch.tensor([[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]]), 0.5)
        tensor([[250.,   0., 160.],
                [  0., 250., 120.],
                [  0.,   0.,   1.]])
    """
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    last = camera_matrix[..., 2:3, :]
    if isinstance(scale_factor, Tensor):
        check_broadcastable(scale_factor, camera_matrix, "scale_factor", "camera_matrix", 0, 2)
        upper = camera_matrix[..., 0:2, :] * scale_factor[..., None, None]
        last = last.expand_as(upper[..., :1, :])
    else:
        check_number(scale_factor, "scale_factor")
        upper = camera_matrix[..., 0:2, :] * scale_factor
    return torch.cat([upper, last], -2)


def projection_from_KRt(K: Tensor, R: Tensor, t: Tensor) -> Tensor:
    """Projection matrices K [R | t].

    Args:
        K: (*, 3, 3), camera matrices, floating point.
        R: (*, 3, 3), rotations from the world to the camera's frame.
        t: (*, 3, 1), translations.

    Returns:
        (*, 3, 4). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> projection_from_KRt(2.0 * torch.eye(3), torch.eye(3), torch.ones(3, 1))
        tensor([[2., 0., 0., 2.],
                [0., 2., 0., 2.],
                [0., 0., 2., 2.]])
    """
    check_matrix(K, 3, 3, "K")
    check_matrix(R, 3, 3, "R")
    check_matrix(t, 3, 1, "t")
    check_same_leading([R, t], ["R", "t"], [2, 2])
    check_leading([K, R], ["K", "R"], [2, 2])
    return small_matmul(K, torch.cat([R, t], -1))


def KRt_from_projection(P: Tensor, eps: float = 1e-6) -> Tuple[Tensor, Tensor, Tensor]:
    """Camera matrix, rotation and translation of projection matrices: P = K [R | t], up to its sign.

    RQ decomposition of the left 3x3 part, where K has a positive diagonal. The sign of P is arbitrary; the
    sign that makes R a rotation is used. R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 6.2.4.
    Computed in float64.

    Args:
        P: (*, 3, 4), its left 3x3 part of rank 3, floating point.
        eps: the least divisor of a row; it keeps the results of singular matrices finite.

    Returns:
        K (*, 3, 3), upper triangular and scaled as P; R (*, 3, 3); t (*, 3, 1). Differentiable.

    Raises:
        TypeError, ValueError: if P is not a floating-point (*, 3, 4) tensor.

    Example:
        >>> K, R, t = KRt_from_projection(
        ...     torch.tensor([[2.0, 0.0, 0.0, 2.0], [0.0, 2.0, 0.0, 4.0], [0.0, 0.0, 1.0, 3.0]])
        ... )
        >>> K.diagonal(), t[:, 0]
        (tensor([2., 2., 1.]), tensor([1., 2., 3.]))
    """
    check_matrix(P, 3, 4, "P")
    full = P.to(torch.float64)
    volume = (full[..., 0, 0:3] * cross(full[..., 1, 0:3], full[..., 2, 0:3])).sum(-1)
    full = torch.where((volume < 0)[..., None, None], -full, full)
    m0, m1, m2 = full[..., 0, 0:3], full[..., 1, 0:3], full[..., 2, 0:3]
    # Rows from the bottom: each is the part of its row that is orthogonal to the rows below it.
    k22, r2 = _length_and_direction(m2, eps)
    k12 = (m1 * r2).sum(-1)
    k11, r1 = _length_and_direction(m1 - k12[..., None] * r2, eps)
    r0 = cross(r1, r2)
    k00, k01, k02 = (m0 * r0).sum(-1), (m0 * r1).sum(-1), (m0 * r2).sum(-1)
    zero = torch.zeros_like(k00)
    K = torch.stack(
        [
            torch.stack([k00, k01, k02], -1),
            torch.stack([zero, k11, k12], -1),
            torch.stack([zero, zero, k22], -1),
        ],
        -2,
    )
    t2 = full[..., 2, 3] / k22.clamp(min=eps)
    t1 = (full[..., 1, 3] - k12 * t2) / k11.clamp(min=eps)
    t0 = (full[..., 0, 3] - k01 * t1 - k02 * t2) / k00.clamp(min=eps)
    return (
        K.to(P.dtype),
        torch.stack([r0, r1, r2], -2).to(P.dtype),
        torch.stack([t0, t1, t2], -1)[..., None].to(P.dtype),
    )


def projections_from_fundamental(F_mat: Tensor) -> Tensor:
    """A pair of projection matrices that have a given fundamental matrix: [I | 0] and [[e]x F | e], e the
    second image's epipole.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., result 9.14. e has unit length and a sign that
    does not depend on the sign of F.

    Args:
        F_mat: (*, 3, 3) of rank 2, floating point.

    Returns:
        (*, 3, 4, 2), the two side by side in the last dimension. Differentiable.

    Raises:
        TypeError, ValueError: if F_mat is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> (
        ...     projections_from_fundamental(
        ...         torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        ...     )[..., 1]
        ...     + 0.0
        ... )
        tensor([[ 0.,  0.,  0.,  1.],
                [ 0., -1.,  0.,  0.],
                [ 0.,  0., -1.,  0.]])
    """
    check_matrix(F_mat, 3, 3, "F_mat")
    e = left_null_vector(F_mat)
    second = torch.cat([small_matmul(cross_product_matrix(e), F_mat), e[..., None]], -1)
    eye = torch.eye(3, dtype=F_mat.dtype, device=F_mat.device).expand_as(F_mat)
    first = torch.cat([eye, torch.zeros_like(e)[..., None]], -1)
    return torch.stack([first, second], -1)


def depth_from_point(R: Tensor, t: Tensor, X: Tensor) -> Tensor:
    """Depths of points in a camera's frame: z of R X + t.

    Args:
        R: (*, 3, 3), rotations from the world to the camera's frame, floating point.
        t: (*, 3, 1), translations.
        X: (*, N, 3), points.

    Returns:
        (*, N). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> depth_from_point(torch.eye(3), torch.ones(3, 1), torch.tensor([[1.0, 2.0, 3.0]]))
        tensor([4.])
    """
    check_matrix(R, 3, 3, "R")
    check_matrix(t, 3, 1, "t")
    check_tensor(X, "X")
    if X.dim() < 2 or X.size(-1) != 3:
        raise ValueError(f"X: expected shape (*, N, 3), got {list(X.shape)}")
    check_leading([R, t, X], ["R", "t", "X"], [2, 2, 2])
    return (X * R[..., 2:3, :]).sum(-1) + t[..., 2, :]


def left_null_vector(m: Tensor) -> Tensor:
    """Unit vector (*, 3) whose product with a (*, 3, 3) matrix of rank 2 is 0: the longest cross product of
    two columns, with the sign of `pointed`."""
    a, b, c = m[..., :, 0], m[..., :, 1], m[..., :, 2]
    ab, bc, ca = cross(a, b), cross(b, c), cross(c, a)
    length_ab, length_bc, length_ca = (
        (ab * ab).sum(-1, keepdim=True),
        (bc * bc).sum(-1, keepdim=True),
        (ca * ca).sum(-1, keepdim=True),
    )
    longest = torch.where(length_ab >= length_bc, ab, bc)
    longest = torch.where(torch.maximum(length_ab, length_bc) >= length_ca, longest, ca)
    squared = torch.maximum(torch.maximum(length_ab, length_bc), length_ca)
    unit = longest / torch.sqrt(torch.where(squared == 0, torch.ones_like(squared), squared))
    return unit * pointed(unit[..., None])[..., 0, :]


def _length_and_direction(v: Tensor, eps: float) -> Tuple[Tensor, Tensor]:
    squared = (v * v).sum(-1)
    tiny = squared < eps * eps
    length = torch.sqrt(torch.where(tiny, torch.full_like(squared, eps * eps), squared))
    return length, v / length[..., None]
