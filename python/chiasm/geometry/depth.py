# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
"""Depth maps: conversion to points and normals, and warps of images by depth."""

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..filters.gradient import spatial_gradient
from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_image,
    check_last,
    check_leading,
    check_matrix,
    check_number,
    check_one_channel,
    check_one_for_each,
    check_rank,
)
from ..primitives.core.modules import Module
from ..primitives.geometry.intrinsics import check_intrinsics, from_pixels, with_one
from ..primitives.linalg.matrices import cross
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.resampling.warping import check_sampling, position_dtype, resample_image, stretched
from .camera.pinhole import PinholeCamera

__all__ = [
    "DepthWarper",
    "depth_from_disparity",
    "depth_from_plane_equation",
    "depth_to_3d",
    "depth_to_3d_v2",
    "depth_to_normals",
    "depth_warp",
    "unproject_meshgrid",
    "warp_frame_depth",
]


def __dir__() -> list[str]:
    return __all__


def depth_from_disparity(
    disparity: Tensor, baseline: Union[float, Tensor], focal: Union[float, Tensor]
) -> Tensor:
    """Depth from a stereo pair's disparity: baseline * focal / (disparity + 1e-8).

    Args:
        disparity: any shape, in pixels, floating point.
        baseline: distance between the cameras, in the unit wanted for depth; a number, or a tensor that
            broadcasts with disparity.
        focal: focal length in pixels; a number, or a tensor that broadcasts with disparity.

    Returns:
        Depth, in disparity's shape. Differentiable.

    Raises:
        TypeError: if disparity is not floating point.
        ValueError: if the shape of baseline or focal is not as above.

    Example:
        >>> depth_from_disparity(torch.tensor([10.0, 20.0]), 0.5, 400.0)
        tensor([20., 10.])
    """
    check_floating(disparity, "disparity")
    # Two branches for each, because TorchScript narrows a union only by isinstance.
    if isinstance(baseline, Tensor):
        check_broadcastable(baseline, disparity, "baseline", "disparity")
        inverse = baseline / (disparity + 1e-8)
    else:
        check_number(baseline, "baseline")
        inverse = baseline / (disparity + 1e-8)
    if isinstance(focal, Tensor):
        check_broadcastable(focal, inverse, "focal", "disparity")
        return inverse * focal
    else:
        check_number(focal, "focal")
        return inverse * focal


def depth_from_plane_equation(
    plane_normals: Tensor, plane_offsets: Tensor, points_uv: Tensor, camera_matrix: Tensor, eps: float = 1e-8
) -> Tensor:
    """Depths of the points where the rays through pixels intersect the plane n . X = d.

    Args:
        plane_normals: (B, 3), n in the camera's frame, floating point.
        plane_offsets: (B, 1), d.
        points_uv: (B, N, 2), pixels.
        camera_matrix: (B, 3, 3).
        eps: the least absolute value of the divisor n . ray, whose sign is kept; it is small for rays that
            are nearly parallel to the plane.

    Returns:
        (B, N). Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> normal, offset = torch.tensor([[0.0, 0.0, 1.0]]), torch.tensor([[5.0]])
        >>> depth_from_plane_equation(normal, offset, torch.tensor([[[3.0, 4.0]]]), torch.eye(3)[None])
        tensor([[5.]])
    """
    check_rank(plane_normals, 2, "(B, 3)", "plane_normals")
    check_last(plane_normals, 3, "plane_normals")
    check_rank(plane_offsets, 2, "(B, 1)", "plane_offsets")
    check_last(plane_offsets, 1, "plane_offsets")
    check_last(points_uv, 2, "points_uv")
    check_rank(points_uv, 3, "(B, N, 2)", "points_uv")
    check_rank(camera_matrix, 3, "(B, 3, 3)", "camera_matrix")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    check_leading(
        [plane_normals, plane_offsets, points_uv, camera_matrix],
        ["plane_normals", "plane_offsets", "points_uv", "camera_matrix"],
        [1, 1, 2, 2],
    )
    ray = with_one(from_pixels(points_uv, camera_matrix[:, None]))
    slope = (ray * plane_normals[:, None]).sum(-1)
    least = torch.where(slope < 0, torch.full_like(slope, -eps), torch.full_like(slope, eps))
    return plane_offsets / torch.where(slope.abs() < eps, least, slope)


