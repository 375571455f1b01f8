"""Drawings of points, lines and solids: in the plane, in space, and tables of numbers. Drawn at double size,
so that lines are smooth."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .plots import FAINT, INK, PAPER, RGB, short

ZOOM = 2
GRAY = (150, 150, 150)
Ink = tuple[int, int, int]


@cache
def font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.load_default(size * ZOOM)


class Sheet:
    """Paper to draw on, in its own pixels."""

    def __init__(self, size: tuple[int, int], paper: Ink = PAPER) -> None:
        self.size = size
        self.canvas = Image.new("RGB", (size[0] * ZOOM, size[1] * ZOOM), paper)
        self.pen = ImageDraw.Draw(self.canvas)

    def stroke(self, pixels: np.ndarray, ink: Ink, width: float = 1) -> None:
        """A line through pixels (N, 2)."""
        pixels = pixels[np.isfinite(pixels).all(1)]
        if len(pixels) > 1:
            self.pen.line(
                [(float(x) * ZOOM, float(y) * ZOOM) for x, y in pixels.clip(-1e4, 1e4)],
                tuple(ink),
                round(width * ZOOM),
                "curve",
            )

    def spot(self, pixel: np.ndarray, radius: float, ink: Ink, hollow: bool = False) -> None:
        if np.isfinite(pixel).all() and (np.abs(pixel) < 1e4).all():
            x, y = (float(v) * ZOOM for v in pixel)
            r = radius * ZOOM
            self.pen.ellipse(
                (x - r, y - r, x + r, y + r),
                None if hollow else tuple(ink),
                tuple(ink) if hollow else None,
                round(1.3 * ZOOM),
            )

    def write(
        self, pixel: tuple[float, float], text: str, ink: Ink = INK, anchor: str = "lt", size: int = 10
    ) -> None:
        self.pen.text((pixel[0] * ZOOM, pixel[1] * ZOOM), text, ink, font(size), anchor)

    def pixels(self) -> np.ndarray:
        return np.asarray(self.canvas.resize(self.size, Image.Resampling.LANCZOS))


class Chart(Sheet, ABC):
    """A sheet that shows points in a coordinate system of its own."""

    @abstractmethod
    def at(self, points: np.ndarray) -> np.ndarray:
        """The pixels of points (N, D)."""

    def path(self, points: np.ndarray, ink: Ink = GRAY, width: float = 1, closed: bool = False) -> None:
        self.stroke(self.at(np.concatenate([points, points[:1]]) if closed else points), ink, width)

    def joins(self, a: np.ndarray, b: np.ndarray, ink: Ink = FAINT, width: float = 1) -> None:
        """Draw a line between each pair of points."""
        for ends in np.stack([a, b], 1):
            self.path(ends, ink, width)


class Plane(Chart):
    """A part of the plane that contains all of `extent` (N, 2), with the limits of both axes at the edges.

    down: whether y grows downwards, as in images.
    equal: whether both axes have one scale.
    """

    def __init__(
        self, size: tuple[int, int], extent: np.ndarray, down: bool = True, equal: bool = True
    ) -> None:
        super().__init__(size)
        extent = extent[np.isfinite(extent).all(1)]
        self.low, self.high = extent.min(0), extent.max(0)
        spread = np.maximum(self.high - self.low, 1e-9 * (1 + np.abs(self.high)))
        self.left, self.top, self.right, self.bottom = 34, 6, size[0] - 8, size[1] - 16
        room = np.array([self.right - self.left - 10, self.bottom - self.top - 10]) / spread
        self.scale = (np.minimum(*room) if equal else room) * np.array([1, 1 if down else -1])
        self.shift = (
            np.array([self.left + self.right, self.top + self.bottom]) / 2
            - (self.low + self.high) / 2 * self.scale
        )
        self.frame()

    def frame(self) -> None:
        for value, anchor in zip(
            (self.low[0], self.high[0]), "lr" if self.high[0] > self.low[0] else "l", strict=False
        ):
            self.write(
                (float(self.at(np.array([[value, 0.0]]))[0, 0]), self.bottom + 4),
                short(value),
                GRAY,
                f"{'m' if self.wide() else anchor}t",
                9,
            )
        for value in {self.low[1], self.high[1]}:
            self.write(
                (self.left - 4, float(self.at(np.array([[0.0, value]]))[0, 1])), short(value), GRAY, "rm", 9
            )
        self.stroke(
            np.array(
                [
                    [self.left, self.top],
                    [self.right, self.top],
                    [self.right, self.bottom],
                    [self.left, self.bottom],
                    [self.left, self.top],
                ]
            ),
            FAINT,
        )

    def wide(self) -> bool:
        """Whether the limits of x are far enough apart for their numbers."""
        return (self.high[0] - self.low[0]) * abs(self.scale[0]) > 60

    def at(self, points: np.ndarray) -> np.ndarray:
        """The pixels of points (N, 2)."""
        return points * self.scale + self.shift

    def dots(
        self, points: np.ndarray, inks: np.ndarray, radius: float | np.ndarray = 2.5, hollow: bool = False
    ) -> None:
        for pixel, ink, r in zip(self.at(points), inks, np.broadcast_to(radius, len(points)), strict=True):
            self.spot(pixel, float(r), tuple(int(v) for v in ink), hollow)

    def lines(self, coefficients: np.ndarray, inks: np.ndarray, width: float = 1) -> None:
        """Draw the lines a x + b y + c = 0 of coefficients (N, 3), up to the frame."""
        corners = (np.array([[self.left, self.top], [self.right, self.bottom]]) - self.shift) / self.scale
        (x0, y0), (x1, y1) = corners.min(0), corners.max(0)
        for (a, b, c), ink in zip(coefficients.astype(np.float64), inks, strict=True):
            ends = [(x, -(a * x + c) / b) for x in (x0, x1) if b] + [
                (-(b * y + c) / a, y) for y in (y0, y1) if a
            ]
            inside = [e for e in ends if x0 - 1e-6 <= e[0] <= x1 + 1e-6 and y0 - 1e-6 <= e[1] <= y1 + 1e-6]
            if len(inside) > 1:
                far = max(inside, key=lambda e: math.dist(e, inside[0]))
                self.path(np.array([inside[0], far]), tuple(int(v) for v in ink), width)


class Photo(Chart):
    """A photograph (H, W, 3) of the given width on the sheet; points are its pixels."""

    def __init__(self, pixels: np.ndarray, width: int) -> None:
        self.scale = width / pixels.shape[1]
        super().__init__((width, round(pixels.shape[0] * self.scale)))
        enlarged = self.scale * ZOOM > 4
        self.canvas.paste(
            Image.fromarray(np.ascontiguousarray(pixels)).resize(
                self.canvas.size, Image.Resampling.NEAREST if enlarged else Image.Resampling.LANCZOS
            )
        )

    def at(self, points: np.ndarray) -> np.ndarray:
        """The centres of pixels (N, 2)."""
        return (points + 0.5) * self.scale


def turned(yaw: float, pitch: float) -> np.ndarray:
    """A rotation by yaw and pitch, in degrees; its rows point to the viewer's right, down, and away from the
    viewer."""
    (ca, sa), (cb, sb) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in (yaw, pitch))
    return np.array([[ca, 0, sa], [sa * sb, cb, -ca * sb], [-sa * cb, sb, ca * cb]])


#: CAMERA: x right, y down, z away, as for cameras, seen from behind, the left and above. TEXTBOOK: x right, y
#: up, z towards the viewer.
CAMERA = turned(35, 25)
TEXTBOOK = turned(-30, 20) @ np.diag([1.0, -1.0, -1.0])


class Space(Chart):
    """A part of space that contains all of `extent` (N, 3).

    box: whether to draw the extent's edges, with the axes' names and limits.
    equal: whether the axes have one scale.
    """

    def __init__(
        self,
        size: tuple[int, int],
        extent: np.ndarray,
        view: np.ndarray = TEXTBOOK,
        box: bool = True,
        equal: bool = True,
    ) -> None:
        super().__init__(size)
        self.low, self.high, self.view = extent.min(0), extent.max(0), view
        spread = np.maximum(self.high - self.low, 1e-9 * (1 + np.abs(self.high)))
        self.stretch = np.ones(3) if equal else 1 / spread
        corners = np.array(
            [
                [pair[i] for pair, i in zip(zip(self.low, self.high, strict=True), index, strict=True)]
                for index in np.ndindex(2, 2, 2)
            ]
        )
        seen = (corners * self.stretch) @ view.T[:, :2]
        margin = (np.array([20, 16]) if box else np.array([6, 6])) * 2
        self.scale = float(((np.array(size) - margin) / np.maximum(np.ptp(seen, axis=0), 1e-9)).min())
        self.shift = np.array(size) / 2 - (seen.min(0) + seen.max(0)) / 2 * self.scale
        if box:
            self.edges(corners)

    def edges(self, corners: np.ndarray) -> None:
        for i, a in enumerate(corners):
            for j in (i | 4, i | 2, i | 1):
                if j != i:
                    self.path(np.array([a, corners[j]]), FAINT)
        middle = self.at(corners.mean(0)[None])[0]
        for axis, name in enumerate("xyz"):
            bit = 4 >> axis
            starts = [i for i in range(8) if not i & bit]
            middles = {i: self.at((corners[i] + corners[i | bit])[None] / 2)[0] for i in starts}
            below = [
                i
                for i in starts
                if middles[i][1] >= sorted(m[1] for m in middles.values())[2 if axis != self.upright() else 0]
            ]
            chosen = (
                min(below, key=lambda i: middles[i][0])
                if axis == self.upright()
                else max(below, key=lambda i: middles[i][1])
            )
            out = middles[chosen] - middle
            place = middles[chosen] + out / max(float(np.hypot(*out)), 1e-9) * 9
            self.write((float(place[0]), float(place[1])), name, RGB[axis], "mm", 10)

    def upright(self) -> int:
        """The axis that is most nearly vertical."""
        return int(np.abs(self.view[1]).argmax())

    def at(self, points: np.ndarray) -> np.ndarray:
        """The pixels of points (N, 3)."""
        return (points * self.stretch) @ self.view.T[:, :2] * self.scale + self.shift

    def dots(
        self, points: np.ndarray, inks: np.ndarray, radius: float | np.ndarray = 2.5, hollow: bool = False
    ) -> None:
        """Draw dots, the far ones first and smaller."""
        away = (points * self.stretch) @ self.view[2]
        nearness = 1.3 - 0.6 * (away - away.min()) / max(float(np.ptp(away)), 1e-9)
        sizes = np.broadcast_to(radius, len(points)) * nearness
        for i in np.argsort(-away):
            self.spot(self.at(points[i : i + 1])[0], float(sizes[i]), tuple(int(v) for v in inks[i]), hollow)

    def axes(self, pose: np.ndarray, length: float = 1.0, width: float = 1.5) -> None:
        """The axes x, y, z (red, green, blue) of a frame whose pose is (4, 4)."""
        for axis, ink in zip(np.eye(3), RGB, strict=True):
            self.path((pose @ np.array([[0, 0, 0, 1], [*axis * length, 1]]).T).T[:, :3], ink, width)

    def cube(self, pose: np.ndarray, half: float = 0.5, ink: Ink = GRAY) -> None:
        """The edges of a cube, centred at a frame's origin."""
        corners = np.array([[*(2.0 * np.array(c) - 1) * half, 1] for c in np.ndindex(2, 2, 2)]) @ pose.T
        for i in range(8):
            for j in (i | 4, i | 2, i | 1):
                if j != i:
                    self.path(corners[[i, j], :3], ink)


