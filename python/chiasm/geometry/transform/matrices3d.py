"""Matrices of 3D transforms, in voxels: x to the right, y down, z away. They are computed in float64, as in
2D."""

import math
from typing import Optional

import torch
from torch import Tensor

from ...primitives.core.checks import check_leading
from ...primitives.linalg.matrices import inverse, small_matmul
from ..conversions import axis_angle_to_rotation_matrix
from .matrices import about_center, check_points, check_vectors, homogeneous, tangent


def get_projective_transform(center: Tensor, angles: Tensor, scales: Tensor) -> Tensor:
    """Rotation of space about a centre, after scaling: T(center) R(angles) S(scales) T(-center).

    Args:
        center: (B, 3), x, y and z in voxels; the fixed point.
        angles: (B, 3), rotation vector (axis times angle) in degrees.
        scales: (B, 3), factors along x, y and z.

    Returns:
        (B, 3, 4), from source to destination voxels.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> get_projective_transform(torch.ones(1, 3), torch.zeros(1, 3), torch.full((1, 3), 2.0))[0]
        tensor([[ 2.,  0.,  0., -1.],
                [ 0.,  2.,  0., -1.],
                [ 0.,  0.,  2., -1.]])
    """
    check_vectors(center, 3, "center")
    check_vectors(angles, 3, "angles")
    check_vectors(scales, 3, "scales")
    check_leading([center, angles, scales], ["center", "angles", "scales"], [1, 1, 1])
    center, scales = torch.broadcast_tensors(center, scales)
    return _rotation(center, angles, scales).to(center.dtype)


def _rotation(center: Tensor, angles: Tensor, scales: Tensor) -> Tensor:
    rotation = axis_angle_to_rotation_matrix(angles.to(torch.float64) * (math.pi / 180.0))
    return about_center(rotation * scales.to(torch.float64)[:, None, :], center)


def get_shear_matrix3d(
    center: Tensor,
    sxy: Optional[Tensor] = None,
    sxz: Optional[Tensor] = None,
    syx: Optional[Tensor] = None,
    syz: Optional[Tensor] = None,
    szx: Optional[Tensor] = None,
    szy: Optional[Tensor] = None,
) -> Tensor:
    """3D homography that shears along z, then y, then x, about a centre: T(center) X Y Z T(-center).

    X adds -tan(sxy) x to y and -tan(sxz) x to z; Y adds -tan(syx) y to x and -tan(syz) y to z; Z adds
    -tan(szx) z to x and -tan(szy) z to y. The centre is a fixed point; in Kornia it moves.

    Args:
        center: (B, 3), x, y and z in voxels.
        sxy, sxz, syx, syz, szx, szy: (B,), or (1,) or a scalar for all: angles in radians; zero by default.

    Returns:
        (B, 4, 4).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> get_shear_matrix3d(torch.tensor([[2.0, 0.0, 0.0]]), torch.tensor([0.5]))[0, 1]
        tensor([-0.5463,  1.0000,  0.0000,  1.0926])
    """
    check_vectors(center, 3, "center")
    return homogeneous(_shear(center, sxy, sxz, syx, syz, szx, szy)).to(center.dtype)


def _shear(
    center: Tensor,
    sxy: Optional[Tensor],
    sxz: Optional[Tensor],
    syx: Optional[Tensor],
    syz: Optional[Tensor],
    szx: Optional[Tensor],
    szy: Optional[Tensor],
) -> Tensor:
    xy, xz = tangent(sxy, center, "sxy"), tangent(sxz, center, "sxz")
    yx, yz = tangent(syx, center, "syx"), tangent(syz, center, "syz")
    zx, zy = tangent(szx, center, "szx"), tangent(szy, center, "szy")
    names = ["center", "sxy", "sxz", "syx", "syz", "szx", "szy"]
    check_leading([center, xy, xz, yx, yz, zx, zy], names, [1, 0, 0, 0, 0, 0, 0])
    xy, xz, yx, yz, zx, zy, _ = torch.broadcast_tensors(xy, xz, yx, yz, zx, zy, center[:, 0])
    one, zero = torch.ones_like(xy), torch.zeros_like(xy)
    along_x = torch.stack([one, -xy, -xz], -1)
    along_y = torch.stack([-yx, one, -yz], -1)
    along_z = torch.stack([-zx, -zy, one], -1)
    unit_x, unit_y = torch.stack([one, zero, zero], -1), torch.stack([zero, one, zero], -1)
    unit_z = torch.stack([zero, zero, one], -1)
    x = torch.stack([along_x, unit_y, unit_z], -1)
    y = torch.stack([unit_x, along_y, unit_z], -1)
    z = torch.stack([unit_x, unit_y, along_z], -1)
    return about_center(small_matmul(small_matmul(x, y), z), center)


