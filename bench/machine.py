"""The description of the machine, the measured bundles, and the C++ program that measures them."""

from __future__ import annotations

import ctypes
import json
import os
import platform
import subprocess
from collections.abc import Iterable
from pathlib import Path

from chiasm.export.manifest import FORMATS
from chiasm.export.workers import export_names

ROOT = Path(__file__).resolve().parents[1]
BUNDLES = ROOT / "build" / "bench" / "bundles"
PROGRAM = ROOT / "build" / "release" / "bin" / "bench"
LIBC = ctypes.CDLL(None)


def cores() -> int:
    return len(os.sched_getaffinity(0))


def cpu() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def keep_memory() -> None:
    """Make malloc reuse freed memory. Otherwise each large result of a peer, which gets no buffer, is in new
    memory from the system, and the first use of its pages takes longer than many ops."""
    mmap_threshold, trim_threshold = -3, -1
    for parameter in (mmap_threshold, trim_threshold):
        LIBC.mallopt(parameter, 1 << 30)


def program(*arguments) -> dict:
    """The output of build/release/bin/bench."""
    return said(PROGRAM, *arguments)


def said(path: Path, *arguments) -> dict:
    """The JSON output of a C++ program; RuntimeError with its message if it fails."""
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{path.name} {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def export_bundles(names: Iterable[str], formats: Iterable[str] = FORMATS) -> None:
    """Export ops of the catalog, without gradients, to the folder in which `bundle_path` finds them."""
    export_names(sorted(set(names)), BUNDLES, tuple(formats), methods=("forward",), jobs=cores())


def bundle_path(bundle: str) -> Path:
    return BUNDLES / f"{bundle}.chiasm"


def notes(page: Path) -> str:
    """The notes for the end of a page: the content of the file next to it whose name ends with _notes."""
    path = page.with_name(f"{page.stem}_notes.md")
    return "\n" + path.read_text() if path.exists() else ""