def depth_to_3d(depth: Tensor, camera_matrix: Tensor, normalize_points: bool = False) -> Tensor:
    """Convert a depth map to points in the camera's frame, as an image of three channels.

    Args:
        depth: (B, 1, H, W), z of the points; their distances from the camera with ``normalize_points``.
            Floating point.
        camera_matrix: (B, 3, 3).
        normalize_points: scale the rays to unit length first.

    Returns:
        (B, 3, H, W). Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> depth_to_3d(torch.full((1, 1, 2, 2), 3.0), torch.eye(3)[None])[0, :, 1, 0]
        tensor([0., 3., 3.])
    """
    check_one_channel(depth, "depth")
    check_rank(camera_matrix, 3, "(B, 3, 3)", "camera_matrix")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    check_leading([depth, camera_matrix], ["depth", "camera_matrix"], [3, 2])
    z = depth[:, 0]
    x, y, one = _rays(camera_matrix, z.size(-2), z.size(-1), normalize_points)
    return torch.stack([x * z, y * z, one * z], 1)


def depth_to_3d_v2(
    depth: Tensor, camera_matrix: Tensor, normalize_points: bool = False, xyz_grid: Optional[Tensor] = None
) -> Tensor:
    """Convert a depth map to points in the camera's frame, with the coordinates in the last dimension.

    Args:
        depth: (*, H, W), z of the points; their distances from the camera with ``normalize_points``. Floating
            point.
        camera_matrix: (*, 3, 3).
        normalize_points: scale the rays to unit length first.
        xyz_grid: (*, H, W, 3), the rays, from :func:`unproject_meshgrid`, to save computing them.

    Returns:
        (*, H, W, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> depth_to_3d_v2(torch.full((2, 2), 3.0), torch.eye(3))[1, 0]
        tensor([0., 3., 3.])
    """
    check_floating(depth, "depth")
    if depth.dim() < 2:
        raise ValueError(f"depth: expected shape (*, H, W), got {list(depth.shape)}")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    if xyz_grid is not None:
        check_last(xyz_grid, 3, "xyz_grid")
        check_broadcastable(xyz_grid, depth, "xyz_grid", "depth", 1, 0)
        return xyz_grid * depth[..., None]
    check_leading([depth, camera_matrix], ["depth", "camera_matrix"], [2, 2])
    x, y, one = _rays(camera_matrix, depth.size(-2), depth.size(-1), normalize_points)
    return torch.stack([x * depth, y * depth, one * depth], -1)


def unproject_meshgrid(
    height: int, width: int, camera_matrix: Tensor, normalize_points: bool = False
) -> Tensor:
    """Rays through the pixels of an image: points of the plane z = 1. The result has the dtype and the device
    of camera_matrix; Kornia has arguments for both.

    Args:
        height, width: size of the image.
        camera_matrix: (*, 3, 3), floating point.
        normalize_points: scale the rays to unit length.

    Returns:
        (*, height, width, 3).

    Raises:
        TypeError, ValueError: if camera_matrix is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> unproject_meshgrid(2, 2, torch.eye(3))[1, 0]
        tensor([0., 1., 1.])
    """
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    return torch.stack(_rays(camera_matrix, height, width, normalize_points), -1)


def depth_to_normals(depth: Tensor, camera_matrix: Tensor, normalize_points: bool = False) -> Tensor:
    """Unit normals of the surface in a depth map. A normal is the direction of dX/du x dX/dv, with Sobel
    derivatives of the points. Normals point away from the camera: a wall in front of the camera has the
    normal (0, 0, 1).

    Args:
        depth: (B, 1, H, W), floating point.
        camera_matrix: (B, 3, 3).
        normalize_points: depth is the distance from the camera instead of z.

    Returns:
        (B, 3, H, W); zero where the derivatives span no plane. Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> depth_to_normals(torch.ones(1, 1, 3, 3), torch.eye(3)[None])[0, :, 1, 1]
        tensor([0., 0., 1.])
    """
    check_floating(depth, "depth")
    check_floating(camera_matrix, "camera_matrix")
    gradient = spatial_gradient(depth_to_3d(widened(depth), widened(camera_matrix), normalize_points))
    du, dv = gradient[:, :, 0].movedim(1, -1), gradient[:, :, 1].movedim(1, -1)
    normal = cross(du, dv).movedim(-1, 1)
    squared = (normal * normal).sum(1, keepdim=True)
    tiny = squared < 1e-36
    unit = normal / torch.sqrt(torch.where(tiny, torch.ones_like(squared), squared))
    return narrowed(torch.where(tiny, torch.zeros_like(unit), unit), depth, camera_matrix)


