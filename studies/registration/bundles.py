"""The example's bundles: registration.pyramid, registration.step and registration.warp."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import torch

from chiasm.export import Spec, export, frame, image
from chiasm.export.spec import TensorSpec

from .settings import Settings
from .step import pyramid, registration_step, warp

#: the minimum height and width of the smallest level
LEAST = 8
LIMITS = {"H": (LEAST, 8192), "W": (LEAST, 8192)}


def ops(settings: Settings) -> list[tuple[Callable, Spec]]:
    """The functions to export, with their specs."""
    whole = {side: (low << (settings.levels - 1), high) for side, (low, high) in LIMITS.items()}
    levels = [
        TensorSpec(f"level{i}", layout="NCHW", description=f"1/{2**i} of the size")
        for i in range(settings.levels)
    ]
    state = [TensorSpec(name, ("B", 3, 3)) for name in ("homography", "mean", "square")]
    after = [TensorSpec(f"{t.name}_after") for t in state]
    step = Spec(
        "registration.step",
        [image("src"), image("dst"), *state, TensorSpec("step", ()), TensorSpec("lr", ())],
        [*after, TensorSpec("losses")],
        symbols=LIMITS,
        takes_gradients=True,
        make_inputs=_sample,
    )
    warping = Spec(
        "registration.warp",
        [frame(), TensorSpec("homography", (1, 3, 3), "float32")],
        [TensorSpec("warped", layout="HWC", color="BGR"), TensorSpec("pixels")],
        symbols=LIMITS,
        make_inputs=_sample_frame,
    )
    return [
        (pyramid, Spec("registration.pyramid", [frame()], levels, {"levels": settings.levels}, whole)),
        (registration_step, step),
        (warp, warping),
    ]


def export_all(
    settings: Settings,
    folder: Path,
    formats: Sequence[str],
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """Write the bundles to a folder, and return it."""
    for function, spec in ops(settings):
        export(
            function,
            spec,
            folder,
            formats=formats,
            methods=("forward",),
            progress=lambda step, name=spec.name: progress(f"{name}: {step}"),
        )
    return folder


def _sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, torch.Tensor]:
    """Example inputs: images, and a state in the middle of a descent."""

    def uniform(*shape: int) -> torch.Tensor:
        return torch.rand(*shape, generator=generator, dtype=torch.float64).to(dtype)

    batch, shape = sizes["B"], [sizes[s] for s in "BCHW"]
    return {
        "src": uniform(*shape),
        "dst": uniform(*shape),
        "homography": _near_identity(uniform(batch, 3, 3)),
        "mean": 0.01 * uniform(batch, 3, 3),
        "square": 0.01 * uniform(batch, 3, 3),
        "step": torch.tensor(3.0, dtype=dtype),
        "lr": torch.tensor(1e-3, dtype=dtype),
    }


def _sample_frame(
    generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype
) -> dict[str, torch.Tensor]:
    pixels = torch.randint(0, 256, (sizes["H"], sizes["W"], 3), generator=generator, dtype=torch.uint8)
    return {"frame": pixels, "homography": _near_identity(torch.rand(1, 3, 3, generator=generator))}


def _near_identity(uniform: torch.Tensor) -> torch.Tensor:
    return torch.eye(3, dtype=uniform.dtype) + 0.1 * uniform
