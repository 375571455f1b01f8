"""chiasm's pipeline: bundles and eager Python.

Images stay bytes in the geometric steps, and are float32 from the colour changes on.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

import chiasm.runtime
from chiasm.augmentation import (
    CLASSES,
    AugmentationSequential,
    RandomAffine,
    RandomHorizontalFlip,
    RandomResizedCrop,
)
from chiasm.export import Spec, TensorSpec, Tolerance, export

from ..machine import ROOT
from .settings import SETTINGS as S
from .settings import STEPS, Call

FOLDER = ROOT / "build" / "bench" / "augmentation"


class Numbers(nn.Module):
    """Bytes as float32 in [0, 1]."""

    def forward(self, input: Tensor) -> Tensor:
        return input.to(torch.float32) / 255.0


def pipeline(steps: Sequence[str]) -> nn.Module:
    made: dict[str, Callable[[], list[nn.Module]]] = {
        "flip": lambda: [RandomHorizontalFlip(S.flip)],
        "crop": lambda: [RandomResizedCrop((S.side, S.side), S.area, S.ratio)],
        "affine": lambda: [RandomAffine(S.degrees, (S.shift, S.shift), S.scale, p=1.0)],
        "jitter": lambda: [Numbers(), CLASSES["ColorJitter"](S.colours, S.colours, S.colours, S.hue)],
        "blur": lambda: [CLASSES["RandomGaussianBlur"]((S.taps, S.taps), S.sigma, p=1.0)],
        "normalise": lambda: [CLASSES["Normalize"](S.mean, S.std)],
    }
    return AugmentationSequential(*(module for step in steps for module in made[step]()))


def takes_bytes(steps: Sequence[str]) -> bool:
    return any(step in steps for step in STEPS[:4])


def name(steps: Sequence[str]) -> str:
    return f"bench.augmentation_{'_'.join(steps)}"


def write(pipelines: Iterable[Sequence[str]]) -> None:
    """Export pipelines of steps."""
    for steps in pipelines:
        dtype = "uint8" if takes_bytes(steps) else "float32"
        spec = Spec(
            name(steps),
            [
                TensorSpec("input", ("B", 3, "H", "W"), dtype, "NCHW", "RGB"),
                TensorSpec("seed", ("B",), "int64", range=(-(2**62), 2**62)),
            ],
            gradients=(),
            # The blur mirrors at the borders. A crop before it gives all images one size.
            symbols={"H": (S.taps, 4096), "W": (S.taps, 4096)} if steps[0] == "blur" else {},
            # A position halfway between two steps of 1/32 pixel may be rounded to either: a difference of a
            # few levels of 255.
            tolerances={"float32": Tolerance(0.25, 0.0)},
        )
        export(pipeline(steps), spec, FOLDER, formats=["native"])


def native(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    chiasm.runtime.set_num_threads(threads)
    bundle: Path = FOLDER / f"{name(steps)}.chiasm"
    method = chiasm.runtime.open(bundle).method("forward", backend="native")
    given = images if takes_bytes(steps) else np.float32(images) / np.float32(255)
    seeds = _seeds(len(images))
    return lambda: method(given, next(seeds))


def eager(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    torch.set_num_threads(threads)
    module, given = pipeline(steps), torch.from_numpy(images)
    given = given if takes_bytes(steps) else given / 255.0
    seeds = _seeds(len(images))

    def call() -> Tensor:
        with torch.no_grad():
            return module(given, torch.from_numpy(next(seeds)))

    return call


def _seeds(count: int) -> Iterator[np.ndarray]:
    return (np.arange(first, first + count) for first in itertools.count(0, count))
