"""The C++ program, build/release/bin/study_batch: the same bundles and photographs without Python, compared
with Debian's OpenCV."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np

from bench.images.data import PHOTOGRAPHS
from bench.machine import ROOT

from .measure import COMPARED, Disagreement, agreement, reference
from .ours import NATIVE
from .ways import Setup, photographs
from .works import WORKS, batches

PROGRAM = ROOT / "build" / "release" / "bin" / "study_batch"
CHIASM, OPENCV = "chiasm native, C++", "OpenCV, C++"


def write_settings(setup: Setup, folder: Path) -> Path:
    """Write the program's settings file."""
    settings, raw = setup.settings, folder / "photographs.raw"
    raw.write_bytes(photographs(len(PHOTOGRAPHS), settings.size).tobytes())
    works = {
        name: {"bundle": str(setup.bundles / f"{work.bundle}.chiasm"), "batches": batches(name, settings)}
        for name, work in WORKS.items()
    }
    path = folder / "settings.json"
    path.write_text(json.dumps(asdict(settings) | {"photographs": str(raw), "works": works}))
    return path


def program(*arguments: object) -> Iterator[dict]:
    """The lines that the program prints; RuntimeError with its message if it fails."""
    with subprocess.Popen(
        [PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout:
            yield json.loads(line)
        problem = process.stderr.read()
    if process.returncode:
        raise RuntimeError(f"study_batch {' '.join(map(str, arguments))}: {problem}")


def check(work: str, setup: Setup, settings_file: Path) -> tuple[dict[str, dict], str]:
    """The differences of both contenders' results from chiasm's eager ones, and OpenCV's version; raises
    Disagreement if a contender exceeds its limits."""
    [said] = program("results", settings_file, work)
    expected, found, ways = reference(work, setup), {}, WORKS[work].ways
    limits = {CHIASM: ways[NATIVE].agrees, OPENCV: WORKS[work].debian or ways["OpenCV"].agrees}
    for name, who in ((CHIASM, "chiasm"), (OPENCV, "OpenCV")):
        made = np.fromfile(settings_file.with_name(f"{work}.{who}.raw"), np.float32)
        try:
            found[name] = agreement(limits[name], made.reshape(COMPARED, *expected.shape[1:]), expected)
        except (Disagreement, ValueError) as error:
            raise Disagreement(f"{work}, {name}: {error}") from error
    return found, said["opencv"]


def race(work: str, threads: int, settings_file: Path) -> Iterator[dict]:
    """A row of times for each batch size."""
    for row in program("race", settings_file, work, threads):
        yield {"work": work, "threads": threads} | row


def memory(work: str, settings_file: Path) -> dict[str, float]:
    """Megabytes per image."""
    return {
        name: next(program("memory", settings_file, work, who))["mb"]
        for name, who in ((CHIASM, "chiasm"), (OPENCV, "OpenCV"))
    }
