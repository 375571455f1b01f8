"""Maps of the plane: grids that they warp, points, segments and boxes."""

from __future__ import annotations

import numpy as np

from examples.plots import SERIES, hues, short
from examples.sheets import GRAY, Plane, table

from .model import Panel, Shown
from .tensors import Size, Sketch, finished, levels, wheel

GRID, OUTLINE, GRID_LINES = (120, 150, 190), (205, 205, 205), 8


def square_of(matrix: np.ndarray) -> np.ndarray:
    """(3, 3) of an affine transform (2, 3) or a homography."""
    return np.concatenate([matrix, [[0, 0, 1]]]) if matrix.shape == (2, 3) else matrix.astype(np.float64)


def mapped(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Where a matrix takes points (..., 2)."""
    made = np.concatenate([points, np.ones_like(points[..., :1])], -1).astype(np.float64) @ square_of(matrix).T
    return made[..., :2] / made[..., 2:]


def grid_of(low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """The lines of a grid, as paths of points."""
    steps, along = np.linspace(0, 1, GRID_LINES + 1), np.linspace(0, 1, 25)
    across = [np.stack([np.full_like(along, s), along], 1) for s in steps]
    return [low + line * (high - low) for line in (*across, *(a[:, ::-1] for a in across))]


def draw_grid(plane: Plane, low: np.ndarray, high: np.ndarray, matrix: np.ndarray | None = None) -> None:
    """A grid, or where a matrix takes it; its first two sides in red and green."""
    lines = grid_of(low, high)
    inks = {0: (40, 150, 60), GRID_LINES + 1: (215, 50, 45)}
    for index, line in enumerate(lines):
        plane.path(line if matrix is None else mapped(matrix, line), inks.get(index, GRID), 1.8 if index in inks else 0.8)


def domain_of(shown: Shown, given: bool) -> tuple[np.ndarray, np.ndarray]:
    """The part of the plane that a matrix acts on: the photograph's pixels, or what the op says."""
    name, config = shown.spec.name, shown.spec.config
    if "normalize_homography" in name:
        if given != ("denormalize" in name):
            return np.zeros(2), np.array(config["dsize_src"][::-1], float) - 1
        return -np.ones(2), np.ones(2)
    h, w = shown.photo.shape[:2]
    return np.zeros(2), np.array([w - 1.0, h - 1.0])


def grid_sketch(label: str, matrix: np.ndarray, domain: tuple[np.ndarray, np.ndarray], given: bool, marks: np.ndarray | None = None) -> Sketch:
    """The grid that a matrix warps, where it was in grey; marks go with it."""

    def draw(size: Size) -> np.ndarray:
        low, high = domain
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
        seen = np.concatenate([mapped(matrix, line) for line in grid_of(low, high)])
        beside = np.concatenate([seen, corners])
        near = np.ptp(beside, axis=0).max() < 3 * np.ptp(seen, axis=0).max() and np.ptp(beside, axis=0).max() < 3 * (high - low).max()
        plane = Plane(size, beside if near else seen)
        if near:
            plane.path(corners, OUTLINE, 1, closed=True)
        draw_grid(plane, low, high, matrix)
        if marks is not None:
            moved = mapped(matrix, marks)
            plane.dots(moved, wheel(moved) if len(moved) > 1 else np.array([[20, 20, 20]]), 3.5)
        return plane.pixels()

    return Sketch(label, draw, given)


def table_sketch(label: str, matrix: np.ndarray, given: bool) -> Sketch:
    return Sketch(label, lambda size: table(matrix, size[0], 20), given)


def plane_maps(shown: Shown) -> list[Panel]:
    """What each matrix makes of a grid, and its numbers."""
    inputs = {t.name: shown.inputs[t.name][0].numpy() for t in shown.spec.inputs}
    given = {n: m for n, m in inputs.items() if m.shape in ((2, 3), (3, 3))}
    made = {n: t[0].numpy() for n, t in shown.outputs.items()}
    marks = next((inputs[n] for n in ("points_src", "center") if n in inputs), None)
    marks = None if marks is None else marks.reshape(-1, 2)
    grids = [grid_sketch(n, m, domain_of(shown, True), True) for n, m in given.items()]
    tables = [table_sketch(n, m, True) for n, m in given.items()]
    if not given:
        label = ", ".join(["a grid", *(n for n in ("points_src", "center") if n in inputs)])
        grids.append(grid_sketch(label, np.eye(3), domain_of(shown, True), True, marks))
    grids += [grid_sketch(n, m, domain_of(shown, False), False, marks) for n, m in made.items()]
    tables += [table_sketch(n, m, False) for n, m in made.items()]
    return finished([*grids, *tables])


def fitted(shown: Shown) -> list[Panel]:
    """Points or segments of two images, over a grid that the matrix takes from one to the other."""
    first, second = (shown.inputs[t.name][0].numpy().astype(np.float64) for t in shown.spec.inputs[:2])
    names = [t.name for t in shown.spec.inputs[:2]]
    matrix = next(t[0].numpy() for t in (*shown.inputs.values(), *shown.outputs.values()) if tuple(t.shape[1:]) in ((3, 3), (2, 3)))
    inks = wheel(first.reshape(len(first), -1, 2).mean(1))
    low, high = first.reshape(-1, 2).min(0), first.reshape(-1, 2).max(0)
    seen = mapped(matrix, first)

    def before(size: Size) -> np.ndarray:
        plane = Plane(size, first.reshape(-1, 2))
        draw_grid(plane, low, high)
        things(plane, first, inks)
        return plane.pixels()

    def after(size: Size) -> np.ndarray:
        plane = Plane(size, np.concatenate([second.reshape(-1, 2), seen.reshape(-1, 2)]))
        draw_grid(plane, low, high, matrix)
        if first.ndim == 2:
            plane.joins(seen, second, (60, 60, 60))
            plane.dots(seen, inks, 4.5, hollow=True)
        things(plane, second, inks)
        return plane.pixels()

    rings = ", rings: where it takes the first" if first.ndim == 2 else ", on the grid"
    sketches = [Sketch(names[0], before, True), Sketch(f"{names[1]}{rings}"[:28], after, True)]
    for name, tensor in shown.outputs.items():
        values = tensor[0].numpy()
        sketches.append(table_sketch(name, values, False) if values.ndim == 2 else Sketch(name, lambda size, v=values: levels(v, inks, size)))
    return finished(sketches)


def things(plane: Plane, places: np.ndarray, inks: np.ndarray) -> None:
    """Points (n, 2), or segments (n, 2, 2)."""
    if places.ndim == 2:
        plane.dots(places, inks, 2.8)
        return
    for ends, ink in zip(places, inks, strict=True):
        plane.path(ends, tuple(int(v) for v in ink), 2.2)
        plane.dots(ends, ink[None].repeat(2, 0), 2.2)


def quadrilaterals(shown: Shown) -> list[Panel]:
    """Four points of two images, a sample a column; whether a homography can take one to the other, as the op says it."""
    made = []
    for name in ("points1", "points2"):
        for i, valid in enumerate(shown.first.tolist()):
            corners = shown.inputs[name][i].numpy()
            plane = Plane((154, 130), corners)
            plane.path(corners, GRAY, 1.3, closed=True)
            plane.dots(corners, hues(4), 4)
            made.append(Panel(name if name == "points1" else f"{name}: {'valid' if valid else 'not valid'}", plane.pixels(), given=True))
    return made


# --- boxes -------------------------------------------------------------------------------------------------------------


def corners_of(boxes: np.ndarray, mode: str = "xyxy") -> np.ndarray:
    """(n, 4, 2) of boxes (n, 4) or such corners."""
    if boxes.ndim == 3:
        return boxes.astype(np.float64)
    x1, y1, x2, y2 = boxes.astype(np.float64).T
    if mode == "xywh":
        x2, y2 = x1 + x2, y1 + y2
    return np.stack([np.stack(c, -1) for c in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))], 1)


