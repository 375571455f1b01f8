"""Panels for tensors other than images, by the kind of their items."""

from __future__ import annotations

import colorsys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gallery.plots import FAINT, INK, short
from gallery.sheets import CAMERA, TEXTBOOK, ZOOM, Plane, Sheet, Space

from .cells import cell
from .images import image_panels
from .images import images as all_images
from .model import HALF, THIRD, WHOLE, Panel, Shown
from .parts import WEIGHTS, Part, parts

Size = tuple[int, int]
QUARTER = 114
JOIN, GHOST = (190, 190, 190), (170, 170, 170)
#: Families whose y grows upwards.
UPWARDS = tuple(
    f"geometry.{n}"
    for n in (
        "linalg",
        "line",
        "plane",
        "quaternion",
        "conversions.cart2pol",
        "conversions.convert_points",
        "conversions.pol2cart",
        "conversions.deg2rad",
        "conversions.rad2deg",
    )
)
#: Families whose z points into the picture.
INWARDS = tuple(
    f"geometry.{n}"
    for n in (
        "calibration",
        "camera",
        "conversions.denormalize_pixel",
        "conversions.normalize_pixel",
        "depth",
        "epipolar",
        "transform",
    )
)


@dataclass(frozen=True)
class Sketch:
    """A panel whose size is not yet known."""

    label: str
    draw: Callable[[Size], np.ndarray]
    given: bool = False
    note: str = ""


def finished(sketches: list[Sketch], others: int = 0) -> list[Panel]:
    """Panels, with a size that depends on their number and on the number of other panels."""
    size = {1: WHOLE, 2: HALF, 4: HALF}.get(len(sketches) + others, THIRD)
    return [Panel(s.label, s.draw(size), s.note, s.given) for s in sketches]


def tensors(shown: Shown) -> list[Panel]:
    """Points and values in plots; for other kinds, three samples side by side."""
    found = parts(shown)
    if not found:
        return all_images(shown)
    images = [
        p
        for t in shown.spec.inputs
        if t.layout
        for p in image_panels(t.name, shown.inputs[t.name], t.layout, t.color, True)
    ]
    if len(found) == 2 and all(p.kind == "values" for p in found):
        return finished([graph(*found)])
    if any(p.kind in ("points", "lines", "image") for p in found) and all(
        p.many or len(p.items) == 1 for p in found if not p.given
    ):
        before = images if all(p.kind == "image" for p in found) else []
        return [*before, *finished(plots_of(shown, found), len(before))]
    samples = min(len(p.items) for p in found)
    if samples > 1:
        return [
            Panel(p.name, cell(p, i, THIRD[0]), given=p.given) for p in found for i in range(min(samples, 3))
        ]
    cells = [
        Sketch(p.name, lambda size, p=p, i=i: cell(p, i, size[0]), p.given)
        for p in found
        for i in range(min(len(p.items), 4))
    ]
    if len(cells) == 4:  # in one row
        return [Panel(c.label, c.draw((QUARTER, QUARTER)), given=c.given, weight=0.75) for c in cells]
    return [*images, *finished(cells, len(images))]


def plots_of(shown: Shown, found: list[Part]) -> list[Sketch]:
    """One plot per part; points in the same place are in one plot."""
    made: list[Sketch] = []
    seen: dict[int, Part] = {}
    weights = next((p.items for p in found if p.name in WEIGHTS and p.kind == "values"), None)
    first = next((p for p in found if p.kind in ("points", "lines")), None)
    inks = wheel(first.items[:, :2]) if first is not None else None
    for part in found:
        if part.kind == "points":
            before = seen.get(part.items.shape[1])
            seen[part.items.shape[1]] = part
            if before is not None and (
                "," in part.name
                or len(before.items) != len(part.items)
                or not overlap(before.items, part.items)
            ):
                before = None
            made.append(Sketch(part.name, drawer(shown, part, before, inks, weights), part.given))
        elif part.kind == "lines":
            beside = next(
                (p for p in found if p.kind == "points" and p.items.shape == (len(part.items), 2)), None
            )
            made.append(Sketch(part.name, line_drawer(shown, part, beside, inks), part.given))
        elif part.kind == "image":
            made.append(
                Sketch(
                    part.name,
                    lambda size, p=part: gray(p.items),
                    part.given,
                    f"black is {short(lowest(part.items))}, white {short(float(part.items.max()))}",
                )
            )
        elif part.kind == "values" and part.name not in WEIGHTS:
            place = seen.get(2)
            if (
                place is not None
                and len(place.items) == len(part.items)
                and (part.given or len(part.items) > 50)
            ):
                note = f"from {short(float(part.items.min()))} (dark) to {short(float(part.items.max()))}"
                made.append(
                    Sketch(part.name, drawer(shown, place, None, shades(part.items), None), part.given, note)
                )
            elif len(part.items) > 1:
                made.append(Sketch(part.name, lambda size, p=part: levels(p.items, inks, size), part.given))
        elif not part.many:
            made.append(Sketch(part.name, lambda size, p=part: cell(p, 0, size[0]), part.given))
    return made


def graph(given: Part, made: Part) -> Sketch:
    """A plot of one number against another."""

    def draw(size: Size) -> np.ndarray:
        points = np.stack([given.items, made.items], 1).astype(np.float64)
        plane = Plane(size, points, down=False, equal=False)
        plane.path(np.array([[plane.low[0], 0], [plane.high[0], 0]]), FAINT)
        plane.path(np.array([[0, plane.low[1]], [0, plane.high[1]]]), FAINT)
        plane.dots(points, wheel(points), 3)
        return plane.pixels()

    return Sketch(f"{made.name} (upwards) of {given.name} (to the right)", draw)


