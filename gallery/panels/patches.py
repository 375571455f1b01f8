"""Patches of a photograph, and their descriptors."""

from __future__ import annotations

import numpy as np

from gallery import plots
from gallery.pictures import rgb_of, visible
from gallery.sheets import Photo, Sheet

from .frames import CIRCLE, ellipse, inks_of, pale
from .images import input_panels, kernel_panel
from .model import THIRD, Panel, Shown

CELL, COLUMNS, EDGE = 56, 4, 3
MARK = (255, 90, 30)


def sheet_of(cells: list[np.ndarray], inks: np.ndarray | None = None) -> np.ndarray:
    """Cells of one size in rows of four, each with an edge in its colour."""
    inks = np.full((len(cells), 3), 255) if inks is None else inks
    framed = []
    for cell, ink in zip(cells, inks, strict=True):
        made = np.full((cell.shape[0] + 2 * EDGE, cell.shape[1] + 2 * EDGE, 3), 255, np.uint8)
        made[1:-1, 1:-1] = ink
        made[EDGE:-EDGE, EDGE:-EDGE] = cell
        framed.append(made)
    framed += [np.full_like(framed[0], 255)] * (-len(framed) % COLUMNS)
    return np.concatenate(
        [np.concatenate(framed[i : i + COLUMNS], 1) for i in range(0, len(framed), COLUMNS)]
    )


def enlarged(patch: np.ndarray) -> Photo:
    """A patch (C, PS, PS) to draw on."""
    return Photo(rgb_of(visible(patch.transpose(1, 2, 0))[0]), CELL)


def given(shown: Shown) -> Panel:
    return Panel(
        "patches", sheet_of([enlarged(p).pixels() for p in shown.inputs["patches"].numpy()]), given=True
    )


def shapes(shown: Shown) -> list[Panel]:
    """The ellipse of each patch's gradients."""
    cells = []
    for patch, (a, b, c) in zip(shown.inputs["patches"].numpy(), shown.first.double().numpy(), strict=True):
        sheet = enlarged(patch)
        root = np.linalg.cholesky(np.linalg.inv([[a, b], [b, c]]))
        middle = np.full(2, patch.shape[1] / 2 - 0.5)
        size = 0.8 * middle[0] / max(np.linalg.norm(root, 2), 1.0)
        sheet.path(CIRCLE @ root.T * size + middle, MARK, 1.6)
        cells.append(sheet.pixels())
    return [given(shown), Panel("ellipses, scaled to fit", sheet_of(cells))]


def orientations(shown: Shown) -> list[Panel]:
    """An arrow along each patch's dominant gradient."""
    cells = []
    for patch, angle in zip(shown.inputs["patches"].numpy(), shown.first.tolist(), strict=True):
        sheet = enlarged(patch)
        middle = np.full(2, patch.shape[1] / 2 - 0.5)
        along = np.array([np.cos(angle), -np.sin(angle)])
        across, end = np.array([-along[1], along[0]]), middle + 6 * along
        sheet.path(np.stack([middle, end]), MARK, 1.8)
        sheet.path(np.stack([end - 2 * along + 1.5 * across, end, end - 2 * along - 1.5 * across]), MARK, 1.8)
        cells.append(sheet.pixels())
    return [given(shown), Panel("angles", sheet_of(cells), "arrows point to the brighter side")]


def means(shown: Shown) -> list[Panel]:
    """Each patch in its mean colour."""
    cells = [np.broadcast_to((mean * 255).astype(np.uint8), (CELL, CELL, 3)) for mean in shown.first.numpy()]
    return [given(shown), Panel("descriptors: red, green, blue", sheet_of(cells))]


def glyph(descriptor: np.ndarray) -> np.ndarray:
    """4 x 4 stars with 8 rays: the gradient in each part of the patch and each direction."""
    sheet = Sheet((CELL, CELL))
    step, angles = CELL / 4, np.arange(8) * np.pi / 4
    rays = np.stack([np.cos(angles), np.sin(angles)], 1)
    lengths = descriptor.reshape(8, 4, 4) / descriptor.max() * step * 0.65
    for row, column in np.ndindex(4, 4):
        middle = np.array([(column + 0.5) * step, (row + 0.5) * step])
        for ray, length in zip(rays, lengths[:, row, column], strict=True):
            sheet.stroke(np.stack([middle, middle + ray * length]), (30, 70, 150), 1)
    return sheet.pixels()


def glyphs(shown: Shown) -> list[Panel]:
    """The patches, or the frames on the photograph, and a glyph for each."""
    found = shown.first.double().numpy()
    found = found[0] if found.ndim == 3 else found
    if "patches" in shown.inputs:
        return [
            given(shown),
            Panel("descriptors: 4 x 4 parts, 8 directions", sheet_of([glyph(d) for d in found])),
        ]
    return [
        framed(shown),
        Panel(
            "descriptors: 4 x 4 parts, 8 directions", sheet_of([glyph(d) for d in found], inks_of(len(found)))
        ),
    ]


def rows(shown: Shown) -> list[Panel]:
    """The patches, and a row of colours for each."""
    return [given(shown), kernel_panel("descriptors: a row for each patch", shown.first)]


def framed(shown: Shown) -> Panel:
    """Frames on the photograph."""
    name = next(n for n in ("laf", "lafs") if n in shown.inputs)
    places = shown.inputs[name][0].double().numpy()
    sheet = pale(shown.photo)
    for place, ink in zip(places, inks_of(len(places)), strict=True):
        ellipse(sheet, place, tuple(int(v) for v in ink))
    return Panel(f"{shown.spec.inputs[0].name}, {name}", sheet.pixels(), given=True)


def extracted(shown: Shown) -> list[Panel]:
    """Frames on the photograph, and the patch of each."""
    patches = shown.first[0].numpy()
    return [
        framed(shown),
        Panel(
            next(iter(shown.outputs)),
            sheet_of([enlarged(p).pixels() for p in patches], inks_of(len(patches))),
        ),
    ]


def layouts(shown: Shown) -> list[Panel]:
    """One descriptor before and after, and its glyph."""
    before, after = shown.inputs["descriptors"][0].numpy(), shown.first[0].numpy()
    size = (THIRD[0] + 20, 110)
    return [
        Panel("an OpenCV descriptor", plots.bars([before], plots.SERIES, [], size), given=True),
        Panel("output: reordered", plots.bars([after], plots.SERIES[1:], [], size)),
        Panel("the output's directions", glyph(after.astype(np.float64)), weight=0.8),
    ]


def dense(shown: Shown) -> list[Panel]:
    """The first three principal components of all descriptors as red, green and blue."""
    found = shown.first[0].double().numpy()
    flat = found.reshape(len(found), -1).T
    centred = flat - flat.mean(0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    parts = centred @ axes[:3].T
    low, high = np.percentile(parts, (1, 99), axis=0)
    pixels = ((parts - low) / (high - low)).clip(0, 1) * 255
    seen = pixels.reshape(*found.shape[1:], 3).astype(np.uint8)
    return [
        *input_panels(shown),
        Panel("descriptors", seen, "their first three principal components are shown as red, green and blue"),
    ]
