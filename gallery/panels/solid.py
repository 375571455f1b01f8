"""Volumes, boxes and maps of space, and the points of depth maps."""

from __future__ import annotations

import numpy as np

from gallery.pictures import rgb_of, visible
from gallery.plots import SERIES, short
from gallery.sheets import CAMERA, Space, table

from .images import image_panels
from .model import Panel, Shown
from .planar import said
from .tensors import Size, Sketch, finished

EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
SLICES, GUTTER = 6, 2


def montage(volume: np.ndarray) -> np.ndarray:
    """Slices of a volume (C, D, H, W), from the front to the back, three in a row."""
    depth = volume.shape[1]
    chosen = np.unique(np.linspace(0, depth - 1, min(SLICES, depth)).round().astype(int))
    pixels, _ = visible(volume.transpose(1, 2, 3, 0))
    larger = max(1, 72 // pixels.shape[2])
    slices = [
        np.pad(
            rgb_of(pixels[i]).repeat(larger, 0).repeat(larger, 1),
            ((0, GUTTER), (0, GUTTER), (0, 0)),
            constant_values=255,
        )
        for i in chosen
    ]
    slices += [np.full_like(slices[0], 255)] * (-len(slices) % 3)
    rows = [np.concatenate(slices[i : i + 3], 1) for i in range(0, len(slices), 3)]
    return np.concatenate(rows)[:-GUTTER, :-GUTTER]


def volumes(shown: Shown) -> list[Panel]:
    """Slices of the volumes before and after."""
    given = [
        Panel(f"{t.name}: slices", montage(shown.inputs[t.name][0].numpy()), given=True)
        for t in shown.spec.inputs
        if t.layout
    ]
    return [*given, *(Panel(f"{n}: slices", montage(t[0].numpy())) for n, t in shown.outputs.items())]


# --- maps ---------------------------------------------------------------------------------------------------


def moved(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 3), mapped by a matrix (3, 4) or (4, 4)."""
    whole = np.concatenate([matrix, [[0, 0, 0, 1]]]) if len(matrix) == 3 else matrix
    made = (
        np.concatenate([points, np.ones_like(points[..., :1])], -1).astype(np.float64)
        @ whole.astype(np.float64).T
    )
    return made[..., :3] / made[..., 3:]


def box_of(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Corners (8, 3): the front's first, clockwise from the upper left one."""
    share = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    return low + share * (high - low)


def draw_box(space: Space, corners: np.ndarray, ink: tuple[int, int, int], width: float = 1.6) -> None:
    """Draw a box, with heavier edges for the front and the top."""
    for i, (a, b) in enumerate(EDGES):
        space.path(corners[[a, b]], ink, width * (1.4 if i < 4 else 0.8))


def box_sketch(label: str, corners: np.ndarray, before: np.ndarray | None, given: bool) -> Sketch:
    """Boxes (n, 8, 3), and others in grey."""

    def draw(size: Size) -> np.ndarray:
        everything = (
            corners.reshape(-1, 3)
            if before is None
            else np.concatenate([corners.reshape(-1, 3), before.reshape(-1, 3)])
        )
        space = Space(size, everything, CAMERA)
        for box in () if before is None else before:
            draw_box(space, box, (190, 190, 190), 0.9)
        for i, box in enumerate(corners):
            draw_box(space, box, SERIES[i % len(SERIES)])
        return space.pixels()

    return Sketch(label, draw, given)


def space_maps(shown: Shown) -> list[Panel]:
    """A box mapped by each matrix, and the matrix's numbers."""
    inputs = {t.name: shown.inputs[t.name][0].numpy() for t in shown.spec.inputs}
    given = {n: m for n, m in inputs.items() if m.shape in ((3, 4), (4, 4))}
    made = {n: t[0].numpy() for n, t in shown.outputs.items()}
    sketches = []
    for names, is_input in ((given, True), (made, False)):
        for name, matrix in names.items():
            box = inputs["src"] if "src" in inputs else box_of(*extent_of(shown, is_input))
            sketches.append(box_sketch(name, moved(matrix, box)[None], box[None], is_input))
    if not given:
        box = inputs["src"] if "src" in inputs else box_of(*extent_of(shown, False))
        sketches.insert(0, box_sketch("src" if "src" in inputs else "a box of voxels", box[None], None, True))
    tables = [
        Sketch(n, lambda size, m=m: table(m, size[0], 20), n in given) for n, m in (given | made).items()
    ]
    return finished([*sketches, *tables])


def extent_of(shown: Shown, given: bool) -> tuple[np.ndarray, np.ndarray]:
    """The part of space on which a matrix acts, in voxels or from -1 to 1."""
    name, config = shown.spec.name, shown.spec.config
    if "normalize_homography" in name:
        if given != ("denormalize" in name):
            return np.zeros(3), np.array(config["dsize_src"][::-1], float) - 1
        return -np.ones(3), np.ones(3)
    return np.zeros(3), np.array([23.0, 15.0, 11.0])


# --- boxes --------------------------------------------------------------------------------------------------


def space_boxes(shown: Shown) -> list[Panel]:
    """Boxes in space, and the op's outputs for each."""
    if "generator" in shown.spec.name:
        given = np.stack([t.numpy() for t in shown.inputs.values()])
        return finished(
            [
                Sketch(", ".join(shown.inputs), lambda size: table(given, size[0], 22), True),
                box_sketch("boxes", shown.first.numpy(), None, False),
            ]
        )
    boxes = shown.inputs["boxes"].numpy()
    if "mask" in shown.spec.name:
        return [
            *finished([box_sketch("boxes", boxes[:1], None, True)], 1),
            Panel("mask: slices of the first", montage(shown.first[0].numpy())),
        ]
    texts = said(shown)
    sketches = [
        box_sketch("boxes", boxes, None, True),
        Sketch(", ".join(shown.outputs), lambda size: verdicts(texts, size)),
    ]
    return finished(sketches)


def verdicts(texts: list[str], size: Size) -> np.ndarray:
    """One line per box, in its colour."""
    space = Space((size[0], 22 * len(texts) + 6), np.zeros((2, 3)), box=False)
    for i, text in enumerate(texts):
        space.write((10, 14 + 22 * i), text, SERIES[i % len(SERIES)], "lm", 12)
    return space.pixels()


# --- depth --------------------------------------------------------------------------------------------------


def cloud_sketch(label: str, points: np.ndarray, inks: np.ndarray) -> Sketch:
    """Many points of space in their colours, seen from the side of the camera."""

    def draw(size: Size) -> np.ndarray:
        space = Space(size, points, CAMERA)
        space.dots(points, inks, 1.3)
        return space.pixels()

    return Sketch(label, draw)


def depth_clouds(shown: Shown) -> list[Panel]:
    """The depth map, and the points in the photograph's colours."""
    depth, points = shown.inputs["depth"], shown.first[0].numpy()
    points = points.transpose(1, 2, 0) if points.shape[0] == 3 else points
    step = max(1, points.shape[0] // 60)
    inks = shown.photo[::step, ::step].reshape(-1, 3)
    plane, note = visible(depth.reshape(*depth.shape[-2:], 1).numpy())
    sketches = [
        Sketch("depth", lambda size: rgb_of(plane), True, note),
        cloud_sketch(
            "points, in the photograph's colours",
            points[::step, ::step].reshape(-1, 3).astype(np.float64),
            inks,
        ),
    ]
    return finished(sketches)


def depth_images(shown: Shown) -> list[Panel]:
    """Depth maps as grey images, photographs and normals as they are."""
    made = []
    for t in shown.spec.inputs:
        if t.layout:
            made += image_panels(t.name, shown.inputs[t.name], t.layout, "", True)
    made = [Panel(p.label, p.image, p.note or range_note(shown, p.label), p.given) for p in made]
    for name, tensor in shown.outputs.items():
        made += image_panels(name, tensor, "NCHW", "", False)
    return made


def range_note(shown: Shown, name: str) -> str:
    tensor = shown.inputs[name]
    if tensor.shape[1] != 1:
        return ""
    high = np.percentile(tensor.numpy(), 99.5)
    return f"black is 0, white {short(float(high))}"