def gray(values: np.ndarray) -> np.ndarray:
    """Values (H, W) as an image."""
    low = lowest(values)
    return (
        ((values[..., None] - low) / max(float(values.max()) - low, 1e-12) * 255)
        .astype(np.uint8)
        .repeat(3, 2)
    )


def lowest(values: np.ndarray) -> float:
    return min(float(values.min()), 0.0)


def is_down(shown: Shown) -> bool:
    return not shown.spec.name.startswith(UPWARDS)


def view_of(shown: Shown) -> np.ndarray:
    return CAMERA if shown.spec.name.startswith(INWARDS) else TEXTBOOK


def drawer(
    shown: Shown, part: Part, before: Part | None, inks: np.ndarray, weights: np.ndarray | None
) -> Callable[[Size], np.ndarray]:
    """Draws points (n, 2 or 3), joined with the original ones."""

    def draw(size: Size) -> np.ndarray:
        points = part.items.astype(np.float64)
        extent = points if before is None else np.concatenate([points, before.items])
        canvas = paper(shown, extent, size)
        radius = np.clip(12 / np.sqrt(len(points)), 1.2, 2.8) * (
            1 if weights is None or len(weights) != len(points) else np.sqrt(np.maximum(weights, 0.05))
        )
        if before is not None:
            canvas.joins(before.items, points, JOIN)
            canvas.dots(before.items, np.broadcast_to(GHOST, (len(points), 3)), 0.6 * np.asarray(radius))
        canvas.dots(
            points, inks if len(inks) == len(points) else np.broadcast_to(INK, (len(points), 3)), radius
        )
        return canvas.pixels()

    return draw


def paper(shown: Shown, extent: np.ndarray, size: Size) -> Plane | Space:
    spread = np.ptp(extent, axis=0)
    equal = bool(spread.max() < 4 * max(float(spread.min()), 1e-9))
    if extent.shape[1] == 2:
        return Plane(size, extent, is_down(shown), equal or not spread.min())
    return Space(size, extent, view_of(shown), equal=equal or not spread.min())


def line_drawer(
    shown: Shown, part: Part, through: Part | None, inks: np.ndarray
) -> Callable[[Size], np.ndarray]:
    """Draws lines a x + b y + c = 0, and points."""

    def draw(size: Size) -> np.ndarray:
        extent = through.items if through is not None else np.array([[-1.0, -1.0], [1.0, 1.0]])
        plane = Plane(size, extent, is_down(shown))
        plane.lines(part.items, inks)
        # Epipolar lines belong to the other image
        if through is not None and (part.given or part.name != "lines"):
            plane.dots(through.items, inks)
        return plane.pixels()

    return draw


def overlap(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether points lie in about the same part of the plane or of space."""
    low, high = np.maximum(a.min(0), b.min(0)), np.minimum(a.max(0), b.max(0))
    whole = np.maximum(a.max(0), b.max(0)) - np.minimum(a.min(0), b.min(0))
    return bool(((high - low) > 0.25 * whole - 1e-9).all())


def wheel(points: np.ndarray) -> np.ndarray:
    """Colours by the direction from the centre."""
    points = points.astype(np.float64) - points.mean(0)
    scale = np.maximum(np.abs(points).max(0), 1e-9)
    turn = np.arctan2(*(points / scale).T[:2]) / (2 * np.pi) % 1
    return np.array([colorsys.hsv_to_rgb(t, 0.85, 0.85) for t in turn]) * 255


def shades(values: np.ndarray, limits: tuple[float, float] | None = None) -> np.ndarray:
    """Colours by value: dark blue to yellow, from the lowest to the highest or between limits."""
    values = values.astype(np.float64)
    low, high = limits or (float(values.min()), float(values.max()))
    share = (values - low) / max(high - low, 1e-12)
    stops = np.array([[40, 20, 110], [170, 40, 110], [245, 130, 50], [250, 215, 70]])
    return np.stack([np.interp(share, np.linspace(0, 1, 4), stops[:, k]) for k in range(3)], -1)


def levels(values: np.ndarray, inks: np.ndarray | None, size: Size) -> np.ndarray:
    """One bar per value, in the colours of the points to which they belong."""
    sheet = Sheet(size)
    values = values.astype(np.float64)
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    left, top, right, bottom = 34, 8, size[0] - 8, size[1] - 8
    scale = (bottom - top) / max(high - low, 1e-12)
    for value in {low, 0.0, high}:
        y = bottom - (value - low) * scale
        sheet.stroke(np.array([[left, y], [right, y]]), FAINT)
        sheet.write((left - 4, y), short(value), (150, 150, 150), "rm", 9)
    step = (right - left) / len(values)
    colors = (
        inks
        if inks is not None and len(inks) == len(values)
        else np.broadcast_to((70, 110, 170), (len(values), 3))
    )
    for i, value in enumerate(values):
        ends = sorted((bottom + low * scale, bottom - (value - low) * scale))
        box = [left + (i + 0.12) * step, ends[0], left + (i + 0.88) * step, ends[1]]
        sheet.pen.rectangle([v * ZOOM for v in box], tuple(int(v) for v in colors[i]))
    return sheet.pixels()
