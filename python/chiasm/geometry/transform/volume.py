"""Warps of volumes. Voxel centres lie at integers. Only in ``warp_affine3d``, align_corners=False stretches
positions as in Kornia; the identity still leaves a volume unchanged."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.checks import check_last, check_leading, check_one_for_each, check_size3d
from ...primitives.linalg.matrices import inverse
from ...primitives.resampling.taps import larger, smaller
from ...primitives.resampling.volumes import check_volume, check_volume_sampling, resample_volume, voxel_axes
from ...primitives.resampling.warping import (
    away_from_zero,
    check_matrices,
    from_normalized,
    normalized_axis,
    position_dtype,
)
from .matrices import check_vectors, homogeneous, numbers
from .matrices3d import get_projective_transform


def warp_affine3d(
    src: Tensor,
    M: Tensor,
    dsize: Tuple[int, int, int],
    flags: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp volumes by affine transforms: out(p) = src(M^-1 p), voxel centres at integers.

    Args:
        src: (B, C, D, H, W), floating point.
        M: (B, 3, 4), invertible, mapping src voxels (x, y, z) to output voxels.
        dsize: (depth, height, width) of the output; may come from another tensor's shape.
        flags: "bilinear" (trilinear, of eight voxels) or "nearest" (halves are rounded to the even
            neighbour).
        padding_mode: the values outside the input: "zeros", "border" (replicate) or "reflection" (about the
            corner voxels' centres, or the outer faces when align_corners is False).
        align_corners: when False, output voxel j stands for (j + 1/2) (w - 1) / w of M's coordinates, and x
            of them is read at x W / (W - 1) - 1/2, along each axis: M counts between the outer faces, size -
            1 units apart. An axis of one voxel counts from its centre, as with True.

    Returns:
        (B, C, depth, height, width). Differentiable in src and M ("nearest": in src).

    Raises:
        TypeError: if src or M is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> deeper = torch.tensor([[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]]])
        >>> warp_affine3d(torch.arange(3.0).reshape(1, 1, 3, 1, 1), deeper, (3, 1, 1)).flatten()
        tensor([0., 0., 1.])
    """
    check_volume(src, "src")
    check_matrices(M, 3, 4, "M")
    check_one_for_each(M, src, "M", "src")
    check_volume_sampling(flags, padding_mode, "flags")
    check_size3d(dsize, "dsize")
    return _warped(src, homogeneous(M.to(torch.float64)), dsize, flags, padding_mode, align_corners, True)


def _warped(
    src: Tensor,
    matrix: Tensor,
    dsize: Tuple[int, int, int],
    mode: str,
    padding_mode: str,
    align_corners: bool,
    affine: bool,
) -> Tensor:
    """Warp by (B, 4, 4) in float64; with ``affine`` and without align_corners, positions are those of
    ``warp_affine3d``."""
    precision = position_dtype(src.dtype)
    m = inverse(matrix).to(precision)
    column, row, plane = voxel_axes(dsize, precision, src.device)
    stretch = affine and not align_corners
    if stretch:
        column, row, plane = _shrunk(column, dsize[2]), _shrunk(row, dsize[1]), _shrunk(plane, dsize[0])
    x, y, z = _mapped(column, row, plane, m)
    if stretch:
        x, y, z = _stretched(x, src.size(4)), _stretched(y, src.size(3)), _stretched(z, src.size(2))
    return resample_volume(src, x, y, z, mode, padding_mode, align_corners)


def _shrunk(x: Tensor, size: int) -> Tensor:
    """(x + 1/2) (size - 1) / size: positions between outer faces that are size - 1 apart. For a single voxel
    x, because a volume of one slice is turned and mirrored about its centre."""
    return (2.0 * x + smaller(size - 1, 1)) * larger(size - 1, 1) / (2 * size)


def _stretched(x: Tensor, size: int) -> Tensor:
    """The inverse of ``_shrunk``."""
    return (x * (2 * size) / larger(size - 1, 1) - smaller(size - 1, 1)) * 0.5