def table(values: np.ndarray, width: int, row: int = 16) -> np.ndarray:
    """Numbers (R, C) in cells, tinted red and blue by their size and sign; cells that are too small show only
    the tints."""
    rows, columns = values.shape
    sheet = Sheet((width, rows * row + 1))
    reach = max(float(np.abs(values[np.isfinite(values)]).max(initial=0)), 1e-12)
    texts = [[cell_text(v, reach) for v in line] for line in values.tolist()]
    longest = max(len(t) for line in texts for t in line)
    step = width / columns
    size = min(10, int(step / max(longest, 1) / 0.52))
    for r in range(rows):
        for c in range(columns):
            tint = float(np.nan_to_num(values[r, c])) / reach
            hue = (235, 150, 130) if tint < 0 else (140, 180, 235)
            ink = tuple(round(p + (h - p) * abs(tint) * 0.75) for p, h in zip(PAPER, hue, strict=True))
            box = [v * ZOOM for v in (c * step, r * row, (c + 1) * step - 1, (r + 1) * row - 1)]
            sheet.pen.rectangle(box, ink)
            if size >= 7:
                sheet.write(((c + 0.5) * step, (r + 0.5) * row), texts[r][c], INK, "mm", size)
    return sheet.pixels()


def cell_text(value: float, reach: float) -> str:
    """A number as text; it is 0 if it is negligible relative to the others."""
    if math.isnan(value):
        return ""
    if abs(value) < 1e-6 * reach:
        return "0"
    return f"{value:.3g}" if 0.001 <= abs(value) < 1000 else short(value)
