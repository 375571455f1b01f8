"""Grids of the plane, mapped by matrices."""

from __future__ import annotations

import numpy as np

from gallery.sheets import Plane

GRID, OUTLINE, GRID_LINES = (120, 150, 190), (205, 205, 205), 8


def square_of(matrix: np.ndarray) -> np.ndarray:
    """The (3, 3) matrix of an affine transform (2, 3) or a homography."""
    return np.concatenate([matrix, [[0, 0, 1]]]) if matrix.shape == (2, 3) else matrix.astype(np.float64)


def mapped(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 2), mapped by a matrix."""
    made = (
        np.concatenate([points, np.ones_like(points[..., :1])], -1).astype(np.float64) @ square_of(matrix).T
    )
    return made[..., :2] / made[..., 2:]


def grid_of(low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """The lines of a grid, as paths of points."""
    steps, along = np.linspace(0, 1, GRID_LINES + 1), np.linspace(0, 1, 25)
    across = [np.stack([np.full_like(along, s), along], 1) for s in steps]
    return [low + line * (high - low) for line in (*across, *(a[:, ::-1] for a in across))]


def draw_grid(plane: Plane, low: np.ndarray, high: np.ndarray, matrix: np.ndarray | None = None) -> None:
    """Draw a grid, mapped by a matrix if one is given, with its first two sides in red and green."""
    lines = grid_of(low, high)
    inks = {0: (40, 150, 60), GRID_LINES + 1: (215, 50, 45)}
    for index, line in enumerate(lines):
        plane.path(
            line if matrix is None else mapped(matrix, line),
            inks.get(index, GRID),
            1.8 if index in inks else 0.8,
        )
