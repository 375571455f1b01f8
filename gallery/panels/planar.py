"""Maps of the plane: grids that they warp, points, segments and boxes."""

from __future__ import annotations

import numpy as np

from gallery.plots import SERIES, hues, short
from gallery.sheets import GRAY, Plane, table

from .grids import OUTLINE, draw_grid, grid_of, mapped
from .model import Panel, Shown
from .tensors import Size, Sketch, finished, levels, wheel


def domain_of(shown: Shown, given: bool) -> tuple[np.ndarray, np.ndarray]:
    """The part of the plane on which a matrix acts: the photograph's pixels, or a region that depends on the
    op."""
    name, config = shown.spec.name, shown.spec.config
    if "normalize_homography" in name:
        if given != ("denormalize" in name):
            return np.zeros(2), np.array(config["dsize_src"][::-1], float) - 1
        return -np.ones(2), np.ones(2)
    h, w = shown.photo.shape[:2]
    return np.zeros(2), np.array([w - 1.0, h - 1.0])


def grid_sketch(
    label: str,
    matrix: np.ndarray,
    domain: tuple[np.ndarray, np.ndarray],
    given: bool,
    marks: np.ndarray | None = None,
) -> Sketch:
    """The grid as warped by a matrix, with the original in grey; marks are warped too."""

    def draw(size: Size) -> np.ndarray:
        low, high = domain
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
        seen = np.concatenate([mapped(matrix, line) for line in grid_of(low, high)])
        beside = np.concatenate([seen, corners])
        near = (
            np.ptp(beside, axis=0).max() < 3 * np.ptp(seen, axis=0).max()
            and np.ptp(beside, axis=0).max() < 3 * (high - low).max()
        )
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
    """A grid warped by each matrix, and the matrix's numbers."""
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
    """Points or segments of two images, over a grid that the matrix maps from one to the other."""
    first, second = (shown.inputs[t.name][0].numpy().astype(np.float64) for t in shown.spec.inputs[:2])
    names = [t.name for t in shown.spec.inputs[:2]]
    matrix = next(
        t[0].numpy()
        for t in (*shown.inputs.values(), *shown.outputs.values())
        if tuple(t.shape[1:]) in ((3, 3), (2, 3))
    )
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

    rings = ", rings: mapped" if first.ndim == 2 else ", mapped grid"
    sketches = [Sketch(names[0], before, True), Sketch(f"{names[1]}{rings}", after, True)]
    for name, tensor in shown.outputs.items():
        values = tensor[0].numpy()
        sketches.append(
            table_sketch(name, values, False)
            if values.ndim == 2
            else Sketch(name, lambda size, v=values: levels(v, inks, size))
        )
    return finished(sketches)


def things(plane: Plane, places: np.ndarray, inks: np.ndarray) -> None:
    """Draw points (n, 2) or segments (n, 2, 2)."""
    if places.ndim == 2:
        plane.dots(places, inks, 2.8)
        return
    for ends, ink in zip(places, inks, strict=True):
        plane.path(ends, tuple(int(v) for v in ink), 2.2)
        plane.dots(ends, ink[None].repeat(2, 0), 2.2)


def quadrilaterals(shown: Shown) -> list[Panel]:
    """Four points of two images, one sample per column, with the op's verdict whether a homography can map
    one to the other."""
    made = []
    for name in ("points1", "points2"):
        for i, valid in enumerate(shown.first.tolist()):
            corners = shown.inputs[name][i].numpy()
            plane = Plane((154, 130), corners)
            plane.path(corners, GRAY, 1.3, closed=True)
            plane.dots(corners, hues(4), 4)
            made.append(
                Panel(
                    name if name == "points1" else f"{name}: {'valid' if valid else 'not valid'}",
                    plane.pixels(),
                    given=True,
                )
            )
    return made


# --- boxes --------------------------------------------------------------------------------------------------


def corners_of(boxes: np.ndarray, mode: str = "xyxy") -> np.ndarray:
    """The corners (n, 4, 2) of boxes (n, 4), which may be corners already."""
    if boxes.ndim == 3:
        return boxes.astype(np.float64)
    x1, y1, x2, y2 = boxes.astype(np.float64).T
    if mode == "xywh":
        x2, y2 = x1 + x2, y1 + y2
    return np.stack([np.stack(c, -1) for c in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))], 1)


def boxes_sketch(
    label: str,
    corners: np.ndarray,
    texts: list[str] | None = None,
    given: bool = False,
    before: np.ndarray | None = None,
    faint: np.ndarray | None = None,
) -> Sketch:
    """Rectangles with texts in them; `before` in grey; those in `faint` are drawn thinly."""

    def draw(size: Size) -> np.ndarray:
        plane = Plane(
            size,
            np.concatenate([corners.reshape(-1, 2)] + ([] if before is None else [before.reshape(-1, 2)])),
        )
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
    """Boxes before and after, each with the op's outputs for it."""
    name, config = shown.spec.name, shown.spec.config
    if "generator" in name:
        given = np.stack([t.numpy() for t in shown.inputs.values()])
        return finished(
            [
                Sketch(", ".join(shown.inputs), lambda size: table(given, size[0], 22), True),
                boxes_sketch("boxes", corners_of(shown.first.numpy())),
            ]
        )
    boxes = shown.inputs["boxes"][0].numpy() if "transform_bbox" in name else shown.inputs["boxes"].numpy()
    corners = corners_of(boxes, config.get("mode", "xyxy"))
    if "transform_bbox" in name:
        moved = corners_of(shown.first[0].numpy(), config["mode"])
        return finished(
            [
                boxes_sketch("boxes", corners, given=True),
                boxes_sketch("boxes_out", moved, before=corners),
                table_sketch("trans_mat", shown.inputs["trans_mat"][0].numpy(), True),
            ]
        )
    if "nms" in name:
        kept = np.zeros(len(boxes), bool)
        kept[shown.first.numpy()] = shown.outputs["kept"].numpy()
        return finished(
            [
                boxes_sketch("boxes", corners, given=True),
                boxes_sketch("kept: those in colour", corners, faint=~kept),
            ]
        )
    if "mask" in name:
        masks = [
            Panel("mask", (m.numpy()[..., None] * SERIES[i]).astype(np.uint8))
            for i, m in enumerate(shown.first[:3])
        ]
        return [*finished([boxes_sketch("boxes", corners[:3], given=True)], len(masks)), *masks]
    return finished(
        [
            boxes_sketch("boxes", corners, given=True),
            boxes_sketch(", ".join(shown.outputs), corners, said(shown)),
        ]
    )


def said(shown: Shown) -> list[str]:
    """The outputs for each box, as text."""
    columns = [t.tolist() for t in shown.outputs.values()]
    if shown.first.dtype.is_floating_point:
        return [" x ".join(short(v) for v in row) for row in zip(*columns, strict=True)]
    return ["valid" if v else "not valid" for v in columns[0]]
