"""Local affine frames: regions of an image as affine maps of the unit disk.

A frame (2, 3) has a matrix A and a centre c, the last column: a point v of the unit disk is at A v + c in
pixels, where (0, 0) is the centre of the upper left pixel. Frames are tensors (B, N, 2, 3). Angles are in
degrees, counterclockwise as seen on the screen (y points down), as in `angle_to_rotation_matrix`. A slot that
holds no frame is all zeros.
"""

from typing import Optional, Union

import torch
from torch import Tensor

from ..geometry.conversions.angles import angle_to_rotation_matrix, rad2deg
from ..primitives.core.checks import (
    check_expands,
    check_floating,
    check_image,
    check_number,
    check_tensor,
)
from ..primitives.geometry.angles import angle_of
from ..primitives.linalg.matrices import small_matmul
from ..primitives.resampling.taps import larger, smaller
from ..primitives.resampling.warping import position_dtype


def get_laf_center(LAF: Tensor) -> Tensor:
    """Centres of local affine frames.

    Args:
        LAF: (B, N, 2, 3), floating point.

    Returns:
        (B, N, 2), x and y.

    Raises:
        TypeError: if LAF is not floating point.
        ValueError: if LAF is not (B, N, 2, 3).

    Example:
        >>> get_laf_center(torch.tensor([[[[2.0, 0.0, 7.0], [0.0, 2.0, 5.0]]]]))
        tensor([[[7., 5.]]])
    """
    check_laf(LAF, "LAF")
    return LAF[..., 2]


def get_laf_scale(LAF: Tensor) -> Tensor:
    """Scales of local affine frames: the radius of the disk of the same area, the square root of |det A|.

    Args:
        LAF: (B, N, 2, 3), floating point.

    Returns:
        (B, N, 1, 1) in pixels; the derivative is 0 where the scale is.

    Raises:
        TypeError: if LAF is not floating point.
        ValueError: if LAF is not (B, N, 2, 3).

    Example:
        >>> get_laf_scale(torch.tensor([[[[2.0, 0.0, 7.0], [1.0, 8.0, 5.0]]]]))
        tensor([[[[4.]]]])
    """
    check_laf(LAF, "LAF")
    area = determinants(LAF).abs()
    flat = area == 0
    scale = torch.where(flat, area, torch.sqrt(torch.where(flat, torch.ones_like(area), area)))
    return scale.to(LAF.dtype)[..., None, None]


def get_laf_orientation(LAF: Tensor) -> Tensor:
    """Orientations of local affine frames: the angle of the rotation that ``make_upright`` undoes.

    Args:
        LAF: (B, N, 2, 3), floating point.

    Returns:
        (B, N, 1), atan2(A12, A11) in degrees, from -180 to 180; 0, with derivative 0, where both are 0.

    Raises:
        TypeError: if LAF is not floating point.
        ValueError: if LAF is not (B, N, 2, 3).

    Example:
        >>> get_laf_orientation(torch.tensor([[[[0.0, 3.0, 7.0], [-3.0, 0.0, 5.0]]]]))
        tensor([[[90.]]])
    """
    check_laf(LAF, "LAF")
    across, down = LAF[..., 0, 0], LAF[..., 0, 1]
    nowhere = (across == 0) & (down == 0)
    angle = angle_of(down, torch.where(nowhere, torch.ones_like(across), across))
    return rad2deg(torch.where(nowhere, torch.zeros_like(angle), angle))[..., None]


def set_laf_orientation(LAF: Tensor, angles_degrees: Tensor) -> Tensor:
    """Rotate local affine frames to given orientations.

    Args:
        LAF: (B, N, 2, 3), floating point.
        angles_degrees: (B, N, 1), the new results of ``get_laf_orientation``; (N, 1) or a scalar for all.

    Returns:
        (B, N, 2, 3), of the same shapes and centres.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> frame = torch.tensor([[[[0.0, 3.0, 7.0], [-3.0, 0.0, 5.0]]]])
        >>> get_laf_orientation(set_laf_orientation(frame, torch.full([1, 1, 1], 30.0))).round()
        tensor([[[30.]]])
    """
    angles_degrees = _angles(LAF, angles_degrees)
    return rotate_laf(LAF, angles_degrees - get_laf_orientation(LAF))


