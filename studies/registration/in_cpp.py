"""The same in C++: registration.cpp, called on files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from bench.machine import said
from gallery.cases import BUILD

from .pairs import Pair
from .settings import Settings

PROGRAM = BUILD / "release" / "bin" / "study_registration"


@dataclass(frozen=True)
class Report:
    """levels: the homographies (3, 3) between normalised coordinates. pixels: the last one, between pixels.
    warped: (H, W, 3), uint8, BGR."""

    levels: list[np.ndarray]
    pixels: np.ndarray
    warped: np.ndarray
    ms: float
    torch: bool


def in_cpp(pair: Pair, settings: Settings, bundles: Path, backend: str) -> Report:
    """The program's report on a pair, whose frames it reads from files next to the bundles."""
    files = [bundles.parent / f"{name}.png" for name in ("src", "dst", f"warped.{backend}")]
    for file, frame in zip(files, (pair.src, pair.dst), strict=False):
        cv2.imwrite(str(file), frame)
    found = said(PROGRAM, bundles, backend, settings.threads, settings.iterations, settings.lr, *files)
    levels = [np.reshape(level["homography"], (3, 3)) for level in found["levels"]]
    return Report(
        levels, np.reshape(found["pixels"], (3, 3)), cv2.imread(str(files[2])), found["ms"], found["torch"]
    )
