"""Matrices of plane transforms, in pixels: x to the right, y down.

They are computed in float64 for every input dtype, as in OpenCV: a centre is hundreds of pixels from the
origin, so that the image moves by hundreds of times the error of a matrix entry.
"""

import math
from typing import List, Optional

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_floating,
    check_last,
    check_leading,
    check_same_leading,
    check_tensor,
)
from ...primitives.linalg.matrices import inverse3x3, small_matmul
from ...primitives.resampling.warping import check_matrices


def get_rotation_matrix2d(center: Tensor, angle: Tensor, scale: Tensor) -> Tensor:
    """Rotation about a centre, after scaling: T(center) R(angle) S(scale) T(-center).

    For equal scales this is ``cv2.getRotationMatrix2D(center, angle, scale)``.

    Args:
        center: (B, 2), x and y in pixels; the fixed point.
        angle: (B,) or a scalar, in degrees, counterclockwise as seen (y points down).
        scale: (B, 2), factors along x and y.

    Returns:
        (B, 2, 3), from source to destination pixels.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> get_rotation_matrix2d(torch.zeros(1, 2), torch.tensor([90.0]), torch.ones(1, 2))[0].round() + 0.0
        tensor([[ 0.,  1.,  0.],
                [-1.,  0.,  0.]])
    """
    check_vectors(center, 2, "center")
    check_tensor(angle, "angle")
    angles = angle.expand(center.size(0)) if angle.dim() == 0 else angle
    check_numbers(angles, "angle")
    check_vectors(scale, 2, "scale")
    check_leading([center, angles, scale], ["center", "angle", "scale"], [1, 0, 1])
    center, scale = torch.broadcast_tensors(center, scale)
    return _rotation(center, angles, scale).to(center.dtype)


def _rotation(center: Tensor, angle: Tensor, scale: Tensor) -> Tensor:
    radians = angle.to(torch.float64) * (math.pi / 180.0)
    factor = scale.to(torch.float64)
    cosine, sine = torch.cos(radians), torch.sin(radians)
    rows = [[cosine * factor[:, 0], sine * factor[:, 1]], [-sine * factor[:, 0], cosine * factor[:, 1]]]
    return about_center(from_rows(rows), center)


def get_translation_matrix2d(translations: Tensor) -> Tensor:
    """Homography that translates an image.

    Args:
        translations: (B, 2), in pixels along x and y.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError: if translations is not floating point.
        ValueError: if its shape is not as above.

    Example:
        >>> get_translation_matrix2d(torch.tensor([[5.0, -2.0]]))[0]
        tensor([[ 1.,  0.,  5.],
                [ 0.,  1., -2.],
                [ 0.,  0.,  1.]])
    """
    check_vectors(translations, 2, "translations")
    one, zero = torch.ones_like(translations[:, 0]), torch.zeros_like(translations[:, 0])
    return from_rows([[one, zero, translations[:, 0]], [zero, one, translations[:, 1]], [zero, zero, one]])


def get_shear_matrix2d(center: Tensor, sx: Optional[Tensor] = None, sy: Optional[Tensor] = None) -> Tensor:
    """Homography that shears along x, then along y, about a centre: T(center) Y X T(-center).

    X maps (x, y) to (x - tan(sx) y, y), and Y maps (x, y) to (x, y - tan(sy) x).

    Args:
        center: (B, 2), x and y in pixels; the fixed point.
        sx: (B,), or (1,) or a scalar for all: angle along x in radians; zero by default.
        sy: (B,), or (1,) or a scalar for all: angle along y in radians; zero by default.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> get_shear_matrix2d(torch.tensor([[0.0, 10.0]]), torch.tensor([0.5]))[0, 0]
        tensor([ 1.0000, -0.5463,  5.4630])
    """
    check_vectors(center, 2, "center")
    return homogeneous(_shear(center, sx, sy)).to(center.dtype)


def _shear(center: Tensor, sx: Optional[Tensor], sy: Optional[Tensor]) -> Tensor:
    along_x, along_y = tangent(sx, center, "sx"), tangent(sy, center, "sy")
    check_leading([center, along_x, along_y], ["center", "sx", "sy"], [1, 0, 0])
    along_x, along_y, _ = torch.broadcast_tensors(along_x, along_y, center[:, 0])
    return about_center(
        from_rows([[torch.ones_like(along_x), -along_x], [-along_y, 1.0 + along_x * along_y]]), center
    )


