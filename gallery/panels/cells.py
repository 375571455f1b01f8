"""One small item as a picture: a rotated cube, a moved frame, a table of numbers."""

from __future__ import annotations

import math

import numpy as np
import torch

from chiasm.geometry import conversions
from gallery.plots import hues
from gallery.sheets import GRAY, TEXTBOOK, Plane, Space, table

from .grids import OUTLINE, draw_grid, grid_of, mapped
from .parts import Part

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
FLAT = ((215, 50, 45), (40, 150, 60))


def cell(part: Part, index: int, width: int) -> np.ndarray:
    """An item, with its numbers under it."""
    item = part.items[index]
    if part.kind in ("quaternion", "axis_angle", "rotation", "motion"):
        picture = cube(pose_of(part.kind, item), (width, int(width * 0.72)))
        return stacked(picture, table(item[:3] if part.kind == "motion" else rows_of(item), width))
    if part.kind == "homography":
        return stacked(warped(item, (width, int(width * 0.8))), table(item, width))
    if part.kind == "epipolar":
        return stacked(lines(item, (width, int(width * 0.8))), table(item, width))
    if part.kind in ("turn", "move"):
        return stacked(square(item, (width, int(width * 0.72))), table(item, width))
    return table(rows_of(item), width)


def rows_of(item: np.ndarray) -> np.ndarray:
    """Numbers as a table: vectors in rows of at most five, matrices below each other, wide ones
    transposed."""
    if item.ndim == 0:
        return item.reshape(1, 1)
    if item.ndim == 1:
        rows = math.ceil(len(item) / 5)
        columns = math.ceil(len(item) / rows)
        return np.concatenate([item, np.full(rows * columns - len(item), np.nan)]).reshape(rows, columns)
    table = item.reshape(-1, item.shape[-1])
    return table.T if table.shape[1] > 8 else table


def stacked(*pictures: np.ndarray) -> np.ndarray:
    return np.concatenate(pictures)


def pose_of(kind: str, item: np.ndarray) -> np.ndarray:
    """The matrix (4, 4) of a motion, or of a rotation in any form."""
    if kind == "motion":
        return item.astype(np.float64)
    to_matrix = {
        "axis_angle": conversions.axis_angle_to_rotation_matrix,
        "quaternion": conversions.quaternion_to_rotation_matrix,
    }
    made = np.eye(4)
    made[:3, :3] = (
        to_matrix[kind](torch.from_numpy(item[None].astype(np.float64)))[0].numpy()
        if kind in to_matrix
        else item
    )
    return made


def whole_pose(item: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) or a pose (3, 4) as a matrix (4, 4)."""
    made = np.eye(4)
    made[:3, : item.shape[1]] = item
    return made


def cube(pose: np.ndarray, size: tuple[int, int], view: np.ndarray = TEXTBOOK) -> np.ndarray:
    """A cube with axes x, y, z (red, green, blue) in a pose; if it is translated, with the original axes in
    grey."""
    moved = np.abs(pose[:3, 3]).max() > 0
    reach = 1.05 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    origin = np.eye(3) * 0.8
    extent = np.concatenate([reach + pose[:3, 3], origin, 0 * origin]) if moved else reach * 1.05
    space = Space(size, extent, view, box=False)
    if moved:
        space.joins(0 * origin, origin, GRAY)
        space.path(np.stack([0 * pose[:3, 3], pose[:3, 3]]), (225, 190, 140))
    space.cube(pose, 0.75)
    space.axes(pose, 1.25, 2.2)
    return space.pixels()


def warped(matrix: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """The square from -1 to 1 with a grid, mapped by a homography."""
    seen = np.concatenate([mapped(matrix, line) for line in grid_of(CORNERS[0], CORNERS[2])])
    plane = Plane(size, np.concatenate([seen, CORNERS]))
    plane.path(CORNERS, OUTLINE, 1, closed=True)
    draw_grid(plane, CORNERS[0], CORNERS[2], matrix)
    return plane.pixels()


def lines(matrix: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Nine points of the square from -1 to 1 and their epipolar lines in it, in the same colours."""
    steps = np.array([-0.6, 0.0, 0.6])
    points = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    plane = Plane(size, CORNERS)
    inks = hues(len(points))
    plane.lines(np.column_stack([points, np.ones(len(points))]) @ matrix.astype(np.float64).T, inks, 1.3)
    plane.dots(points, inks, 2.5)
    return plane.pixels()


def square(matrix: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """A square with its axes, rotated and moved in the plane from the grey one."""
    move = np.eye(3)
    move[: len(matrix), : len(matrix)] = matrix
    corners = CORNERS @ move[:2, :2].T + move[:2, 2]
    plane = Plane(size, np.concatenate([corners, CORNERS]) * 1.15, down=False)
    plane.path(CORNERS, OUTLINE, 1, closed=True)
    plane.path(corners, GRAY, 1.4, closed=True)
    for axis, ink in zip(np.eye(2), FLAT, strict=True):
        plane.path(np.stack([move[:2, 2], move[:2, :2] @ axis + move[:2, 2]]), ink, 2.4)
    return plane.pixels()
