"""Motion blur: averages along a line in any direction."""

import math
from typing import Tuple, Union

import torch
from torch import Tensor

from ..geometry.conversions import axis_angle_to_rotation_matrix
from ..primitives.core.checks import (
    check_broadcastable,
    check_choice,
    check_floating,
    check_image,
    check_triple,
)
from ..primitives.resampling.volumes import check_volume
from .correlation import check_kernel_batch, filter2d, filter3d
from .gaussian_kernels import as_column


def get_motion_kernel2d(
    kernel_size: int,
    angle: Union[float, Tensor],
    direction: Union[float, Tensor] = 0.0,
    mode: str = "nearest",
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """Motion blur kernel: a line through the centre of a square, which sums to 1. The horizontal line is
    rotated about the centre and resampled, like OpenCV's ``warpAffine`` with ``getRotationMatrix2D``. If two
    pixels across the line are equally near, neither is used.

    Args:
        kernel_size: odd, at least 3.
        angle: of the motion in degrees, counterclockwise; a float, or a tensor (B,).
        direction: in [-1, 1], a float or a tensor (B,). 0 gives equal weights; they rise linearly towards the
            line's end for -1, and fall for 1.
        mode: "nearest" or "bilinear". Only "bilinear" has a gradient with respect to angle.
        dtype: dtype of the kernel when angle is a float.

    Returns:
        (B, kernel_size, kernel_size), with B = 1 for floats.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape, kernel_size or mode is not as above.

    Example:
        >>> get_motion_kernel2d(3, 90.0)[0]
        tensor([[0.0000, 0.3333, 0.0000],
                [0.0000, 0.3333, 0.0000],
                [0.0000, 0.3333, 0.0000]])
    """
    _check(kernel_size, mode)
    turn = as_column(angle, dtype, "angle")
    line = _line(kernel_size, direction, turn)
    turn = turn[:, :, None] * (math.pi / 180.0)
    grid = torch.arange(kernel_size, device=turn.device).to(turn.dtype) - kernel_size // 2
    x, y = grid[None, None, :], grid[None, :, None]
    c, s = torch.cos(turn), torch.sin(turn)
    along, across = c * x - s * y, s * x + c * y
    kernel = _sampled(line.to(turn.device), along, mode) * _nearness(across, mode)
    return kernel / kernel.sum([1, 2], keepdim=True)


def get_motion_kernel3d(
    kernel_size: int,
    angle: Union[Tuple[float, float, float], Tensor],
    direction: Union[float, Tensor] = 0.0,
    mode: str = "nearest",
    dtype: torch.dtype = torch.float32,
) -> Tensor:
    """Motion blur kernel: a line through the centre of a cube, which sums to 1. The line along x is rotated
    about the centre by the rotation vector ``angle`` and resampled. If two voxels across the line are equally
    near, neither is used.

    Args:
        kernel_size: odd, at least 3.
        angle: rotation about the axis (x, y, z) by the vector's length in degrees; a tuple, or a tensor (B,
            3).
        direction: in [-1, 1], a float or a tensor (B,). 0 gives equal weights; they rise linearly towards the
            line's end for -1, and fall for 1.
        mode: "nearest" or "bilinear". Only "bilinear" has a gradient with respect to angle.
        dtype: dtype of the kernel when angle is a tuple.

    Returns:
        (B, kernel_size, kernel_size, kernel_size), with B = 1 for a tuple.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape, kernel_size or mode is not as above.

    Example:
        >>> get_motion_kernel3d(3, (0.0, 0.0, 90.0))[0, 1, :, 1]
        tensor([0.3333, 0.3333, 0.3333])
    """
    _check(kernel_size, mode)
    if isinstance(angle, Tensor):
        if angle.dim() != 2 or angle.size(1) != 3:
            raise ValueError(f"angle: expected shape (B, 3), got {list(angle.shape)}")
        check_floating(angle, "angle")
        turn = angle
    else:
        check_triple(angle, "angle")
        turn = torch.tensor([[angle[0], angle[1], angle[2]]], dtype=dtype)
    line = _line(kernel_size, direction, turn)
    rotation = axis_angle_to_rotation_matrix(turn * (math.pi / 180.0))[..., None, None, None]
    grid = torch.arange(kernel_size, device=turn.device).to(turn.dtype) - kernel_size // 2
    x, y, z = grid[None, None, None, :], grid[None, None, :, None], grid[None, :, None, None]
    # The inverse of a rotation is its transpose: column i gives the coordinate i before the rotation.
    along = rotation[:, 0, 0] * x + rotation[:, 1, 0] * y + rotation[:, 2, 0] * z
    across_y = rotation[:, 0, 1] * x + rotation[:, 1, 1] * y + rotation[:, 2, 1] * z
    across_z = rotation[:, 0, 2] * x + rotation[:, 1, 2] * y + rotation[:, 2, 2] * z
    kernel = (
        _sampled(line.to(turn.device)[:, None], along, mode)
        * _nearness(across_y, mode)
        * _nearness(across_z, mode)
    )
    return kernel / kernel.sum([1, 2, 3], keepdim=True)


def motion_blur(
    input: Tensor,
    kernel_size: int,
    angle: Union[float, Tensor],
    direction: Union[float, Tensor],
    border_type: str = "reflect",
    mode: str = "nearest",
) -> Tensor:
    """Blur as if the camera had moved along a line.

    Args:
        input: (B, C, H, W), floating point.
        kernel_size: length of the line, odd, at least 3.
        angle: of the motion in degrees, counterclockwise; a float, or a tensor (B,).
        direction: in [-1, 1], a float or a tensor (B,); see ``get_motion_kernel2d``.
        border_type: "reflect" (the border pixel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        mode: how the line is resampled, "nearest" or "bilinear".

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> motion_blur(torch.eye(5)[None, None], 5, 135.0, 0.0, "constant")[0, 0, 2, 2]
        tensor(1.)
    """
    check_image(input, "input")
    kernel = get_motion_kernel2d(kernel_size, angle, direction, mode, input.dtype)
    check_kernel_batch(kernel, input, "angle, direction")
    return filter2d(input, kernel.to(input.device), border_type)


def motion_blur3d(
    input: Tensor,
    kernel_size: int,
    angle: Union[Tuple[float, float, float], Tensor],
    direction: Union[float, Tensor],
    border_type: str = "replicate",
    mode: str = "nearest",
) -> Tensor:
    """``motion_blur`` for volumes.

    Args:
        input: (B, C, D, H, W), floating point.
        kernel_size: length of the line, odd, at least 3.
        angle: rotation about the axis (x, y, z) by the vector's length in degrees; a tuple, or a tensor (B,
            3).
        direction: in [-1, 1], a float or a tensor (B,); see ``get_motion_kernel3d``.
        border_type: "reflect" (the edge voxel is not repeated), "replicate", "circular" or "constant"
            (zeros).
        mode: how the line is resampled, "nearest" or "bilinear".

    Returns:
        (B, C, D, H, W).

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> motion_blur3d(torch.ones(1, 1, 3, 4, 5), 3, (10.0, 20.0, 30.0), 0.5).shape
        torch.Size([1, 1, 3, 4, 5])
    """
    check_volume(input, "input")
    kernel = get_motion_kernel3d(kernel_size, angle, direction, mode, input.dtype)
    check_kernel_batch(kernel, input, "angle, direction")
    return filter3d(input, kernel.to(input.device), border_type)


def _check(kernel_size: int, mode: str) -> None:
    if kernel_size < 3 or kernel_size % 2 == 0:
        raise ValueError(f"kernel_size: expected an odd size of at least 3, got {kernel_size}")
    check_choice(mode, ["nearest", "bilinear"], "mode")


def _line(size: int, direction: Union[float, Tensor], angle: Tensor) -> Tensor:
    """Weights (B, 1, 1, size) that change linearly from one end to the other."""
    slope = as_column(direction, angle.dtype, "direction").to(angle.dtype)
    check_broadcastable(slope, angle, "direction", "angle", 1, 1)
    start = 0.5 * (slope.clamp(-1.0, 1.0) + 1.0)
    step = torch.arange(size, device=start.device).to(angle.dtype) / (size - 1)
    return (start + (1.0 - 2.0 * start) * step)[:, None, None]


def _sampled(line: Tensor, along: Tensor, mode: str) -> Tensor:
    """The value of the line at a signed distance from its centre; zero beyond its ends."""
    taps = torch.arange(line.size(-1), device=along.device).to(along.dtype) - line.size(-1) // 2
    distance = along[..., None] - taps
    if mode == "nearest":
        # Rotations by 30 or 60 degrees hit the exact middle between two taps, where rounding errors would
        # decide.
        near = ((distance >= -0.4999) & (distance < 0.5001)).to(along.dtype)
    else:
        near = (1.0 - distance.abs()).clamp(min=0.0)
    return (line * near).sum(-1)


def _nearness(across: Tensor, mode: str) -> Tensor:
    """The weight of a line at a distance across it."""
    if mode == "nearest":
        return (across.abs() < 0.4999).to(across.dtype)
    return (1.0 - across.abs()).clamp(min=0.0)
