# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
"""Conversions between 3D points and pixels of a pinhole camera."""

from typing import Optional

import torch
from torch import Tensor

from ...primitives.core.checks import (
    check_broadcastable,
    check_last,
    check_leading,
    check_matrix,
    check_one_channel,
    check_rank,
)
from ...primitives.core.modules import Module, hold
from ...primitives.geometry.intrinsics import (
    check_intrinsics,
    from_pixels,
    moved,
    over_depth,
    to_pixels,
    with_one,
)
from ...primitives.linalg.matrices import inverse
from ...primitives.numbers.loss_reduction import narrowed, widened
from ..epipolar.projection import scale_intrinsics
from ..linalg import inverse_transformation, transform_points


def project_points(point_3d: Tensor, camera_matrix: Tensor) -> Tensor:
    """Project points in a camera's frame to pixels: (fx x / z + cx, fy y / z + cy).

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 6.1. As in OpenCV and Kornia, only the focal
    lengths and the principal point of the camera matrix are used.

    Args:
        point_3d: (*, 3), floating point. A depth below 1e-8 counts as 1e-8, with its sign.
        camera_matrix: (*, 3, 3), with leading dimensions that are the same or broadcast.

    Returns:
        (*, 2). Differentiable in both.

    Raises:
        TypeError, ValueError: if point_3d is not a floating-point (*, 3), or camera_matrix not a
            floating-point (*, 3, 3) tensor.

    Example:
        >>> project_points(torch.tensor([2.0, 4.0, 2.0]), torch.eye(3))
        tensor([1., 2.])
    """
    check_last(point_3d, 3, "point_3d")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    check_broadcastable(camera_matrix, point_3d, "camera_matrix", "point_3d", 2, 1)
    pixels = to_pixels(over_depth(widened(point_3d), 1e-8), widened(camera_matrix))
    return narrowed(pixels, point_3d, camera_matrix)


def unproject_points(
    point_2d: Tensor, depth: Tensor, camera_matrix: Tensor, normalize: bool = False
) -> Tensor:
    """Points in a camera's frame from pixels and depths; the inverse of :func:`project_points`.

    Args:
        point_2d: (*, 2) pixels, floating point.
        depth: (*, 1), z of the points; their distances from the camera with ``normalize``.
        camera_matrix: (*, 3, 3).
        normalize: scale the rays to unit length first.

    Returns:
        (*, 3). Differentiable in all tensors.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its last dimensions are not as above.

    Example:
        >>> unproject_points(torch.tensor([1.0, 2.0]), torch.tensor([3.0]), torch.eye(3))
        tensor([3., 6., 3.])
    """
    check_last(point_2d, 2, "point_2d")
    check_last(depth, 1, "depth")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    check_broadcastable(depth, point_2d, "depth", "point_2d", 1, 1)
    check_broadcastable(camera_matrix, point_2d, "camera_matrix", "point_2d", 2, 1)
    check_broadcastable(camera_matrix, depth, "camera_matrix", "depth", 2, 1)
    ray = with_one(from_pixels(point_2d, camera_matrix))
    if normalize:
        ray = ray / (ray * ray).sum(-1, keepdim=True).sqrt()
    return ray * depth


def cam2pixel(cam_coords_src: Tensor, dst_proj_src: Tensor, eps: float = 1e-12) -> Tensor:
    """Project points of one camera's frame to pixels of another camera.

    Args:
        cam_coords_src: (B, H, W, 3), points in the source camera's frame, floating point.
        dst_proj_src: (B, 4, 4), from the source camera's frame to destination pixels times depth; the last
            row is (0, 0, 0, 1).
        eps: added to the depth before dividing by it.

    Returns:
        (B, H, W, 2), x and y. Differentiable in both.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> cam2pixel(torch.tensor([2.0, 4.0, 2.0]).reshape(1, 1, 1, 3), torch.eye(4)[None])
        tensor([[[[1., 2.]]]])
    """
    check_rank(cam_coords_src, 4, "(B, H, W, 3)", "cam_coords_src")
    check_last(cam_coords_src, 3, "cam_coords_src")
    check_rank(dst_proj_src, 3, "(B, 4, 4)", "dst_proj_src")
    check_matrix(dst_proj_src, 4, 4, "dst_proj_src")
    check_leading([cam_coords_src, dst_proj_src], ["cam_coords_src", "dst_proj_src"], [3, 2])
    seen = moved(dst_proj_src[:, None, None], cam_coords_src)
    return seen[..., 0:2] / (seen[..., 2:3] + eps)


