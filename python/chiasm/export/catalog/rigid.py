"""Rotations and motions: what makers of inputs share, in float64, and SciPy's classes of them as peers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Generator, Tensor

from ..peer import Call, Peer

#: torch.linalg, whose functions torch declares without types.
linalg: Any = torch.linalg


def normal(generator: Generator, *shape: int) -> Tensor:
    """Normally distributed values."""
    return torch.randn(shape, generator=generator, dtype=torch.float64)


def uniform(generator: Generator, low: float, high: float, *shape: int) -> Tensor:
    """Uniformly distributed values."""
    return torch.rand(shape, generator=generator, dtype=torch.float64) * (high - low) + low


def lengths(v: Tensor, dim: int = -1) -> Tensor:
    """The Euclidean norms along a dimension, which stays with size 1."""
    return v.norm(dim=dim, keepdim=True)  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]


def quaternions(generator: Generator, count: int) -> Tensor:
    """(count, 4), of unit length, with w away from 0, where the sign changes."""
    q = normal(generator, count, 4)
    q[:, 0] += torch.where(q[:, 0] < 0, -0.2, 0.2)
    return q / lengths(q)


def rotations(generator: Generator, count: int) -> Tensor:
    """(count, 3, 3)."""
    w, x, y, z = quaternions(generator, count).unbind(-1)
    rows = [
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    ]
    return torch.stack(rows, -1).reshape(count, 3, 3)


def rotations2d(generator: Generator, count: int) -> Tensor:
    """(count, 2, 2), by less than half a turn."""
    angle = uniform(generator, -2.8, 2.8, count)
    return torch.stack([angle.cos(), -angle.sin(), angle.sin(), angle.cos()], -1).reshape(count, 2, 2)


def motions(generator: Generator, rotation: Tensor) -> Tensor:
    """(count, n + 1, n + 1) with these rotations (count, n, n) and some translations."""
    count, n, _ = rotation.shape
    made = torch.eye(n + 1, dtype=torch.float64).repeat(count, 1, 1)
    made[:, :n, :n], made[:, :n, n] = rotation, normal(generator, count, n)
    return made


def scipys(
    call: Call, *, before: Call | None = None, after: Callable[[Any], Any] | None = None, **options: Any
) -> Peer:
    """A peer in SciPy's Rotation or RigidTransform, which take a whole batch. `call` gets their module. Those
    with a RigidTransform are not timed, because it does more than the ops, such as an SVD of each matrix."""
    return Peer("scipy.spatial.transform", call, "batch", before=before, after=after, **options)


def pose(transform: Any, r: Any, t: Any) -> Any:
    """SciPy's RigidTransform of rotation matrices (N, 3, 3) and translations (N, 3, 1)."""
    return transform.RigidTransform.from_components(t[..., 0], transform.Rotation.from_matrix(r))


def parts(motion: Any) -> tuple[Any, Any]:
    """The rotation matrices and translations of SciPy's RigidTransform."""
    return motion.rotation.as_matrix(), motion.translation[..., None]