def depth_warp(
    intrinsics_dst: Tensor,
    extrinsics_dst: Tensor,
    intrinsics_src: Tensor,
    extrinsics_src: Tensor,
    depth_src: Tensor,
    patch_dst: Tensor,
    align_corners: bool = True,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
) -> Tensor:
    """Warp the image of a destination camera into the view of a source camera with a depth map. Each source
    pixel is unprojected by its depth, projected into the destination camera, and read there. Kornia takes
    camera objects and the size of depth_src instead of matrices. Each of the B entries is a pair of views.
    For B views with one source, the tensors of the source may have a batch of 1.

    Args:
        intrinsics_dst, intrinsics_src: (B, 3, 3) or (B, 4, 4), camera matrices in pixels, floating point.
        extrinsics_dst, extrinsics_src: (B, 4, 4), rotations and translations from the world to the cameras'
            frames.
        depth_src: (B, 1, H, W), z in the source camera's frame.
        patch_dst: (B, C, H2, W2).
        align_corners, mode, padding_mode: as in :func:`chiasm.geometry.transform.warp_perspective`.

    Returns:
        (B, C, H, W); zero for points behind the destination camera. Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> K, E = torch.eye(3)[None], torch.eye(4)[None]
        >>> patch = torch.arange(4.0).reshape(1, 1, 2, 2)
        >>> depth_warp(K, E, K, E, torch.ones(1, 1, 2, 2), patch).equal(patch)
        True
    """
    check_intrinsics(intrinsics_dst, "intrinsics_dst")
    check_intrinsics(intrinsics_src, "intrinsics_src")
    check_matrix(extrinsics_dst, 4, 4, "extrinsics_dst")
    check_matrix(extrinsics_src, 4, 4, "extrinsics_src")
    check_one_channel(depth_src, "depth_src")
    check_image(patch_dst, "patch_dst")
    check_sampling(mode, padding_mode)
    _check_matrices(
        [intrinsics_dst, extrinsics_dst, intrinsics_src, extrinsics_src],
        ["intrinsics_dst", "extrinsics_dst", "intrinsics_src", "extrinsics_src"],
        patch_dst,
        "patch_dst",
    )
    check_one_for_each(depth_src, patch_dst, "depth_src", "patch_dst")
    # dst <- world <- src, with R^T in place of the inverse of a rotation.
    dst, src = widened(extrinsics_dst), widened(extrinsics_src)
    rotation_src = src[:, None, 0:3, 0:3]
    rotation = (dst[:, 0:3, None, 0:3] * rotation_src).sum(-1)
    shift = dst[:, 0:3, 3] - (rotation * src[:, None, 0:3, 3]).sum(-1)
    motion = torch.cat([rotation, shift[..., None]], -1)
    return _read_through_depth(
        patch_dst, depth_src, motion, intrinsics_src, intrinsics_dst, False, align_corners, mode, padding_mode
    )