def get_affine_matrix2d(
    translations: Tensor,
    center: Tensor,
    scale: Tensor,
    angle: Tensor,
    sx: Optional[Tensor] = None,
    sy: Optional[Tensor] = None,
) -> Tensor:
    """Homography that shears, scales and rotates about a centre and then translates.

    The product of ``get_translation_matrix2d(translations)``, ``get_rotation_matrix2d(center, -angle,
    scale)`` (note the sign, as in Kornia) and ``get_shear_matrix2d(center, sx, sy)``.

    Args:
        translations: (B, 2), pixels along x and y.
        center: (B, 2), x and y in pixels.
        scale: (B, 2), factors along x and y.
        angle: (B,) in degrees, clockwise as seen.
        sx: (B,), or (1,) or a scalar for all: shearing angle along x in radians; zero by default.
        sy: (B,), or (1,) or a scalar for all: shearing angle along y in radians; zero by default.

    Returns:
        (B, 3, 3).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> two = torch.full((1, 2), 2.0)
        >>> get_affine_matrix2d(torch.ones(1, 2), torch.zeros(1, 2), two, torch.zeros(1))[0] + 0.0
        tensor([[2., 0., 1.],
                [0., 2., 1.],
                [0., 0., 1.]])
    """
    check_vectors(translations, 2, "translations")
    check_vectors(center, 2, "center")
    check_vectors(scale, 2, "scale")
    check_numbers(angle, "angle")
    names = ["translations", "center", "scale", "angle"]
    check_leading([translations, center, scale, angle], names, [1, 1, 1, 0])
    translations, center, scale, _ = torch.broadcast_tensors(translations, center, scale, angle[:, None])
    rotation = _rotation(center, -angle, scale)
    matrix = torch.cat(
        [rotation[:, :, :2], rotation[:, :, 2:] + translations.to(torch.float64)[:, :, None]], 2
    )
    if sx is not None or sy is not None:
        matrix = small_matmul(matrix, homogeneous(_shear(center, sx, sy)))
    return homogeneous(matrix).to(center.dtype)


def get_perspective_transform(points_src: Tensor, points_dst: Tensor) -> Tensor:
    """Homography that maps four points exactly to four others, like ``cv2.getPerspectiveTransform``. In
    closed form: one homography maps the points at infinity of the axes, the origin and (1, 1, 1) to any four
    points; two of these give the homography between two quadruples (R. Hartley, A. Zisserman, Multiple View
    Geometry, 2nd ed., section 2.3).

    Args:
        points_src: (B, 4, 2), no three on a line.
        points_dst: (B, 4, 2), no three on a line.

    Returns:
        (B, 3, 3), the last entry 1. Differentiable in both.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> square = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
        >>> get_perspective_transform(square, 3.0 * square + 1.0)[0]
        tensor([[3., 0., 1.],
                [0., 3., 1.],
                [0., 0., 1.]])
    """
    check_points(points_src, 4, 2, "points_src")
    check_points(points_dst, 4, 2, "points_dst")
    check_leading([points_src, points_dst], ["points_src", "points_dst"], [2, 2])
    source = _projective_basis(points_src.to(torch.float64))
    matrix = small_matmul(_projective_basis(points_dst.to(torch.float64)), inverse3x3(source))
    return (matrix / matrix[:, 2:3, 2:3]).to(points_src.dtype)


def _projective_basis(points: Tensor) -> Tensor:
    """Matrix (B, 3, 3) that maps the unit vectors to the first three points and their sum to the fourth."""
    p = torch.cat([points, torch.ones_like(points[:, :, :1])], 2).transpose(1, 2)
    weight = small_matmul(inverse3x3(p[:, :, :3]), p[:, :, 3:])
    return p[:, :, :3] * weight.transpose(1, 2)


