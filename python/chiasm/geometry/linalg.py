"""Points and rigid transformations: products, distances, composition."""

import torch
from torch import Tensor

from ..primitives.core.checks import broadcastable, check_broadcastable, check_floating, check_leading
from ..primitives.linalg.matrices import small_matmul
from ..primitives.numbers.loss_reduction import narrowed, widened

__all__ = [
    "batched_dot_product",
    "batched_squared_norm",
    "compose_transformations",
    "euclidean_distance",
    "inverse_transformation",
    "point_line_distance",
    "relative_transformation",
    "transform_points",
]


def __dir__() -> list[str]:
    return __all__


def batched_dot_product(x: Tensor, y: Tensor, keepdim: bool = False) -> Tensor:
    """Dot product along the last dimension.

    Args:
        x: (*, D), floating point.
        y: (*, D); the other dimensions are broadcast.
        keepdim: keep the last dimension, with size 1.

    Returns:
        (*), or (*, 1).

    Raises:
        TypeError: if x or y is not floating point.
        ValueError: if the last dimensions differ.

    Example:
        >>> batched_dot_product(torch.tensor([[1.0, 2.0]]), torch.tensor([[3.0, 4.0]]))
        tensor([11.])
    """
    _check_vectors(x, y)
    return (x * y).sum(-1, keepdim)


def batched_squared_norm(x: Tensor, keepdim: bool = False) -> Tensor:
    """Squared length along the last dimension.

    Args:
        x: (*, D), floating point.
        keepdim: keep the last dimension, with size 1.

    Returns:
        (*), or (*, 1).

    Raises:
        TypeError: if x is not floating point.
        ValueError: if x has no dimension.

    Example:
        >>> batched_squared_norm(torch.tensor([[3.0, 4.0]]))
        tensor([25.])
    """
    return batched_dot_product(x, x, keepdim)


def euclidean_distance(x: Tensor, y: Tensor, keepdim: bool = False, eps: float = 1e-6) -> Tensor:
    """Distance between points along the last dimension.

    Args:
        x: (*, D), floating point.
        y: (*, D); the other dimensions are broadcast.
        keepdim: keep the last dimension, with size 1.
        eps: distances below eps have the gradient 0; their values are exact.

    Returns:
        (*), or (*, 1).

    Raises:
        TypeError: if x or y is not floating point.
        ValueError: if the last dimensions differ.

    Example:
        >>> euclidean_distance(torch.tensor([[1.0, 1.0]]), torch.tensor([[4.0, 5.0]]))
        tensor([5.])
    """
    _check_vectors(x, y)
    squared = batched_squared_norm(x - y, keepdim)
    near = squared < eps * eps
    return torch.where(
        near, torch.sqrt(squared.detach()), torch.sqrt(torch.where(near, torch.ones_like(squared), squared))
    )


def point_line_distance(point: Tensor, line: Tensor, eps: float = 1e-9) -> Tensor:
    """Distance of points in the plane from lines.

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 2.2: |a x + b y + c w| / (|w| sqrt(a^2 + b^2)).

    Args:
        point: (*, 2), or (*, 3) in homogeneous coordinates (x, y, w) with w other than 0; floating point.
        line: (*, 3), the coefficients of a x + b y + c = 0; the other dimensions are broadcast.
        eps: the least divisor; the length of the normal (a, b) is replaced by eps if it is less.

    Returns:
        (*).

    Raises:
        TypeError: if point or line is not floating point.
        ValueError: if the last dimensions are not as above.

    Example:
        >>> point_line_distance(torch.tensor([[1.0, 2.0]]), torch.tensor([[3.0, 4.0, -1.0]]))
        tensor([2.])
    """
    check_floating(point, "point")
    check_floating(line, "line")
    if point.dim() < 1 or (point.size(-1) != 2 and point.size(-1) != 3):
        raise ValueError(f"point: expected shape (*, 2) or (*, 3), got {list(point.shape)}")
    if line.dim() < 1 or line.size(-1) != 3:
        raise ValueError(f"line: expected shape (*, 3), got {list(line.shape)}")
    check_broadcastable(line, point, "line", "point", 1, 1)
    p, coefficients = widened(point), widened(line)
    normal = coefficients[..., :2]
    along = batched_dot_product(p[..., :2], normal)
    away = along + coefficients[..., 2]
    if p.size(-1) == 3:
        away = (along + coefficients[..., 2] * p[..., 2]) / p[..., 2]
    squared = batched_squared_norm(normal)
    short = squared < eps * eps
    length = torch.sqrt(torch.where(short, torch.ones_like(squared), squared))
    distance = away.abs() / torch.where(short, torch.full_like(length, eps), length)
    return narrowed(distance, point, line)


