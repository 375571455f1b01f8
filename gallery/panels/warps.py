"""Warped images, and rendered heat maps."""

from __future__ import annotations

import numpy as np
import torch
from PIL import Image, ImageDraw

from gallery.sheets import ZOOM

from .images import image_panels, output_panels
from .model import Panel, Shown
from .solid import volumes

MARK = (255, 60, 0)


def warps(shown: Shown) -> list[Panel]:
    """Images and maps, with the places that other inputs name marked on the image."""
    if any(t.layout == "NCDHW" for t in shown.spec.inputs):
        return volumes(shown)
    made = []
    for t in shown.spec.inputs:
        tensor = shown.inputs[t.name]
        if t.layout:
            made += [
                Panel(p.label, marked(shown, p.image), p.note, True)
                for p in image_panels(t.name, tensor, t.layout, t.color, True)
            ]
        elif t.shape[1:] == ("OH", "OW"):
            made += image_panels(
                t.name,
                (tensor - tensor.min()) / (tensor.max() - tensor.min()),
                "HW" if tensor.dim() == 2 else "CHW",
                "",
                True,
            )
        elif t.name == "noise":
            made += image_panels("noise: x", tensor[:, :1] / (2 * tensor.abs().max()) + 0.5, "NCHW", "", True)
    return [*made, *output_panels(shown)]


def marked(shown: Shown, pixels: np.ndarray) -> np.ndarray:
    """Boxes, centres and control points of splines, on an image."""
    h, w = pixels.shape[:2]
    canvas = Image.fromarray(pixels).resize((w * ZOOM, h * ZOOM))
    pen = ImageDraw.Draw(canvas)
    scale = ZOOM * np.ones(2)

    def places(tensor: torch.Tensor, normalised: bool = False) -> list[tuple[float, float]]:
        points = tensor[0].reshape(-1, 2).double().numpy()
        points = (points + 1) / 2 * [w - 1, h - 1] if normalised else points
        return [tuple(p) for p in points * scale]

    for name in ("src_box", "boxes"):
        if name in shown.inputs:
            corners = places(shown.inputs[name])
            pen.line([*corners, corners[0]], MARK, 2 * ZOOM)
    for name, normalised in (("center", False), ("kernel_centers", True)):
        for x, y in places(shown.inputs[name], normalised) if name in shown.inputs else ():
            pen.ellipse((x - 4 * ZOOM, y - 4 * ZOOM, x + 4 * ZOOM, y + 4 * ZOOM), MARK)
    return np.asarray(canvas.resize((w, h), Image.Resampling.LANCZOS))


def rendered(shown: Shown) -> list[Panel]:
    """One picture for each of the first three."""
    return image_panels("output", shown.first[:3, None], "NCHW", "", False)