def _mapped(x: Tensor, y: Tensor, z: Tensor, matrix: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    m = matrix[:, :, :, None, None, None]
    depth = away_from_zero(m[:, 3, 0] * x + m[:, 3, 1] * y + m[:, 3, 2] * z + m[:, 3, 3])
    mapped_x = (m[:, 0, 0] * x + m[:, 0, 1] * y + m[:, 0, 2] * z + m[:, 0, 3]) / depth
    mapped_y = (m[:, 1, 0] * x + m[:, 1, 1] * y + m[:, 1, 2] * z + m[:, 1, 3]) / depth
    return mapped_x, mapped_y, (m[:, 2, 0] * x + m[:, 2, 1] * y + m[:, 2, 2] * z + m[:, 2, 3]) / depth


def affine3d(
    tensor: Tensor,
    matrix: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """``warp_affine3d`` with an output of the volume's size.

    Args:
        tensor: (B, C, D, H, W), floating point.
        matrix: (B, 3, 4), invertible, mapping source voxels (x, y, z) to output voxels.
        mode, padding_mode, align_corners: as ``flags``, ``padding_mode`` and ``align_corners`` in
            :func:`warp_affine3d`.

    Returns:
        (B, C, D, H, W). Differentiable in tensor and matrix.

    Raises:
        TypeError: if tensor or matrix is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> affine3d(torch.ones(1, 1, 2, 3, 4), torch.eye(4)[None, :3]).sum()
        tensor(24.)
    """
    check_volume(tensor, "tensor")
    check_matrices(matrix, 3, 4, "matrix")
    check_one_for_each(matrix, tensor, "matrix", "tensor")
    check_volume_sampling(mode, padding_mode)
    size = (tensor.size(2), tensor.size(3), tensor.size(4))
    return warp_affine3d(tensor, matrix, size, mode, padding_mode, align_corners)


def rotate3d(
    tensor: Tensor,
    yaw: Tensor,
    pitch: Tensor,
    roll: Tensor,
    center: Optional[Tensor] = None,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """Rotate volumes by rotation vectors (yaw, pitch, roll).

    Args:
        tensor: (B, C, D, H, W), floating point.
        yaw, pitch, roll: (B,), or (1,) or a scalar for all: components along x, y and z in degrees. They form
            one rotation vector (axis times angle) as in Kornia, not three successive rotations.
        center: (B, 3), x, y and z in voxels; the centre of the volume by default.
        mode, padding_mode, align_corners: as in :func:`affine3d`.

    Returns:
        (B, C, D, H, W). Differentiable in tensor, the angles and center.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> turn, zero = torch.tensor([180.0]), torch.zeros(1)
        >>> rotate3d(torch.arange(4.0).reshape(1, 1, 1, 2, 2), zero, zero, turn, align_corners=True)[
        ...     0, 0, 0
        ... ].round()
        tensor([[3., 2.],
                [1., 0.]])
    """
    check_volume(tensor, "tensor")
    yaw, pitch, roll = numbers(yaw, "yaw"), numbers(pitch, "pitch"), numbers(roll, "roll")
    check_one_for_each(yaw, tensor, "yaw", "tensor")
    check_one_for_each(pitch, tensor, "pitch", "tensor")
    check_one_for_each(roll, tensor, "roll", "tensor")
    yaw, pitch, roll = torch.broadcast_tensors(yaw, pitch, roll)
    angles = torch.stack([yaw, pitch, roll], -1).to(torch.float64)
    if center is None:
        one = torch.ones_like(angles[:, 0])
        sides = [
            one * (tensor.size(4) - 1) * 0.5,
            one * (tensor.size(3) - 1) * 0.5,
            one * (tensor.size(2) - 1) * 0.5,
        ]
        middle = torch.stack(sides, -1)
    else:
        check_vectors(center, 3, "center")
        check_one_for_each(center, tensor, "center", "tensor")
        middle = center.to(torch.float64)
    matrix = get_projective_transform(middle, angles, torch.ones_like(angles))
    return affine3d(tensor, matrix, mode, padding_mode, align_corners)


def warp_perspective3d(
    src: Tensor,
    M: Tensor,
    dsize: Tuple[int, int, int],
    flags: str = "bilinear",
    border_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """Warp volumes by 3D homographies: out(p) = src(M^-1 p), voxel centres at integers.

    Args:
        src: (B, C, D, H, W), floating point.
        M: (B, 4, 4), invertible, mapping src voxels (x, y, z) to output voxels.
        dsize: (depth, height, width) of the output; may come from another tensor's shape.
        flags: "bilinear" (trilinear, of eight voxels) or "nearest" (halves are rounded to the even
            neighbour).
        border_mode: the values outside the input: "zeros", "border" or "reflection", as in
            :func:`warp_affine3d`.
        align_corners: where "reflection" mirrors: at the corner voxels' centres, or at the outer faces. (As
            :func:`warp_perspective`; without it Kornia's moves an image that the identity should leave.)

    Returns:
        (B, C, depth, height, width). Differentiable in src and M ("nearest": in src).

    Raises:
        TypeError: if src or M is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(8.0).reshape(1, 1, 2, 2, 2)
        >>> torch.equal(warp_perspective3d(x, torch.eye(4)[None], (2, 2, 2), align_corners=True), x)
        True
    """
    check_volume(src, "src")
    check_matrices(M, 4, 4, "M")
    check_one_for_each(M, src, "M", "src")
    check_volume_sampling(flags, border_mode, "flags", "border_mode")
    check_size3d(dsize, "dsize")
    return _warped(src, M.to(torch.float64), dsize, flags, border_mode, align_corners, False)


def warp_grid3d(grid: Tensor, src_homo_dst: Tensor) -> Tensor:
    """Transform a grid of 3D points by homographies.

    Args:
        grid: (B or 1, D, H, W, 3), points (x, y, z).
        src_homo_dst: (B, 4, 4).

    Returns:
        (B, D, H, W, 3). Differentiable in both.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> warp_grid3d(torch.ones(1, 1, 1, 1, 3), torch.diag(torch.tensor([3.0, 2.0, 1.0, 0.5]))[None])
        tensor([[[[[6., 4., 2.]]]]])
    """
    check_last(grid, 3, "grid")
    if grid.dim() != 5:
        raise ValueError(f"grid: expected shape (B, D, H, W, 3), got {list(grid.shape)}")
    check_matrices(src_homo_dst, 4, 4, "src_homo_dst")
    check_leading([grid, src_homo_dst], ["grid", "src_homo_dst"], [4, 2])
    x, y, z = _mapped(grid[..., 0], grid[..., 1], grid[..., 2], src_homo_dst)
    return torch.stack([x, y, z], -1)


def homography_warp3d(
    patch_src: Tensor,
    src_homo_dst: Tensor,
    dsize: Tuple[int, int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
    normalized_coordinates: bool = True,
) -> Tensor:
    """Warp volumes by homographies from the output to the volume: out(p) = patch_src(src_homo_dst p).

    Args:
        patch_src: (B, C, D, H, W), floating point.
        src_homo_dst: (B, 4, 4), between coordinates in [-1, 1].
        dsize: (depth, height, width) of the output; may come from another tensor's shape.
        mode, padding_mode: as ``flags`` and ``padding_mode`` in :func:`warp_affine3d`.
        align_corners: coordinates -1 and 1, of patch_src and of the output, are the corner voxels' centres,
            or the outer faces when False. (Of the output Kornia takes the centres in either case, so that the
            identity moves the image.)
        normalized_coordinates: when False, src_homo_dst maps output voxels to voxels of patch_src.

    Returns:
        (B, C, depth, height, width). Differentiable in patch_src and src_homo_dst ("nearest": in patch_src).

    Raises:
        TypeError: if patch_src or src_homo_dst is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> mirror = torch.diag(torch.tensor([-1.0, 1.0, 1.0, 1.0]))[None]
        >>> homography_warp3d(torch.arange(3.0).expand(1, 1, 2, 2, 3), mirror, (2, 2, 3), align_corners=True)[
        ...     0, 0, 0, 0
        ... ]
        tensor([2., 1., 0.])
    """
    check_volume(patch_src, "patch_src")
    check_matrices(src_homo_dst, 4, 4, "src_homo_dst")
    check_one_for_each(src_homo_dst, patch_src, "src_homo_dst", "patch_src")
    check_volume_sampling(mode, padding_mode)
    check_size3d(dsize, "dsize")
    precision = position_dtype(patch_src.dtype)
    m = src_homo_dst.to(precision)
    if normalized_coordinates:
        column = normalized_axis(dsize[2], align_corners, precision, patch_src.device)[None, None, None, :]
        row = normalized_axis(dsize[1], align_corners, precision, patch_src.device)[None, None, :, None]
        plane = normalized_axis(dsize[0], align_corners, precision, patch_src.device)[None, :, None, None]
        x, y, z = _mapped(column, row, plane, m)
        x, y = (
            from_normalized(x, patch_src.size(4), align_corners),
            from_normalized(y, patch_src.size(3), align_corners),
        )
        z = from_normalized(z, patch_src.size(2), align_corners)
    else:
        column, row, plane = voxel_axes(dsize, precision, patch_src.device)
        x, y, z = _mapped(column, row, plane, m)
    return resample_volume(patch_src, x, y, z, mode, padding_mode, align_corners)


def crop_by_transform_mat3d(
    tensor: Tensor,
    transform: Tensor,
    out_size: Tuple[int, int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp volumes by 3D homographies: out(p) = tensor(transform^-1 p).

    Kornia ignores the last row of the transform; for affine transforms the result is the same.

    Args:
        tensor: (B, C, D, H, W), floating point.
        transform: (B, 4, 4), or (1, 4, 4) for all volumes, from tensor's voxels to the output's.
        out_size: (depth, height, width) of the output; may come from another tensor's shape.
        mode, padding_mode, align_corners: as ``flags``, ``padding_mode`` and ``align_corners`` in
            :func:`warp_affine3d`.

    Returns:
        (B, C, depth, height, width). Differentiable in tensor and transform.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> nearer = torch.eye(4)[None].clone()
        >>> nearer[0, 2, 3] = -1.0
        >>> crop_by_transform_mat3d(torch.arange(3.0).reshape(1, 1, 3, 1, 1), nearer, (2, 1, 1)).flatten()
        tensor([1., 2.])
    """
    check_volume(tensor, "tensor")
    check_matrices(transform, 4, 4, "transform")
    check_one_for_each(transform, tensor, "transform", "tensor")
    check_volume_sampling(mode, padding_mode)
    check_size3d(out_size, "out_size")
    matrix = transform.expand(tensor.size(0), 4, 4).to(torch.float64)
    return _warped(tensor, matrix, out_size, mode, padding_mode, align_corners, True)