def get_affine_matrix3d(
    translations: Tensor,
    center: Tensor,
    scale: Tensor,
    angles: Tensor,
    sxy: Optional[Tensor] = None,
    sxz: Optional[Tensor] = None,
    syx: Optional[Tensor] = None,
    syz: Optional[Tensor] = None,
    szx: Optional[Tensor] = None,
    szy: Optional[Tensor] = None,
) -> Tensor:
    """3D homography that shears, scales and rotates about a centre and then translates.

    The product of a translation, ``get_projective_transform(center, -angles, scale)`` (note the sign, as in
    Kornia) and ``get_shear_matrix3d(center, sxy, ...)``.

    Args:
        translations: (B, 3), voxels along x, y and z.
        center: (B, 3), x, y and z in voxels.
        scale: (B, 3), factors along x, y and z.
        angles: (B, 3), rotation vector in degrees, of the inverse rotation.
        sxy, sxz, syx, syz, szx, szy: (B,), or (1,) or a scalar for all: shearing angles in radians; zero by
            default.

    Returns:
        (B, 4, 4).

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> two, zero = torch.full((1, 3), 2.0), torch.zeros(1, 3)
        >>> get_affine_matrix3d(torch.ones(1, 3), zero, two, zero)[0, 0]
        tensor([2., 0., 0., 1.])
    """
    check_vectors(translations, 3, "translations")
    check_vectors(center, 3, "center")
    check_vectors(scale, 3, "scale")
    check_vectors(angles, 3, "angles")
    names = ["translations", "center", "scale", "angles"]
    check_leading([translations, center, scale, angles], names, [1, 1, 1, 1])
    translations, center, scale, angles = torch.broadcast_tensors(translations, center, scale, angles)
    rotation = _rotation(center, -angles, scale)
    matrix = torch.cat(
        [rotation[:, :, :3], rotation[:, :, 3:] + translations.to(torch.float64)[:, :, None]], 2
    )
    given = (
        sxy is not None
        or sxz is not None
        or syx is not None
        or syz is not None
        or szx is not None
        or szy is not None
    )
    if given:
        matrix = small_matmul(matrix, homogeneous(_shear(center, sxy, sxz, syx, syz, szx, szy)))
    return homogeneous(matrix).to(center.dtype)


def get_perspective_transform3d(src: Tensor, dst: Tensor) -> Tensor:
    """3D homography between two boxes with eight corners.

    Five points determine it; as in Kornia these are corners 0, 1, 2, 5 and 7 (front: upper left, upper right,
    lower right; back: upper right, lower left), where no four may lie in a plane. The other three corners are
    ignored; if one box is an affine image of the other, they are mapped correctly too.

    Args:
        src: (B, 8, 3), front corners from the upper left clockwise, then the back's.
        dst: (B, 8, 3), the corners after the transform.

    Returns:
        (B, 4, 4), the last entry 1. Differentiable in both.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> front = torch.tensor([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
        >>> box = torch.cat([front, front + torch.tensor([0.0, 0.0, 1.0])])[None]
        >>> get_perspective_transform3d(box, 2.0 * box)[0].round().diagonal()
        tensor([2., 2., 2., 1.])
    """
    check_points(src, 8, 3, "src")
    check_points(dst, 8, 3, "dst")
    check_leading([src, dst], ["src", "dst"], [2, 2])
    matrix = small_matmul(
        _projective_basis(dst.to(torch.float64)), inverse(_projective_basis(src.to(torch.float64)))
    )
    return (matrix / matrix[:, 3:4, 3:4]).to(src.dtype)


def _projective_basis(points: Tensor) -> Tensor:
    """Matrix (B, 4, 4) that maps the unit vectors to four of the points and their sum to the fifth."""
    five = torch.stack([points[:, 0], points[:, 1], points[:, 2], points[:, 5], points[:, 7]], 2)
    p = torch.cat([five, torch.ones_like(five[:, :1])], 1)
    weight = small_matmul(inverse(p[:, :, :4]), p[:, :, 4:])
    return p[:, :, :4] * weight.transpose(1, 2)
