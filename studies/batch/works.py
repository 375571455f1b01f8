"""The races by name, and chiasm's bundles for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from chiasm.export import Spec, export
from chiasm.export.catalog import catalog
from chiasm.export.spec import image

from . import five_ops, frames, sobel
from .pipeline import prepare
from .settings import Settings

WORKS = {
    "sobel": sobel.WORK,
    "edges": frames.EDGES,
    "preprocess": frames.PREPROCESS,
    "prepare": five_ops.WORK,
}


def batches(work: str, settings: Settings) -> tuple[int, ...]:
    return settings.batches if work == "sobel" else settings.pipeline_batches


def export_bundle(
    work: str, settings: Settings, folder: Path, formats: Sequence[str] = ("native", "onnx")
) -> Path:
    """The bundle of a race, float32 and without its gradient."""
    if work != "prepare":
        entry = catalog()[WORKS[work].bundle]
        return export(
            entry.function(),
            replace(entry.spec, dtypes=("float32",)),
            folder,
            formats=formats,
            methods=("forward",),
        )
    spec = Spec(
        WORKS[work].bundle,
        [image("image", channels=3, color="RGB")],
        config=five_ops.config(settings),
        symbols={"H": (8, 8192), "W": (8, 8192)},
        reference="OpenCV undistort, resize, cvtColor, GaussianBlur",
        without_nan=True,
    )
    return export(prepare, spec, folder, formats=formats, methods=("forward",))
