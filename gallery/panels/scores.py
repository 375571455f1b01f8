"""Metrics of classes, boxes and poses."""

from __future__ import annotations

import numpy as np
from PIL import Image

from gallery.plots import INK, SERIES
from gallery.sheets import GRAY, ZOOM, Photo, Plane, Sheet, Space, table

from .cells import whole_pose
from .compared import compared
from .model import HALF, THIRD, WHOLE, WIDE, Panel, Shown
from .planar import corners_of
from .seen import CLASSES
from .tensors import levels

STRIP, WRONG, RIGHT = 8, (214, 60, 30), (40, 150, 60)


def confusion(shown: Shown) -> list[Panel]:
    """The matrix, its rows and columns marked with the classes' colours."""
    values = shown.first[0].double().numpy()
    side = (THIRD[0] - STRIP) // len(values) * len(values)
    colors = np.repeat(CLASSES[: len(values)], side // len(values), 0).astype(np.uint8)
    cells = table(values.round(2), side, side // len(values))[:side]
    top = np.broadcast_to(colors, (STRIP, side, 3))
    left = np.pad(
        np.broadcast_to(colors[:, None], (side, STRIP, 3)), ((STRIP, 0), (0, 0), (0, 0)), constant_values=255
    )
    picture = np.concatenate([left, np.concatenate([top, cells])], 1)
    return [
        *compared_inputs(shown),
        Panel(next(iter(shown.outputs)), picture, "rows: true classes, columns: predicted ones"),
    ]


def compared_inputs(shown: Shown) -> list[Panel]:
    return [p for p in compared(shown) if p.given]


def class_values(shown: Shown) -> list[Panel]:
    """One bar per class."""
    inks = np.minimum(CLASSES, 225)
    return [
        *compared_inputs(shown),
        Panel(
            f"{next(iter(shown.outputs))} of each class",
            levels(shown.first[0].numpy(), inks, (THIRD[0], 116)),
        ),
    ]


def ranking(shown: Shown) -> list[Panel]:
    """Scores, one column per sample, with a frame around the true class, which is green if its score is the
    highest."""
    pred, target = shown.inputs["pred"].numpy().T, shown.inputs["target"].numpy()
    width, row = WHOLE[0], 20
    sheet = Sheet((width, len(pred) * row + 2))
    sheet.canvas.paste(
        Image.fromarray(table(pred.round(2), width, row)).resize(
            (width * ZOOM, (len(pred) * row + 1) * ZOOM), Image.Resampling.LANCZOS
        )
    )
    step = width / pred.shape[1]
    for i, label in enumerate(target.tolist()):
        x0, y0, x1, y1 = i * step + 1, label * row + 1, (i + 1) * step - 2, (label + 1) * row - 2
        sheet.stroke(
            np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]),
            RIGHT if pred[:, i].argmax() == label else WRONG,
            2,
        )
    return [
        Panel(
            "pred: one column per sample, one row per class; framed: target",
            sheet.pixels(),
            "red where another class has the highest score",
            True,
        )
    ]


def areas(shown: Shown) -> list[Panel]:
    """The curve of the share of errors below the threshold on the x axis, and the area under it up to each
    threshold."""
    errors = np.sort(shown.inputs["errors"].double().numpy())
    thresholds = shown.spec.config["thresholds"]
    share = np.arange(1, len(errors) + 1) / len(errors)
    steps = np.stack([np.repeat(errors, 2), np.concatenate([[0], np.repeat(share, 2)[:-1]])], 1)
    plane = Plane((320, 150), np.array([[0.0, 0.0], [thresholds[-1] * 1.05, 1.0]]), down=False, equal=False)
    for value, ink in zip(thresholds, SERIES, strict=False):
        plane.path(np.array([[value, 0.0], [value, 1.0]]), ink, 1.4)
    kept = steps[steps[:, 0] <= plane.high[0]]
    plane.path(np.concatenate([[[0.0, 0.0]], kept, [[plane.high[0], kept[-1, 1]]]]), INK, 1.8)
    bars = levels(shown.first.numpy(), np.array(SERIES), (152, 150))
    return [
        Panel("share of errors below (upwards), and the thresholds", plane.pixels(), given=True, weight=2),
        Panel("areas, of 1", bars),
    ]


# --- boxes --------------------------------------------------------------------------------------------------


def draw_boxes(sheet: Photo, boxes: np.ndarray, inks: np.ndarray, texts: list[str]) -> None:
    for corners, ink, text in zip(corners_of(boxes), inks, texts, strict=True):
        sheet.path(corners, tuple(int(v) for v in ink), 1.8, closed=True)
        x, y = sheet.at(corners[:1])[0]
        sheet.write((float(x), float(y) - 1), text, tuple(int(v) for v in ink), "lb", 9)


