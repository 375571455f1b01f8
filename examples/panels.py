"""What to show of an op: its inputs and what the C++ program made of them, as labelled pictures, and a caption."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from PIL import Image, ImageDraw

from chiasm.export.spec import Spec
from chiasm.geometry import conversions

from . import plots
from .pictures import TINTED, channels_of, chroma_of, labels_of, planes_of, rgb_of, visible

HALF, THIRD, WHOLE = (236, 177), (154, 154), (480, 170)


@dataclass(frozen=True)
class Panel:
    """One picture.

    given: whether it is an input.
    weight: its share of a row's width, relative to the others'.
    matrix: whether it is the values of a small matrix.
    """

    label: str
    image: np.ndarray
    note: str = ""
    given: bool = False
    weight: float = 1.0
    matrix: bool = False


@dataclass(frozen=True)
class Shown:
    """An op, the photograph, the inputs and outputs by name, and what the manifest says of the outputs."""

    spec: Spec
    photo: np.ndarray
    inputs: dict[str, torch.Tensor]
    described: list[dict]
    outputs: dict[str, torch.Tensor]

    @property
    def first(self) -> torch.Tensor:
        return next(iter(self.outputs.values()))


def panels(shown: Shown) -> list[Panel]:
    """Inputs first."""
    parts = sorted(name for name in SPECIAL if shown.spec.name.startswith(name))
    return SPECIAL[parts[-1]](shown) if parts else [*input_panels(shown), *output_panels(shown)]


def caption(shown: Shown, made: list[Panel]) -> str:
    """Configuration, values of the inputs and outputs that are no pictures, and how values were mapped to colours."""
    said = [", ".join(f"{k}={v!r}" for k, v in shown.spec.config.items())]
    seen = {p.label for p in made}
    said += [numbers(n, t) for n, t in shown.inputs.items() if 0 < t.numel() <= 9 and not (seen & {n} or n == "M")]
    said += [numbers(n, t) for n, t in shown.outputs.items() if t.numel() <= 4]
    labels = {p.note: [q.label for q in made if q.note == p.note] for p in made if p.note}
    said += [note if len(names) == len(made) else f"{', '.join(dict.fromkeys(names))}: {note}" for note, names in labels.items()]
    return "; ".join(s for s in said if s)


def numbers(name: str, tensor: torch.Tensor) -> str:
    rows = tensor if tensor.dim() == 0 or len(tensor) > 1 else tensor[0]
    texts = [f"{v:.3g}" for v in rows.flatten().tolist()]
    return f"{name} {texts[0] if len(set(texts)) == 1 else ' '.join(texts)}"


def input_panels(shown: Shown) -> list[Panel]:
    made = []
    for t in shown.spec.inputs:
        tensor = shown.inputs[t.name]
        if t.layout or "H" in t.shape:
            made += image_panels(t.name, tensor, t.layout or "NCHW", t.color, True)
        elif t.name in ("kernel", "hit", "miss") and tensor.squeeze().dim() == 2:
            made.append(kernel_panel(t.name, tensor.squeeze(), True, 0.32))
    return made


def output_panels(shown: Shown) -> list[Panel]:
    made = []
    for d in shown.described:
        if d["layout"]:
            made += image_panels(d["name"], shown.outputs[d["name"]], d["layout"], d["color"], False)
    return made


def image_panels(name: str, tensor: torch.Tensor, layout: str, color: str, given: bool) -> list[Panel]:
    """A panel an image of the batch; one a channel where channels are no red, green and blue."""
    made, arrays = [], planes_of(tensor, layout)
    for array in arrays:
        if color in TINTED:
            made += [Panel(label, image, note, given) for label, image, note in channels_of(array, color)]
        elif array.shape[2] == 2:
            made += [Panel(label, image, note, given) for label, image, note in chroma_of(array)]
        else:
            pixels, note = visible(array)
            image = rgb_of(pixels)
            if color == "BGR" and layout == "HWC":
                image = image[..., ::-1]
            elif color == "BGR":
                note = "blue is shown as red, as it lies"
            made.append(Panel(name, image, "" if given and color != "BGR" else note, given, 0.5 if len(arrays) > 1 else 1.0))
    return made


def kernel_panel(name: str, kernel: torch.Tensor, given: bool = False, weight: float = 1.0) -> Panel:
    """A matrix, enlarged; its values are not spread further than to black and white."""
    values = kernel.numpy()[..., None] / max(float(kernel.abs().max()), 1e-12)
    signed = values.min() < 0
    return Panel(name, rgb_of(visible(values / 2 + 0.5 if signed else values)[0]), "grey is 0" if signed else "", given, weight, True)


def kernels(shown: Shown) -> list[Panel]:
    """Bars of 1-D kernels, pictures of 2-D ones, the slices of a 3-D one."""
    kernel, known = shown.first, {n: t for n, t in shown.inputs.items() if len(set(t.flatten().tolist())) > 1}
    labels = [", ".join(numbers(n, t[i]) for n, t in known.items()) for i in range(len(kernel))]
    if kernel.dim() == 2:
        return [Panel("kernel", plots.bars([k.numpy() for k in kernel], plots.SERIES, labels, WHOLE))]
    if kernel.dim() == 4:
        return [kernel_panel(f"slice {i}", plane) for i, plane in enumerate(kernel[0] / kernel[0].max())]
    values = [", ".join(numbers("", t[i])[1:] for t in known.values()) for i in range(len(kernel))]
    return [kernel_panel(label, k) for label, k in zip(values, kernel, strict=True)]


def gradient(shown: Shown) -> list[Panel]:
    planes = shown.first[:, :, :, shown.first.shape[3] // 2] if shown.first.dim() == 6 else shown.first
    made = [image_panels(f"d/d{axis}", planes[:, :, i], "NCHW", "", False) for i, axis in enumerate("xyz"[: planes.shape[2]])]
    return [*input_panels(shown), *(panel for group in made for panel in group)]


def labels(shown: Shown) -> list[Panel]:
    return [*input_panels(shown), Panel("labels", labels_of(planes_of(shown.first, "NCHW")[0]))]


def picture(shown: Shown) -> list[Panel]:
    return [*input_panels(shown), *image_panels("output", shown.first, "NCHW", "", False)]


def comparison(shown: Shown) -> list[Panel]:
    """What a number compares."""
    return input_panels(shown)


def keypoints(shown: Shown) -> list[Panel]:
    """A ring at each valid point (x, y)."""
    given = input_panels(shown)
    canvas = Image.fromarray(given[0].image)
    pen = ImageDraw.Draw(canvas)
    for x, y in shown.first[0][shown.outputs["valid"][0]].tolist():
        pen.ellipse((x - 4, y - 4, x + 4, y + 4), outline=(255, 60, 0), width=2)
    return [*given, Panel("keypoints", np.asarray(canvas))]


def histogram(shown: Shown) -> list[Panel]:
    """Bars; of an image's histogram one colour a channel."""
    given = input_panels(shown) or [Panel("x: brightness of its pixels", shown.photo, given=True)]
    counts = shown.first[0].reshape(-1, shown.first.shape[-1]).numpy()
    names = ["red", "green", "blue"] if len(counts) == 3 else []
    return [*given, Panel(next(iter(shown.outputs)), plots.bars(list(counts), plots.RGB if names else plots.SERIES, names, HALF))]


