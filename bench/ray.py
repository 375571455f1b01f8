"""make bench WHAT=ray: a bundle on generated JPEGs, on Ray, in a plain loop and by `chiasm map`, compared
with OpenCV and NumPy -> docs/benchmarks_ray.md. ray_contenders.py, which runs in .deps/data, measures.

    python -m bench ray 1000     1,000 images instead of 20,000: a quick test, which writes no page
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from datetime import date

from rich.progress import track

from tools.columns import wrapped

from .machine import ROOT, bundle_path, cores, cpu, export_bundles, notes

PAGE = ROOT / "docs" / "benchmarks_ray.md"
FOLDER = ROOT / "build" / "bench" / "ray"
PYTHON = ROOT / ".deps" / "data" / "bin" / "python"
BUNDLE = "pipelines.preprocess"
COUNT, SIZE = 20_000, (480, 640)
#: the aims: the rate of Ray over the plain loop, of chiasm over OpenCV in the same actors, and the most bytes
#: of driver and workers
AIMS = (0.85, 1.4, 1.5 * 2**30)


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    export_bundles([BUNDLE])
    photos = make_images(count)
    command = [PYTHON, "-m", "bench.ray_contenders", bundle_path(BUNDLE), photos, FOLDER]
    done = subprocess.run(
        [str(part) for part in command],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT / "python"), "RAY_USAGE_STATS_ENABLED": "0"},
    )
    if done.returncode:
        sys.exit("bench.ray_contenders failed")
    kilobytes = sum(file.stat().st_size for file in photos.iterdir()) / count / 1000
    text = page(json.loads(done.stdout.splitlines()[-1]), count, kilobytes)
    if count == COUNT:
        PAGE.write_text(wrapped(text))
    print(text)
    return 0


def make_images(count: int):
    """A folder of ``count`` different JPEGs: blots and noise, with about as many bytes as photographs."""
    import cv2
    import numpy as np

    folder = FOLDER / f"photos-{count}"
    folder.mkdir(parents=True, exist_ok=True)
    height, width = SIZE
    have = len(list(folder.iterdir()))
    for i in track(range(max(0, have - 1), count), description="images", disable=have == count):
        rng = np.random.default_rng(i)
        blots = cv2.resize(rng.integers(0, 256, (30, 40, 3), np.uint8), (width, height), interpolation=2)
        noise = rng.integers(0, 12, (height, width, 3), np.uint8)
        cv2.imwrite(str(folder / f"{i:05}.jpg"), cv2.add(blots, noise), [cv2.IMWRITE_JPEG_QUALITY, 85])
    return folder


def page(found: dict, count: int, kilobytes: float) -> str:
    rates = {name: statistics.median(run["rate"] for run in runs) for name, runs in found["runs"].items()}
    on_ray, loop, opencv = rates["chiasm on Ray"], rates["chiasm, plain loop"], rates["OpenCV on Ray"]
    versions = found["versions"]
    memory = max(run["peak"] for run in found["runs"]["chiasm on Ray"])
    growth = max(run["growth"] for run in found["runs"]["chiasm on Ray"])
    lines = [
        "# Benchmark of data sets",
        "",
        f"Made by `make bench WHAT=ray` on {date.today()}: {cpu()}, {cores()} cores. {count} generated JPEGs",
        f"of {SIZE[1]}x{SIZE[0]} ({kilobytes:.0f} KB) are read, decoded and run through `{BUNDLE}`",
        "(3 x 224 x 224 float32) by two workers with one thread each; contenders take turns, three times;",
        "medians. Rates are measured over the last three quarters of a run. "
        + ", ".join(f"{name} {version}" for name, version in versions.items())
        + ".",
        "",
        "| contender | images a second |",
        "|---|---|",
        *(f"| {name} | {rate:.0f} |" for name, rate in rates.items()),
        "",
        "| | measured | aim |",
        "|---|---|---|",
        ratio("Ray, times as fast as the plain loop", on_ray / loop, AIMS[0]),
        ratio("chiasm, times as fast as OpenCV and NumPy in the same actors", on_ray / opencv, AIMS[1]),
        (
            f"| peak memory of driver and workers (proportional set size) | {memory / 2**20:.0f} MB | under"
            f" {AIMS[2] / 2**20:.0f} MB |"
        ),
        f"| growth of this memory from a quarter of a run to its end | {growth / 2**20:+.0f} MB | flat |",
        "",
        "`chiasm map` on the same images in two processes:",
        "",
        "| run | seconds | shards | the same bytes |",
        "|---|---|---|---|",
        *(
            f"| {run['name']} | {run['seconds']:.0f} | {run['shards']} | {run['same']} |"
            for run in found["map"]
        ),
        "",
    ]
    return "\n".join(lines) + notes(PAGE)


def ratio(what: str, value: float, aim: float) -> str:
    return f"| {what} | {f'{value:.2f}' if value >= aim else f'**{value:.2f}**'} | {aim} |"


if __name__ == "__main__":
    sys.exit(main())
