"""Composes panels: one picture per op, and sheets with many pictures."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from .panels import WIDE, Panel
from .plots import FAINT, FONT, INK

GAP, STRIP = 8, 14
GIVEN, MADE = (70, 90, 120), (176, 62, 0)


def compose(panels: list[Panel], width: int = 480) -> Image.Image:
    """Panels side by side, each under its label; wide panels have their own rows."""
    runs = [list(run) for _, run in groupby(panels, lambda p: p.weight >= WIDE)]
    rows = [row_of(row, columns, width) for run in runs for row, columns in rows_of(run)]
    canvas = Image.new("RGB", (width, sum(r.height for r in rows) + GAP * (len(rows) - 1)), "white")
    top = 0
    for row in rows:
        canvas.paste(row, (0, top))
        top += row.height + GAP
    return canvas


def rows_of(panels: list[Panel]) -> Iterator[tuple[list[Panel], int]]:
    """Rows of up to three panels, four as a square, small ones in one row; and the number of places in each
    row."""
    columns = 2 if len(panels) == 4 else min(len(panels), 3)
    if all(p.matrix for p in panels) or sum(p.weight for p in panels) <= 3:
        columns = len(panels)
    if panels[0].weight >= WIDE:
        columns = 1
    for i in range(0, len(panels), columns):
        yield panels[i : i + columns], columns


def row_of(panels: list[Panel], columns: int, width: int) -> Image.Image:
    total = sum(p.weight for p in panels) + columns - len(panels)
    cells = [int((width - GAP * (columns - 1)) * p.weight / total) for p in panels]
    images = [scaled(p.image, cell) for p, cell in zip(panels, cells, strict=True)]
    canvas = Image.new("RGB", (width, max(i.height for i in images) + STRIP), "white")
    pen, left = ImageDraw.Draw(canvas), 0
    for panel, cell, image in zip(panels, cells, images, strict=True):
        pen.text((left, 0), cut(panel.label, cell), fill=GIVEN if panel.given else MADE, font=FONT)
        canvas.paste(image, (left, STRIP))
        if panel.matrix:
            pen.rectangle((left, STRIP, left + image.width - 1, STRIP + image.height - 1), outline=FAINT)
        left += cell + GAP
    return canvas


def cut(text: str, width: int) -> str:
    """A label, cut off if it is too long."""
    if FONT.getlength(text) <= width:
        return text
    return next(
        f"{text[:n]}..."
        for n in range(len(text), -1, -1)
        if n == 0 or FONT.getlength(f"{text[:n]}...") <= width
    )


def scaled(pixels: np.ndarray, width: int) -> Image.Image:
    """The image, enlarged in whole pixels or reduced smoothly; no taller than wide."""
    image = Image.fromarray(np.ascontiguousarray(pixels))
    width = min(width, int(width * image.width / image.height))
    if image.width < width:
        factor = math.ceil(width / image.width)
        image = image.resize((image.width * factor, image.height * factor), Image.Resampling.NEAREST)
    if image.width != width:
        image = image.resize(
            (width, max(1, round(image.height * width / image.width))), Image.Resampling.LANCZOS
        )
    return image


def titled(image: Image.Image, name: str, caption: str = "") -> Image.Image:
    """A picture under the op's name and a caption."""
    lines = [name, *textwrap.wrap(caption, image.width // 6)]
    canvas = Image.new("RGB", (image.width, image.height + 15 * len(lines) + 4), "white")
    pen = ImageDraw.Draw(canvas)
    for i, line in enumerate(lines):
        pen.text((0, 15 * i), line, fill="black" if i == 0 else INK, font=FONT)
    canvas.paste(image, (0, 15 * len(lines) + 4))
    return canvas


def contact_sheet(tiles: list[Image.Image], path: Path, columns: int = 3) -> None:
    """All pictures on one page."""
    width = max(t.width for t in tiles) + 16
    rows = [tiles[i : i + columns] for i in range(0, len(tiles), columns)]
    heights = [max(t.height for t in row) + 12 for row in rows]
    sheet = Image.new("RGB", (columns * width, sum(heights)), "white")
    top = 0
    for row, height in zip(rows, heights, strict=True):
        for column, tile in enumerate(row):
            sheet.paste(tile, (column * width + 8, top + 4))
        top += height
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(path)
