"""Kornia and torchvision v2."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import torch
from torch import Tensor, nn
from torchvision.transforms import v2

from .settings import SETTINGS as S
from .settings import Call, shares

#: warm-up calls, until torch.compile makes no new graphs of Kornia's pipeline; eleven were enough
COMPILING = 30


class Numbers(nn.Module):
    """Bytes as float32 in [0, 1]."""

    def forward(self, input: Tensor) -> Tensor:
        return input.float() / 255.0


def kornia_pipeline(steps: Sequence[str]) -> nn.Module:
    # uses the project's torch (tools/kornia.sh)
    sys.path.append(".deps/kornia")
    import kornia.augmentation as K

    made: dict[str, Callable[[], nn.Module]] = {
        "flip": lambda: K.RandomHorizontalFlip(p=S.flip),
        "crop": lambda: K.RandomResizedCrop((S.side, S.side), S.area, S.ratio),
        "affine": lambda: K.RandomAffine(S.degrees, (S.shift, S.shift), S.scale, p=1.0),
        "jitter": lambda: K.ColorJitter(S.colours, S.colours, S.colours, S.hue),
        "blur": lambda: K.RandomGaussianBlur((S.taps, S.taps), S.sigma, p=1.0),
        "normalise": lambda: K.Normalize(S.mean, S.std),
    }
    return nn.Sequential(Numbers(), *(made[step]() for step in steps))


def kornia_eager(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    return _batch(kornia_pipeline(steps), images, threads)


def kornia_compiled(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    torch._dynamo.config.recompile_limit = 64  # each order of the colours needs its own graph
    call = _batch(torch.compile(kornia_pipeline(steps)), images, threads)
    for _ in range(COMPILING):
        call()
    return call


def _batch(pipeline: Callable[[Tensor], Tensor], images: np.ndarray, threads: int) -> Call:
    torch.set_num_threads(threads)
    given = torch.from_numpy(images)

    def call() -> Tensor:
        with torch.no_grad():
            return pipeline(given)

    return call


def torchvision_pipeline(steps: Sequence[str], as_float: bool) -> Callable[[Tensor], Tensor]:
    """On bytes until the normalisation, or on floats from the start."""
    bilinear = v2.InterpolationMode.BILINEAR
    shift = (S.shift, S.shift)
    made: dict[str, Callable[[], nn.Module]] = {
        "flip": lambda: v2.RandomHorizontalFlip(S.flip),
        "crop": lambda: v2.RandomResizedCrop(S.side, S.area, S.ratio, bilinear),
        "affine": lambda: v2.RandomAffine((-S.degrees, S.degrees), shift, S.scale, interpolation=bilinear),
        "jitter": lambda: v2.ColorJitter(S.colours, S.colours, S.colours, S.hue),
        "blur": lambda: v2.GaussianBlur(S.taps, S.sigma),
        "normalise": lambda: v2.Normalize(S.mean, S.std),
    }
    listed = [made[step]() for step in steps]
    if as_float:
        listed.insert(0, v2.ToDtype(torch.float32, scale=True))
    elif "normalise" in steps:
        listed.insert(-1, v2.ToDtype(torch.float32, scale=True))
    return v2.Compose(listed)


def torchvision_bytes(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    return _each(torchvision_pipeline(steps, False), images, threads)


def torchvision_float(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    return _each(torchvision_pipeline(steps, True), images, threads)


def torchvision_batch(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    """One set of parameters for all images, which is less work and a different distribution."""
    return _batch(torchvision_pipeline(steps, False), images, threads)


def _each(pipeline: Callable[[Tensor], Tensor], images: np.ndarray, threads: int) -> Call:
    """Each image in its own call, distributed over threads with one torch thread each, like the workers of a
    loader."""
    torch.set_num_threads(1)
    pool = ThreadPoolExecutor(threads, initializer=lambda: torch.set_num_threads(1))
    given = torch.from_numpy(images)

    def part(some: range) -> list[Tensor]:
        with torch.no_grad():
            return [pipeline(given[i]) for i in some]

    def call() -> Tensor:
        return torch.stack([image for some in pool.map(part, shares(len(given), threads)) for image in some])

    return call
