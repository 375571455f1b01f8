"""Conversions of camera poses: (R, t) and 4x4 matrices, camera-to-world and world-to-camera, the axes of
graphics and of vision. In graphics (OpenGL, ARKit), the camera looks along -z and y points up; in vision
(OpenCV, COLMAP), it looks along +z and y points down.
"""

from typing import Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_leading, check_matrix, check_same_leading
from ...primitives.linalg.matrices import small_matmul
from .homogeneous import convert_affinematrix_to_homography3d
from .rotations import quaternion_to_rotation_matrix, require_rotation, rotation_matrix_to_quaternion


def Rt_to_matrix4x4(R: Tensor, t: Tensor) -> Tensor:
    """The matrix [[R, t], [0, 1]].

    Args:
        R: (B, 3, 3), floating point.
        t: (B, 3, 1).

    Returns:
        (B, 4, 4).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> Rt_to_matrix4x4(torch.eye(3)[None], torch.ones(1, 3, 1))[0, :, 3]
        tensor([1., 1., 1., 1.])
    """
    _check_pose(R, t)
    check_same_leading([R, t], ["R", "t"], [2, 2])
    return convert_affinematrix_to_homography3d(torch.cat([R, t], -1))


def matrix4x4_to_Rt(extrinsics: Tensor) -> Tuple[Tensor, Tensor]:
    """R and t of the matrix [[R, t], [0, 1]].

    Args:
        extrinsics: (*, 4, 4), floating point.

    Returns:
        R (*, 3, 3) and t (*, 3, 1).

    Raises:
        TypeError, ValueError: if extrinsics is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> R, t = matrix4x4_to_Rt(torch.eye(4)[None])
        >>> R.shape, t.shape
        (torch.Size([1, 3, 3]), torch.Size([1, 3, 1]))
    """
    check_matrix(extrinsics, 4, 4, "extrinsics")
    return extrinsics[..., :3, :3], extrinsics[..., :3, 3:]


def camtoworld_graphics_to_vision_4x4(extrinsics_graphics: Tensor) -> Tensor:
    """Convert camera-to-world matrices from graphics axes to vision axes: the y and z axes are negated.

    Args:
        extrinsics_graphics: (*, 4, 4), floating point.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError, ValueError: if extrinsics_graphics is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> camtoworld_graphics_to_vision_4x4(torch.eye(4)).diagonal()
        tensor([ 1., -1., -1.,  1.])
    """
    check_matrix(extrinsics_graphics, 4, 4, "extrinsics_graphics")
    return _turned(extrinsics_graphics)


def camtoworld_vision_to_graphics_4x4(extrinsics_vision: Tensor) -> Tensor:
    """The inverse of `camtoworld_graphics_to_vision_4x4`.

    Args:
        extrinsics_vision: (*, 4, 4), floating point.

    Returns:
        (*, 4, 4).

    Raises:
        TypeError, ValueError: if extrinsics_vision is not a floating-point (*, 4, 4) tensor.

    Example:
        >>> camtoworld_vision_to_graphics_4x4(torch.eye(4)).diagonal()
        tensor([ 1., -1., -1.,  1.])
    """
    check_matrix(extrinsics_vision, 4, 4, "extrinsics_vision")
    return _turned(extrinsics_vision)


def camtoworld_graphics_to_vision_Rt(R: Tensor, t: Tensor) -> Tuple[Tensor, Tensor]:
    """`camtoworld_graphics_to_vision_4x4` for R and t.

    Args:
        R: (*, 3, 3), floating point.
        t: (*, 3, 1).

    Returns:
        R (*, 3, 3) and t (*, 3, 1), which is unchanged.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> camtoworld_graphics_to_vision_Rt(torch.eye(3), torch.ones(3, 1))[0].diagonal()
        tensor([ 1., -1., -1.])
    """
    _check_pose(R, t)
    return _turned(R), t.clone()


def camtoworld_vision_to_graphics_Rt(R: Tensor, t: Tensor) -> Tuple[Tensor, Tensor]:
    """The inverse of `camtoworld_graphics_to_vision_Rt`.

    Args:
        R: (*, 3, 3), floating point.
        t: (*, 3, 1).

    Returns:
        R (*, 3, 3) and t (*, 3, 1), which is unchanged.

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> camtoworld_vision_to_graphics_Rt(torch.eye(3), torch.ones(3, 1))[0].diagonal()
        tensor([ 1., -1., -1.])
    """
    _check_pose(R, t)
    return _turned(R), t.clone()


