"""One optimisation by each engine: eager Python, native code and ONNX Runtime, from Python and from C++."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch

from bench.machine import said
from gallery.cases import BUILD

from .descent import Functions, Level, descend
from .scenes import Scene
from .score import Difference, Score, depth_at_full_size, difference, score
from .settings import Settings

PROGRAM = BUILD / "release" / "bin" / "study_depth"
#: The tolerances: the least share of pixels whose depth after the whole optimisation differs from eager
#: Python's by less than 1%, and the largest difference of the mean error against the truth.
AGREEING, ERROR_APART = 0.9, 0.005


@dataclass(frozen=True)
class Run:
    """An engine's result for a scene. depth: (H, W). milliseconds: per step at the finest scale."""

    engine: str
    depth: np.ndarray
    loss: float
    seconds: float
    milliseconds: float


def in_python(
    engine: str,
    scene: Scene,
    settings: Settings,
    functions: Functions,
    advance: Callable[[int], None] = lambda pixels: None,
) -> tuple[Run, list[Level]]:
    """The run, and its results at every scale."""
    start = time.perf_counter()
    levels = descend(scene, settings, functions, advance)
    last = levels[-1]
    return (
        Run(
            engine,
            depth_at_full_size(last.inverse_depth, scene),
            last.loss,
            time.perf_counter() - start,
            last.milliseconds,
        ),
        levels,
    )


def in_cpp(backend: str, scene: Scene, bundles: Path, folder: Path) -> Run:
    """The C++ program's run of a scene that was saved in a folder."""
    report = said(PROGRAM, bundles, backend, folder)
    if report["libtorch"]:
        raise RuntimeError(f"{PROGRAM.name}: libtorch is in its process")
    inverse_depth = torch.from_numpy(
        cv2.imread(str(folder / f"inverse_depth.{backend}.tiff"), cv2.IMREAD_UNCHANGED)
    )[None, None]
    engine = {"native": "C++, native code", "onnx": "C++, ONNX Runtime"}[backend]
    return Run(
        engine, depth_at_full_size(inverse_depth, scene), report["loss"], report["seconds"], report["step_ms"]
    )


@dataclass(frozen=True)
class Judged:
    """A run, its errors against the truth, and its difference from the first run."""

    run: Run
    score: Score
    difference: Difference


def judge(runs: list[Run], scene: Scene) -> list[Judged]:
    """Compare the runs with the first one.

    Raises:
        RuntimeError: if a run exceeds the tolerances.
    """
    judged = [Judged(run, score(run.depth, scene), difference(run.depth, runs[0].depth)) for run in runs]
    for one in judged:
        errors = one.score.error, judged[0].score.error
        if one.difference.within < AGREEING or abs(errors[0] - errors[1]) > ERROR_APART:
            raise RuntimeError(
                f"{scene.name}: {one.run.engine} does not agree with {runs[0].engine}: {one.difference},"
                f" errors {errors}"
            )
    return judged
