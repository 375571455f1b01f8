"""Random cameras and scenes, for tests and experiments."""

import math
from typing import Dict, Union

import torch
from torch import Tensor

from ..conversions.rotations import axis_angle_to_rotation_matrix
from .projection import projection_from_KRt


def random_intrinsics(low: Union[float, Tensor], high: Union[float, Tensor]) -> Tensor:
    """A camera matrix whose focal lengths and principal point are drawn from [low, high), by PyTorch's
    generator.

    Returns:
        (1, 3, 3), of the bounds' dtype if they are tensors.

    Example:
        >>> random_intrinsics(1.0, 2.0)[0, 2]
        tensor([0., 0., 1.])
    """
    first, last = torch.as_tensor(low), torch.as_tensor(high)
    u = torch.rand(4, dtype=first.dtype if first.is_floating_point() else None, device=first.device)
    drawn = first + (last - first) * u
    camera = torch.eye(3, dtype=drawn.dtype, device=drawn.device)
    camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2] = drawn.unbind()
    return camera[None]


def generate_scene(num_views: int, num_points: int) -> Dict[str, Tensor]:
    """Random points in the unit cube, seen by random cameras with one camera matrix; every point lies in
    front of every camera. Drawn by PyTorch's generator.

    Args:
        num_views: number V of cameras.
        num_points: number N of points.

    Returns:
        K (1, 3, 3), R (V, 3, 3), t (V, 3, 1), P (V, 3, 4) = K [R | t], points3d (1, N, 3), points2d (V, N,
        2).

    Raises:
        ValueError: if a number is not positive.

    Example:
        >>> scene = generate_scene(2, 5)
        >>> scene["P"].shape, scene["points2d"].shape
        (torch.Size([2, 3, 4]), torch.Size([2, 5, 2]))
    """
    if num_views < 1 or num_points < 1:
        raise ValueError(
            f"num_views, num_points: expected positive numbers, got {num_views} and {num_points}"
        )
    points = torch.rand(1, num_points, 3)
    axis = torch.nn.functional.normalize(torch.randn(num_views, 3), dim=-1)
    R = axis_angle_to_rotation_matrix(2.0 * math.pi * torch.rand(num_views, 1) * axis)
    t = torch.rand(num_views, 3, 1) * torch.tensor([[1.0], [1.0], [3.0]]) - torch.tensor(
        [[0.5], [0.5], [1.0]]
    )
    nearest = (points @ R.mT).amin(1)[:, 2] + t[:, 2, 0]
    t[:, 2, 0] += torch.where(nearest < 1.0, 1.0 - nearest, torch.zeros_like(nearest))
    K = random_intrinsics(0.0, 100.0)
    P = projection_from_KRt(K.expand(num_views, -1, -1), R, t)
    return {"K": K, "R": R, "t": t, "P": P, "points3d": points, "points2d": _seen(P, points)}


def _seen(P: Tensor, points: Tensor) -> Tensor:
    """(V, N, 2), points (1, N, 3) by cameras (V, 3, 4)."""
    image = points @ P[..., :3].mT + P[..., 3][:, None]
    return image[..., :2] / image[..., 2:]