def overlaps(shown: Shown) -> list[Panel]:
    """Both sets on the photograph, and the table."""
    sheet = Photo(shown.photo, HALF[0])
    for name, ink, mark in (("boxes_1", (90, 190, 255), "abcdefgh"), ("boxes_2", (255, 170, 60), "")):
        boxes = shown.inputs[name].numpy()
        draw_boxes(sheet, boxes, np.array([ink] * len(boxes)), [""] * len(boxes))
        for i, (x, y) in enumerate(
            sheet.at(boxes[:, :2].astype(np.float64) if mark else boxes[:, 2:].astype(np.float64))
        ):
            sheet.write((float(x), float(y)), f"{i}", ink, "rb" if mark else "lt", 11)
    return [
        Panel("boxes_1 (blue), boxes_2 (orange)", sheet.pixels(), given=True),
        Panel("iou: row boxes_1, column boxes_2", table(shown.first.double().numpy(), HALF[0], 30)),
    ]


def precisions(shown: Shown) -> list[Panel]:
    """True boxes, and detected ones with their scores, in the classes' colours; boxes that a mask excludes
    are grey."""
    made = []
    for kind, label in (("gt", "gt_boxes"), ("pred", "pred_boxes, scores")):
        boxes, labels = (shown.inputs[f"{kind}_{n}"][0].numpy() for n in ("boxes", "labels"))
        there = (
            shown.inputs[f"{kind}_mask"][0].numpy()
            if f"{kind}_mask" in shown.inputs
            else np.ones(len(boxes), bool)
        )
        texts = (
            [f"{v:.2f}"[1:] for v in shown.inputs["pred_scores"][0].tolist()]
            if kind == "pred"
            else [""] * len(boxes)
        )
        sheet = Photo(shown.photo, HALF[0])
        draw_boxes(sheet, boxes, np.where(there[:, None], VIVID[labels - 1], GRAY), texts)
        made.append(
            Panel(
                label, sheet.pixels(), "colours are classes" + ("" if there.all() else ", grey: masked"), True
            )
        )
    return [
        *made,
        Panel(
            "average precision of each class",
            levels(shown.outputs["precisions"].numpy(), VIVID, (WHOLE[0], 90)),
            weight=WIDE,
        ),
    ]


VIVID = np.array([(60, 170, 255), (255, 150, 40), (70, 210, 90), (235, 90, 220)])

# --- poses --------------------------------------------------------------------------------------------------


def pose_errors(shown: Shown) -> list[Panel]:
    """The axes of each pair of poses, or of directions; the true one is thin."""
    found, true = (shown.inputs[t.name].numpy() for t in shown.spec.inputs)
    made = []
    for i in range(len(found)):
        label = ", ".join(f"{value[i]:.3g}°" for value in shown.outputs.values())
        space = Space(THIRD, np.concatenate([ends_of(found[i]), ends_of(true[i])]), box=False)
        for thing, width in ((true[i], 1.2), (found[i], 3.0)):
            draw_pose(space, thing, width)
        made.append(Panel(label, space.pixels(), f"{', '.join(shown.outputs)}: the true one is thin"))
    return made


def ends_of(thing: np.ndarray) -> np.ndarray:
    """The visible end points, and the origin."""
    if thing.ndim == 1:
        return np.stack([0 * thing, thing / np.linalg.norm(thing)])
    moved = whole_pose(thing)[:3, 3]
    return np.concatenate([np.zeros((1, 3)), moved[None], moved + thing[:, :3].T])


def draw_pose(space: Space, thing: np.ndarray, width: float) -> None:
    """Draw a direction (3,), or a frame with the path to it if it is moved."""
    if thing.ndim == 1:
        space.path(ends_of(thing), RIGHT if width < 2 else SERIES[0], width)
        return
    pose = whole_pose(thing)
    if pose[:3, 3].any():
        space.path(np.stack([np.zeros(3), pose[:3, 3]]), GRAY, width)
    space.axes(pose, 1.0, width)


def drift(shown: Shown) -> list[Panel]:
    """Both paths, joined point by point, and the distances."""
    found, true = (shown.inputs[n].double().numpy() for n in ("t", "t_gt"))
    inks = np.broadcast_to(np.array(SERIES[0]), (len(true), 3))
    space = Space((HALF[0], 190), np.concatenate([found, true]))
    space.joins(found, true, SERIES[1], 1.4)
    space.path(true, RIGHT, 1.2)
    space.path(found, SERIES[0], 1.2)
    space.dots(found, inks, 2.2)
    return [
        Panel("t (blue), t_gt (green)", space.pixels(), given=True),
        Panel(
            "distance",
            levels(shown.first.numpy(), np.broadcast_to(np.array(SERIES[1]), (len(true), 3)), (HALF[0], 190)),
        ),
    ]