def joint_density(shown: Shown) -> list[Panel]:
    x1, x2 = (shown.inputs[n][0].numpy()[::7] for n in ("x1", "x2"))
    inks = np.stack([x1, x2, np.zeros_like(x1)], 1) * 200
    density = shown.first[0].flip(0).sqrt()
    return [
        Panel("x1 (red), x2 (green): pixels", plots.scatter(np.stack([x2, x1], 1), inks, HALF), given=True),
        Panel("density", kernel_panel("", density).image, "its square root is shown"),
    ]


def whitening(shown: Shown) -> list[Panel]:
    """Features 0 and 1 of each sample before and after."""
    before, after = shown.inputs["inp"].numpy(), shown.first.numpy()
    inks = (before[:, :3] * 230).clip(0, 230)
    return [
        Panel("inp: red and green of pixels", plots.scatter(before[:, :2] - before[:, :2].mean(0), inks, HALF), given=True),
        Panel("output: the same samples", plots.scatter(after[:, :2], inks, HALF)),
    ]


def matrices(shown: Shown) -> list[Panel]:
    before = shown.inputs["inp"].numpy()
    points = plots.scatter(before[:, :2], (before[:, :3] * 230).clip(0, 230), THIRD)
    return [Panel("inp: pixels", points, given=True), *(kernel_panel(n, shown.outputs[n]) for n in ("transform_matrix", "inverse"))]


def homography(shown: Shown) -> list[Panel]:
    """Points as dots, rings where the matrix takes those of the first image."""
    first, second = (shown.inputs[n][0].double() for n in ("points1", "points2"))
    mapped = torch.cat([first, torch.ones_like(first[:, :1])], 1) @ shown.first[0].double().T
    rings, inks, down = (mapped[:, :2] / mapped[:, 2:]).numpy(), plots.hues(len(first)), (1, -1)
    text = [" ".join(f"{v:.4f}" for v in row) for row in shown.first[0].tolist()]
    return [
        Panel("points1", plots.scatter(first.numpy() * down, inks, HALF, radius=3), given=True),
        Panel("points2, rings: points1 mapped", plots.scatter(second.numpy() * down, inks, HALF, rings * down, 3), f"homography {'; '.join(text)}"),
    ]


def rotation(shown: Shown) -> list[Panel]:
    """The first rotations in numbers, and a cube that each result turns."""
    name, kind = shown.spec.inputs[0].name, shown.described[0]["name"]
    to_matrix: dict[str, Callable] = {
        "rotation_matrix": lambda m: m,
        "axis_angle": conversions.axis_angle_to_rotation_matrix,
        "quaternion": conversions.quaternion_to_rotation_matrix,
    }
    count, size = 3, THIRD
    cubes = to_matrix[kind](shown.first[:count]).numpy()
    made = []
    for i in range(count):
        for key, tensor, given in ((name, shown.inputs[name][i], True), (kind, shown.first[i], False)):
            rows = [" ".join(f"{v:6.2f}" for v in row) for row in tensor.reshape(-1, tensor.shape[-1]).tolist()]
            made.append(Panel(key, plots.lines(rows, (size[0], 62)), given=given))
        made.append(Panel("cube turned by it", plots.cube(cubes[i], size)))
    return made[0::3] + made[1::3] + made[2::3]


#: By the beginning of an op's name: what has no image to show, or another than its layout says.
SPECIAL: dict[str, Callable[[Shown], list[Panel]]] = {
    "contrib.connected_components": labels,
    "contrib.interp": picture,
    "enhance.count_histogram": histogram,
    "enhance.histogram": histogram,
    "enhance.histogram2d": joint_density,
    "enhance.image_histogram2d": histogram,
    "enhance.linear_transform": whitening,
    "enhance.zca_mean": matrices,
    "enhance.zca_whiten": whitening,
    "feature.harris_keypoints": keypoints,
    "filters.gaussian": kernels,
    "filters.gaussian_blur2d": picture,
    "filters.get_": kernels,
    "filters.spatial_gradient": gradient,
    "geometry.conversions": rotation,
    "geometry.homography": homography,
    "losses": comparison,
}
