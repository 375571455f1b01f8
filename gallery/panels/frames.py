"""Local affine frames: ellipses with a line along their first axis, on the photograph."""

from __future__ import annotations

import numpy as np
import torch

from chiasm.geometry import transform
from gallery.plots import hues
from gallery.sheets import Chart, Photo, Plane

from .images import input_panels
from .model import HALF, Panel, Shown

Ink = tuple[int, int, int]
YES, NO, GHOST = (20, 150, 60), (230, 40, 20), (150, 150, 150)
TURN = np.linspace(0, 2 * np.pi, 49)
CIRCLE = np.stack([np.cos(TURN), np.sin(TURN)], 1)
#: The inputs that define frames, the most informative first.
PLACED = ("laf", "LAF", "lafs", "lafs_1", "threepts", "ells", "xy")


def frames(shown: Shown) -> list[Panel]:
    """The inputs, with their numbers; and the outputs, with the inputs in grey below."""
    name = next(n for n in PLACED if n in shown.inputs)
    places = shown.inputs[name][0].double().numpy()
    numbers = {
        n: t
        for n, t in shown.inputs.items()
        if t.shape[:2] == (1, len(places)) and t[0].numel() == len(places)
    }
    before = paper(shown, places, shown.photo)
    draw(before, name, places, inks_of(len(places)))
    write(before, name, places, list(numbers.values()))
    made = [Panel(", ".join([name, *numbers]), before.pixels(), given=True)]
    for label, value in shown.outputs.items():
        note = f"green: true, {int(value.sum())} of {len(places)}" if value.dtype == torch.bool else ""
        made.append(Panel(label, after(shown, name, places, label, value[0]), note))
    return made


def after(shown: Shown, name: str, places: np.ndarray, label: str, value: torch.Tensor) -> np.ndarray:
    """An output: frames or points as they are, numbers and flags at the input frames."""
    count = len(places)
    if value.numel() == count:
        sheet = paper(shown, places, shown.photo)
        if value.dtype == torch.bool:
            draw(sheet, name, places, np.where(value.numpy()[:, None], YES, NO))
        else:
            draw(sheet, name, places, inks_of(count))
            write(sheet, name, places, [value[None]])
        return sheet.pixels()
    array = value.double().numpy()
    sheet = paper(shown, array, seen(shown))
    if (
        isinstance(sheet, Photo)
        and name not in ("xy", "ells", "threepts")
        and "trans_01" not in shown.inputs
        and spans(places) == spans(array)
    ):
        draw(sheet, name, places, np.array([GHOST] * count))
    draw(sheet, label, array, inks_of(count))
    return sheet.pixels()


def seen(shown: Shown) -> np.ndarray:
    """The photograph on which the output frames lie."""
    if "trans_01" not in shown.inputs:
        return shown.photo
    photo = torch.from_numpy(shown.photo.copy()).permute(2, 0, 1)[None].float()
    moved = transform.warp_perspective(photo, shown.inputs["trans_01"], shown.photo.shape[:2])
    return moved[0].permute(1, 2, 0).round().byte().numpy()


def spans(places: np.ndarray) -> bool:
    """Whether they are in pixels; else they are relative to the image's size."""
    return bool(np.abs(places).max() > 3)


def paper(shown: Shown, places: np.ndarray, photo: np.ndarray) -> Chart:
    return pale(photo) if spans(places) else Plane(HALF, np.array([[0.0, 0.0], [1.0, 1.0]]), equal=False)


def pale(photo: np.ndarray) -> Photo:
    """A pale photograph, on which colours are easy to see."""
    return Photo(photo // 2 + 127, HALF[0])


def inks_of(count: int) -> np.ndarray:
    """Distinct, and dark enough for a pale photograph."""
    return hues(count) * 4 // 5


def draw(sheet: Chart, name: str, places: np.ndarray, inks: np.ndarray) -> None:
    """Draw frames (N, 2, 3), three points each, forms (N, 5), points (N, 2) or (N, P, 2)."""
    for place, ink in zip(places, (tuple(int(v) for v in i) for i in inks), strict=True):
        if place.shape == (2, 3) and name in ("threepts", "points"):
            sheet.path(place.T[[0, 2, 1]], ink, 1.6)
            for pixel, radius in zip(sheet.at(place.T), (3.5, 2.5, 1.5), strict=True):
                sheet.spot(pixel, radius, ink)
        elif place.shape == (2, 3):
            ellipse(sheet, place, ink)
        elif place.shape == (5,):
            a, b, c = place[2:]
            root = np.linalg.cholesky(np.linalg.inv([[a, b], [b, c]]))
            sheet.path(CIRCLE @ root.T + place[:2], ink, 1.6)
        else:
            for pixel in sheet.at(place.reshape(-1, 2)):
                sheet.spot(pixel, 3.0 if place.ndim == 1 else 1.0, ink)


def ellipse(sheet: Chart, frame: np.ndarray, ink: Ink, width: float = 1.6) -> None:
    """The frame's circle, and a line from its centre along its first axis."""
    ring(sheet, frame, ink, width)
    sheet.path(np.stack([frame[:, 2], frame[:, 2] + frame[:, 0]]), ink, width)


def ring(sheet: Chart, frame: np.ndarray, ink: Ink, width: float) -> None:
    sheet.path(CIRCLE @ frame[:, :2].T + frame[:, 2], ink, width)


def write(sheet: Chart, name: str, places: np.ndarray, numbers: list[torch.Tensor]) -> None:
    """Numbers under the centres."""
    centres = places[:, :, 2] if places.ndim == 3 else places[:, :2]
    for i, (x, y) in enumerate(sheet.at(centres) if numbers else ()):
        text = ", ".join(f"{float(n[0, i].flatten()[0]):.3g}" for n in numbers)
        sheet.write((float(x), float(y) + 3), text, (0, 0, 0), "mt", 11)


def detected(shown: Shown) -> list[Panel]:
    """A ring around each key point, as large as its frame."""
    valid = shown.outputs["valid"][0].numpy()
    sheet = Photo(shown.photo, HALF[0])
    for frame in shown.outputs["lafs"][0].double().numpy()[valid]:
        ring(sheet, frame, NO, 1.2)
    count = f"{valid.sum()} of {len(valid)} slots are filled"
    return [Panel("img", shown.photo, given=True), Panel("lafs", sheet.pixels(), count)]


def proposed(shown: Shown) -> list[Panel]:
    """A dot at each window's key point, larger with its response."""
    given = input_panels(shown)
    sheet = Photo(given[0].image, HALF[0])
    places, scores = (
        shown.outputs[n][0].double().flatten(end_dim=-k).numpy()
        for n, k in (("coordinates", 2), ("scores", 1))
    )
    for (x, y), score in zip(places, (scores / scores.max()).clip(0), strict=True):
        ring(sheet, np.array([[1 + 5 * score, 0, x], [0, 1 + 5 * score, y]]), NO, 1.2)
    return [*given, Panel("coordinates", sheet.pixels(), "rings grow with scores")]
