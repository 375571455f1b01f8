"""Images, channels and kernels."""

from __future__ import annotations

import numpy as np
import torch
from PIL import Image, ImageDraw

from gallery import plots
from gallery.pictures import TINTED, channels_of, chroma_of, labels_of, planes_of, rgb_of, visible

from .model import WHOLE, Panel, Shown, numbers


def images(shown: Shown) -> list[Panel]:
    """Inputs first."""
    return [*input_panels(shown), *output_panels(shown)]


def input_panels(shown: Shown) -> list[Panel]:
    made = []
    for t in shown.spec.inputs:
        tensor = shown.inputs[t.name]
        if "a label for each" in t.description:
            weight = 0.5 if len(tensor) > 1 else 1.0
            made.append(Panel(t.name, labels_of(label_image(tensor)), "", True, weight))
        elif t.layout or "H" in t.shape:
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
    """One panel per image of the batch; one per channel if the channels are not red, green and blue."""
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
                note = "stored order: blue is shown as red"
            made.append(
                Panel(
                    name,
                    image,
                    "" if given and color != "BGR" else note,
                    given,
                    0.5 if len(arrays) > 1 else 1.0,
                )
            )
    return made


def label_image(labels: torch.Tensor) -> np.ndarray:
    """The first labels (H, W, 1) of (B, H, W); of volumes (B, D, H, W) the middle slice."""
    first = labels[0] if labels.dim() == 3 else labels[0, labels.shape[1] // 2]
    return first[..., None].numpy()


def kernel_panel(name: str, kernel: torch.Tensor, given: bool = False, weight: float = 1.0) -> Panel:
    """A matrix, enlarged; its values range at most from black to white."""
    values = kernel.numpy()[..., None] / max(float(kernel.abs().max()), 1e-12)
    signed = values.min() < 0
    return Panel(
        name,
        rgb_of(visible(values / 2 + 0.5 if signed else values)[0]),
        "grey is 0" if signed else "",
        given,
        weight,
        True,
    )


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
    made = [
        image_panels(f"d/d{axis}", planes[:, :, i], "NCHW", "", False)
        for i, axis in enumerate("xyz"[: planes.shape[2]])
    ]
    return [*input_panels(shown), *(panel for group in made for panel in group)]


def labels(shown: Shown) -> list[Panel]:
    layout = shown.described[0]["layout"]
    return [*input_panels(shown), Panel("labels", labels_of(planes_of(shown.first, layout)[0]))]


def picture(shown: Shown) -> list[Panel]:
    return [*input_panels(shown), *image_panels("output", shown.first, "NCHW", "", False)]


def keypoints(shown: Shown) -> list[Panel]:
    """A ring at each valid point (x, y)."""
    given = input_panels(shown)
    canvas = Image.fromarray(given[0].image)
    pen = ImageDraw.Draw(canvas)
    for x, y in shown.first[0][shown.outputs["valid"][0]].tolist():
        pen.ellipse((x - 4, y - 4, x + 4, y + 4), outline=(255, 60, 0), width=2)
    return [*given, Panel("keypoints", np.asarray(canvas))]
