"""Between points in space and pixels of a pinhole camera."""

from torch import Tensor

from ...primitives.checks import check_last, check_matrix, check_rank
from ...primitives.intrinsics import check_depth, from_pixels, moved, over_depth, to_pixels, with_one


def project_points(point_3d: Tensor, camera_matrix: Tensor) -> Tensor:
    """Pixels at which points in a camera's frame are seen: (fx x / z + cx, fy y / z + cy).

    R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 6.1. As in OpenCV and Kornia, of the camera matrix only focal
    lengths and principal point are read.

    Args:
        point_3d: (*, 3), floating point. A depth below 1e-8 counts as 1e-8, with its sign.
        camera_matrix: (*, 3, 3) with the same leading dimensions, or such as broadcast.

    Returns:
        (*, 2). Differentiable in both.

    Raises:
        TypeError, ValueError: if point_3d is not a floating-point (*, 3), or camera_matrix not a floating-point (*, 3, 3) tensor.

    Example:
        >>> project_points(torch.tensor([2.0, 4.0, 2.0]), torch.eye(3))
        tensor([1., 2.])
    """
    check_last(point_3d, 3, "point_3d")
    check_matrix(camera_matrix, 3, 3, "camera_matrix")
    return to_pixels(over_depth(point_3d, 1e-8), camera_matrix)


def unproject_points(point_2d: Tensor, depth: Tensor, camera_matrix: Tensor, normalize: bool = False) -> Tensor:
    """Points in a camera's frame that are seen at given pixels with given depths; the inverse of :func:`project_points`.

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
    ray = with_one(from_pixels(point_2d, camera_matrix))
    if normalize:
        ray = ray / (ray * ray).sum(-1, keepdim=True).sqrt()
    return ray * depth


def cam2pixel(cam_coords_src: Tensor, dst_proj_src: Tensor, eps: float = 1e-12) -> Tensor:
    """Pixels of another camera at which the points of a frame are seen.

    Args:
        cam_coords_src: (B, H, W, 3), points in the source camera's frame, floating point.
        dst_proj_src: (B, 4, 4), from the source camera's frame to destination pixels times depth; the last row is (0, 0, 0, 1).
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
    seen = moved(dst_proj_src[:, None, None], cam_coords_src)
    return seen[..., 0:2] / (seen[..., 2:3] + eps)


def pixel2cam(depth: Tensor, intrinsics_inv: Tensor, pixel_coords: Tensor) -> Tensor:
    """Points in a camera's frame that are seen at given pixels with given depths.

    Args:
        depth: (B, 1, H, W), floating point.
        intrinsics_inv: (B, 4, 4), the inverse of the camera matrix; the last row is (0, 0, 0, 1).
        pixel_coords: (B, H, W, 3), homogeneous: (x, y, 1). B may be 1.

    Returns:
        (B, H, W, 3). Differentiable in all.

    Raises:
        TypeError, ValueError: if a tensor is not floating point or its shape is not as above.

    Example:
        >>> pixel2cam(torch.full((1, 1, 1, 1), 2.0), torch.eye(4)[None], torch.tensor([3.0, 4.0, 1.0]).reshape(1, 1, 1, 3))
        tensor([[[[6., 8., 2.]]]])
    """
    check_depth(depth, "depth")
    check_rank(intrinsics_inv, 3, "(B, 4, 4)", "intrinsics_inv")
    check_matrix(intrinsics_inv, 4, 4, "intrinsics_inv")
    check_rank(pixel_coords, 4, "(B, H, W, 3)", "pixel_coords")
    check_last(pixel_coords, 3, "pixel_coords")
    return moved(intrinsics_inv[:, None, None], pixel_coords) * depth[:, 0, :, :, None]
