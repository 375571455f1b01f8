"""make bench WHAT=peers: ops that another library has too, compared with it from Python ->
docs/benchmarks_peers.md."""

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
from tools.columns import wrapped

from ..machine import ROOT, cores, cpu, export_bundles, notes
from ..tables import compared, table
from .measure import WORDS, chosen, sizes, variants

PAGE = ROOT / "docs" / "benchmarks_peers.md"
#: the aims, in times as fast as the peer: the geometric mean, and the limit below which rows are highlighted
MEAN, LEAST = 1.0, 0.5
HEAD = f"""# Benchmarks beside other libraries

Made by `make bench WHAT=peers` on {{date}}: {{cpu}}, {{cores}} cores.
chiasm {chiasm.__version__}'s native backend writes into the caller's buffers; OpenCV's wheel {{opencv}}
(with IPP) and the other libraries allocate their results, in memory that malloc reuses. All
are called from Python, in turns, in one process; medians. The images are photographs with three channels. A
peer that takes one image is called for each image of a batch.

Results are compared before they are timed. *Apart* is their largest difference. *Of copy* is the bandwidth
(inputs read once, outputs written once) as a share of the bandwidth of one thread's copy of as many bytes in
the same turns.

*Times as fast* is the peer's time over chiasm's; rows are sorted by it (on one thread). The number is
**bold** if the peer is faster, and ***bold and slanted*** under {LEAST}."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.peers", description=__doc__)
    parser.add_argument("ops", nargs="*", help="only ops whose name has one of these in it, and no page")
    parser.add_argument("--seconds", type=float, default=0.5, help="that contenders take turns for")
    options = parser.parse_args()
    entries = chosen(options.ops)
    load = os.getloadavg()[0]
    export_bundles((e.spec.name for e in entries), formats=("native",))
    rows: list[dict] = []
    threads = sorted({1, cores()})
    with Progress() as progress:
        task = progress.add_task(
            "speed", total=sum(len(sizes(e.spec)) * len(variants(e.spec)) for e in entries) * len(threads)
        )
        for n in threads:
            command = [
                sys.executable,
                "-m",
                "bench.peers.measure",
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
    problems = [row["problem"] for row in rows if "problem" in row]
    text = page([row for row in rows if "problem" not in row], load)
    if not options.ops:
        PAGE.write_text(wrapped(text))
    print(text)
    for problem in problems:
        print(f"not in the table: {problem}", file=sys.stderr)
    return 1 if problems else 0


def page(rows: list[dict], load: float) -> str:
    """`load`: the machine's load before the run."""
    lines = [*HEAD.format(date=date.today(), cpu=cpu(), cores=cores(), opencv=cv2.__version__).splitlines()]
    lines += busy(load)
    titles = [title(row) for row in rows]
    for each in ("Frames of bytes", "Frames of 16 bits", "Planes"):
        if each in titles:
            some = [row for row, its in zip(rows, titles, strict=True) if its == each]
            lines += ["", f"## {each}", "", *speed_table(some)]
    return "\n".join(lines) + "\n" + notes(PAGE)


def title(row: dict) -> str:
    """That of the table with this row."""
    if not row["bundle"].endswith(".frames"):
        return "Planes"
    return "Frames of 16 bits" if row["dtype"] == WORDS else "Frames of bytes"


def busy(load: float) -> list[str]:
    if load < 0.5:
        return []
    said = f"The machine was busy with other work: a load of {load:.1f} on {cores()} cores before the run."
    return ["", said]


def ratio(row: dict) -> float:
    return row["race"]["peer"] / row["race"]["native"]


def speed_table(rows: list[dict]) -> list[str]:
    return table(
        sorted(rows, key=ratio),
        "peer ms",
        compared("race", "native", "peer", 1.0, LEAST),
        (MEAN, LEAST),
        lambda row: [row["library"], f"{row['difference']:.2g}"],
        ["peer", "apart"],
    )


if __name__ == "__main__":
    raise SystemExit(main())
