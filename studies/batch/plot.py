"""A plot of lines on two logarithmic axes, each named at its end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from PIL import Image, ImageDraw

from gallery.plots import FAINT, FONT, INK, blank, hues, short

LEFT, TOP, RIGHT, BOTTOM = 44, 34, 190, 30
LINE = 13


def log_log(
    lines: Mapping[str, Sequence[tuple[float, float]]],
    bold: Sequence[str],
    title: str,
    axes: tuple[str, str],
    size: tuple[int, int],
) -> Image.Image:
    """Points (x, y), all positive, by the lines' names; those in `bold` are drawn thick.

    The names are at the right in the order of the lines' ends, moved apart if they would overlap.
    """
    canvas, pen = blank(size)
    points = np.log10(np.array([p for line in lines.values() for p in line]))
    low, high = points.min(0), points.max(0)
    low[1], high[1] = math.floor(low[1] * 3) / 3, math.ceil(high[1] * 3) / 3
    span = np.maximum(high - low, 1e-9)
    area = np.array([size[0] - LEFT - RIGHT, size[1] - TOP - BOTTOM])

    def place(x: float, y: float) -> tuple[float, float]:
        at = (np.log10([x, y]) - low) / span * area
        return float(LEFT + at[0]), float(size[1] - BOTTOM - at[1])

    pen.text((LEFT, 4), title, fill="black", font=FONT)
    pen.text((4, 18), axes[1], fill=INK, font=FONT)
    pen.text((LEFT + area[0] / 2, size[1] - 14), axes[0], fill=INK, font=FONT, anchor="ma")
    for x in sorted({p[0] for line in lines.values() for p in line}):
        at = place(x, 10 ** low[1])
        pen.line((at[0], TOP, at[0], at[1]), fill=FAINT)
        pen.text((at[0], at[1] + 3), short(x), fill=INK, font=FONT, anchor="ma")
    for y in (m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5)):
        if low[1] - 1e-9 <= math.log10(y) <= high[1] + 1e-9:
            at = place(10 ** low[0], y)
            pen.line((at[0], at[1], at[0] + area[0], at[1]), fill=FAINT)
            pen.text((at[0] - 3, at[1]), f"{y:g}", fill=INK, font=FONT, anchor="rm")
    count = len(lines)
    order = [*range(0, count, 2), *range(1, count, 2)]  # neighbours in the list get different colours
    inks = [tuple(int(v) for v in ink) for ink in hues(count)[order]]
    ends = {}
    for ink, (name, line) in zip(inks, lines.items(), strict=True):
        path = [place(*p) for p in line]
        wide = 3 if name in bold else 1
        pen.line(path, fill=ink, width=wide, joint="curve")
        for x, y in path:
            pen.ellipse((x - wide, y - wide, x + wide, y + wide), fill=ink)
        ends[name] = (path[-1], ink)
    _name(pen, ends, size[0] - RIGHT, size[1] - BOTTOM)
    return canvas


def _name(
    pen: ImageDraw.ImageDraw,
    ends: Mapping[str, tuple[tuple[float, float], tuple[int, int, int]]],
    left: float,
    bottom: float,
) -> None:
    """Write each name next to its line's end, from the top down, with a thin line to it if the name was
    moved."""
    order = sorted(ends, key=lambda name: ends[name][0][1])
    heights: list[float] = []
    for name in order:
        heights.append(max(ends[name][0][1], heights[-1] + LINE if heights else TOP))
    for i in reversed(range(len(heights))):  # names below the plane are moved up again
        heights[i] = min(heights[i], bottom - (len(heights) - 1 - i) * LINE)
    for name, y in zip(order, heights, strict=True):
        end, ink = ends[name]
        pen.line((end[0] + 2, end[1], left + 12, y), fill=ink)
        pen.text((left + 15, y), name, fill=ink, font=FONT, anchor="lm")


def beside(charts: Sequence[Image.Image]) -> Image.Image:
    canvas = Image.new("RGB", (sum(c.width for c in charts), max(c.height for c in charts)), "white")
    left = 0
    for chart in charts:
        canvas.paste(chart, (left, 0))
        left += chart.width
    return canvas