def invert_affine_transform(matrix: Tensor) -> Tensor:
    """The inverse of an affine transform, like ``cv2.invertAffineTransform``.

    Args:
        matrix: (B, 2, 3), its left 2 x 2 part invertible.

    Returns:
        (B, 2, 3).

    Raises:
        TypeError: if matrix is not floating point.
        ValueError: if its shape is not as above.

    Example:
        >>> invert_affine_transform(torch.tensor([[[2.0, 0.0, 6.0], [0.0, 4.0, 2.0]]]))[0] + 0.0
        tensor([[ 0.5000,  0.0000, -3.0000],
                [ 0.0000,  0.2500, -0.5000]])
    """
    check_matrices(matrix, 2, 3, "matrix")
    return inverse_affine(matrix.to(torch.float64)).to(matrix.dtype)


def inverse_affine(m: Tensor) -> Tensor:
    """Inverse of (B, 2, 3) by Cramer's rule."""
    determinant = m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0]
    a, b = m[:, 1, 1] / determinant, -m[:, 0, 1] / determinant
    c, d = -m[:, 1, 0] / determinant, m[:, 0, 0] / determinant
    return from_rows([[a, b, -(a * m[:, 0, 2] + b * m[:, 1, 2])], [c, d, -(c * m[:, 0, 2] + d * m[:, 1, 2])]])


def projection_from_Rt(rmat: Tensor, tvec: Tensor) -> Tensor:
    """Concatenate rotation and translation: [R | t].

    Args:
        rmat: (*, 3, 3).
        tvec: (*, 3, 1).

    Returns:
        (*, 3, 4).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> projection_from_Rt(torch.eye(3), torch.ones(3, 1))
        tensor([[1., 0., 0., 1.],
                [0., 1., 0., 1.],
                [0., 0., 1., 1.]])
    """
    check_floating(rmat, "rmat")
    check_floating(tvec, "tvec")
    if rmat.dim() < 2 or rmat.size(-1) != 3 or rmat.size(-2) != 3:
        raise ValueError(f"rmat: expected shape (*, 3, 3), got {list(rmat.shape)}")
    if tvec.dim() < 2 or tvec.size(-1) != 1 or tvec.size(-2) != 3:
        raise ValueError(f"tvec: expected shape (*, 3, 1), got {list(tvec.shape)}")
    check_same_leading([rmat, tvec], ["rmat", "tvec"], [2, 2])
    return torch.cat([rmat, tvec], -1)


# --- helpers of the matrices --------------------------------------------------------------------------------


def check_vectors(value: Tensor, size: int, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, size) tensor."""
    check_last(value, size, name)
    if value.dim() != 2:
        raise ValueError(f"{name}: expected shape (B, {size}), got {list(value.shape)}")


def check_numbers(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B,) tensor."""
    check_floating(value, name)
    if value.dim() != 1:
        raise ValueError(f"{name}: expected shape (B,), got {list(value.shape)}")


def numbers(value: Tensor, name: str) -> Tensor:
    """``value`` (B,), or a scalar as (1,); raise for anything else that is not floating point."""
    check_tensor(value, name)
    value = value.reshape(1) if value.dim() == 0 else value
    check_numbers(value, name)
    return value


def check_points(value: Tensor, count: int, size: int, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, count, size) tensor."""
    check_floating(value, name)
    if value.dim() != 3 or value.size(1) != count or value.size(2) != size:
        raise ValueError(f"{name}: expected shape (B, {count}, {size}), got {list(value.shape)}")


def from_rows(rows: List[List[Tensor]]) -> Tensor:
    """Entries (B,) as a matrix (B, rows, columns)."""
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def homogeneous(matrix: Tensor) -> Tensor:
    """(B, n, n + 1) with the row (0, ..., 0, 1) below it."""
    zero = torch.zeros_like(matrix[:, :1, 1:])
    return torch.cat([matrix, torch.cat([zero, torch.ones_like(matrix[:, :1, :1])], 2)], 1)


def about_center(m: Tensor, center: Tensor) -> Tensor:
    """(B, n, n + 1) in float64: a linear map (B, n, n), shifted so that ``center`` (B, n) is its fixed
    point."""
    c = center.to(torch.float64)[:, :, None]
    return torch.cat([m, c - small_matmul(m, c)], 2)


def tangent(angle: Optional[Tensor], like: Tensor, name: str) -> Tensor:
    """Tangent in float64 of angles (B,) or of one angle; 0 for None."""
    if angle is None:
        return torch.zeros_like(like[:, 0].to(torch.float64))
    radians = numbers(angle, name).to(torch.float64)
    return torch.sin(radians) / torch.cos(radians)
