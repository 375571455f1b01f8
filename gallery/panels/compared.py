"""The inputs that losses and metrics compare, and the maps that they return."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch

from gallery.plots import FAINT, short
from gallery.sheets import Plane

from .model import THIRD, Panel, Shown
from .seen import DEPTHS, HIDDEN, heat, heat_note, limits_of, picture
from .solid import montage

DOT, LEFT_OUT = (31, 119, 180), (190, 190, 190)


def compared(shown: Shown) -> list[Panel]:
    """The inputs, and the outputs that are maps."""
    depths = [
        shown.inputs[t.name]
        for t in shown.spec.inputs
        if any(word in t.description for word in DEPTHS) and "mask" not in t.name
    ]
    limits = limits_of(depths) if depths else (0.0, 1.0)
    made = []
    for t in shown.spec.inputs:
        value = shown.inputs[t.name]
        if (value.dim() > 2 and not t.name.endswith("_mask")) or t.name == "valid_mask":
            pixels, note = picture(t, value, limits)
            made.append(
                Panel(
                    f"{t.name}: slices" if "D" in t.shape else t.name,
                    hidden(shown, t.name, pixels),
                    note,
                    True,
                )
            )
    return [*made, *maps(shown)]


def hidden(shown: Shown, name: str, pixels: np.ndarray) -> np.ndarray:
    """The pixels without those that the input's mask excludes."""
    mask = shown.inputs.get(f"{name}_mask")
    if mask is None:
        return pixels
    seen = montage(mask[:1].numpy()) if mask.dim() == 4 else mask[0].numpy()[..., None] * np.full(3, 255)
    return np.where(seen > 0, pixels, HIDDEN).astype(np.uint8)


def maps(shown: Shown) -> list[Panel]:
    """The outputs with a value per pixel, as the mean of their channels."""
    made = []
    for name, value in shown.outputs.items():
        if value.dim() == 5:
            made.append(Panel(f"{name}: slices", montage(value[0].numpy())))
        elif value.dim() > 2:
            flat = value[0] if value.dim() == 3 else value[0].mean(0)
            limits = limits_of([flat])
            made.append(Panel(name, heat(flat.numpy(), limits), heat_note(limits)))
    return made


def labelled(shown: Shown) -> list[str]:
    """The first output's values as text."""
    return [
        f"{next(iter(shown.outputs))} {short(v) if abs(v) >= 100 else f'{v:.3g}'}"
        for v in shown.first.flatten().tolist()
    ]


def series(shown: Shown) -> list[Panel]:
    """One image per sample, with its value."""
    images = shown.inputs[shown.spec.inputs[0].name]
    return [
        Panel(label, (image[0].numpy()[..., None] * np.full(3, 255)).astype(np.uint8))
        for label, image in zip(labelled(shown), images, strict=True)
    ]


def pairs(draw: Callable[[Shown, int], list[Panel]]) -> Callable[[Shown], list[Panel]]:
    """A column of panels for each pair and its value, made by `draw`."""

    def panels(shown: Shown) -> list[Panel]:
        columns = [draw(shown, i) for i in range(shown.first.numel())]
        return [column[row] for row in range(len(columns[0])) for column in columns]

    return panels


def planes(shown: Shown, index: int) -> list[Panel]:
    """A channel of the input and of the target as grey images; what a mask excludes is hidden."""
    made = []
    for name, label in (("input", "input"), ("target", f"target, {labelled(shown)[index]}")):
        gray = (shown.inputs[name][0, index].clamp(0, 1).numpy()[..., None] * np.full(3, 255)).astype(
            np.uint8
        )
        mask = shown.inputs.get(f"{name}_mask")
        gray = (
            gray
            if mask is None
            else np.where(mask[0, index].numpy()[..., None], gray, HIDDEN).astype(np.uint8)
        )
        made.append(Panel(label, gray, given=True))
    return made


def signals(shown: Shown, index: int) -> list[Panel]:
    """The target plotted against the input; what a mask excludes is grey."""
    points = torch.stack([shown.inputs[n][index] for n in ("input", "target")], 1).double().numpy()
    masks = [shown.inputs[n][index].numpy() for n in ("input_mask", "target_mask") if n in shown.inputs]
    counted = np.logical_and.reduce([np.ones(len(points), bool), *masks])
    plane = Plane(THIRD, points, down=False, equal=False)
    plane.path(np.array([[plane.low[0], 0], [plane.high[0], 0]]), FAINT)
    plane.dots(points, np.where(counted[:, None], DOT, LEFT_OUT), 1.4)
    return [
        Panel(
            labelled(shown)[index],
            plane.pixels(),
            "target upwards, input to the right" + (", grey: masked" if masks else ""),
        )
    ]


def each_class(shown: Shown) -> list[Panel]:
    """The labels, and one image per class."""
    given = [p for p in compared(shown) if p.given]
    return given + [
        Panel(f"class {i}", (plane.numpy()[..., None] * np.full(3, 255)).astype(np.uint8))
        for i, plane in enumerate(shown.first[0])
    ]