def rotate_laf(LAF: Tensor, angles_degrees: Tensor) -> Tensor:
    """Rotate local affine frames about their centres: A times the rotation matrix. The ellipses do not
    change.

    Args:
        LAF: (B, N, 2, 3), floating point.
        angles_degrees: (B, N, 1), counterclockwise as seen on the screen where A is a multiple of the
            identity; (N, 1) or a scalar for all.

    Returns:
        (B, N, 2, 3).

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> frame = torch.tensor([[[[3.0, 0.0, 7.0], [0.0, 3.0, 5.0]]]])
        >>> rotate_laf(frame, torch.full([1, 1, 1], 90.0)).round().long()
        tensor([[[[ 0,  3,  7],
                  [-3,  0,  5]]]])
    """
    angles_degrees = _angles(LAF, angles_degrees)
    rotation = angle_to_rotation_matrix(angles_degrees[..., 0].to(LAF.dtype))
    return torch.cat([small_matmul(LAF[..., :2], rotation), LAF[..., 2:]], -1)


def scale_laf(laf: Tensor, scale_coef: Union[float, Tensor]) -> Tensor:
    """Enlarge local affine frames about their centres.

    Args:
        laf: (B, N, 2, 3), floating point.
        scale_coef: a number, or a tensor that broadcasts against (B, N, 1, 1).

    Returns:
        (B, N, 2, 3).

    Raises:
        TypeError: if laf is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> scale_laf(torch.tensor([[[[3.0, 0.0, 7.0], [0.0, 3.0, 5.0]]]]), 2.0)
        tensor([[[[6., 0., 7.],
                  [0., 6., 5.]]]])
    """
    check_laf(laf, "laf")
    matrix = laf[..., :2]
    if isinstance(scale_coef, Tensor):
        check_expands(scale_coef, matrix, "scale_coef", "laf[..., :2]")
        scaled = matrix * scale_coef.to(laf.dtype)
    else:
        check_number(scale_coef, "scale_coef")
        scaled = matrix * scale_coef
    return torch.cat([scaled, laf[..., 2:]], -1)


def make_upright(laf: Tensor, eps: float = 1e-9) -> Tensor:
    """Rotate local affine frames so that their second axis points straight down. A12 becomes 0, and A11
    becomes the length of A's first row. Mirrored frames (det A < 0) stay mirrored (Kornia loses the sign);
    ellipses do not change.

    Args:
        laf: (B, N, 2, 3), floating point. Half precision is computed in float32.
        eps: the least length of a first row for which A11 becomes the full length.

    Returns:
        (B, N, 2, 3), of the same shapes and centres.

    Raises:
        TypeError: if laf is not floating point.
        ValueError: if laf is not (B, N, 2, 3).

    Example:
        >>> make_upright(torch.tensor([[[[0.0, 3.0, 7.0], [-3.0, 0.0, 5.0]]]]))
        tensor([[[[3., 0., 7.],
                  [0., 3., 5.]]]])
    """
    check_laf(laf, "laf")
    exact = laf.to(position_dtype(laf.dtype))
    a, b, c, d = exact[..., 0, 0], exact[..., 0, 1], exact[..., 1, 0], exact[..., 1, 1]
    squared = a * a + b * b
    short = squared <= eps * eps
    length = torch.where(
        short,
        torch.full_like(squared, eps),
        torch.sqrt(torch.where(short, torch.ones_like(squared), squared)),
    )
    first = torch.stack([squared / length, torch.zeros_like(a)], -1)
    second = torch.stack([(a * c + b * d) / length, determinants(laf).to(exact.dtype) / length], -1)
    return torch.cat([torch.stack([first, second], -2).to(laf.dtype), laf[..., 2:]], -1)