def pixel2cam(depth: Tensor, intrinsics_inv: Tensor, pixel_coords: Tensor) -> Tensor:
    """Points in a camera's frame from pixels and depths.

    Args:
        depth: (B, 1, H, W), floating point.
        intrinsics_inv: (B, 4, 4), the inverse of the camera matrix; the last row is (0, 0, 0, 1).
        pixel_coords: (B, H, W, 3), homogeneous: (x, y, 1). B may be 1.

    Returns:
        (B, H, W, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> pixel2cam(
        ...     torch.full((1, 1, 1, 1), 2.0),
        ...     torch.eye(4)[None],
        ...     torch.tensor([3.0, 4.0, 1.0]).reshape(1, 1, 1, 3),
        ... )
        tensor([[[[6., 8., 2.]]]])
    """
    check_one_channel(depth, "depth")
    check_rank(intrinsics_inv, 3, "(B, 4, 4)", "intrinsics_inv")
    check_matrix(intrinsics_inv, 4, 4, "intrinsics_inv")
    check_rank(pixel_coords, 4, "(B, H, W, 3)", "pixel_coords")
    check_last(pixel_coords, 3, "pixel_coords")
    check_leading(
        [depth, intrinsics_inv, pixel_coords], ["depth", "intrinsics_inv", "pixel_coords"], [3, 2, 3]
    )
    check_broadcastable(pixel_coords, depth[:, 0], "pixel_coords", "depth[:, 0]", 1, 0)
    return moved(intrinsics_inv[:, None, None], pixel_coords) * depth[:, 0, :, :, None]


