"""The measurements: pairs registered by native code and by OpenCV, and one pair registered by every
engine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
import torch

from chiasm.geometry.registration import ImageRegistrator
from chiasm.image import frames_to_tensor

from .descent import Engine, in_pixels
from .in_cpp import in_cpp
from .pairs import Pair, corner_error
from .peers import ecc, ecc_multi_scale
from .settings import Settings

T = TypeVar("T")


@dataclass(frozen=True)
class Result:
    """A contender's mean error of the corners, in pixels, and its CPU time in milliseconds."""

    error: float
    ms: float


@dataclass(frozen=True)
class Trial:
    """levels: the homographies (3, 3) between normalised coordinates. errors: mean errors of the corners, at
    the start and after each level."""

    pair: Pair
    levels: list[np.ndarray]
    errors: list[float]
    results: dict[str, Result]


def trial(pair: Pair, engine: Engine, settings: Settings) -> Trial:
    """Register a pair by chiasm and by OpenCV."""
    levels, ms = timed(lambda: engine.register(pair.src, pair.dst, settings))
    errors = [
        corner_error(pair, np.eye(3)),
        *(corner_error(pair, in_pixels(level, settings)) for level in levels),
    ]
    results = {"gradient descent": Result(errors[-1], ms)}
    for find in (ecc, ecc_multi_scale):
        found, ms = timed(lambda find=find: find(pair.src, pair.dst))
        results[find.__name__] = Result(corner_error(pair, found), ms)
    return Trial(pair, levels, errors, results)


@dataclass(frozen=True)
class Run:
    """An engine's result for a pair: the homography (3, 3) between normalised coordinates, and the CPU time
    from frames to it in milliseconds."""

    engine: str
    homography: np.ndarray
    ms: float


def runs(pair: Pair, settings: Settings, bundles: Path) -> Iterator[Run]:
    """Register one pair with every engine, eager Python first."""
    engines: dict[str, Callable[[], Engine]] = {
        "eager": lambda: Engine.eager(settings),
        "native": lambda: Engine.bundles(bundles, "native"),
        "ONNX Runtime": lambda: Engine.bundles(bundles, "onnx"),
    }
    for name, load in engines.items():
        engine = load()
        levels, ms = timed(lambda engine=engine: engine.register(pair.src, pair.dst, settings))
        yield Run(f"Python, {name}", levels[-1], ms)
    registrator = ImageRegistrator(
        pyramid_levels=settings.levels, lr=settings.lr, num_iterations=settings.iterations
    )
    found, ms = timed(
        lambda: registrator.register(
            *(frames_to_tensor(torch.from_numpy(frame)) for frame in (pair.src, pair.dst))
        )
    )
    yield Run("Python, `ImageRegistrator` with `torch.optim.Adam`", found[0].numpy(), ms)
    for name, backend in {"native": "native", "ONNX Runtime": "onnx"}.items():
        report = in_cpp(pair, settings, bundles, backend)
        if report.torch:
            raise RuntimeError("study_registration has loaded a library of torch")
        yield Run(f"C++, {name}", report.levels[-1], report.ms)


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """A result and its CPU time in milliseconds, which other programs on the machine hardly affect."""
    start = time.process_time()
    result = call()
    return result, 1000 * (time.process_time() - start)