def laf_from_center_scale_ori(
    xy: Tensor, scale: Optional[Tensor] = None, ori: Optional[Tensor] = None
) -> Tensor:
    """Local affine frames of disks: ori's rotation matrix times scale, and the centre.

    Args:
        xy: (B, N, 2), floating point, centres in pixels.
        scale: (B, N, 1, 1), radii in pixels; 1 if None.
        ori: (B, N, 1), orientations in degrees; 0 if None.

    Returns:
        (B, N, 2, 3).

    Raises:
        TypeError: if xy is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> laf_from_center_scale_ori(torch.tensor([[[7.0, 5.0]]]), torch.full([1, 1, 1, 1], 3.0)).long()
        tensor([[[[3, 0, 7],
                  [0, 3, 5]]]])
    """
    check_floating(xy, "xy")
    if xy.dim() != 3 or xy.size(2) != 2:
        raise ValueError(f"xy: expected shape (B, N, 2), got {list(xy.shape)}")
    if ori is None:
        angle = torch.zeros_like(xy[..., 0])
    else:
        check_tensor(ori, "ori")
        if ori.dim() != 3 or ori.size(2) != 1:
            raise ValueError(f"ori: expected shape (B, N, 1), got {list(ori.shape)}")
        check_expands(ori, xy[..., 0:1], "ori", "xy[..., 0:1]")
        angle = ori[..., 0].to(xy.dtype).expand_as(xy[..., 0])
    matrix = angle_to_rotation_matrix(angle)
    if scale is not None:
        check_tensor(scale, "scale")
        if scale.dim() != 4 or scale.size(2) != 1 or scale.size(3) != 1:
            raise ValueError(f"scale: expected shape (B, N, 1, 1), got {list(scale.shape)}")
        check_expands(scale, xy[..., None, 0:1], "scale", "xy[..., None, 0:1]")
        matrix = matrix * scale.to(xy.dtype)
    return torch.cat([matrix, xy[..., None]], -1)


def normalize_laf(LAF: Tensor, images: Tensor) -> Tensor:
    """Normalize frames in pixels by the image size: x / (W - 1), y / (H - 1) and A / min(W - 1, H - 1).

    Args:
        LAF: (B, N, 2, 3), floating point, in pixels.
        images: (B, C, H, W), floating point; only their size is used.

    Returns:
        (B, N, 2, 3). An axis of one pixel is not divided.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> normalize_laf(torch.tensor([[[[2.0, 0.0, 8.0], [0.0, 2.0, 4.0]]]]), torch.zeros(1, 1, 5, 9))
        tensor([[[[0.5000, 0.0000, 1.0000],
                  [0.0000, 0.5000, 1.0000]]]])
    """
    return LAF / _extent(LAF, images)


def denormalize_laf(LAF: Tensor, images: Tensor) -> Tensor:
    """The inverse of ``normalize_laf``.

    Args:
        LAF: (B, N, 2, 3), floating point, normalised.
        images: (B, C, H, W), floating point; only their size is used.

    Returns:
        (B, N, 2, 3) in pixels.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> denormalize_laf(torch.tensor([[[[0.5, 0.0, 1.0], [0.0, 0.5, 1.0]]]]), torch.zeros(1, 1, 5, 9))
        tensor([[[[2., 0., 8.],
                  [0., 2., 4.]]]])
    """
    return LAF * _extent(LAF, images)


def check_laf(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, N, 2, 3) tensor."""
    check_floating(value, name)
    if value.dim() != 4 or value.size(2) != 2 or value.size(3) != 3:
        raise ValueError(f"{name}: expected shape (B, N, 2, 3), got {list(value.shape)}")


def determinants(laf: Tensor) -> Tensor:
    """The determinants (B, N) in float64, since the two products nearly cancel for long, thin frames."""
    a = laf.to(torch.float64)
    return a[..., 0, 0] * a[..., 1, 1] - a[..., 0, 1] * a[..., 1, 0]


def _angles(laf: Tensor, angles: Tensor) -> Tensor:
    """(B, N, 1), or what broadcasts with it, of that, (N, 1) or a scalar."""
    check_laf(laf, "LAF")
    check_floating(angles, "angles_degrees")
    if angles.dim() == 0:
        angles = angles.reshape(1, 1, 1)
    elif angles.dim() == 2:
        angles = angles.unsqueeze(0)
    if angles.dim() != 3 or angles.size(2) != 1:
        raise ValueError(f"angles_degrees: expected shape (B, N, 1), got {list(angles.shape)}")
    check_expands(angles, laf[..., 0, 0:1], "angles_degrees", "LAF[..., 0, 0:1]")
    return angles


def _extent(laf: Tensor, images: Tensor) -> Tensor:
    """(2, 3): the unit, in pixels, of each entry of a normalized frame."""
    check_laf(laf, "LAF")
    check_image(images, "images")
    one = torch.ones([2], dtype=laf.dtype, device=laf.device)
    width, height = larger(images.size(3) - 1, 1), larger(images.size(2) - 1, 1)
    shortest = one * smaller(width, height)
    return torch.stack([shortest, shortest, torch.stack([one[0] * width, one[1] * height])], 1)