def boxes_sketch(label: str, corners: np.ndarray, texts: list[str] | None = None, given: bool = False, before: np.ndarray | None = None, faint: np.ndarray | None = None) -> Sketch:
    """Rectangles with texts in them; `before` in grey, `faint` says which are drawn thinly."""

    def draw(size: Size) -> np.ndarray:
        plane = Plane(size, np.concatenate([corners.reshape(-1, 2)] + ([] if before is None else [before.reshape(-1, 2)])))
        for box in () if before is None else before:
            plane.path(box, OUTLINE, 1.2, closed=True)
        for i, box in enumerate(corners):
            thin = faint is not None and faint[i]
            ink = (175, 175, 175) if thin else SERIES[i % len(SERIES)] if faint is None else SERIES[1]
            plane.path(box, ink, 1 if thin else 2, closed=True)
        for i, text in enumerate(texts or []):
            x, y = plane.at(corners[i].mean(0)[None])[0]
            plane.write((float(x), float(y)), text, SERIES[i % len(SERIES)], "mm", 10)
        return plane.pixels()

    return Sketch(label, draw, given)


def plane_boxes(shown: Shown) -> list[Panel]:
    """Boxes before and after, with what the op says of each in it."""
    name, config = shown.spec.name, shown.spec.config
    if "generator" in name:
        given = np.stack([t.numpy() for t in shown.inputs.values()])
        label = ", ".join(shown.inputs)
        return finished([Sketch(f"{label}, a box a column"[:44], lambda size: table(given, size[0], 22), True), boxes_sketch("boxes", corners_of(shown.first.numpy()))])
    boxes = shown.inputs["boxes"][0].numpy() if "transform_bbox" in name else shown.inputs["boxes"].numpy()
    corners = corners_of(boxes, config.get("mode", "xyxy"))
    if "transform_bbox" in name:
        moved = corners_of(shown.first[0].numpy(), config["mode"])
        return finished([boxes_sketch("boxes", corners, given=True), boxes_sketch("boxes_out", moved, before=corners), table_sketch("trans_mat", shown.inputs["trans_mat"][0].numpy(), True)])
    if "nms" in name:
        kept = np.zeros(len(boxes), bool)
        kept[shown.first.numpy()] = shown.outputs["kept"].numpy()
        return finished([boxes_sketch("boxes", corners, given=True), boxes_sketch("kept: those in colour", corners, faint=~kept)])
    if "mask" in name:
        masks = [Panel("mask", (m.numpy()[..., None] * 255).astype(np.uint8).repeat(3, 2)) for m in shown.first[:2]]
        return [*finished([boxes_sketch("boxes", corners, given=True)] * 3)[:1], *masks]
    return finished([boxes_sketch("boxes", corners, given=True), boxes_sketch(", ".join(shown.outputs), corners, said(shown))])


def said(shown: Shown) -> list[str]:
    """What the outputs say of each box."""
    columns = [t.tolist() for t in shown.outputs.values()]
    if shown.first.dtype.is_floating_point:
        return [" x ".join(short(v) for v in row) for row in zip(*columns, strict=True)]
    return ["valid" if v else "not valid" for v in columns[0]]
