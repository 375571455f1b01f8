"""make bench WHAT=geometry: geometry ops compared with Debian's OpenCV, in C++ ->
docs/benchmarks_geometry.md."""

from __future__ import annotations

import argparse
import json
from datetime import date

from rich.progress import track

import chiasm
from tools.columns import wrapped

from ..images.data import photograph_file
from ..machine import ROOT, bundle_path, cores, cpu, export_bundles, notes, program
from ..tables import ms, share, times
from .cases import CASES, IMAGE_AIM, MATRIX_AIM, Case

PAGE = ROOT / "docs" / "benchmarks_geometry.md"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.geometry", description=__doc__)
    parser.add_argument("ops", nargs="*", help="only bundles whose name has one of these in it, and no page")
    parser.add_argument("--seconds", type=float, default=1.0, help="that contenders take turns for")
    chosen = parser.parse_args()
    cases = [c for c in CASES if not chosen.ops or any(o in c.bundle for o in chosen.ops)]
    export_bundles(c.bundle for c in cases)
    runs = [(case, size) for case in cases for size in case.sizes]
    rows = [row(*run, chosen.seconds) for run in track(runs, "speed")]
    if not chosen.ops:
        PAGE.write_text(wrapped(page(rows)))
    print("\n".join(table(rows)))
    return 0


def row(case: Case, size: tuple[int, int, int], seconds: float) -> dict:
    values = json.dumps(case.values(*size))
    measured = {
        n: program("speed", bundle_path(case.bundle), n, *size, photograph_file(size), values, seconds)
        for n in sorted({1, cores()})
    }
    return {"case": case, "size": size, "measured": measured}


def page(rows: list[dict]) -> str:
    opencv = next(iter(rows[0]["measured"].values()))["opencv_version"]
    lines = [
        "# Benchmarks of geometry ops",
        "",
        (
            f"Made by `make bench WHAT=geometry` on {date.today()}: {cpu()}, {cores()} cores. chiasm"
            f" {chiasm.__version__}'s native backend writes into the caller's buffers"
        ),
        (
            f"and Debian's OpenCV {opencv} into matrices that are reused, in C++, in turns in one process;"
            " medians. Images are photographs, float32, three"
        ),
        (
            "channels, planar for chiasm and HWC for OpenCV. *Difference* is the mean absolute difference of"
            " their results, for values from 0 to 1."
        ),
        (
            "*Of copy* is the bandwidth (inputs read once, outputs written once) as a share of the bandwidth"
            " of one thread's memcpy of as many bytes in the same run."
        ),
        "",
        (
            f"Aims: {IMAGE_AIM:g} times as fast for images, {MATRIX_AIM:g} times for matrices. Numbers under"
            " the aim are ***bold and slanted***, other numbers under 1 **bold**."
        ),
        "",
        *table(rows),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def table(rows: list[dict]) -> list[str]:
    threads = list(rows[0]["measured"])
    columns = ["op", "case", "size", "difference"]
    for n in threads:
        columns += [f"{n} thread{'s' * (n > 1)}: chiasm ms", "of copy", "OpenCV ms", "times as fast"]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for r in rows:
        case, measured = r["case"], r["measured"]
        difference = measured[threads[0]].get("difference")
        size = "x".join(map(str, r["size"])) if r["size"][1] > 1 else f"batch {r['size'][0]}"
        line = [case.bundle, case.what, size, "" if difference is None else f"{difference:.1g}"]
        for n in threads:
            ratio = measured[n]["opencv"] / measured[n]["native"]
            line += [
                ms(measured[n]["native"]),
                share(measured[n], "native"),
                ms(measured[n]["opencv"]),
                times(ratio, 1.0, case.aim),
            ]
        lines.append(f"| {' | '.join(line)} |")
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