def camtoworld_to_worldtocam_Rt(R: Tensor, t: Tensor, check_rotation: bool = False) -> Tuple[Tensor, Tensor]:
    """The inverse pose: R^T and -R^T t.

    Args:
        R: (*, 3, 3), rotations, floating point.
        t: (*, 3, 1).
        check_rotation: True checks the values and raises an error if a matrix is not a rotation; such a call
            cannot be exported.

    Returns:
        R (*, 3, 3) and t (*, 3, 1).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above, or
            check_rotation finds that R is not a rotation.

    Example:
        >>> camtoworld_to_worldtocam_Rt(torch.eye(3), torch.ones(3, 1))[1][:, 0]
        tensor([-1., -1., -1.])
    """
    return _inverse_pose(R, t, check_rotation)


def worldtocam_to_camtoworld_Rt(R: Tensor, t: Tensor, check_rotation: bool = False) -> Tuple[Tensor, Tensor]:
    """The inverse pose, as `camtoworld_to_worldtocam_Rt`: R^T and -R^T t.

    Args:
        R: (*, 3, 3), rotations, floating point.
        t: (*, 3, 1).
        check_rotation: True checks the values and raises an error if a matrix is not a rotation; such a call
            cannot be exported.

    Returns:
        R (*, 3, 3) and t (*, 3, 1).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above, or
            check_rotation finds that R is not a rotation.

    Example:
        >>> worldtocam_to_camtoworld_Rt(torch.eye(3), torch.ones(3, 1))[1][:, 0]
        tensor([-1., -1., -1.])
    """
    return _inverse_pose(R, t, check_rotation)


def ARKitQTVecs_to_ColmapQTVecs(qvec: Tensor, tvec: Tensor) -> Tuple[Tensor, Tensor]:
    """Convert ARKit's camera-to-world poses (graphics axes) to COLMAP's world-to-camera poses (vision axes).

    Args:
        qvec: (*, 4), unit quaternions in the order w, x, y, z, floating point.
        tvec: (*, 3, 1), translations.

    Returns:
        Quaternions (*, 4) with w >= 0, and translations (*, 3, 1).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> ARKitQTVecs_to_ColmapQTVecs(torch.tensor([1.0, 0.0, 0.0, 0.0]), torch.ones(3, 1))[1][:, 0]
        tensor([-1.,  1.,  1.])
    """
    _check_vectors(qvec, tvec)
    R, t = camtoworld_graphics_to_vision_Rt(quaternion_to_rotation_matrix(qvec), tvec)
    R, t = camtoworld_to_worldtocam_Rt(R, t)
    return rotation_matrix_to_quaternion(R), t


def ColmapQTVecs_to_ARKitQTVecs(qvec: Tensor, tvec: Tensor) -> Tuple[Tensor, Tensor]:
    """The inverse of `ARKitQTVecs_to_ColmapQTVecs`.

    Args:
        qvec: (*, 4), unit quaternions in the order w, x, y, z, floating point.
        tvec: (*, 3, 1), translations.

    Returns:
        Quaternions (*, 4) with w >= 0, and translations (*, 3, 1).

    Raises:
        TypeError, ValueError: if an argument is not floating point or not of the shape above.

    Example:
        >>> ColmapQTVecs_to_ARKitQTVecs(torch.tensor([0.0, 1.0, 0.0, 0.0]), torch.ones(3, 1))[1][:, 0]
        tensor([-1.,  1.,  1.])
    """
    _check_vectors(qvec, tvec)
    R, t = worldtocam_to_camtoworld_Rt(quaternion_to_rotation_matrix(qvec), tvec)
    R, t = camtoworld_vision_to_graphics_Rt(R, t)
    return rotation_matrix_to_quaternion(R), t


def _check_pose(R: Tensor, t: Tensor) -> None:
    check_matrix(R, 3, 3, "R")
    check_matrix(t, 3, 1, "t")


def _check_vectors(qvec: Tensor, tvec: Tensor) -> None:
    check_last(qvec, 4, "qvec")
    check_matrix(tvec, 3, 1, "tvec")
    check_leading([qvec, tvec], ["qvec", "tvec"], [1, 2])


def _turned(matrix: Tensor) -> Tensor:
    """Columns 1 and 2 negated."""
    return torch.cat([matrix[..., :1], -matrix[..., 1:3], matrix[..., 3:]], -1)


def _inverse_pose(R: Tensor, t: Tensor, check_rotation: bool) -> Tuple[Tensor, Tensor]:
    _check_pose(R, t)
    check_leading([R, t], ["R", "t"], [2, 2])
    if check_rotation:
        require_rotation(R, "R")
    inverse = R.transpose(-1, -2).contiguous()
    return inverse, -small_matmul(inverse, t)
