"""Polynomials and their roots, lines and planes fitted to points, rotations around a mean."""

from __future__ import annotations

import numpy as np

from gallery.plots import FAINT
from gallery.sheets import TEXTBOOK, Plane, Space, table

from .cells import cube, pose_of
from .model import THIRD, Panel, Shown
from .tensors import Size, Sketch, finished, wheel

ROOT, CURVE, FIT = (214, 90, 10), (31, 119, 180), (214, 90, 10)


def polynomials(shown: Shown) -> list[Panel]:
    """Curves with dots at the real roots, one polynomial per column, with the coefficients above and the
    roots below."""
    coefficients, roots = shown.inputs["coeffs"].double().numpy(), shown.first.double().numpy()
    columns = range(min(3, len(roots)))
    tables = [Panel("coeffs", table(coefficients[i : i + 1], THIRD[0], 20), given=True) for i in columns]
    curves = [Panel("the polynomial, its roots", curve(coefficients[i], roots[i])) for i in columns]
    return [*tables, *curves, *(Panel("roots", table(roots[i : i + 1], THIRD[0], 20)) for i in columns)]


def curve(coefficients: np.ndarray, roots: np.ndarray) -> np.ndarray:
    x = np.linspace(-1.3, 2.2, 161)
    y = np.polyval(coefficients, x)
    real = roots[np.abs(np.polyval(coefficients, roots)) < 1e-3]
    reach = float(np.abs(np.polyval(coefficients, np.linspace(-1, 1.6, 60))).max())
    plane = Plane((THIRD[0], 120), np.array([[x[0], -reach], [x[-1], reach]]), down=False, equal=False)
    plane.path(np.array([[x[0], 0], [x[-1], 0]]), FAINT, 1.2)
    inside = np.abs(y) <= reach
    for run in np.split(np.arange(len(x)), np.flatnonzero(np.diff(inside)) + 1):
        if inside[run[0]]:
            plane.path(np.stack([x[run], y[run]], 1), CURVE, 1.8)
    plane.dots(np.stack([real, 0 * real], 1), np.array([ROOT] * len(real)), 3.5)
    return plane.pixels()


def fit(shown: Shown) -> list[Panel]:
    """Points, larger with more weight, and the fitted line or plane."""
    points = shown.inputs["points"][0].double().numpy()
    radius = 2.6 * np.sqrt(shown.inputs["weights"][0].numpy())
    inks = wheel(points)

    def plot(fitted: bool, size: Size) -> np.ndarray:
        canvas = Plane(size, points, down=False) if points.shape[1] == 2 else Space(size, points, TEXTBOOK)
        if fitted:
            for path in paths_of(shown, points):
                canvas.path(path, FIT, 2)
        canvas.dots(points, inks, radius)
        return canvas.pixels()

    names = ", ".join(shown.outputs)
    return finished(
        [
            Sketch("points, by weight", lambda size: plot(False, size), True),
            Sketch(names, lambda size: plot(True, size)),
        ]
    )


def paths_of(shown: Shown, points: np.ndarray) -> list[np.ndarray]:
    """The line through the origin, or a piece of the plane with normal . x + offset = 0."""
    if "direction" in shown.outputs:
        origin, direction = (shown.outputs[n][0].double().numpy() for n in ("origin", "direction"))
        along = (points - origin) @ direction
        return [origin + np.array([[along.min()], [along.max()]]) * direction]
    normal, offset = shown.outputs["normal"][0].double().numpy(), float(shown.outputs["offset"][0])
    low, high = points[:, :2].min(0), points[:, :2].max(0)
    steps = np.linspace(0, 1, 6)
    x, y = (
        low + s * (high - low) for s in (np.stack([steps, 0 * steps], 1), np.stack([0 * steps, steps], 1))
    )
    grid = [np.array([[a, y[0, 1]], [a, y[-1, 1]]]) for a in x[:, 0]] + [
        np.array([[x[0, 0], b], [x[-1, 0], b]]) for b in y[:, 1]
    ]
    return [np.column_stack([line, -(line @ normal[:2] + offset) / normal[2]]) for line in grid]


def mean_rotation(shown: Shown) -> list[Panel]:
    """The axes of all rotations, and those of the mean."""
    given = [pose_of("quaternion", q) for q in shown.inputs["Q"][0].numpy()]
    mean = pose_of("quaternion", shown.first[0].numpy())

    def axes(size: Size) -> np.ndarray:
        space = Space(
            size, 1.15 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]), box=False
        )
        for pose in given:
            space.axes(pose, 1.2, 0.9)
        return space.pixels()

    return finished(
        [
            Sketch("Q: their axes x, y, z", axes, True),
            Sketch("output", lambda size: cube(mean, size)),
            Sketch("output", lambda size: table(shown.first.numpy(), size[0], 20)),
        ]
    )