def transform_points(trans_01: Tensor, points_1: Tensor) -> Tensor:
    """Apply affine or projective transformations to points.

    Args:
        trans_01: (B, D + 1, D + 1), (1, D + 1, D + 1) or (D + 1, D + 1), from frame 1 to frame 0, acting on
            homogeneous columns.
        points_1: (B, ..., D) for a batch of transformations; any (*, D) for one. A batch of 1 broadcasts to
            any B.

    Returns:
        The points' shape and dtype, with the batch broadcast; computed in the wider dtype of both. Points at
        infinity (the absolute value of the last coordinate is at most 1e-8) are not divided by it.

    Raises:
        TypeError: if trans_01 or points_1 is not floating point.
        ValueError: if the shapes are not as above.

    Example:
        >>> shift = torch.tensor([[[1.0, 0.0, 5.0], [0.0, 1.0, 7.0], [0.0, 0.0, 1.0]]])
        >>> transform_points(shift, torch.zeros(1, 2, 2))
        tensor([[[5., 7.],
                 [5., 7.]]])
    """
    check_floating(trans_01, "trans_01")
    check_floating(points_1, "points_1")
    d = points_1.size(-1) if points_1.dim() > 0 else 0
    if d < 1:
        raise ValueError(f"points_1: expected shape (*, D), got {list(points_1.shape)}")
    if trans_01.dim() < 2 or trans_01.size(-1) != d + 1 or trans_01.size(-2) != d + 1:
        raise ValueError(
            f"trans_01: expected shape (B, {d + 1}, {d + 1}) for points in {d} dimensions, got"
            f" {list(trans_01.shape)}"
        )
    m = trans_01
    for _ in range(points_1.dim() + 1 - trans_01.dim() if trans_01.dim() > 2 else 0):
        m = m.unsqueeze(-3)
    if trans_01.dim() - 1 > points_1.dim() or not broadcastable(m, points_1, 2, 1):
        raise ValueError(
            f"points_1: expected the batch dimensions of trans_01 {list(trans_01.shape)}, got"
            f" {list(points_1.shape)}"
        )
    moved = m[..., d]
    for k in range(d):
        moved = moved + points_1[..., k : k + 1] * m[..., k]
    w = moved[..., d:]
    far = w.abs() <= 1e-8
    return (moved[..., :d] / torch.where(far, torch.ones_like(w), w)).to(points_1.dtype)


def compose_transformations(trans_01: Tensor, trans_12: Tensor) -> Tensor:
    """Compose rigid transformations from frame 1 to 0 and from frame 2 to 1 to one from frame 2 to 0: the
    product.

    Args:
        trans_01: (*, 4, 4), floating point, [R t; 0 1].
        trans_12: (*, 4, 4); the other dimensions are broadcast.

    Returns:
        (*, 4, 4), with the last row (0, 0, 0, 1), whatever the inputs' last rows are.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> shift = torch.eye(4)
        >>> shift[:3, 3] = torch.tensor([1.0, 2.0, 3.0])
        >>> compose_transformations(shift, shift)[:3, 3]
        tensor([2., 4., 6.])
    """
    _check_transformation(trans_01, "trans_01")
    _check_transformation(trans_12, "trans_12")
    check_leading([trans_01, trans_12], ["trans_01", "trans_12"], [2, 2])
    rotation = trans_01[..., :3, :3]
    product = small_matmul(rotation, trans_12[..., :3, :])
    shift = trans_01[..., :3, 3:]
    return _rigid(product[..., :3], product[..., 3:] + shift)


def inverse_transformation(trans_12: Tensor) -> Tensor:
    """Inverse of a rigid transformation: [R^T, -R^T t].

    Args:
        trans_12: (*, 4, 4), floating point, [R t; 0 1] with an orthonormal R.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError: if trans_12 is not floating point.
        ValueError: if its shape is not as above.

    Example:
        >>> shift = torch.eye(4)
        >>> shift[:3, 3] = torch.tensor([1.0, 2.0, 3.0])
        >>> inverse_transformation(shift)[:3, 3]
        tensor([-1., -2., -3.])
    """
    _check_transformation(trans_12, "trans_12")
    rotation = trans_12[..., :3, :3].transpose(-1, -2)
    return _rigid(rotation, -small_matmul(rotation, trans_12[..., :3, 3:]))


def relative_transformation(trans_01: Tensor, trans_02: Tensor) -> Tensor:
    """Rigid transformation from frame 2 to frame 1: inverse(trans_01) trans_02.

    Args:
        trans_01: (*, 4, 4), floating point, [R t; 0 1] with an orthonormal R.
        trans_02: (*, 4, 4); the other dimensions are broadcast.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> shift = torch.eye(4)
        >>> shift[:3, 3] = torch.tensor([1.0, 2.0, 3.0])
        >>> relative_transformation(torch.eye(4), shift)[:3, 3]
        tensor([1., 2., 3.])
    """
    _check_transformation(trans_01, "trans_01")
    _check_transformation(trans_02, "trans_02")
    check_leading([trans_01, trans_02], ["trans_01", "trans_02"], [2, 2])
    return compose_transformations(inverse_transformation(trans_01), trans_02)


def _check_vectors(x: Tensor, y: Tensor) -> None:
    check_floating(x, "x")
    check_floating(y, "y")
    if x.dim() < 1:
        raise ValueError(f"x: expected shape (*, D), got {list(x.shape)}")
    if y.dim() < 1 or y.size(-1) != x.size(-1):
        raise ValueError(f"y: expected shape (*, {x.size(-1)}) like x, got {list(y.shape)}")
    check_broadcastable(y, x, "y", "x", 1, 1)


def _check_transformation(value: Tensor, name: str) -> None:
    check_floating(value, name)
    if value.dim() < 2 or value.size(-1) != 4 or value.size(-2) != 4:
        raise ValueError(f"{name}: expected shape (*, 4, 4), got {list(value.shape)}")


def _rigid(rotation: Tensor, shift: Tensor) -> Tensor:
    """[R t; 0 1]."""
    upper = torch.cat([rotation, shift], -1)
    last = torch.tensor([[0.0, 0.0, 0.0, 1.0]], dtype=upper.dtype, device=upper.device)
    return torch.cat([upper, last.expand_as(upper[..., :1, :])], -2)
