"""Two views of one scene: points, the lines on which their corresponding points lie, and the distances from
these lines."""

from __future__ import annotations

import numpy as np

from gallery.plots import INK
from gallery.sheets import Plane, table

from .model import Panel, Shown
from .parts import EPIPOLAR
from .tensors import Size, Sketch, finished, levels, wheel


def lines_of(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The lines F x of points x (n, 2)."""
    return (
        np.concatenate([points, np.ones_like(points[:, :1])], 1).astype(np.float64)
        @ matrix.astype(np.float64).T
    )


def pair(shown: Shown) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The names and the points of the two images."""
    chosen = [t.name for t in shown.spec.inputs if t.shape[2:] == (2,)][:2]
    first, second = (shown.inputs[n][0].numpy() for n in chosen)
    return chosen, first, second


def two_views(shown: Shown) -> list[Panel]:
    """Points of the first image, those of the second on their lines, and the op's outputs for them."""
    names, first, second = pair(shown)
    found = next(t[0] for n, t in (shown.inputs | shown.outputs).items() if n in EPIPOLAR).numpy()
    matrix = found if found.ndim == 2 else found[best(found, first, second)]
    inks = wheel(first)
    closest = shown.first[0].numpy() if shown.first.shape[2:] == (2,) else None

    def before(size: Size) -> np.ndarray:
        plane = Plane(size, first)
        if "right_to_left" in shown.spec.name:
            plane.lines(lines_of(matrix.T, second), inks)
        plane.dots(first, inks, 3)
        return plane.pixels()

    def after(size: Size) -> np.ndarray:
        plane = Plane(size, second)
        if "right_to_left" not in shown.spec.name:
            plane.lines(lines_of(matrix, first), inks)
        if closest is not None:
            plane.joins(second, closest, INK, 1.4)
            plane.dots(closest, inks, 4, hollow=True)
        plane.dots(second, inks, 3)
        return plane.pixels()

    sketches = [
        Sketch(names[0], before, True),
        Sketch(f"{names[1]} and lines" + (", rings: output" if closest is not None else ""), after, True),
    ]
    for name, tensor in shown.outputs.items():
        values = tensor[0].numpy()
        if values.dtype != bool and values.ndim == 1:
            sketches.append(Sketch(name, lambda size, v=values: levels(v, inks, size)))
        elif values.ndim >= 2 and closest is None:
            note = (
                f"the best of {int(shown.outputs['exists'][0].sum())} solutions is shown"
                if found.ndim == 3
                else ""
            )
            sketches.append(Sketch(name, lambda size: table(matrix, size[0], 20), note=note))
    return finished(sketches)


def best(matrices: np.ndarray, first: np.ndarray, second: np.ndarray) -> int:
    """The index of the matrix whose lines are nearest to the second image's points."""
    errors = []
    for matrix in matrices:
        lines = lines_of(matrix, first)
        distance = (np.concatenate([second, np.ones_like(second[:, :1])], 1) * lines).sum(1) / np.maximum(
            np.hypot(lines[:, 0], lines[:, 1]), 1e-12
        )
        errors.append(np.abs(distance).sum() if np.abs(matrix).max() else np.inf)
    return int(np.argmin(errors))