class DepthWarper(Module):
    """``depth_warp`` as a module with fixed cameras: it warps images of B destination cameras into one view.

    E. Riba et al., Kornia: an Open Source Differentiable Computer Vision Library for PyTorch, WACV 2020.

    Args:
        pinhole_dst: B destination cameras, whose images are read.
        height, width: the size of the source's depth maps.
        mode, padding_mode, align_corners: as in :func:`depth_warp`.

    Shape:
        After ``compute_projection_matrix(pinhole_src)`` with B cameras or one: depth_src (B, 1, height,
        width), or (1, 1, height, width) for one, and patch_dst (B, C, H2, W2), both floating point, to (B, C,
        height, width).

    Raises:
        TypeError, ValueError: as :func:`depth_warp`.
        ValueError: if no source camera was given or depth_src has another size.

    Example:
        >>> left = PinholeCamera.from_parameters(10.0, 10.0, 1.5, 0.5, 2, 4)
        >>> right = PinholeCamera.from_parameters(10.0, 10.0, 1.5, 0.5, 2, 4, tx=-0.1)
        >>> warper = DepthWarper(right, 2, 4).compute_projection_matrix(left)
        >>> warper(torch.ones(1, 1, 2, 4), torch.arange(4.0).expand(1, 1, 2, 4))[0, 0, 0]
        tensor([0., 0., 1., 2.])
    """

    def __init__(
        self,
        pinhole_dst: PinholeCamera,
        height: int,
        width: int,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None:
        super().__init__()
        check_sampling(mode, padding_mode)
        self.pinhole_dst, self.pinhole_src = pinhole_dst, None
        self.height, self.width, self.mode, self.padding_mode, self.align_corners = (
            height,
            width,
            mode,
            padding_mode,
            align_corners,
        )

    def compute_projection_matrix(self, pinhole_src: PinholeCamera) -> "DepthWarper":
        """Set the source camera; call this before the module is scripted. (The name is Kornia's.)"""
        self.pinhole_src = pinhole_src
        return self

    def compute_subpixel_step(self) -> Tensor:
        """The step in inverse depth, a scalar, that moves the middle pixel of the source by half a pixel
        in the destination, at a depth of 1: the step of planes of a cost volume. The least of all cameras.

        R. Szeliski, D. Scharstein, Symmetric sub-pixel stereo matching, ECCV 2002.

        Raises:
            ValueError: if no source camera was given.
        """
        if self.pinhole_src is None:
            raise ValueError("pinhole_src: expected a camera, given to compute_projection_matrix, got None")
        dst, src = self.pinhole_dst, self.pinhole_src
        change, half = 0.01, torch.tensor([self.width / 2.0, self.height / 2.0, 1.0]).to(src.intrinsics)
        ray = torch.linalg.solve(src.camera_matrix, half.expand(src.batch_size, -1))
        moved = dst.extrinsics.matmul(torch.linalg.inv(src.extrinsics))
        seen = []
        for inverse_depth in (1.0 - change, 1.0 + change):
            point = moved[:, :3, :3].matmul(ray[..., None]) + inverse_depth * moved[:, :3, 3:]
            image = dst.camera_matrix.matmul(point)[..., 0]
            seen.append(image[:, :2] / image[:, 2:])
        return (change / torch.linalg.vector_norm(seen[1] - seen[0], dim=-1)).min()

    def forward(self, depth_src: Tensor, patch_dst: Tensor) -> Tensor:
        if self.pinhole_src is None:
            raise ValueError("pinhole_src: expected a camera, given to compute_projection_matrix, got None")
        if depth_src.size(-2) != self.height or depth_src.size(-1) != self.width:
            raise ValueError(
                f"depth_src: expected shape (B, 1, {self.height}, {self.width}), got {list(depth_src.shape)}"
            )
        dst, src = self.pinhole_dst, self.pinhole_src
        return depth_warp(
            dst.intrinsics,
            dst.extrinsics,
            src.intrinsics,
            src.extrinsics,
            depth_src,
            patch_dst,
            self.align_corners,
            self.mode,
            self.padding_mode,
        )


def warp_frame_depth(
    image_src: Tensor,
    depth_dst: Tensor,
    src_trans_dst: Tensor,
    camera_matrix: Tensor,
    normalize_points: bool = False,
) -> Tensor:
    """Warp the image of a source camera into the view of a destination camera with a depth map. Both cameras
    have the same camera matrix.

    Args:
        image_src: (B, C, H, W), floating point.
        depth_dst: (B, 1, H2, W2), z in the destination camera's frame.
        src_trans_dst: (B, 4, 4), from the destination camera's frame to the source's.
        camera_matrix: (B, 3, 3).
        normalize_points: depth is the distance from the camera instead of z.

    Returns:
        (B, C, H2, W2); zero outside image_src and for points behind the source camera. Differentiable in all
        tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> image = torch.arange(4.0).reshape(1, 1, 2, 2)
        >>> warp_frame_depth(image, torch.ones(1, 1, 2, 2), torch.eye(4)[None], torch.eye(3)[None]).equal(
        ...     image
        ... )
        True
    """
    check_image(image_src, "image_src")
    check_one_channel(depth_dst, "depth_dst")
    check_matrix(src_trans_dst, 4, 4, "src_trans_dst")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    check_one_for_each(depth_dst, image_src, "depth_dst", "image_src")
    _check_matrices(
        [src_trans_dst, camera_matrix], ["src_trans_dst", "camera_matrix"], image_src, "image_src"
    )
    return _read_through_depth(
        image_src,
        depth_dst,
        src_trans_dst,
        camera_matrix,
        camera_matrix,
        normalize_points,
        True,
        "bilinear",
        "zeros",
    )


def _check_matrices(matrices: List[Tensor], names: List[str], image: Tensor, image_name: str) -> None:
    """Raise unless each of ``matrices`` has one batch dimension, of ``image``'s size or of 1."""
    for i in range(len(matrices)):
        check_rank(matrices[i], 3, "(B, rows, columns)", names[i])
        check_one_for_each(matrices[i], image, names[i], image_name)


def _rays(camera_matrix: Tensor, height: int, width: int, unit: bool) -> Tuple[Tensor, Tensor, Tensor]:
    """x, y and z (*, height, width) of the rays through the pixels, with z = 1 or of unit length."""
    column = torch.arange(width, device=camera_matrix.device).to(camera_matrix.dtype)
    row = torch.arange(height, device=camera_matrix.device).to(camera_matrix.dtype)[:, None]
    m = camera_matrix[..., None, None]
    x = (column - m[..., 0, 2, :, :]) / m[..., 0, 0, :, :] + torch.zeros_like(row)
    y = (row - m[..., 1, 2, :, :]) / m[..., 1, 1, :, :] + torch.zeros_like(column)
    one = torch.ones_like(x)
    if unit:
        one = 1.0 / torch.sqrt(x * x + y * y + 1.0)
    return x * one, y * one, one


def _read_through_depth(
    image: Tensor,
    depth: Tensor,
    motion: Tensor,
    own: Tensor,
    other: Tensor,
    unit: bool,
    align_corners: bool,
    mode: str,
    padding_mode: str,
) -> Tensor:
    """Read image (B, C, H, W) of the camera ``other`` at the points of a depth map of the camera ``own``,
    which are transformed by (B, 3 or 4, 4)."""
    precision = position_dtype(image.dtype)
    for each in [depth, motion, own, other]:
        precision = torch.promote_types(precision, each.dtype)
    z = depth[:, 0].to(precision)
    x, y, one = _rays(own.to(precision), z.size(-2), z.size(-1), unit)
    x, y, z = x * z, y * z, one * z
    m, k = motion.to(precision)[..., None, None], other.to(precision)[..., None, None]
    z2 = m[:, 2, 0] * x + m[:, 2, 1] * y + m[:, 2, 2] * z + m[:, 2, 3]
    in_front = z2 > 1e-8
    safe = torch.where(in_front, z2, torch.ones_like(z2))
    u = (m[:, 0, 0] * x + m[:, 0, 1] * y + m[:, 0, 2] * z + m[:, 0, 3]) / safe * k[:, 0, 0] + k[:, 0, 2]
    v = (m[:, 1, 0] * x + m[:, 1, 1] * y + m[:, 1, 2] * z + m[:, 1, 3]) / safe * k[:, 1, 1] + k[:, 1, 2]
    if not align_corners:
        u, v = stretched(u, image.size(3)), stretched(v, image.size(2))
    u, v = u.to(position_dtype(image.dtype)), v.to(position_dtype(image.dtype))
    if padding_mode != "zeros":
        out = resample_image(
            image, torch.where(in_front, u, torch.zeros_like(u)), v, mode, padding_mode, align_corners, None
        )
        return torch.where(in_front[:, None], out, torch.zeros_like(out))
    # A position outside, where all taps have weight zero.
    u = torch.where(in_front, u, torch.full_like(u, -4.0))
    return resample_image(image, u, v, mode, padding_mode, align_corners, None)
