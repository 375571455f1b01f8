"""The optimisation: from the coarsest scale to the finest, by functions of eager Python or of bundles."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import torch
from torch import Tensor

from chiasm import runtime

from . import step
from .scenes import Scene
from .settings import Settings

#: the arguments of :func:`step.step` that are constants in bundles
CONFIG = ("window", "ssim_weight", "l1_weight", "smoothness", "inertia")


@dataclass(frozen=True)
class Functions:
    """The functions of step.py."""

    step: Callable
    reduce: Callable
    enlarge: Callable


@dataclass(frozen=True)
class Level:
    """The results at one scale.

    images: (B, 3, H, W); cameras: (B, 3, 3); inverse_depth: (1, 1, H, W).
    loss: before the last step. milliseconds: per step.
    """

    images: Tensor
    cameras: Tensor
    inverse_depth: Tensor
    loss: float
    milliseconds: float


def eager(settings: Settings) -> Functions:
    """The functions in eager Python."""
    return Functions(
        partial(step.step, **{name: getattr(settings, name) for name in CONFIG}), step.reduce, step.enlarge
    )


def loaded(folder: Path, backend: str) -> Functions:
    """The functions of the bundles in a folder; ONNX Runtime uses standard operators, not native code."""
    bundles = (runtime.open(folder / f"depth.{name}.chiasm") for name in ("step", "reduce", "enlarge"))
    return Functions(*(bundle.method("forward", backend=backend, fused=False) for bundle in bundles))


def descend(
    scene: Scene,
    settings: Settings,
    functions: Functions,
    advance: Callable[[int], None] = lambda pixels: None,
) -> list[Level]:
    """Depth at every scale, the coarsest first.

    Args:
        advance: called after every step with the number of pixels, on which its time depends.
    """
    scales = [(scene.images, scene.cameras)]
    for _ in range(settings.scales - 1):
        scales.append(functions.reduce(*scales[-1]))
    # The size of the coarsest scale, not one pixel: resampling a constant gives rounding errors, which differ
    # between engines.
    inverse_depth = torch.full_like(scales[-1][0][:1, :1], float(scene.limits.mean()))
    levels = []
    for images, cameras in reversed(scales):
        inverse_depth = functions.enlarge(inverse_depth, images[:1])
        velocity = torch.zeros_like(inverse_depth)
        views = (images[:1], images[1:], cameras[:1], cameras[1:], scene.motions[1:], scene.limits)
        start = time.perf_counter()
        for iteration in range(settings.iterations):
            inverse_depth, velocity, loss = functions.step(
                inverse_depth, velocity, *views, torch.tensor(settings.rate_at(iteration))
            )
            advance(inverse_depth.numel())
        milliseconds = (time.perf_counter() - start) * 1000 / settings.iterations
        levels.append(Level(images, cameras, inverse_depth, float(loss), milliseconds))
    return levels
