"""Pictures of the bundles' results for the photographs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

import chiasm.runtime
from bench.images.data import PHOTOGRAPHS
from gallery.plots import FONT, INK

from .ways import Images, Setup, photographs
from .works import WORKS

SIDE, GAP, STRIP = 128, 6, 16


def sheet(setup: Setup) -> Image.Image:
    """A row of photographs, and a row of results for each bundle, by native code."""
    settings, images = setup.settings, Images(photographs(len(PHOTOGRAPHS), setup.settings.size))

    def run(work: str) -> Callable[[np.ndarray], np.ndarray]:
        return chiasm.runtime.open(setup.bundles / f"{WORKS[work].bundle}.chiasm").method(
            "forward", backend="native"
        )

    mean, std = (np.array(v, np.float32)[:, None, None] for v in (settings.mean, settings.std))
    sobel, prepared = run("sobel")(images.floats), run("prepare")(images.floats)
    rows = {
        "photographs": list(images.floats),
        "Sobel, amplified four times": list(4 * sobel),
        "edges": [np.repeat(run("edges")(f)[None] / np.float32(255), 3, 0) for f in images.frames],
        "preprocess, the normalisation undone": [run("preprocess")(f)[0] * std + mean for f in images.frames],
        "five ops, the normalisation undone": list(prepared * std + mean),
    }
    canvas = Image.new(
        "RGB", (len(PHOTOGRAPHS) * (SIDE + GAP) - GAP, len(rows) * (SIDE + STRIP + GAP)), "white"
    )
    pen = ImageDraw.Draw(canvas)
    for row, (label, planes) in enumerate(rows.items()):
        top = row * (SIDE + STRIP + GAP)
        pen.text((0, top + 2), label, fill=INK, font=FONT)
        for column, image in enumerate(planes):
            pixels = Image.fromarray((image.clip(0, 1) * 255).round().astype(np.uint8).transpose(1, 2, 0))
            canvas.paste(
                pixels.resize((SIDE, SIDE), Image.Resampling.LANCZOS), (column * (SIDE + GAP), top + STRIP)
            )
    return canvas.quantize(palette=canvas.quantize(256))  # a third of the bytes