class PinholeCamera(Module):
    """B cameras without distortion, each with its own pose; a call with points is ``project``.

    E. Riba et al., Kornia: an Open Source Differentiable Computer Vision Library for PyTorch, WACV 2020. A
    tensor that is an ``nn.Parameter`` becomes a learnable parameter of the module.

    Args:
        intrinsics: (B, 3, 3) or (B, 4, 4), camera matrices in pixels, floating point; skew is ignored, as in
            :func:`project_points`.
        extrinsics: (B, 4, 4), rigid, from the world to the cameras' frames.
        height, width: (B,), sizes of the images in pixels.

    Raises:
        TypeError: if intrinsics or extrinsics is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> camera = PinholeCamera.from_parameters(100.0, 100.0, 32.0, 24.0, 48, 64, tz=1.0)
        >>> camera.project(torch.tensor([[[0.1, 0.2, 1.0]]]))
        tensor([[[37., 34.]]])
        >>> camera.unproject(torch.tensor([[[37.0, 34.0]]]), torch.tensor([[[2.0]]]))
        tensor([[[0.1000, 0.2000, 1.0000]]])
    """

    def __init__(self, intrinsics: Tensor, extrinsics: Tensor, height: Tensor, width: Tensor) -> None:
        super().__init__()
        check_intrinsics(intrinsics, "intrinsics")
        check_rank(intrinsics, 3, "(B, 3, 3) or (B, 4, 4)", "intrinsics")
        check_rank(extrinsics, 3, "(B, 4, 4)", "extrinsics")
        check_matrix(extrinsics, 4, 4, "extrinsics")
        batch = intrinsics.size(0)
        for name, value in (("extrinsics", extrinsics), ("height", height), ("width", width)):
            if value.size(0) != batch:
                raise ValueError(
                    f"{name}: expected a batch of {batch} as intrinsics has, got {list(value.shape)}"
                )
        hold(self, "intrinsics", intrinsics)
        hold(self, "extrinsics", extrinsics)
        hold(self, "height", height)
        hold(self, "width", width)

    @classmethod
    def from_parameters(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        height: int,
        width: int,
        tx: float = 0.0,
        ty: float = 0.0,
        tz: float = 0.0,
        batch_size: int = 1,
        device: Optional[torch.device] = None,
        dtype: Optional[torch.dtype] = None,
    ) -> "PinholeCamera":
        """Equal cameras that look along the world's z axis, from numbers: intrinsics in pixels, and the
        translation in the world's unit."""
        intrinsics, extrinsics = torch.eye(4, dtype=torch.float64), torch.eye(4, dtype=torch.float64)
        intrinsics[0, 0], intrinsics[1, 1], intrinsics[0, 2], intrinsics[1, 2] = fx, fy, cx, cy
        extrinsics[0, 3], extrinsics[1, 3], extrinsics[2, 3] = tx, ty, tz
        values = [
            v.to(device, dtype or torch.get_default_dtype())
            for v in (intrinsics, extrinsics, torch.tensor(height), torch.tensor(width))
        ]
        return cls(*[v.expand(batch_size, *v.shape).clone() for v in values])

    @property
    def batch_size(self) -> int:
        """B."""
        return self.intrinsics.size(0)

    @property
    def fx(self) -> Tensor:
        """(B,), horizontal focal lengths in pixels."""
        return self.intrinsics[:, 0, 0]

    @property
    def fy(self) -> Tensor:
        """(B,), vertical focal lengths in pixels."""
        return self.intrinsics[:, 1, 1]

    @property
    def cx(self) -> Tensor:
        """(B,), columns of the principal points."""
        return self.intrinsics[:, 0, 2]

    @property
    def cy(self) -> Tensor:
        """(B,), rows of the principal points."""
        return self.intrinsics[:, 1, 2]

    @property
    def tx(self) -> Tensor:
        """(B,), the x coordinate of the world's origin in the cameras' frames."""
        return self.extrinsics[:, 0, 3]

    @tx.setter
    def tx(self, value: Tensor) -> None:
        self.extrinsics[:, 0, 3] = value

    @property
    def ty(self) -> Tensor:
        """(B,), the y coordinate of the world's origin in the cameras' frames."""
        return self.extrinsics[:, 1, 3]

    @ty.setter
    def ty(self, value: Tensor) -> None:
        self.extrinsics[:, 1, 3] = value

    @property
    def tz(self) -> Tensor:
        """(B,), the z coordinate of the world's origin in the cameras' frames."""
        return self.extrinsics[:, 2, 3]

    @tz.setter
    def tz(self, value: Tensor) -> None:
        self.extrinsics[:, 2, 3] = value

    @property
    def camera_matrix(self) -> Tensor:
        """(B, 3, 3), K."""
        return self.intrinsics[:, :3, :3]

    @property
    def rotation_matrix(self) -> Tensor:
        """(B, 3, 3), from the world to the cameras' frames."""
        return self.extrinsics[:, :3, :3]

    @property
    def translation_vector(self) -> Tensor:
        """(B, 3, 1), the world's origin in the cameras' frames."""
        return self.extrinsics[:, :3, 3:]

    @property
    def rt_matrix(self) -> Tensor:
        """(B, 3, 4), [R | t]."""
        return self.extrinsics[:, :3]

    @torch.jit.export
    def intrinsics_inverse(self) -> Tensor:
        """Inverse of the intrinsics, in their shape."""
        return inverse(self.intrinsics)

    @torch.jit.export
    def project(self, point_3d: Tensor) -> Tensor:
        """Project points of the world (B, *, 3) to pixels (B, *, 2), as :func:`project_points`; a batch of 1
        broadcasts to any B."""
        seen = transform_points(self.extrinsics, point_3d)
        return project_points(seen, self._matrices(seen))

    @torch.jit.export
    def unproject(self, point_2d: Tensor, depth: Tensor) -> Tensor:
        """Points of the world (B, *, 3) seen at pixels (B, *, 2) with depths (B, *, 1), z in the cameras'
        frames."""
        return transform_points(
            inverse_transformation(self.extrinsics),
            unproject_points(point_2d, depth, self._matrices(point_2d)),
        )

    def scale(self, scale_factor: Tensor) -> "PinholeCamera":
        """The cameras of images scaled by factors (B,), or (1,) for all: see :func:`scale_intrinsics`."""
        height, width = self.height * scale_factor, self.width * scale_factor
        return PinholeCamera(self._scaled(scale_factor), self.extrinsics, height, width)

    @torch.jit.unused
    def scale_(self, scale_factor: Tensor) -> "PinholeCamera":
        """``scale`` of these cameras themselves."""
        self.intrinsics.copy_(self._scaled(scale_factor))
        self.height.mul_(scale_factor)
        self.width.mul_(scale_factor)
        return self

    def _scaled(self, scale_factor: Tensor) -> Tensor:
        """The matrices of scaled images, of the size of ``intrinsics``."""
        made = self.intrinsics.clone()
        made[..., :3, :3] = scale_intrinsics(self.camera_matrix, scale_factor)
        return made

    @torch.jit.unused
    def device(self) -> torch.device:
        """The device of the matrices."""
        return self.camera_matrix.device

    @torch.jit.unused
    def clone(self) -> "PinholeCamera":
        """A copy of the cameras, with copied tensors."""
        parts = (self.intrinsics, self.extrinsics, self.height, self.width)
        return PinholeCamera(*[part.clone() for part in parts])

    def forward(self, point_3d: Tensor) -> Tensor:
        return self.project(point_3d)

    def _matrices(self, points: Tensor) -> Tensor:
        """The camera matrices, with extra dimensions for the dimensions of points between batch and
        coordinates."""
        m = self.camera_matrix
        for _ in range(points.dim() - 2):
            m = m.unsqueeze(1)
        return m
