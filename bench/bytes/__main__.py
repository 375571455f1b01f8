"""make bench WHAT=bytes: ops on frames of bytes beside OpenCV's wheel, from Python ->
docs/benchmarks_bytes.md."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from datetime import date

import cv2
from rich.progress import Progress

import chiasm

from ..machine import ROOT, cores, cpu, export_bundles, notes
from ..tables import compared, table
from .cases import SIZES
from .measure import chosen

PAGE = ROOT / "docs" / "benchmarks_bytes.md"
#: how many times as fast as OpenCV: in the geometric mean, and below which a row is named
MEAN, LEAST = 1.0, 0.9


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.bytes", description=__doc__)
    parser.add_argument("ops", nargs="*", help="only bundles whose name has one of these in it, and no page")
    parser.add_argument("--seconds", type=float, default=0.8, help="that contenders take turns for")
    options = parser.parse_args()
    export_bundles((c.bundle for c in chosen(options.ops)), formats=("native",))
    load = os.getloadavg()[0]
    rows = []
    threads = sorted({1, cores()})
    with Progress() as progress:
        task = progress.add_task("speed", total=len(chosen(options.ops)) * len(SIZES) * len(threads))
        for n in threads:
            command = [
                sys.executable,
                "-m",
                "bench.bytes.measure",
                str(n),
                str(options.seconds),
                *options.ops,
            ]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
                for line in process.stdout:
                    rows.append(json.loads(line))
                    progress.advance(task)
            if process.returncode:
                return process.returncode
    text = page(rows, load)
    if not options.ops:
        PAGE.write_text(text)
    print(text)
    return 0


def page(rows: list[dict], load: float) -> str:
    """`load`: of the machine, before the run."""
    lines = [
        "# Benchmarks of frames of bytes",
        "",
        (
            f"Made by `make bench WHAT=bytes` on {date.today()}: {cpu()}, {cores()} cores. chiasm"
            f" {chiasm.__version__}'s native backend into the caller's buffers"
        ),
        (
            f"and OpenCV's wheel {cv2.__version__} (with IPP) into matrices that are kept, from Python, in"
            " turns in one process; medians."
        ),
        (
            "Both read the same frames (B, H, W, 3) of bytes, photographs; OpenCV is called for each frame of"
            " a batch. What is a table in OpenCV"
        ),
        "is made outside of its time; chiasm makes its own of its inputs in each call.",
        "",
        (
            "Results are compared before they are timed. *Levels* is by how many they differ at most; in the"
            " median the outermost pixels, where"
        ),
        (
            "OpenCV has another border, are left out. *Of copy* is the bandwidth, of frames read once and"
            " outputs written once, as a share of that"
        ),
        "of one thread's copy of as many bytes in the same turns.",
        "",
        (
            "*Times as fast* is OpenCV's time over chiasm's, by which rows are sorted (on one thread). Where"
            f" OpenCV is faster it is **bold**, under {LEAST} ***bold and slanted***."
        ),
        *busy(load),
        "",
        *speed_table(rows),
        *slow(rows),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def busy(load: float) -> list[str]:
    if load < 0.5:
        return []
    said = f"The machine was busy with other work: a load of {load:.1f} on {cores()} cores before the run."
    return ["", said]


def ratio(row: dict) -> float:
    return row["wheel"]["opencv"] / row["wheel"]["native"]


def speed_table(rows: list[dict]) -> list[str]:
    return table(
        sorted(rows, key=ratio),
        "OpenCV ms",
        compared("wheel", "native", "opencv", 1.0, LEAST),
        (MEAN, 0.0),
        lambda row: [str(row["difference"])],
        ["levels"],
    )


def slow(rows: list[dict]) -> list[str]:
    lines = ["", f"Under {LEAST}:", ""]
    for row in sorted(rows, key=ratio):
        if ratio(row) < LEAST:
            some = f"{row['threads']} thread{'s' * (row['threads'] > 1)}"
            lines.append(f"* {row['bundle']}, {row['size']}, {some}: {ratio(row):.2f}")
    return lines if len(lines) > 3 else ["", f"Under {LEAST}: none."]


if __name__ == "__main__":
    raise SystemExit(main())
