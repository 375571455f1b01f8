"""make bench WHAT=images: the image ops compared with OpenCV and Kornia -> docs/benchmarks_images.md.

First every peer's values are compared with chiasm's (check.py). Then Debian's OpenCV is measured in C++, in
one process per row, and everything else in Python, in one process per number of threads (measure.py).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys

from rich.progress import Progress

from tools.columns import wrapped

from ..machine import ROOT, bundle_path, cores, export_bundles, program
from .chiasm_ops import measured
from .data import FOLDER, SIZES, bench_arguments
from .ops import OPS
from .page import PAGE, page

ROWS = FOLDER / "rows.json"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.images", description=__doc__)
    parser.add_argument("ops", nargs="*", help="only these, and no page")
    parser.add_argument("--seconds", type=float, default=0.8, help="that contenders take turns for")
    chosen = parser.parse_args()
    listed = [op for op in OPS if not chosen.ops or op.bundle in chosen.ops]
    export_bundles(name for op in listed for name in (op.bundle, op.constant) if name)
    ops = measured(chosen.ops)
    run_module("kornia_peers")
    run_module("check", *chosen.ops)
    rows = []
    with Progress() as progress:
        threads = sorted({1, cores()})
        task = progress.add_task("speed", total=2 * len(ops) * len(SIZES) * len(threads))
        for n in threads:
            for op in ops:
                for size in SIZES:
                    debian = program(
                        "speed", bundle_path(op.bundle), n, *bench_arguments(op, size), chosen.seconds
                    )
                    rows.append(
                        {
                            "bundle": op.bundle,
                            "size": "x".join(map(str, size)),
                            "threads": n,
                            "debian": debian,
                        }
                    )
                    progress.advance(task)
        by_key = {key(row): row for row in rows}
        for n in threads:
            command = [sys.executable, "-m", "bench.images.measure", str(n), str(chosen.seconds), *chosen.ops]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
                for line in process.stdout:
                    row = json.loads(line)
                    by_key[key(row)].update(row)
                    progress.advance(task)
            if process.returncode:
                return process.returncode
    ROWS.write_text(json.dumps(rows, indent=1))
    text = page(rows)
    if not chosen.ops:
        PAGE.write_text(wrapped(text))
    print(text)
    return 0


def key(row: dict) -> tuple:
    return row["bundle"], row["size"], row["threads"]


def run_module(name: str, *arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", f"bench.images.{name}", *arguments], cwd=ROOT)
    if done.returncode:
        sys.exit(f"bench.images.{name} failed")


if __name__ == "__main__":
    raise SystemExit(main())
