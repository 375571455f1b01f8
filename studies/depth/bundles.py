"""The functions of step.py as bundles: all computations of the optimisation, for a program without Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from torch import Tensor

from chiasm.export import Spec, TensorSpec, export

from .descent import CONFIG
from .settings import Settings
from .step import enlarge, reduce, step

INVERSE_DEPTH = TensorSpec("inverse_depth", (1, 1, "H", "W"), layout="NCHW", description="of the reference")


def specs(settings: Settings) -> dict[str, tuple[Callable, Spec]]:
    """The functions and their specs, by the bundles' names."""
    least = settings.window // 2 + 1  # reflection needs more pixels than half of the window
    inputs = [
        INVERSE_DEPTH,
        TensorSpec("velocity", (1, 1, "H", "W"), layout="NCHW", description="zeros at first"),
        TensorSpec("reference", (1, 3, "H", "W"), layout="NCHW", color="RGB", range=(0.0, 1.0)),
        TensorSpec("views", ("B", 3, "H", "W"), layout="NCHW", color="RGB", range=(0.0, 1.0)),
        TensorSpec("camera", (1, 3, 3), description="the reference's camera matrix, in pixels"),
        TensorSpec("view_cameras", ("B", 3, 3), description="the views'"),
        TensorSpec("motions", ("B", 4, 4), description="from the reference's frame to each view's"),
        TensorSpec("limits", (2,), description="least and greatest inverse depth"),
        TensorSpec("rate", (), description="learning rate"),
    ]
    config = {name: getattr(settings, name) for name in CONFIG}
    outputs = [
        TensorSpec("next_inverse_depth", layout="NCHW"),
        TensorSpec("next_velocity", layout="NCHW"),
        TensorSpec("loss"),
    ]
    images = [
        TensorSpec("images", ("B", 3, "H", "W"), layout="NCHW", color="RGB", range=(0.0, 1.0)),
        TensorSpec("cameras", ("B", 3, 3), description="camera matrices, in pixels"),
    ]
    smaller = [TensorSpec("smaller_images", layout="NCHW"), TensorSpec("smaller_cameras")]
    like = TensorSpec("like", (1, 3, "OH", "OW"), layout="NCHW", description="an image of the size wanted")
    sides = {"H": (least, 8192), "W": (least, 8192), "B": (1, 64)}
    finer, any_size = {"H": (4, 8192), "W": (4, 8192), "B": (1, 64)}, {"OH": (1, 8192), "OW": (1, 8192)}
    found = [
        (step, Spec("depth.step", inputs, outputs, config, sides, make_inputs=_views, takes_gradients=True)),
        (reduce, Spec("depth.reduce", images, smaller, symbols=finer, gradients=())),
        (
            enlarge,
            Spec(
                "depth.enlarge",
                [INVERSE_DEPTH, like],
                [TensorSpec("enlarged", layout="NCHW")],
                symbols=any_size,
                gradients=(),
            ),
        ),
    ]
    return {spec.name: (fn, spec) for fn, spec in found}


def export_all(
    settings: Settings,
    folder: Path,
    formats: Sequence[str],
    progress: Callable[[str], None] = lambda step: None,
) -> None:
    """Write the bundles into a folder."""
    for name, (fn, spec) in specs(settings).items():
        export(
            fn, spec, folder, formats=formats, progress=lambda what, name=name: progress(f"{name}: {what}")
        )


def _views(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Example inputs: a wall of noise four metres away, and cameras side by side."""
    views, height, width = sizes["B"], sizes["H"], sizes["W"]
    camera = torch.tensor([[[width, 0.0, width / 2], [0.0, width, height / 2], [0.0, 0.0, 1.0]]])
    motions = torch.eye(4).repeat(views, 1, 1)
    motions[:, :3, 3] = 0.3 * torch.rand(views, 3, generator=generator) - 0.1
    made = {
        "inverse_depth": 0.25 + 0.02 * torch.rand(1, 1, height, width, generator=generator),
        "velocity": torch.rand(1, 1, height, width, generator=generator) - 0.5,
        "reference": torch.rand(1, 3, height, width, generator=generator),
        "views": torch.rand(views, 3, height, width, generator=generator),
        "camera": camera,
        "view_cameras": camera.repeat(views, 1, 1),
        "motions": motions,
        "limits": torch.tensor([0.1, 1.0]),
        "rate": torch.tensor(0.01),
    }
    return {name: value.to(dtype) for name, value in made.items()}
